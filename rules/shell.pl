:- module(shell, [start/0]).
:- use_module(library(lists)).
:- use_module(library(readutil)).

/** <module> The Prolog shell of a scene

Started by `deixis shell`: the arguments are a file with one list of base facts, which is deleted once it is
read, and the rule files. Afterwards this is SWI-Prolog as it always is.
*/

%!  start is det.
%
%   Load the facts and the rule files given as arguments, and print what is there.

start :-
    current_prolog_flag(argv, Argv),
    append(_, [--, FactsFile|RuleFiles], [--|Argv]),
    !,
    doc_comments,
    forall(member(File, RuleFiles), user:use_module(File)),
    setup_call_cleanup(
        open(FactsFile, read, Stream, [encoding(utf8)]),
        read_term(Stream, Facts, []),
        ( close(Stream), delete_file(FactsFile) )),
    forall(member(Fact, Facts), assertz(facts:Fact)),
    banner.

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
