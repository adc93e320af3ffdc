% expect: 2:9: left_of/2 is not defined
p(X) :- left_of(X, floor).
