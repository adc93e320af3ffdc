% expect: 4:1: clauses of p/1 are not together
p(a).
q(a).
p(b).
