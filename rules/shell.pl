:- module(shell,
          [ objects/0,
            axioms/0,
            view/1,                     % ?View
            why_not/1,                  % :Goal
            help/1                      % +Name
          ]).
:- use_module(library(aggregate)).
:- use_module(library(apply)).
:- use_module(library(lists)).
:- use_module(library(yall)).
:- use_module(guess).
:- use_module(manual).

/** <module> The Prolog shell of a scene

Started by `deixis shell`: the arguments are two files with lists of base facts, which are deleted once they are
read, the rule files, and the predicates to table. Afterwards this is SWI-Prolog as it always is, with a few
commands more:

  | objects         | what is in the scene                                                   |
  | axioms          | the axioms of the theory                                               |
  | help(on_top_of) | the axiom, what it says, and its rule                                  |
  | why(Goal)       | why it holds, or how far it is from holding                            |
  | why_not(Goal)   | the derivation that comes closest                                      |
  | contrast(A, B)  | why A holds rather than B                                              |
  | view(v1)        | look from v1: left_of(X, Y) now means left_of(X, Y, v1); view(V) tells |

A name that nothing has is answered with what may have been meant.
*/

:- meta_predicate why_not(0).

:- dynamic looking_from/1.

:- multifile user:expand_query/4, user:violation/2, user:violation/3, user:says/3.
:- dynamic user:expand_query/4.

%   start: load the facts and the rule files given as arguments, and print what is there.

start :-
    current_prolog_flag(argv, Argv),
    append(_, [--, OfPairs, OfViews|Rest], [--|Argv]),
    !,
    partition([Argument]>>sub_atom(Argument, 0, _, _, 'table:'), Rest, Tables, RuleFiles),
    load_files(user:RuleFiles, [if(not_loaded), must_be_module(false)]),
    forall(member(Table, Tables), keep_answers(Table)),
    % No predicate is in both: so each has its facts in their order.
    thread_create(load_facts(OfViews), Other),
    load_facts(OfPairs),
    thread_join(Other),
    forall(facts:viewpoint(View), assertz(looking_from(View))),
    banner,
    thread_create(index_pairs, _, [detached(true)]).

%   load_facts(+File): lists, one after the other; a single one of all facts would need much more memory. The file
%   is deleted.

load_facts(File) :-
    setup_call_cleanup(
        open(File, read, Stream, [encoding(utf8)]),
        load_lists(Stream),
        ( close(Stream), delete_file(File) )).

load_lists(Stream) :-
    repeat,
    read_term(Stream, Facts, []),
    (   Facts == end_of_file
    ->  !
    ;   maplist(add_fact, Facts),
        fail
    ).

add_fact(Fact) :- assertz(facts:Fact).

%   index_pairs: SWI-Prolog indexes facts when they are first looked for, which takes a moment for a million.

index_pairs :-
    ignore(facts:pair('', _, _, _, _, _, _, _, _)),
    ignore(facts:pair(_, '', _, _, _, _, _, _, _)),
    ignore(facts:figure_reference('', _)),
    ignore(facts:figure_reference(_, '')).

%   keep_answers(+Argument): the argument table:Arity:Name asks for tables, so that recursion ends.

keep_answers(Argument) :-
    atomic_list_concat([table, Number|Parts], :, Argument),
    atom_number(Number, Arity),
    atomic_list_concat(Parts, :, Name),
    functor(Head, Name, Arity),
    forall(( current_module(Module),
             module_property(Module, class(user)),
             current_predicate(Module:Name/Arity),
             \+ predicate_property(Module:Head, imported_from(_))
           ),
           table(Module:Name/Arity)).

banner :-
    aggregate_all(count, facts:surface(_), Surfaces),
    aggregate_all(count, facts:spatial_obj(_), Things),
    aggregate_all(count, facts:viewpoint(_), Views),
    aggregate_all(count, facts:pair(_, _, _, _, _, _, _, _, _), Pairs),
    Objects is Things - Surfaces,
    relations(Pairs, Relations),
    format("Deixis: ~D objects, ~D surfaces, ~D views, ~w, ~D measured pairs.~n",
           [Objects, Surfaces, Views, Relations, Pairs]),
    format("Ask:    on_top_of(X, Y).   why(on_top_of(X, Y)).   help(on_top_of).   objects.   axioms.   halt.~n"),
    (   looking_from(View)
    ->  format("View:   ~q; left_of(X, Y) is as seen from there, view(V) changes it.~n~n", [View])
    ;   nl
    ).

%   relations(+Pairs, -Text): how many relations hold, where counting them takes no time to speak of.

relations(Pairs, "relations not counted") :- Pairs > 5000, !.
relations(_, Text) :-
    findall(Goal,
            ( axioms:relation(Name/Arity), functor(Goal, Name, Arity), user:Goal ),
            Found0),
    sort(Found0, Found),
    length(Found, Count),
    format(string(Text), "~D relations", [Count]).

%!  objects is det.
%
%   Print the objects and surfaces of the scene with their labels, at most 100.

