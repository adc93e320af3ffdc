% expect: 4:25: touches/2 is not imported
:- module(mine, [p/1]).
:- use_module(facts).
p(X) :- spatial_obj(X), touches(X, floor).
