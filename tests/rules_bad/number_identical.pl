% expect: 2:30: numbers are compared with ==
p(X) :- distance(X, _, D), D == 0.3.
