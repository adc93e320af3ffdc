% expect: 2:1: a predicate has at most 16 arguments
p(a, a, a, a, a, a, a, a, a, a, a, a, a, a, a, a, a).
