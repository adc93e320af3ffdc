:- module(verbalise,
          [ node_text/2,                % +Node, -Text
            node_dict/2,                % +Node, -Dict
            hindrance/2,                % +Goal, -Text
            obstacles/2,                % +Node, -Texts
            denied_text/2,              % +Goal, -Text
            print_proof/1,              % +Node
            length_text/2               % +Metres, -Text
          ]).
:- use_module(library(lists)).
:- use_module(library(apply)).
:- use_module(facts).
:- use_module(axioms).
:- use_module(naming).
:- use_module(lang/en).

/** <module> Proofs in words

Turns the nodes of explain.pl into sentences by the templates of a language, and into dicts for other
renderers. Numbers are rounded for people in the sentences and exact in the dicts.
*/

%!  node_text(+Node, -Text:string) is det.
%
%   Text says what Node says, in one sentence without its reasons.

node_text(node(negation, \+ Goal, _, _, Near), Text) :-
    !,
    negation_text(Goal, Core),
    near_text(Goal, Near, Tail),
    string_concat(Core, Tail, Text).
node_text(node(comparison, Goal, Margin, _, _), Text) :-
    !,
    comparison_text(Goal, Margin, Text).
node_text(node(_, Goal, _, _, _), Text) :-
    goal_text(Goal, yes, Text).

%   goal_text(+Goal, +Polarity, -Text): by template, else as it stands.

goal_text((A, B), Polarity, Text) :-
    !,
    goal_text(A, Polarity, TextA),
    goal_text(B, Polarity, TextB),
    connective(and, And),
    join([TextA, And, TextB], Text).
goal_text(A \== B, Polarity, Text) :-
    !,
    goal_text_items([the(A), is, 'other than', the(B)], Polarity, Text).
goal_text(Marked, no, Text) :-
    term_variables(Marked, [_|_]),
    !,
    goal_text(Marked, yes, Core),
    connective(no_way, Not),
    join([Not, Core], Text).
goal_text(Marked, Polarity, Text) :-
    plain(Marked, Goal),
    (   sentence(Goal, Template)
    ->  goal_text_items(Template, Polarity, Text)
    ;   format(string(Core), "~W", [Goal, [quoted(true), numbervars(true), max_depth(20)]]),
        (   Polarity == yes
        ->  Text = Core
        ;   connective(no_way, Not),
            join([Not, Core], Text)
        )
    ).

goal_text_items(Template, Polarity, Text) :-
    (   memberchk(view(View), Template), nonvar(View)
    ->  Said = View
    ;   Said = unsaid
    ),
    maplist(item_text(Polarity, Said), Template, Words),
    join(Words, Text).

item_text(_, Said, the(X), Text) :- !, the(X, Said, Text).
item_text(yes, _, is, "is") :- !.
item_text(no, _, is, "is not") :- !.
item_text(yes, _, v(Yes, _), Yes) :- !.
item_text(no, _, v(_, No), No) :- !.
item_text(_, _, metres(N), Text) :- !, length_text(N, Text).
item_text(_, _, cubic_metres(N), Text) :- !, volume_text(N, Text).
item_text(_, _, view(V), Text) :- !, view_text(V, Text).
item_text(_, _, name(X), Text) :- !, ( var(X) -> Text = "something" ; Text = X ).
item_text(_, _, Word, Word).

%   the(+Thing, +Said, -Text): Said is the view that the sentence speaks of, or `unsaid`.

the(X, _, "something") :- var(X), !.
the(X, unsaid, Text) :- !, thing_name(X, Text).
the(X, Said, Text) :- thing_name(X, Said, Text).

%!  length_text(+Metres, -Text:string) is det.
%
%   Text is a length as people say it: centimetres below a metre, with at most one decimal.

length_text(N, "some distance") :- var(N), !.
length_text(N, Text) :-
    (   abs(N) < 0.9995
    ->  Tenths is round(N * 1000),
        Whole is Tenths // 10,
        (   Tenths mod 10 =:= 0
        ->  format(string(Text), "~d cm", [Whole])
        ;   Centimetres is Tenths / 10.0,
            format(string(Text), "~1f cm", [Centimetres])
        )
    ;   format(string(Text), "~2f m", [N])
    ).

volume_text(N, "some room") :- var(N), !.
volume_text(N, Text) :-
    (   abs(N) < 0.001
    ->  Cubic is N * 1000000,
        format(string(Text), "~0f cubic centimetres", [Cubic])
    ;   Litres is N * 1000,
        format(string(Text), "~1f litres", [Litres])
    ).

