% expect: 2:24: X is a number here and a name elsewhere
p(X) :- touches(X, _), X < 3.
