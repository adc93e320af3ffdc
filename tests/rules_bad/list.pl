% expect: 2:20: lists are not in the subset
p(X) :- touches(X, [a, b]).
