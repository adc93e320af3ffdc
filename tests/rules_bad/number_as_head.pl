% expect: 2:1: this is no head of a rule
3 :- surface(_).
