% expect: 2:1: the clause has no end
p(X) :- surface(X)