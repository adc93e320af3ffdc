% expect: 2:4: 'table' is not in the subset
:- table p/1.
p(X) :- surface(X).
