% expect: 2:26: Y is compared and never bound
p(X) :- surface(X), \+ ( Y \== X, touches(Y, X) ).
