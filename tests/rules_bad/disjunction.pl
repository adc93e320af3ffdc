% expect: 2:22: ';' is not in the subset
p(X) :- ( surface(X) ; touches(X, floor) ).
