% expect: 2:39: ';' is not in the subset
p(X) :- ( surface(X) -> touches(X, _) ; near(X, _) ).
