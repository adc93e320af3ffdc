% expect: 2:26: the order of terms is not in the subset
p(X) :- touches(X, Y), X @< Y.
