/** <module> Questions: what they may call, and their answers

Questions are read and called in module `question`, into which the rule files are loaded.
*/

:- module(questions,
          [ read_one/4,
            question/3,
            stranger/2,
            ask/4,
            relations/2,
            remember_vocabulary/0
          ]).
:- use_module(library(apply), [maplist/2]).
:- use_module(library(lists), [append/3, list_to_set/2, member/2]).
:- use_module(library(wfs), [call_delays/2]).
:- autoload(library(sandbox), [safe_goal/1]).   % 35 ms: loaded by the first question

:- dynamic vocabulary/2.

%!  remember_vocabulary is det.
%
%   Note what the rule files define or export: what can be asked, and offered for a misspelt name.

remember_vocabulary :-
    forall(( current_predicate(question:Name/Arity),
             \+ sub_atom(Name, 0, _, _, $),
             functor(Head, Name, Arity),
             \+ ( predicate_property(question:Head, multifile),
                  \+ predicate_property(question:Head, number_of_clauses(_))
                ),
             \+ ( predicate_property(question:Head, imported_from(Module)),
                  \+ module_property(Module, class(user))
                )
           ),
           assertz(vocabulary(Name, Arity))).

%!  read_one(+Text, +Module, -Term, -Names) is det.
%
%   The one term in Text, which has a full stop, maybe a second one, at its end.

read_one(Text, Module, Term, Names) :-
    setup_call_cleanup(
        open_string(Text, In),
        ( read_term(In, Term, [module(Module), variable_names(Names)]),
          read_string(In, _, Rest)
        ),
        close(In)),
    (   split_string(Rest, "", " \t\r\n.", [""])
    ->  true
    ;   throw(bridge(query, "more than one question is asked: ask them one by one", []))
    ).

%!  question(+Text, -Goal, -Bindings) is det.
%
%   The goal that Text asks, with or without a full stop, made sure to be safe to call in module
%   `question`, and the Name = Variable pairs of its variables.
%
%   @throws bridge(Kind, Message, Details) or a syntax error.

question(Text, Goal, Bindings) :-
    string_concat(Text, "\n.\n", Closed),
    read_one(Closed, question, Term, Bindings),
    (   Term == end_of_file
    ->  throw(bridge(query, "the question is empty", []))
    ;   nonvar(Term),
        Term = (?- Goal0)
    ->  Goal = Goal0
    ;   Goal = Term
    ),
    permitted(Goal),
    safe_goal(question:Goal).


                 /*******************************
                 *     WHAT A QUESTION CALLS    *
                 *******************************/

%   permitted(+Goal): all it calls is in the vocabulary or only computes. So a question changes nothing,
%   waits for nothing and reaches nothing outside. safe_goal/1 then looks through the rules as well.

permitted(Goal) :-
    var(Goal),
    !,
    throw(bridge(query, "a variable is called: write its goal out", [])).
permitted(Goal) :-
    \+ callable(Goal),
    !,
    format(string(Message), "~p is no goal", [Goal]),
    throw(bridge(query, Message, [])).
permitted(Goal) :-
    calls(Goal, Called),
    !,
    maplist(permitted_call, Called).
permitted(Goal) :-
    functor(Goal, Name, Arity),
    (   vocabulary(Name, Arity)
    ;   computes(Arity, Names),
        memberchk(Name, Names)
    ;   prints(Goal, Format),
        harmless(Format)
    ),
    !.
permitted(Goal) :-
    functor(Goal, Name, Arity),
    refuse(Name/Arity).

permitted_call(Goal+Extra) :-
    (   with_arguments(Goal, Extra, Called)
    ->  permitted(Called)
    ;   permitted(Goal)
    ).

with_arguments(Goal, Extra, Called) :-
    Extra > 0,
    callable(Goal),
    length(More, Extra),
    Goal =.. Given,
    append(Given, More, All),
    Called =.. All.

%!  stranger(+Goal, -Name) is nondet.
%
%   Name is an argument of a spoken or base relation that Goal calls, and no thing and no view here.

stranger(Goal, Name) :-
    current_predicate(axioms:relation/1),
    called(Goal+0, Called),
    functor(Called, Functor, Arity),
    once(( axioms:relation(Functor/Arity) ; axioms:base(Functor/Arity) )),
    arg(_, Called, Name),
    atom(Name),
    \+ facts:spatial_obj(Name),
    \+ facts:viewpoint(Name).

called(Goal+Extra, Called) :-
    with_arguments(Goal, Extra, Whole),
    !,
    called(Whole+0, Called).
called(Goal+_, Called) :-
    callable(Goal),
    (   calls(Goal, Inner)
    ->  member(One, Inner),
        called(One, Called)
    ;   Called = Goal
    ).

refuse(Name/Arity) :-
    functor(Goal, Name, Arity),
    predicate_property(question:Goal, defined),
    !,
    format(string(Message),
           "~q is not allowed in a question: it could change the knowledge or reach beyond it",
           [Name/Arity]),
    throw(bridge(permission, Message, [])).
