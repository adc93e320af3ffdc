% expect: 2:21: 'findall' is not in the subset
p(X) :- surface(X), findall(Y, touches(Y, X), _).
