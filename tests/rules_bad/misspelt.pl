% expect: 2:9: on_topof/2 is not defined
p(X) :- on_topof(X, floor).
