% expect: 2:1: rainy has no argument
rainy :- surface(_).
