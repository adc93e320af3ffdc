% expect: 2:14: a module in front of a goal is not in the subset
p(X) :- facts:surface(X).
