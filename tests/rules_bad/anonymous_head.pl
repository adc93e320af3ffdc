% expect: 2:3: _ in the head of a rule
p(_) :- surface(floor).