refuse(Name/Arity) :-
    findall([N, A], vocabulary(N, A), Known),
    format(string(Message), "no rule or fact is called ~q", [Name/Arity]),
    throw(bridge(unknown, Message, [name = Name, arity = Arity, known = Known])).

%   calls(+Goal, -Called): what Goal calls, each as Goal+N where N arguments are added to it.

calls((A, B), [A+0, B+0]).
calls((A ; B), [A+0, B+0]).
calls((A -> B), [A+0, B+0]).
calls((A *-> B), [A+0, B+0]).
calls(\+ A, [A+0]).
calls(not(A), [A+0]).
calls(once(A), [A+0]).
calls(ignore(A), [A+0]).
calls(forall(A, B), [A+0, B+0]).
calls(findall(_, A, _), [A+0]).
calls(findall(_, A, _, _), [A+0]).
calls(aggregate_all(_, A, _), [A+0]).
calls(aggregate_all(_, _, A, _), [A+0]).
calls(bagof(_, A, _), [B+0]) :- unquantified(A, B).
calls(setof(_, A, _), [B+0]) :- unquantified(A, B).
calls(distinct(A), [A+0]).
calls(distinct(_, A), [A+0]).
calls(limit(_, A), [A+0]).
calls(offset(_, A), [A+0]).
calls(order_by(_, A), [A+0]).
calls(include(A, _, _), [A+1]).
calls(exclude(A, _, _), [A+1]).
calls(partition(A, _, _, _), [A+1]).
calls(foldl(A, _, _, _), [A+3]).
calls(maplist(A, _), [A+1]).
calls(maplist(A, _, _), [A+2]).
calls(maplist(A, _, _, _), [A+3]).
calls(Goal, [A+Extra]) :-
    compound(Goal),
    compound_name_arguments(Goal, call, [A|More]),
    length(More, Extra).

unquantified(Goal0, Goal) :-
    (   nonvar(Goal0),
        Goal0 = _^Goal1
    ->  unquantified(Goal1, Goal)
    ;   Goal = Goal0
    ).

%   computes(+Arity, -Names): predicates without effect beyond their arguments and the text printed.

computes(0, [true, fail, false, otherwise, !, nl]).
computes(1, [ var, nonvar, atom, atomic, callable, compound, ground, is_list, number, integer, float,
              rational, string, write, writeln, writeq, tab
            ]).
computes(2, [ =, \=, ==, \==, @<, @>, @=<, @>=, =@=, \=@=, ?=, unify_with_occurs_check, dif,
              is, =:=, =\=, <, >, =<, >=, succ,
              length, member, memberchk, last, msort, sort, permutation, reverse, flatten, list_to_set,
              sum_list, max_list, min_list, max_member, min_member, pairs_keys, pairs_values, keysort,
              =.., copy_term, term_variables, atomic_list_concat, atom_length, atom_number, atom_string,
              atom_chars, atom_codes, char_code, number_codes, number_string, string_length, string_chars,
              string_codes, string_lower, string_upper, upcase_atom, downcase_atom, text_to_string
            ]).
computes(3, [ between, plus, numlist, append, nth0, nth1, select, subtract, intersection, union, delete,
              pairs_keys_values, arg, functor, compare, atomic_list_concat, atom_concat, string_concat
            ]).
computes(4, [ sort, split_string ]).
computes(5, [ sub_atom, sub_string ]).

%   Output is caught by ask/4, so that it is safe; library(sandbox) cannot know that.

:- multifile sandbox:safe_primitive/1.

sandbox:safe_primitive(system:nl).
sandbox:safe_primitive(system:write(_)).
sandbox:safe_primitive(system:writeln(_)).
sandbox:safe_primitive(system:writeq(_)).
sandbox:safe_primitive(system:tab(_)).

%   prints(+Goal, -Format): a goal that prints by a format, where ~@ would call one.

prints(format(Format), Format).
prints(format(Format, _), Format).

harmless(Format) :-
    ( atom(Format) ; string(Format) ),
    !,
    (   sub_atom(Format, _, _, _, @)
    ->  throw(bridge(permission, "a format with @ in it is not allowed in a question", []))
    ;   true
    ).
harmless(_) :-
    throw(bridge(permission, "the format in a question must be written out", [])).


                 /*******************************
                 *           ANSWERS            *
                 *******************************/

%!  ask(+Text, +Limit, +Inferences, -Reply) is det.
%
%   The distinct answers in the order of their proofs, at most Limit of them, within Inferences steps.
%   Limit and Inferences are `none` or integers. With them the names that nothing here has.

ask(Text, Limit, Inferences, Reply) :-
    question(Text, Goal, Bindings),
    strangers(Goal, Strangers),
    named(Bindings, Names, Values),
    with_output_to(
        string(Output),
        within(Inferences, answers(Goal, Names, Values, Limit, Rows, Truncated))),
    Reply = json([ names = Names, rows = Rows, truncated = Truncated, output = Output,
                   strangers = Strangers
                 ]).

strangers(Goal, Texts) :-
    findall(Text, ( stranger(Goal, Name), atom_string(Name, Text) ), Texts0),
    list_to_set(Texts0, Texts).

