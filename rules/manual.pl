:- module(manual,
          [ manual/1,                   % +Predicate
            predicate_says/2            % +Predicate, -Text
          ]).
:- use_module(library(lists)).
:- use_module(library(readutil)).

/** <module> The rule files as their own manual

The comment in front of a predicate and its clauses, as they stand in the rule files that are loaded.
*/

%!  manual(+Predicate) is semidet.
%
%   Print what the rule files say of Predicate, a Name or Name/Arity; fail where they say nothing.

manual(Predicate) :-
    (   Predicate = Name/Arity -> true ; Predicate = Name ),
    atom(Name),
    findall(Name/Arity-Entry, entry(Name/Arity, Entry), Found),
    Found \== [],
    forall(member(One-Entry, Found), print_entry(One, Entry)).

print_entry(Name/Arity, entry(File, Comment, Clauses)) :-
    file_base_name(File, Base),
    (   axioms:axiom(Name/Arity, Number)
    ->  format("~q  (axiom ~d, ~w)~n~n", [Name/Arity, Number, Base])
    ;   format("~q  (~w)~n~n", [Name/Arity, Base])
    ),
    print_comment(Comment),
    forall(member(Clause, Clauses), format("~w~n", [Clause])),
    nl.

print_comment(Comment) :-
    forall(member(Line, Comment), format("~w~n", [Line])),
    nl.

%!  predicate_says(+Predicate, -Text) is semidet.
%
%   Text is the first sentence of the comment on Predicate, without the axiom's number.

predicate_says(Predicate, Text) :-
    once(entry(Predicate, entry(_, [_|Lines], _))),
    exclude_blank(Lines, Said),
    atomic_list_concat(Said, ' ', Whole),
    (   sub_atom(Whole, 0, _, _, 'Axiom'),
        sub_atom(Whole, Before, 2, After0, '. ')
    ->  Start is Before + 2,
        sub_atom(Whole, Start, _, 0, Rest),
        After0 >= 0
    ;   Rest = Whole
    ),
    (   sub_atom(Rest, End, 2, _, '. ')
    ->  Length is End + 1,
        sub_atom(Rest, 0, Length, _, Text)
    ;   Text = Rest
    ).

exclude_blank(Lines, Said) :-
    findall(Line, ( member(Line, Lines), Line \== '' ), Said).

%   entry(?Name/?Arity, -Entry): the predicates that some rule file documents.

entry(Name/Arity, entry(File, Comment, Clauses)) :-
    module_property(facts, file(Facts)),
    file_directory_name(Facts, Directory),
    source_file(File),
    (   file_directory_name(File, Directory) -> true ; \+ module_file(File) ; knowledge(File) ),
    read_file_to_string(File, Text, [encoding(utf8)]),
    split_string(Text, "\n", "", Lines),
    documented(Lines, Name, Arity, Comment),
    findall(Clause, clause_text(File, Text, Name/Arity, Clause), Clauses).

module_file(File) :- module_property(_, file(File)).

knowledge(File) :- module_property(background, file(File)).

%   documented(+Lines, ?Name, ?Arity, -Comment): a comment that begins with %! and a head.

documented(Lines, Name, Arity, Comment) :-
    append(_, [First|Rest], Lines),
    string_concat("%!", Mode0, First),
    split_string(Mode0, "", " ", [Mode]),
    head(Mode, Name, Arity),
    comment_lines(Rest, More),
    atom_string(Top, Mode),
    Comment = [Top|More].

%   head(+Mode, ?Name, -Arity): Mode is as in `pair(?Figure, ?Reference) is nondet.`

head(Mode, Name, Arity) :-
    split_string(Mode, "(", " :", [Name0, Rest0|_]),
    !,
    split_string(Rest0, ")", "", [Arguments|_]),
    split_string(Arguments, ",", "", Parts),
    length(Parts, Arity),
    atom_string(Name, Name0).
head(Mode, Name, 0) :-
    split_string(Mode, " ", ".", [Name0|_]),
    atom_string(Name, Name0).

comment_lines([Line|Lines], [Text|More]) :-
    string_concat("%", Rest, Line),
    \+ sub_string(Rest, 0, _, _, "!"),
    !,
    (   string_concat("   ", Text0, Rest) -> true ; Text0 = Rest ),
    atom_string(Text, Text0),
    comment_lines(Lines, More).
comment_lines(_, []).

%   clause_text(+File, +Text, +Predicate, -Clause): the clauses as they are written.

clause_text(File, Text, Predicate, Clause) :-
    setup_call_cleanup(
        open(File, read, Stream, [encoding(utf8)]),
        findall(Start-End-Term, written(Stream, Start, End, Term), Found),
        close(Stream)),
    member(Start-End-Term, Found),
    defines(Term, Predicate),
    Length is End - Start,
    sub_string(Text, Start, Length, _, Clause).

written(Stream, Start, End, Term) :-
    repeat,
    read_term(Stream, Read, [term_position(Position)]),
    (   Read == end_of_file
    ->  !,
        fail
    ;   Term = Read,
        stream_position_data(char_count, Position, Start),
        character_count(Stream, End)
    ).

defines((Head :- _), Name/Arity) :- !, callable(Head), functor(Head, Name, Arity).
defines((:- _), _) :- !, fail.
defines(Head, Name/Arity) :- functor(Head, Name, Arity).
