% expect: 2:3: grammar rules are not in the subset
p --> q.