%   Variables whose name begins with _ are not asked for, as at the Prolog prompt.

named([], [], []).
named([Name = Value|Bindings], Names, Values) :-
    (   sub_atom(Name, 0, _, _, '_')
    ->  named(Bindings, Names, Values)
    ;   Names = [Name|Names1],
        Values = [Value|Values1],
        named(Bindings, Names1, Values1)
    ).

within(none, Goal) :-
    !,
    call(Goal).
within(Inferences, Goal) :-
    call_with_inference_limit(Goal, Inferences, Result),
    (   Result == inference_limit_exceeded
    ->  format(string(Message), "the question took more than ~D steps", [Inferences]),
        throw(bridge(inferences, Message, []))
    ;   true
    ).

%   A question without variables is answered by its first proof.

answers(Goal, Names, [], _, Rows, false) :-
    !,
    (   solution(Goal, Names, [], Row)
    ->  Rows = [Row]
    ;   Rows = []
    ).
answers(Goal, Names, Values, Limit, Rows, Truncated) :-
    trie_new(Seen),
    findall(Row, bounded(solution(Goal, Names, Values, Row), Row, Limit, Seen), Rows0),
    (   integer(Limit),
        length(Rows, Limit),
        append(Rows, [_], Rows0)
    ->  Truncated = true
    ;   Rows = Rows0,
        Truncated = false
    ).

%   One row beyond Limit is looked for, to know whether there are more.

bounded(Goal, Row, Limit, Seen) :-
    State = count(0),
    call(Goal),
    trie_insert(Seen, Row),
    arg(1, State, Count0),
    Count is Count0 + 1,
    nb_setarg(1, State, Count),
    (   integer(Limit),
        Count > Limit
    ->  !
    ;   true
    ).

solution(Goal, Names, Values, Row) :-
    certain(Goal),
    copy_term(Values, Row0, Constraints),
    (   Constraints \== []
    ->  throw(bridge(query, "an answer is constrained, not known: bind its variables", []))
    ;   cyclic_term(Row0)
    ->  throw(bridge(query, "an answer is a cyclic term", []))
    ;   name_variables(Names, Row0),
        term_variables(Row0, Others),
        number_variables(Others, 1),
        typed_row(Row0, Row)
    ).

%   Well-founded semantics has a third truth value, which call/1 takes for true.

certain(Goal) :-
    call_delays(question:Goal, Delays),
    (   Delays == true
    ->  true
    ;   throw(bridge(query, "an answer depends on its own negation: it is neither true nor false", []))
    ).

name_variables([], []).
name_variables([Name|Names], [Value|Values]) :-
    (   var(Value)
    ->  Value = '$variable'(Name)
    ;   true
    ),
    name_variables(Names, Values).

number_variables([], _).
number_variables(['$variable'(Name)|Variables], N) :-
    atom_concat('_', N, Name),
    N1 is N + 1,
    number_variables(Variables, N1).

typed_row([], []).
typed_row([Value|Values], [term(Value)|Row]) :-
    typed_row(Values, Row).


                 /*******************************
                 *        ALL RELATIONS         *
                 *******************************/

%!  relations(+Indicators, -Reply) is det.
%
%   For each Name/Arity the cells of its answers, sorted and distinct, row after row. Cells are numbers
%   into one table, so that an id is written once however many rows it is in.

relations(Indicators, json([rows = Tables, cells = Cells])) :-
    trie_new(Index),
    tables(Indicators, Index, 0, Tables, Cells).

tables([], _, _, [], []).
tables([Name/Arity|Indicators], Index, N0, [Table|Tables], Cells) :-
    (   vocabulary(Name, Arity)
    ->  true
    ;   refuse(Name/Arity)
    ),
    functor(Head, Name, Arity),
    findall(Head, certain(Head), Heads0),
    sort(Heads0, Heads),
    rows(Heads, Index, N0, N, Table, Cells, Cells1),
    tables(Indicators, Index, N, Tables, Cells1).

rows([], _, N, N, [], Cells, Cells).
rows([Head|Heads], Index, N0, N, Table, Cells, Cells2) :-
    (   ground(Head)
    ->  true
    ;   format(string(Complaint), "~p holds for anything", [Head]),
        throw(bridge(rules, "a rule leaves a variable unbound", [complaints = [Complaint]]))
    ),
    Head =.. [_|Row],
    row(Row, Index, N0, N1, Table, Table1, Cells, Cells1),
    rows(Heads, Index, N1, N, Table1, Cells1, Cells2).

row([], _, N, N, Table, Table, Cells, Cells).
row([Cell|Row], Index, N0, N, [At|Table], Table1, Cells, Cells2) :-
    (   trie_lookup(Index, Cell, At0)
    ->  At = At0,
        N1 = N0,
        Cells1 = Cells
    ;   At = N0,
        trie_insert(Index, Cell, At),
        N1 is N0 + 1,
        Cells = [term(Cell)|Cells1]
    ),
    row(Row, Index, N1, N, Table, Table1, Cells1, Cells2).
