:- module(amounts,
          [ length_text/2,              % +Metres, -Text
            volume_text/2,              % +CubicMetres, -Text
            number_text/2               % +Number, -Text
          ]).
:- use_module(words).

/** <module> Numbers as people say them

Rounded, with the units and the decimal mark of the language that is spoken. The exact numbers stand in the
evidence.
*/

%!  length_text(+Metres, -Text:string) is det.
%
%   Text is a length as people say it: centimetres below a metre, with at most one decimal.

length_text(N, Text) :-
    var(N),
    !,
    saying(some_distance, [], Text).
length_text(N, Text) :-
    (   abs(N) < 0.9995
    ->  Tenths is round(N * 1000),
        (   Tenths mod 10 =:= 0
        ->  Whole is Tenths // 10,
            format(string(Number), "~d", [Whole])
        ;   Centimetres is Tenths / 10.0,
            decimal("~1f", Centimetres, Number)
        ),
        saying(centimetres, [Number], Text)
    ;   decimal("~2f", N, Number),
        saying(metres, [Number], Text)
    ).

%!  volume_text(+CubicMetres, -Text:string) is det.
%
%   Text is a volume: cubic centimetres below a litre.

volume_text(N, Text) :-
    var(N),
    !,
    saying(some_room, [], Text).
volume_text(N, Text) :-
    (   abs(N) < 0.001
    ->  Cubic is N * 1000000,
        decimal("~0f", Cubic, Number),
        saying(cubic_centimetres, [Number], Text)
    ;   Litres is N * 1000,
        decimal("~1f", Litres, Number),
        saying(litres, [Number], Text)
    ).

%!  number_text(+Number, -Text:string) is det.
%
%   Text is a number that is no length, with at most six digits.

number_text(N, Text) :-
    Number is N,
    decimal("~6g", Number, Text).

decimal(Format, Number, Text) :-
    format(string(Plain), Format, [Number]),
    language(Words),
    Words:connective(decimal_mark, Mark),
    split_string(Plain, ".", "", Parts),
    atomic_list_concat(Parts, Mark, Atom),
    atom_string(Atom, Text).
