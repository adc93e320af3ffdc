% expect: 2:41: a denial within a denial is not in the subset
p(X) :- surface(X), \+ ( touches(Y, X), \+ near(Y, X) ).
