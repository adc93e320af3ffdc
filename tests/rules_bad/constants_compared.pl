% expect: 2:23: two constants are compared
p(X) :- surface(X), a \== b.
