/** <module> JSON text of replies

A reply is made of

  - dicts, and json([Key = Value, ...]), which keeps the order of its keys;
  - lists, strings, integers and finite floats;
  - atoms: `true`, `false` and `null` are the constants, others text, so an id goes as a string;
  - term(Term): any term, typed as terms.py describes.
*/

:- module(json_text, [json_text/2]).

%   deepest(-Levels): nesting beyond this is refused, since readers of JSON recurse.

deepest(200).

%!  json_text(+Reply, -Text:string) is det.
%
%   @throws bridge(query, Message, []) if a value has no JSON text or is nested too deeply.

json_text(Reply, Text) :-
    deepest(Levels),
    with_output_to(string(Text), json(Reply, Levels)).

json(Value, _) :-
    var(Value),
    !,
    throw(bridge(query, "an unbound variable has no JSON text", [])).
json(Value, _) :-
    integer(Value),
    !,
    write(Value).
json(Value, _) :-
    string(Value),
    !,
    quoted(Value).
json(Value, _) :-
    atom(Value),
    !,
    (   memberchk(Value, [true, false, null])
    ->  write(Value)
    ;   quoted(Value)
    ).
json(Value, _) :-
    float(Value),
    float_class(Value, Class),
    \+ memberchk(Class, [infinite, nan]),
    !,
    write(Value).
json(term(Term), Levels) :-
    !,
    typed(Term, Levels).
json(Value, Levels) :-
    is_list(Value),
    !,
    inner(Levels, Inner),
    put_char('['),
    items(Value, Inner, '').
json(json(Fields), Levels) :-
    !,
    inner(Levels, Inner),
    put_char('{'),
    fields(Fields, Inner, '').
json(Value, Levels) :-
    is_dict(Value),
    !,
    dict_pairs(Value, _, Pairs),
    inner(Levels, Inner),
    put_char('{'),
    fields(Pairs, Inner, '').
json(Value, _) :-
    format(string(Message), "~p has no JSON text", [Value]),
    throw(bridge(query, Message, [])).

items([], _, _) :-
    put_char(']').
items([Value|Values], Levels, Separator) :-
    write(Separator),
    json(Value, Levels),
    items(Values, Levels, ',').

fields([], _, _) :-
    put_char('}').
fields([Field|Fields], Levels, Separator) :-
    ( Field = (Key = Value) ; Field = (Key-Value) ),
    !,
    write(Separator),
    quoted(Key),
    put_char(':'),
    json(Value, Levels),
    fields(Fields, Levels, ',').

inner(Levels, Inner) :-
    (   Levels > 0
    ->  Inner is Levels - 1
    ;   deepest(Most),
        format(string(Message), "the answer is nested more than ~d deep", [Most]),
        throw(bridge(query, Message, []))
    ).


                 /*******************************
                 *            TERMS             *
                 *******************************/

typed(Term, _) :-
    var(Term),
    !,
    format(string(Name), "~w", [Term]),
    tagged(v, Name).
typed('$variable'(Name), _) :-
    !,
    tagged(v, Name).
typed(Term, _) :-
    integer(Term),
    !,
    (   abs(Term) < 1<<60
    ->  write(Term)
    ;   format(string(Digits), "~16r", [Term]),
        tagged(i, Digits)
    ).
typed(Term, _) :-
    string(Term),
    !,
    quoted(Term).
typed(Term, _) :-
    atom(Term),                 % [] is not one
    !,
    tagged(a, Term).
typed(Term, _) :-
    float(Term),
    !,
    float_class(Term, Class),
    (   Class == nan
    ->  tagged(f, nan)
    ;   Class == infinite
    ->  (   Term > 0
        ->  tagged(f, inf)
        ;   tagged(f, '-inf')
        )
    ;   write(Term)
    ).
typed(Term, _) :-
    rational(Term, Over, Under),
    !,
    format("[\"r\",\"~16r\",\"~16r\"]", [Over, Under]).
typed(Term, Levels) :-
    is_list(Term),
    !,
    inner(Levels, Inner),
    write('["l"'),
    typed_items(Term, Inner).
typed(Term, Levels) :-
    compound(Term),
    !,
    inner(Levels, Inner),
    compound_name_arguments(Term, Name, Arguments),
    write('["c",'),
    quoted(Name),
    typed_items(Arguments, Inner).
typed(Term, _) :-               % a stream or another handle: known by what is printed of it
    format(string(Text), "~w", [Term]),
    tagged(a, Text).

typed_items([], _) :-
    put_char(']').
typed_items([Term|Terms], Levels) :-
    put_char(','),
    typed(Term, Levels),
    typed_items(Terms, Levels).

tagged(Tag, Text) :-
    format("[\"~w\",", [Tag]),
    quoted(Text),
    put_char(']').


                 /*******************************
                 *             TEXT             *
                 *******************************/

quoted(Text) :-
    put_char('"'),
    (   plain(Text)
    ->  write(Text)
    ;   string_codes(Text, Codes),
        escape(Codes)
    ),
    put_char('"').

%   A NUL would end the list of separators in 9.0.4, so it is looked for by itself.

plain(Text) :-
    escaped_characters(Escaped),
    split_string(Text, Escaped, "", [_]),
    \+ sub_string(Text, _, _, _, "\x0\").

escape([]).
escape([Code|Codes]) :-
    (   memberchk(Code, [0'", 0'\\])
    ->  put_char(\),
        put_code(Code)
    ;   Code < 0x20
    ->  format("\\u~|~`0t~16r~4+", [Code])
    ;   put_code(Code)
    ),
    escape(Codes).

escaped_characters("\"\\\x1\\x2\\x3\\x4\\x5\\x6\\x7\\x8\\x9\\xa\\xb\\xc\\xd\\xe\\xf\\c
                    \x10\\x11\\x12\\x13\\x14\\x15\\x16\\x17\\x18\\x19\\x1a\\x1b\\x1c\\x1d\\x1e\\x1f\").