objects :-
    findall(Thing, facts:spatial_obj(Thing), Things),
    length(Things, Count),
    forall(( nth1(N, Things, Thing), N =< 100 ), object_line(Thing)),
    (   Count > 100
    ->  Rest is Count - 100,
        format("... and ~D more: spatial_obj(X) finds them.~n", [Rest])
    ;   true
    ).

object_line(Thing) :-
    (   facts:label(Thing, Label, _) -> true ; Label = '' ),
    (   facts:surface(Thing) -> Kind = surface ; Kind = '' ),
    format("~q~t~24| ~w~t~48| ~w~n", [Thing, Label, Kind]).

%!  axioms is det.
%
%   Print the axioms of the theory: number, predicate, and what it says.

axioms :-
    forall(( axioms:axiom(Name/Arity, Number), predicate_says(Name/Arity, Says) ),
           format("~t~d~3|  ~w~t~24|~w~n", [Number, Name/Arity, Says])).

%!  view(?View) is semidet.
%
%   Look from View: relations that depend on the view, given without one, are as seen from there. Unbound, View
%   is the present one; at first it is the scene's first.

view(View) :-
    var(View),
    !,
    once(looking_from(View)).
view(View) :-
    facts:viewpoint(View),
    !,
    retractall(looking_from(_)),
    assertz(looking_from(View)).
view(View) :-
    findall(Known, facts:viewpoint(Known), Views),
    unknown_name("no view is called", View, Views),
    fail.

%!  why_not(:Goal) is det.
%
%   Print the derivation of Goal that comes closest to holding, each step with what it is short by.

why_not(Goal) :-
    (   explain:best_proof(Goal, Node)
    ->  verbalise:node_text(Node, Text),
        words:saying(it_holds, [Text], Said),
        format("~s.~n", [Said])
    ;   explain:refusal(Goal, Node),
        outline:print_proof(Node),
        strip_module(Goal, _, Plain),
        forall(refusals:hindrance(Plain, Text), format("  ~s~n", [Text])),
        (   Node = node(_, _, _, _, [Miss])
        ->  words:saying(comes_closest, [], Said),
            format("~s~n", [Said]),
            outline:print_proof(Miss)
        ;   true
        )
    ).

%!  help(+Name) is det.
%
%   Print the axiom that Name or Name/Arity encodes, what it says, and its rules; of what is no predicate of
%   the rule files, the manual of Prolog.

help(Name) :-
    manual(Name),
    !.
help(Name) :-
    load_files(library(help), [if(not_loaded), imports([])]),
    prolog_help:help(Name).

%   Before a question is asked, its relations get the view they are given without, and its names are looked up.

user:expand_query(Goal0, Goal, Bindings, Bindings) :-
    Goal0 \== end_of_file,
    shell:with_view(Goal0, Goal1),
    shell:checked(Goal1, Goal).

%   with_view(+Term0, -Term): left_of(X, Y) becomes left_of(X, Y, v0), wherever it stands.

with_view(Term, Term) :- \+ compound(Term), !.
with_view(Term0, Term) :-
    compound_name_arguments(Term0, Name, [Figure, Reference]),
    axioms:relation(Name/3),
    looking_from(View),
    !,
    compound_name_arguments(Term, Name, [Figure, Reference, View]).
with_view(Term0, Term) :-
    compound_name_arguments(Term0, Name, Args0),
    maplist(with_view, Args0, Args),
    compound_name_arguments(Term, Name, Args).

%   checked(+Goal0, -Goal): Goal0, or false where it calls what there is not. A thing that is not there is
%   told, and the question asked all the same.

checked(Goal0, Goal) :-
    called(Goal0, Called),
    exclude([One]>>predicate_property(user:One, visible), Called, Strange),
    (   Strange = [First|_]
    ->  functor(First, Name, Arity),
        findall(Known, ( current_predicate(user:Known/_) ), Names),
        unknown_predicate(Name/Arity, Names),
        Goal = fail
    ;   Goal = Goal0,
        forall(( member(One, Called), stranger(One, Stranger) ),
               ( findall(Known, ( facts:spatial_obj(Known) ; facts:viewpoint(Known) ), Names),
                 unknown_name("nothing is called", Stranger, Names)
               ))
    ).

%   called(+Goal, -Called): the goals in it, as far as they are written out.

called(Goal, []) :- \+ callable(Goal), !.
called(Goal, Called) :-
    control(Goal, Inner),
    !,
    maplist(called, Inner, Lists),
    append(Lists, Called).
called(_:_, []) :- !.
called(Goal, [Goal]).

control((A, B), [A, B]).
control((A ; B), [A, B]).
control((A -> B), [A, B]).
control((A *-> B), [A, B]).
control(\+ A, [A]).
control(once(A), [A]).
control(forall(A, B), [A, B]).
control(findall(_, A, _), [A]).
control(aggregate_all(_, A, _), [A]).
control(why(A), [A]).
control(why_not(A), [A]).
control(contrast(A, B), [A, B]).

stranger(Goal, Name) :-
    functor(Goal, Functor, Arity),
    once(( axioms:relation(Functor/Arity) ; axioms:base(Functor/Arity) )),
    arg(_, Goal, Name),
    atom(Name),
    \+ facts:spatial_obj(Name),
    \+ facts:viewpoint(Name).
