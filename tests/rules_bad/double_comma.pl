% expect: 2:20: ',' is not expected here
p(X) :- surface(X),, touches(X, _).
