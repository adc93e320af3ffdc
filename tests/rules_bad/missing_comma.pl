% expect: 2:23: 'surface' is not expected here
p(X) :- touches(X, Y) surface(Y).
