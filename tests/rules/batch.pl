/** <module> Many small programs in one request, for the differential test of the engines

Each program is loaded into a module of its own, which sees what the rule files offer.
*/

:- multifile bridge:operation/3.

%   programs([[Text, Defined, Recursive, Wanted], ...], ...): for each program the rows of each wanted
%   predicate; predicates are [Name, Arity].

bridge:operation(programs, Programs, Replies) :-
    maplist(program, Programs, Replies).

program([Text, Defined, Recursive, Wanted], Tables) :-
    gensym(program, Module),
    add_import_module(Module, question, start),
    forall(member([Name, Arity], Defined), dynamic(Module:Name/Arity)),
    setup_call_cleanup(
        open_string(Text, In),
        load_clauses(In, Module),
        close(In)),
    forall(member([Name, Arity], Recursive), table(Module:Name/Arity)),
    maplist(rows(Module), Wanted, Tables).

load_clauses(In, Module) :-
    repeat,
    read_term(In, Clause, [module(Module)]),
    (   Clause == end_of_file
    ->  !
    ;   Clause = (:- _)
    ->  fail
    ;   assertz(Module:Clause),
        fail
    ).

rows(Module, [Name, Arity], Rows) :-
    functor(Goal, Name, Arity),
    findall(Cells, ( call(Module:Goal), Goal =.. [_|Args], maplist(cell, Args, Cells) ), Bag),
    sort(Bag, Rows).

cell(Number, Float) :-
    number(Number),
    !,
    Float is float(Number).
cell(Atom, Text) :-
    atom_string(Atom, Text).
