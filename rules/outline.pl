:- module(outline,
          [ node_dict/2,                % +Node, -Dict
            print_proof/1               % +Node
          ]).
:- use_module(library(apply)).
:- use_module(library(lists), [member/2]).
:- use_module(axioms).
:- use_module(verbalise).
:- use_module(words).

/** <module> Proofs as outlines

The nodes of explain.pl as dicts for other renderers, with exact numbers, and as indented lines.
*/

%!  node_dict(+Node, -Dict) is det.
%
%   Dict is Node for other renderers: kind, predicate and arguments, sentence, margin (null where no length
%   is involved), axiom, rule file and line, whether the outline for people shows it, and children. Each
%   first reason has its sentence also as a clause that goes on after the conclusion: "it touches the wall".

node_dict(Node, Dict) :-
    Node = node(_, Goal, _, _, _),
    subject(Goal, Subject),
    node_dict(root, Node, Dict, Subject, _).

%   node_dict(+Place, +Node, -Dict, +Subject, -Next): Subject and Next are those of going_on/4 while Node and
%   what is below it may be first reasons, and else `none`.

node_dict(Place, Node, Dict, Subject, Next) :-
    Node = node(Kind, Goal, Margin, Clause, Children),
    (   shown(Node, Place) -> Shown = true ; Shown = false ),
    node_text(Node, Text),
    (   Place == inner, Shown == true, Subject \== none
    ->  going_on(Goal, node_text(Node, Said), Subject, Next),
        ( Said == Text -> SaidOn = null ; SaidOn = Said ),
        Below = none
    ;   SaidOn = null,
        ( Kind == negation -> Below = none, Next = Subject ; Below = Subject, Next = After )
    ),
    goal_parts(Goal, Functor, Args),
    atom_string(Functor, Name),
    (   number(Margin) -> Metres = Margin ; Metres = null ),
    goal_axiom(Goal, Axiom),
    clause_source(Clause, Rule),
    foldl(node_dict(inner), Children, Reasons, Below, After),
    Dict = _{ kind: Kind, predicate: Name, args: Args, text: Text, clause: SaidOn, margin: Metres,
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
    language(Words),
    Words:connective(axiom, Axiom),
    format(string(Text), "  [~w ~d]", [Axiom, Number]).
node_source(_, "").