negation_text((Goal, Other \== Exception), Text) :-
    var(Other),
    no_other(Goal, Exception, Template),
    !,
    goal_text_items(Template, yes, Text).
negation_text(Goal, Text) :-
    term_variables(Goal, [_|_]),
    none(Goal, Template),
    !,
    goal_text_items(Template, yes, Text).
negation_text(Goal, Text) :-
    goal_text(Goal, no, Text).

%   near_text(+Goal, +Near, -Tail): the witness of a negation is what came closest to refuting it.

near_text(_, [], "") :- !.
near_text(Goal, [node(_, Found, Margin, _, _)], Tail) :-
    number(Margin),
    copy_term(Goal, Copy),
    term_variables(Copy, Variables),
    plain(Found, Copy),
    include(spatial, Variables, Objects),
    Objects = [Object|_],
    !,
    the(Object, unsaid, Name),
    short_text(Margin, Short),
    connective(closest, Closest),
    format(string(Tail), " (~w ~w, ~w)", [Closest, Name, Short]).
near_text(_, [node(_, _, Margin, _, _)], Tail) :-
    number(Margin),
    !,
    short_text(Margin, Short),
    format(string(Tail), " (~w)", [Short]).
near_text(_, _, "").

spatial(X) :- atom(X), spatial_obj(X).

short_text(Margin, Text) :-
    By is -Margin,
    length_text(By, Length),
    connective(short_by, Short),
    join([Short, Length], Text).

comparison_text(A \== B, _, Text) :-
    !,
    goal_text(A \== B, yes, Text).
comparison_text(Marked, Margin, Text) :-
    plain(Marked, Goal),
    Goal =.. [Op, A0, B0],
    A is A0,
    B is B0,
    operator(Op, Name),
    connective(Name, Words),
    (   number(Margin)
    ->  length_text(A, X),
        length_text(B, Y),
        (   Margin < 0
        ->  short_text(Margin, Tail)
        ;   length_text(Margin, Length),
            connective(to_spare, Spare),
            join([Length, Spare], Tail)
        ),
        format(string(Text), "~w is ~w ~w (~w)", [X, Words, Y, Tail])
    ;   format(string(Text), "~6g is ~w ~6g", [A, Words, B])
    ).

operator(=<, at_most).
operator(<, less).
operator(>=, at_least).
operator(>, more).
operator(=:=, equal).
operator(=\=, unequal).

join(Words, Text) :-
    atomic_list_concat(Words, ' ', Atom),
    atom_string(Atom, Text).

%!  hindrance(+Goal, -Text:string) is semidet.
%
%   Text says what keeps a relation from being stated at all, whatever was measured: the order of figure and
%   reference, a view that stands too close, things out of each other's reach.

hindrance(Goal, Text) :-
    functor(Goal, Name, Arity),
    relation(Name/Arity),
    Goal =.. [Name, Figure, Reference|View],
    atom(Figure),
    atom(Reference),
    (   \+ figure_reference(Figure, Reference),
        figure_reference(Reference, Figure)
    ->  hindrance_text(order(Figure, Reference), Text)
    ;   View = [V],
        withheld(Reference, V, Reason)
    ->  atom_string(Reason, Text)
    ;   \+ pair(Figure, Reference, _, _, _, _, _, _, _),
        Figure \== Reference
    ->  hindrance_text(apart(Figure, Reference), Text)
    ).

%!  obstacles(+Node, -Texts:list) is det.
%
%   Texts say what keeps the derivation Node from holding: each of its parts that fails.

obstacles(node(_, _, _, _, Children), Texts) :-
    findall(Text, ( member(Child, Children), fails(Child), obstacle(Child, Text) ), Texts).

fails(node(_, _, Margin, _, _)) :-
    (   number(Margin)
    ->  Margin < 0
    ;   Margin == minus_inf
    ).

%   Of a denial what refutes it is named; of a rule or fact, that it does not hold.

obstacle(node(negation, _, _, _, [Miss]), Text) :-
    !,
    witness(Miss, Witness),
    node_text(Witness, Text).
obstacle(node(comparison, Goal, Margin, _, _), Text) :-
    !,
    comparison_text(Goal, Margin, Text).
obstacle(node(_, Goal, Margin, _, _), Text) :-
    goal_text(Goal, no, Core),
    (   number(Margin)
    ->  short_text(Margin, Short),
        format(string(Text), "~s (~s)", [Core, Short])
    ;   Text = Core
    ).

witness(node(conjunction, _, _, _, [First|_]), First) :- !.
witness(Miss, Miss).

