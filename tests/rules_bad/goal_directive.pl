% expect: 2:4: the directive 'surface' is not in the subset
:- surface(floor).
p(X) :- surface(X).
