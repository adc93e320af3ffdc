% expect: 2:3: the quote is not closed
p('cup) :- surface(floor).
q(X) :- surface(X).
