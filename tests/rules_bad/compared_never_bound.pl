% expect: 2:21: D is compared and never bound
p(X) :- surface(X), D < 0.3.
