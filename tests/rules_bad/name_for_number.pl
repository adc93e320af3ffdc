% expect: 2:24: argument 3 of distance/3 is a name here and a number elsewhere
p(X) :- distance(X, _, near).
