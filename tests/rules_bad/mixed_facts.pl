% expect: 3:11: argument 2 of size/2 is a number here and a name elsewhere
size(cup, small).
size(mug, 3).
