% expect: 2:15: no rule file 'comonsense' is loaded
:- use_module(comonsense).
p(X) :- surface(X).
