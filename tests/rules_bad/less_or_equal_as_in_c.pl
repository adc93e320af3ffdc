% expect: 2:30: '<' means nothing here
p(X) :- distance(X, _, D), D <= 0.3.
