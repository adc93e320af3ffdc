/** <module> Tests of prepositions.pl: words that fit, and words that do not

They stand on what axioms.plt gives them: given/1, gap/4, on/4 and all/2.
*/

:- use_module(deixis(facts)).
:- use_module(deixis(prepositions)).

%   things(+Things, -Facts): these are things and no surfaces.

things(Things, Facts) :-
    findall(spatial_obj(Thing), member(Thing, Things), Facts).

%   A cup on a table.

cup_on_table(Facts) :-
    things([cup, table], Things),
    on(cup, table, 0.0, Pair),
    all([Things, Pair, [figure_reference(cup, table)]], Facts).

%   A pencil that leans on the foot of a mug; both stand on the table, and the pencil is closer to that.

pencil_at_mug(Facts) :-
    things([pencil, mug, table], Things),
    on(pencil, mug, 0.004, A),
    on(pencil, table, 0.0, B),
    on(mug, table, 0.0, C),
    all([Things, A, B, C], Facts).

%   Fruit in a bowl, and fruit on that which touches the bowl.

fruit(Facts) :-
    things([low, high, bowl], Things),
    on(high, low, 0.0, A),
    gap(high, bowl, 0.0, B),
    all([Things, A, B,
         [ pair(low, bowl, 0.0, -0.07, 0.0, 0.001, 0.0001, -0.07, -0.07),
           pair(bowl, low, 0.0, -0.07, 0.2, 0.001, 0.0010, -0.07, -0.07),
           figure_reference(low, bowl),
           figure_reference(high, bowl) ]], Facts).

:- begin_tests(prepositions).

test(on_is_contact_from_above, [setup(( cup_on_table(F), given(F) )), nondet]) :-
    fits(on, cup, table), fits('on top of', cup, table), fits(under, table, cup).

test(above_is_not_said_of_what_rests, [setup(( cup_on_table(F), given(F) )), fail]) :-
    fits(above, cup, table).

test(near_is_not_said_of_what_touches, [setup(( cup_on_table(F), given(F) )), fail]) :-
    fits(near, cup, table).

test(above_is_apart, [setup(( things([lamp, table], T), on(lamp, table, 0.5, P), all([T, P], F), given(F) )),
                      all(W == [above, over, near])]) :-
    fits(W, lamp, table).

test(what_stands_on_the_same_ground_is_against, [setup(( pencil_at_mug(F), given(F) )), nondet]) :-
    fits(against, pencil, mug).

test(and_not_on, [setup(( pencil_at_mug(F), given(F) )), fail]) :-
    fits(on, pencil, mug).

test(but_on_the_ground, [setup(( pencil_at_mug(F), given(F) )), nondet]) :-
    fits(on, pencil, table).

test(fruit_on_fruit_is_in_the_bowl, [setup(( fruit(F), given(F) )), set(X == [low, high])]) :-
    fits(in, X, bowl).

test(but_not_inside, [setup(( fruit(F), given(F) )), set(X == [low])]) :-
    fits(inside, X, bowl).

test(a_shelf_that_reaches_higher, [setup(( things([mug, shelf], T), all([T, [
        pair(mug, shelf, 0.0, 0.0, 0.1, 0.0, 0.0, 0.04, -0.4),
        pair(shelf, mug, 0.0, 0.0, 0.5, 0.0, 0.0, -0.01, 0.04) ]], F), given(F) )), fail]) :-
    fits('on top of', mug, shelf).

test(nobody_says_where_a_floor_is, [setup(( cup_on_table(F), given([surface(table)|F]) )), fail]) :-
    fits(_, table, _).

:- end_tests(prepositions).
