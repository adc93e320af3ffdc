% expect: 2:6: Y is bound by no goal
p(X, Y) :- surface(X).
