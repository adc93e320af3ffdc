% expect: 3:4: module/2 is not the first term
p(X) :- surface(X).
:- module(mine, [p/1]).
