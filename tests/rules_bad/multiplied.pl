% expect: 2:30: '*' is not in the subset
p(X) :- distance(X, _, D), D * 2 < 1.
