% expect: 2:28: _ is compared
p(X) :- distance(X, _, _), _ < 0.3.
