% expect: 2:3: X is bound by no goal
p(X) :- surface(floor), \+ touches(X, floor).
