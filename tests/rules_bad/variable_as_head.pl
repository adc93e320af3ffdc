% expect: 2:1: this is no head of a rule
X :- surface(X).
