% expect: 2:3: a term within a term is not in the subset
p(at(X)) :- surface(X).
