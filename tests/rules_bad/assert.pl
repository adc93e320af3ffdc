% expect: 2:21: 'assertz' is not in the subset
p(X) :- surface(X), assertz(q(X)).
