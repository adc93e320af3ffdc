% expect: 2:17: '(' stands apart from its name
p(X) :- surface (X).
