% expect: 2:20: argument 2 of touches/2 is a number here and a name elsewhere
p(X) :- touches(X, 3).
