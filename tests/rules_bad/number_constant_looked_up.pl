% expect: 2:27: the number 0 is looked up
p(X, Y) :- distance(X, Y, 0.0).
