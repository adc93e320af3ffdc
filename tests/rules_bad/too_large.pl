% expect: 2:32: 1.0e16 is beyond 1e+15
p(X) :- distance(X, _, D), D < 1.0e16.
