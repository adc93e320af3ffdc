/** <module> Tests of support.pl and safety.pl: each rule with a case that holds and one that does not

They stand on what axioms.plt gives them: given/1, gap/4, on/4 and all/2.
*/

:- use_module(deixis(facts)).
:- use_module(deixis(support)).
:- use_module(deixis(commonsense)).

%   A cup on a tray on a table.

stack(Facts) :-
    on(cup, tray, 0.0, A),
    on(tray, table, 0.0, B),
    all([A, B, [figure_reference(cup, tray), figure_reference(tray, table)]], Facts).

:- begin_tests(support).

test(held_by_what_it_is_on, [setup(( stack(F), given(F) )), nondet]) :-
    held_by(cup, tray), \+ held_by(cup, table).

test(through_others, [setup(( stack(F), given(F) )), all(X == [tray, table])]) :-
    supported_by(cup, X).

test(the_other_way_round, [setup(( stack(F), given(F) )), set(X == [cup, tray])]) :-
    supports(table, X).

test(nothing_supports_itself, [setup(( stack(F), given(F) )), fail]) :-
    supported_by(X, X).

test(apart, [setup(( gap(cup, tray, 0.3, F), given([figure_reference(cup, tray)|F]) )), fail]) :-
    supported_by(cup, tray).

:- end_tests(support).