%!  denied_text(+Goal, -Text:string) is det.
%
%   Text says that Goal does not hold.

denied_text(Goal, Text) :-
    goal_text(Goal, no, Text).

hindrance_text(What, Text) :-
    hindered(What, Template),
    goal_text_items(Template, yes, Text).

%   plain(+Marked, -Goal): numbers without the mark that they are no lengths.

plain(X, X) :- var(X), !.
plain(no_length(N), N) :- !.
plain(X, Y) :-
    compound(X),
    !,
    X =.. [F|Args],
    maplist(plain, Args, Plain),
    Y =.. [F|Plain].
plain(X, X).

%!  node_dict(+Node, -Dict) is det.
%
%   Dict is Node for other renderers: kind, predicate and arguments, sentence, margin (null where no length
%   is involved), axiom, rule file and line, whether the outline for people shows it, and children.

node_dict(Node, Dict) :-
    node_dict(Node, root, Dict).

node_dict(Node, Place, Dict) :-
    Node = node(Kind, Goal, Margin, Clause, Children),
    (   shown(Node, Place) -> Shown = true ; Shown = false ),
    node_text(Node, Text),
    goal_parts(Goal, Functor, Args),
    atom_string(Functor, Name),
    (   number(Margin) -> Metres = Margin ; Metres = null ),
    goal_axiom(Goal, Axiom),
    clause_source(Clause, Rule),
    findall(Reason, ( member(Child, Children), node_dict(Child, inner, Reason) ), Reasons),
    Dict = _{ kind: Kind, predicate: Name, args: Args, text: Text, margin: Metres,
              axiom: Axiom, rule: Rule, shown: Shown, children: Reasons }.

goal_parts(\+ Goal, Name, Args) :- !, goal_parts(Goal, Name, Args).
goal_parts((A, _), Name, Args) :- !, goal_parts(A, Name, Args).
goal_parts(Goal, Name, Args) :-
    plain(Goal, Plain),
    Plain =.. [Name|Terms],
    maplist(part, Terms, Args).

part(X, null) :- var(X), !.
part(X, X) :- number(X), !.
part(X, Y) :- atom(X), !, atom_string(X, Y).   % a string: an object may be called null
part(X, Y) :- ground(X), catch(Y is X, _, fail), !.
part(X, Y) :- term_string(X, Y).

goal_axiom(\+ _, null) :- !.
goal_axiom(Goal, Number) :-
    functor(Goal, Name, Arity),
    (   axiom(Name/Arity, Number)
    ->  true
    ;   Number = null
    ).

clause_source(none, null) :- !.
clause_source(Clause, _{ file: Name, line: Line }) :-
    clause_property(Clause, file(File)),
    clause_property(Clause, line_count(Line)),
    file_base_name(File, Name),
    !.
clause_source(_, null).

%!  print_proof(+Node) is det.
%
%   Print Node and its reasons, one a line, indented; only what is shown/2.

print_proof(Node) :-
    print_proof(Node, root, 0).

print_proof(Node, Place, Depth) :-
    Node = node(_, _, _, _, Children),
    (   shown(Node, Place)
    ->  node_text(Node, Text),
        node_source(Node, Source),
        forall(between(1, Depth, _), write('  ')),
        format("~w~w~n", [Text, Source]),
        Next is Depth + 1
    ;   Next = Depth
    ),
    (   Node = node(negation, _, _, _, _)
    ->  true
    ;   forall(member(Child, Children), print_proof(Child, inner, Next))
    ).

%   shown(+Node, +Place): whether a person needs the line. Thresholds and comparisons with zero are said by
%   the line above them, and a step that only renames its single reason by that reason.

shown(_, root) :- !.
shown(node(Kind, Goal, _, _, Children), _) :-
    \+ silent(Kind, Goal),
    \+ ( Kind == rule,
         exclude(silent_node, Children, [node(rule, _, _, _, _)])
       ).

silent_node(node(Kind, Goal, _, _, _)) :- silent(Kind, Goal).

silent(negation, \+ ( label(_, _, _), _ > _ )).
silent(fact, threshold(_, _)).
silent(fact, viewpoint(_)).
silent(fact, pair(_, _, _, _, _, _, _, _, _)).
silent(fact, aspect(_, _, _, _, _, _, _)).
silent(fact, strict(_, _, _, _, _)).
silent(comparison, _ >= Zero) :- Zero == 0.

node_source(node(rule, Goal, _, _, _), Text) :-
    goal_axiom(Goal, Number),
    integer(Number),
    !,
    format(string(Text), "  [axiom ~d]", [Number]).
node_source(_, "").
