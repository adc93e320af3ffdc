% expect: 2:23: '=..' takes terms apart, which is not in the subset
p(X) :- surface(X), X =.. _.
