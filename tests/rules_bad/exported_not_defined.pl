% expect: 4:1: q/2 is exported and not defined
:- module(mine, [p/1, q/2]).
:- use_module(facts).
p(X) :- surface(X).
