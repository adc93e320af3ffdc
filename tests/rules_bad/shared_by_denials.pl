% expect: 2:47: Y stands in two denials
p(X) :- surface(X), \+ touches(Y, X), \+ near(Y, X).
