% expect: 2:5: the escape \q is not known
p('a\qb').
