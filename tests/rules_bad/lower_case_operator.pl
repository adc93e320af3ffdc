% expect: 2:20: 'and' is not expected here
p(X) :- surface(X) and touches(X, _).
