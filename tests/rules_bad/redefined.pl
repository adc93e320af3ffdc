% expect: 2:1: touches/2 belongs to the theory, in topology.pl
touches(cup, table).
