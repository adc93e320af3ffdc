% expect: 2:28: a sum is compared with ==
p(X) :- distance(X, _, D), D + 1 == 2.
