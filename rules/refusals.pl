:- module(refusals,
          [ hindrance/2,                % +Goal, -Text
            obstacles/3,                % +Node, +Subject, -Texts
            fails/1                     % +Node
          ]).
:- use_module(library(lists), [append/3, member/2, min_list/2, same_length/2]).
:- use_module(library(pairs)).
:- use_module(library(apply)).
:- use_module(facts).
:- use_module(axioms).
:- use_module(direction, []).
:- use_module(naming).
:- use_module(verbalise).
:- use_module(words).

/** <module> Why something does not hold, in words

What keeps a relation from being stated at all, and what fails in the derivation that comes closest. The
sentences are those of verbalise.pl.
*/

%!  hindrance(+Goal, -Text) is semidet.
%
%   Text says what keeps a relation from being stated at all, whatever was measured: the order of figure and
%   reference, a view that stands too close, things out of each other's reach.

hindrance(Goal, Text) :-
    functor(Goal, Name, Arity),
    once(( relation(Name/Arity) ; base(Name/Arity) )),
    Goal =.. [Name, Figure, Reference|Views],
    atom(Figure),
    atom(Reference),
    Figure \== Reference,
    (   one_way(Name/Arity),
        wrong_way(Figure, Reference)
    ->  hindrance_text(order(Figure, Reference), Text)
    ;   Views = [View],
        withheld(Reference, View, Reason)
    ->  hindrance_text(withheld(Reference, View, Reason), Text)
    ;   \+ pair(Figure, Reference, _, _, _, _, _, _, _)
    ->  hindrance_text(apart(Figure, Reference), Text)
    ;   atom_concat(Side, '_s', Name),
        atom_concat(Side, '_r', Relaxed),
        Weaker =.. [Relaxed, Figure, Reference],
        \+ direction:Weaker
    ->  denied_text(Weaker, Text)
    ).

%   one_way(+Predicate): it is concluded in figure-reference order only.

one_way(Predicate) :- relation(Predicate), !.
one_way(Name/2) :-
    member(Side, [east, west, north, south]),
    atom_concat(Side, _, Name),
    !.

%   wrong_way(+Figure, +Reference): people say where Reference is by Figure, however far apart the two are.

wrong_way(Figure, Reference) :-
    figure_reference(Reference, Figure),
    !,
    \+ figure_reference(Figure, Reference).
wrong_way(Figure, Reference) :-
    \+ pair(Figure, Reference, _, _, _, _, _, _, _),
    \+ surface(Reference),
    (   surface(Figure)
    ->  true
    ;   facts:box_volume(Figure, Larger),
        facts:box_volume(Reference, Smaller),
        Larger > Smaller
    ).

hindrance_text(What, Text) :-
    language(Words),
    Words:hindered(What, Template),
    template_text(Template, yes, Text).

%!  obstacles(+Node, +Subject, -Texts:list) is det.
%
%   Texts say what keeps the derivation Node from holding: each of its parts that fails. Subject is what they go
%   on about, or `none`.

obstacles(node(_, Goal, _, Clause, Children), Subject, Texts) :-
    (   lacking(Goal, Clause, Children, Lacking, Others)
    ->  include(fails, Others, Failing),
        append(Failing, [Lacking], Told)
    ;   include(fails, Children, Told)
    ),
    foldl(obstacle_clause, Told, Texts, Subject, _).

obstacle_clause(Child, Text, Subject, Next) :-
    ( witnessed(Child, Told) -> true ; Told = Child ),
    Told = node(_, Goal, _, _, _),
    going_on(Goal, obstacle(Child, Text), Subject, Next).

%   lacking(+Goal, +Clause, +Children, -Lacking, -Others): goals of Clause ask for something that the head does not
%   name, and the language says that there is nothing of the kind. What came closest is named then, as one of many:
%   that this one fails is no reason by itself. Others are the other children.

lacking(Goal, Clause, Children, node(lacking, Sought, Margin, none, [Template, Witness]), Others) :-
    Clause \== none,
    clause(Qualified, Body, Clause),
    strip_module(Qualified, Module, Goal),
    conjuncts(Body, Goals),
    same_length(Goals, Children),
    term_variables(Goals, Open),
    pairs_keys_values(Pairs, Goals, Children),
    language(Words),
    member(Variable, Open),
    partition(speaks_of(Variable), Pairs, Asking, Rest),
    pairs_keys_values(Asking, Asked, Nodes),
    conjuncts(Sought, Asked),
    Words:none(Sought, Template),
    \+ call(Module:Sought),
    !,
    include(fails, Nodes, Failing),
    maplist(node_margin, Failing, Margins),
    maplist(number, Margins),
    min_list(Margins, Margin),
    witness_of(Variable, Asking, Witness),
    pairs_values(Rest, Others).

conjuncts(Goal, [Goal]) :- Goal \= (_, _), !.
conjuncts((Goal, Conjunction), [Goal|Goals]) :- conjuncts(Conjunction, Goals).

node_margin(node(_, _, Margin, _, _), Margin).

speaks_of(Variable, Goal-_) :-
    term_variables(Goal, Variables),
    member(Other, Variables),
    Other == Variable,
    !.

%   witness_of(+Variable, +Asking, -Thing): what the derivation has in the place of Variable.

witness_of(Variable, Asking, Thing) :-
    member(Goal-node(_, Found, _, _, _), Asking),
    arg(Place, Goal, Argument),
    Argument == Variable,
    arg(Place, Found, Thing),
    atom(Thing),
    spatial_obj(Thing),
    !.

%!  fails(+Node) is semidet.
%
%   Node does not hold: by the sign of its margin; at a bound, where that is zero, by what it consists of.

fails(node(_, _, Margin, _, _)) :-
    number(Margin),
    Margin =\= 0,
    !,
    Margin < 0.
fails(node(_, _, minus_inf, _, _)) :- !.
fails(node(comparison, Marked, Margin, _, _)) :-
    number(Margin),
    !,
    plain(Marked, Goal),
    \+ call(Goal).
fails(node(negation, _, _, _, [Miss])) :-
    !,
    \+ fails(Miss).
fails(node(_, _, Margin, _, Children)) :-
    number(Margin),
    member(Child, Children),
    fails(Child),
    !.

%   Of a denial what refutes it is named; of a rule or fact, that it does not hold.

obstacle(Node, Text) :-
    witnessed(Node, Witness),
    !,
    node_text(Witness, Text).
obstacle(node(lacking, _, Margin, _, [Template, Witness]), Text) :-
    !,
    template_text(Template, yes, Core),
    thing_name(Witness, Name),
    short_text(Margin, Short),
    saying(closest, [Name, Short], Tail),
    string_concat(Core, Tail, Text).
obstacle(node(comparison, Goal, Margin, _, _), Text) :-
    !,
    comparison_text(Goal, Margin, Text).
obstacle(node(_, Goal, Margin, _, _), Text) :-
    denied_text(Goal, Core),
    (   number(Margin)
    ->  short_text(Margin, Short),
        saying(aside, [Short], Tail),
        string_concat(Core, Tail, Text)
    ;   Text = Core
    ).

witnessed(node(negation, _, _, _, [Miss]), Witness) :-
    (   Miss = node(conjunction, _, _, _, [Witness|_])
    ->  true
    ;   Witness = Miss
    ).
