% expect: 2:33: 'is' is not in the subset
p(X, E) :- distance(X, _, D), E is D + 1.
