% expect: 2:20: X is denied before it is bound
p(X) :- \+ surface(X), spatial_obj(X).
