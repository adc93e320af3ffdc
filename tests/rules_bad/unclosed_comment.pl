% expect: 3:1: the comment is not closed
p(X) :- surface(X).
/* and so on
