% expect: 2:4: the directive 'initialization' is not in the subset
:- initialization(halt).
p(X) :- surface(X).
