:- module(shell, [start/0]).
:- use_module(library(apply)).
:- use_module(library(lists)).
:- use_module(library(readutil)).
:- use_module(library(yall)).

/** <module> The Prolog shell of a scene

Started by `deixis shell`: the arguments are a file with one list of base facts, which is deleted once it is
read, the rule files, and the predicates to table. Afterwards this is SWI-Prolog as it always is.
*/

%!  start is det.
%
%   Load the facts and the rule files given as arguments, and print what is there.

start :-
    current_prolog_flag(argv, Argv),
    append(_, [--, FactsFile|Rest], [--|Argv]),
    !,
    doc_comments,
    partition([Argument]>>sub_atom(Argument, 0, _, _, 'table:'), Rest, Tables, RuleFiles),
    load_files(user:RuleFiles, [if(not_loaded), must_be_module(false)]),
    forall(member(Table, Tables), keep_answers(Table)),
    setup_call_cleanup(
        open(FactsFile, read, Stream, [encoding(utf8)]),
        read_term(Stream, Facts, []),
        ( close(Stream), delete_file(FactsFile) )),
    forall(member(Fact, Facts), assertz(facts:Fact)),
    banner.

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

%   PlDoc comments are kept, so that help(on_top_of) shows the axiom.

doc_comments :-
    use_module(library(pldoc)),
    doc_collect(true).

banner :-
    aggregate_all(count, facts:spatial_obj(_), Objects),
    aggregate_all(count, facts:viewpoint(_), Views),
    aggregate_all(count, facts:pair(_, _, _, _, _, _, _, _, _), Pairs),
    format("Deixis: ~D objects, ~D views, ~D measured pairs.~n", [Objects, Views, Pairs]),
    format("Ask:    on_top_of(X, Y).   left_of(X, Y, View).   why(on_top_of(X, Y)).   halt.~n~n").
