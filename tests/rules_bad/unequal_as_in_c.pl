% expect: 2:26: '!' is not expected here
p(X) :- touches(X, Y), X != Y.
