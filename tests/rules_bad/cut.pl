% expect: 2:21: the cut ! is not in the subset
p(X) :- surface(X), !.
