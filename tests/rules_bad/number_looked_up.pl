% expect: 2:46: the number D is looked up
p(X, Y) :- distance(X, _, D), distance(_, Y, D).
