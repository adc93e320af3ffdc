% expect: 2:20: Singleton variable Other
p(X) :- touches(X, Other).
