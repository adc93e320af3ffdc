% expect: 2:19: '.' means nothing here
p(X) :- surface(X).q(X) :- surface(X).
