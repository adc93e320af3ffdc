% expect: 2:3: _X stands more than once
p(_X) :- surface(_X).
