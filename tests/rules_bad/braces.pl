% expect: 2:9: '{}' is not in the subset
p(X) :- { surface(X) }.
