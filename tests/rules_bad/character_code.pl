% expect: 2:32: 0'a is not in the subset
p(X) :- distance(X, _, D), D < 0'a.
