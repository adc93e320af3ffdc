% expect: 2:1: terms are nested more than 60 deep
p(X) :- distance(X, _, D), D < - - - - - - - - - - - - - - - - - - - - - - - - - - - - - - - - - - - - - - - - - - - - - - - - - - - - - - - - - - - - - - - - - - - - - - - - - - - - - - - - 1.
