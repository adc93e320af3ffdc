% expect: 2:18: argument 2 of label/3 is a string here and a name elsewhere
p(X) :- label(X, "cup", _).
