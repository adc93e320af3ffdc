% expect: 2:1: why/1 belongs to the theory, in explain.pl
why(X) :- surface(X).
