% expect: 2:1: surface/1 belongs to the base facts
surface(cup).
