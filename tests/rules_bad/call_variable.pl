% expect: 2:21: a variable is no goal
p(X) :- surface(X), X.
