% expect: 2:25: the clause ends too early
p(X) :- touches(X, floor.
