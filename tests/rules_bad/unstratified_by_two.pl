% expect: 2:24: p/1 rests on its own denial: p/1 needs q/1 needs r/1 needs p/1
p(X) :- surface(X), \+ q(X).
q(X) :- near(X, Y), r(Y).
r(X) :- p(X).
