% expect: 2:9: zzz/1 is not defined
p(X) :- zzz(X).
