% expect: 2:3: X in a fact
p(X).
