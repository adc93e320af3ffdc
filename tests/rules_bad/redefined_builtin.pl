% expect: 2:1: atom_length/2 belongs to Prolog itself
atom_length(X, X) :- surface(X).
