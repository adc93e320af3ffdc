% expect: 2:9: D is compared before it is bound
p(X) :- D < 0.3, distance(X, _, D).
