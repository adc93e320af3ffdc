/** <module> Tests of the axioms, one unit an axiom, each with a case that holds and one that does not

The scenes are written as base facts, so that a rule is tested without any geometry.
*/

:- use_module(deixis(facts)).
:- use_module(deixis(topology)).
:- use_module(deixis(direction)).
:- use_module(deixis(commonsense)).

%   given(+Facts): these are the facts, and the default thresholds.

given(Facts) :-
    forall(member(Head, [ spatial_obj(_), surface(_), label(_, _, _), viewpoint(_), view_label(_, _),
                          threshold(_, _), figure_reference(_, _), pair(_, _, _, _, _, _, _, _, _),
                          aspect(_, _, _, _, _, _, _), strict(_, _, _, _, _), withheld(_, _, _) ]),
           retractall(facts:Head)),
    forall(member(Fact, [ threshold(granularity, 0.02), threshold(penetration, 0.04),
                          threshold(closeness, 1.0), threshold(halfspace_scale, 1.2), viewpoint(v0) ]),
           assertz(facts:Fact)),
    forall(member(Fact, Facts), assertz(facts:Fact)).

%   gap(+A, +B, +Separation, -Facts): both orders of a pair that meet in no halfspace.

gap(A, B, S, [ pair(A, B, D, S, 1.0, 0.0, 0.0, -1.0, -1.0), pair(B, A, D, S, 1.0, 0.0, 0.0, -1.0, -1.0) ]) :-
    D is max(S, 0.0).

%   on(+A, +B, +Separation, -Facts): the same, A over B.

on(A, B, S, [ pair(A, B, D, S, 1.0, 0.0, 0.0, 0.05, -1.0), pair(B, A, D, S, 1.0, 0.0, 0.0, -1.0, 0.05) ]) :-
    D is max(S, 0.0).

all(Lists, Facts) :- append(Lists, Facts).

:- begin_tests(axiom_14_distance).

test(the_measured_one, [setup(( gap(a, b, 0.3, F), given(F) )), nondet]) :-
    distance(a, b, D), D =:= 0.3.

test(not_negative, [setup(( gap(a, b, -0.3, F), given(F) )), nondet]) :-
    distance(a, b, D), D =:= 0.0.

:- end_tests(axiom_14_distance).

:- begin_tests(axiom_15_is_close).

test(at_the_limit, [setup(( gap(a, b, 1.0, F), given(F) )), nondet]) :-
    is_close(a, b), is_close(b, a).

test(beyond, [setup(( gap(a, b, 1.001, F), given(F) )), fail]) :-
    is_close(a, b).

:- end_tests(axiom_15_is_close).

:- begin_tests(axiom_16_touches).

test(gap_of_D, [setup(( gap(a, b, 0.02, F), given(F) )), nondet]) :-
    touches(a, b), touches(b, a).

test(overlap_of_P, [setup(( gap(a, b, -0.04, F), given(F) )), nondet]) :-
    touches(a, b).

test(too_far, [setup(( gap(a, b, 0.021, F), given(F) )), fail]) :-
    touches(a, b).

test(too_deep, [setup(( gap(a, b, -0.041, F), given(F) )), fail]) :-
    touches(a, b).

:- end_tests(axiom_16_touches).

:- begin_tests(axiom_17_intersects).

test(deeper_than_contact, [setup(( gap(a, b, -0.041, F), given(F) )), nondet]) :-
    intersects(a, b), intersects(b, a).

test(contact_only, [setup(( gap(a, b, -0.04, F), given(F) )), fail]) :-
    intersects(a, b).

:- end_tests(axiom_17_intersects).

:- begin_tests(axiom_18_intersection).

test(volume, [setup(( given([pair(a, b, 0.0, -0.1, 0.0, 0.25, 0.0, 0.0, 0.0)]) )), nondet]) :-
    intersection(a, b, V), V =:= 0.25.

test(none_measured, [setup(( given([]) )), fail]) :-
    intersection(a, b, _).

:- end_tests(axiom_18_intersection).

:- begin_tests(axiom_19_compl_cont).

test(within, [setup(( given([pair(jar, cabinet, 0.0, -0.15, -0.01, 0.01, 0.0, -0.3, -0.3), pair(cabinet, jar, 0.0, -0.15, 0.8, 0.01, 0.002, -0.3, -0.3), figure_reference(jar, cabinet)]) )), nondet]) :-
    compl_cont(cabinet, jar).

test(sticks_out_by_D, [setup(( given([pair(jar, cabinet, 0.0, -0.15, 0.02, 0.01, 0.0, -0.3, -0.3), pair(cabinet, jar, 0.0, -0.15, 0.8, 0.01, 0.002, -0.3, -0.3), figure_reference(jar, cabinet)]) )), nondet]) :-
    compl_cont(cabinet, jar).

test(sticks_out_further, [setup(( given([pair(jar, cabinet, 0.0, -0.15, 0.021, 0.01, 0.0, -0.3, -0.3), pair(cabinet, jar, 0.0, -0.15, 0.8, 0.01, 0.002, -0.3, -0.3), figure_reference(jar, cabinet)]) )), fail]) :-
    compl_cont(cabinet, jar).

test(container_first, [setup(( given([pair(jar, cabinet, 0.0, -0.15, -0.01, 0.01, 0.0, -0.3, -0.3), pair(cabinet, jar, 0.0, -0.15, 0.8, 0.01, 0.002, -0.3, -0.3), figure_reference(jar, cabinet)]) )), fail]) :-
    compl_cont(jar, cabinet).

test(inside, [setup(( given([pair(jar, cabinet, 0.0, -0.15, -0.01, 0.01, 0.0, -0.3, -0.3), pair(cabinet, jar, 0.0, -0.15, 0.8, 0.01, 0.002, -0.3, -0.3), figure_reference(jar, cabinet)]) )), nondet]) :-
    inside(jar, cabinet).

test(not_inside, [setup(( given([pair(jar, cabinet, 0.0, -0.15, 0.3, 0.01, 0.0, -0.3, -0.3), pair(cabinet, jar, 0.0, -0.15, 0.8, 0.01, 0.002, -0.3, -0.3), figure_reference(jar, cabinet)]) )), fail]) :-
    inside(jar, cabinet).

:- end_tests(axiom_19_compl_cont).

:- begin_tests(axiom_22_east_r).

test(reaches_in, [setup(( given([aspect(world, a, b, 0.0, -1.0, -1.0, -1.0), figure_reference(a, b), strict(a, b, 'X+', world, -0.1)]) )), nondet]) :-
    east_r(a, b).

test(misses, [setup(( given([aspect(world, a, b, -0.001, -1.0, -1.0, -1.0), figure_reference(a, b), strict(a, b, 'X+', world, -0.1)]) )), fail]) :-
    east_r(a, b).

test(only_there, [setup(( given([aspect(world, a, b, -1.0, 0.5, -1.0, -1.0), figure_reference(a, b), strict(a, b, 'X+', world, -0.1)]) )), fail]) :-
    east_r(a, b).

:- end_tests(axiom_22_east_r).

:- begin_tests(axiom_21_east_s).

test(wholly_in, [setup(( given([aspect(world, a, b, 0.1, -1.0, -1.0, -1.0), figure_reference(a, b), strict(a, b, 'X+', world, 0.0)]) )), nondet]) :-
    east_s(a, b).

test(in_part, [setup(( given([aspect(world, a, b, 0.1, -1.0, -1.0, -1.0), figure_reference(a, b), strict(a, b, 'X+', world, -0.001)]) )), fail]) :-
    east_s(a, b).

:- end_tests(axiom_21_east_s).

:- begin_tests(axiom_23_west_r).

test(reaches_in, [setup(( given([aspect(world, a, b, -1.0, 0.0, -1.0, -1.0), figure_reference(a, b), strict(a, b, 'X-', world, -0.1)]) )), nondet]) :-
    west_r(a, b).

test(misses, [setup(( given([aspect(world, a, b, -1.0, -0.001, -1.0, -1.0), figure_reference(a, b), strict(a, b, 'X-', world, -0.1)]) )), fail]) :-
    west_r(a, b).

test(only_there, [setup(( given([aspect(world, a, b, -1.0, -1.0, 0.5, -1.0), figure_reference(a, b), strict(a, b, 'X-', world, -0.1)]) )), fail]) :-
    west_r(a, b).

:- end_tests(axiom_23_west_r).

:- begin_tests(axiom_21_west_s).

test(wholly_in, [setup(( given([aspect(world, a, b, -1.0, 0.1, -1.0, -1.0), figure_reference(a, b), strict(a, b, 'X-', world, 0.0)]) )), nondet]) :-
    west_s(a, b).

test(in_part, [setup(( given([aspect(world, a, b, -1.0, 0.1, -1.0, -1.0), figure_reference(a, b), strict(a, b, 'X-', world, -0.001)]) )), fail]) :-
    west_s(a, b).

:- end_tests(axiom_21_west_s).

:- begin_tests(axiom_24_north_r).

test(reaches_in, [setup(( given([aspect(world, a, b, -1.0, -1.0, 0.0, -1.0), figure_reference(a, b), strict(a, b, 'Y+', world, -0.1)]) )), nondet]) :-
    north_r(a, b).

test(misses, [setup(( given([aspect(world, a, b, -1.0, -1.0, -0.001, -1.0), figure_reference(a, b), strict(a, b, 'Y+', world, -0.1)]) )), fail]) :-
    north_r(a, b).

test(only_there, [setup(( given([aspect(world, a, b, -1.0, -1.0, -1.0, 0.5), figure_reference(a, b), strict(a, b, 'Y+', world, -0.1)]) )), fail]) :-
    north_r(a, b).

:- end_tests(axiom_24_north_r).

:- begin_tests(axiom_21_north_s).

test(wholly_in, [setup(( given([aspect(world, a, b, -1.0, -1.0, 0.1, -1.0), figure_reference(a, b), strict(a, b, 'Y+', world, 0.0)]) )), nondet]) :-
    north_s(a, b).

test(in_part, [setup(( given([aspect(world, a, b, -1.0, -1.0, 0.1, -1.0), figure_reference(a, b), strict(a, b, 'Y+', world, -0.001)]) )), fail]) :-
    north_s(a, b).

:- end_tests(axiom_21_north_s).

:- begin_tests(axiom_25_south_r).

test(reaches_in, [setup(( given([aspect(world, a, b, -1.0, -1.0, -1.0, 0.0), figure_reference(a, b), strict(a, b, 'Y-', world, -0.1)]) )), nondet]) :-
    south_r(a, b).

test(misses, [setup(( given([aspect(world, a, b, -1.0, -1.0, -1.0, -0.001), figure_reference(a, b), strict(a, b, 'Y-', world, -0.1)]) )), fail]) :-
    south_r(a, b).

test(only_there, [setup(( given([aspect(world, a, b, 0.5, -1.0, -1.0, -1.0), figure_reference(a, b), strict(a, b, 'Y-', world, -0.1)]) )), fail]) :-
    south_r(a, b).

:- end_tests(axiom_25_south_r).

:- begin_tests(axiom_21_south_s).

test(wholly_in, [setup(( given([aspect(world, a, b, -1.0, -1.0, -1.0, 0.1), figure_reference(a, b), strict(a, b, 'Y-', world, 0.0)]) )), nondet]) :-
    south_s(a, b).

test(in_part, [setup(( given([aspect(world, a, b, -1.0, -1.0, -1.0, 0.1), figure_reference(a, b), strict(a, b, 'Y-', world, -0.001)]) )), fail]) :-
    south_s(a, b).

:- end_tests(axiom_21_south_s).

:- begin_tests(axiom_26_above_r).

test(reaches_in, [setup(( given([pair(a, b, 0.3, 0.3, 1.0, 0.0, 0.0, 0.0, -1.0), figure_reference(a, b), strict(a, b, 'Z+', world, -0.1)]) )), nondet]) :-
    above_r(a, b).

test(misses, [setup(( given([pair(a, b, 0.3, 0.3, 1.0, 0.0, 0.0, -0.001, -1.0), figure_reference(a, b), strict(a, b, 'Z+', world, -0.1)]) )), fail]) :-
    above_r(a, b).

:- end_tests(axiom_26_above_r).

:- begin_tests(axiom_21_above_s).

test(wholly_in, [setup(( given([pair(a, b, 0.3, 0.3, 1.0, 0.0, 0.0, 0.1, -1.0), figure_reference(a, b), strict(a, b, 'Z+', world, 0.0)]) )), nondet]) :-
    above_s(a, b).

test(in_part, [setup(( given([pair(a, b, 0.3, 0.3, 1.0, 0.0, 0.0, 0.1, -1.0), figure_reference(a, b), strict(a, b, 'Z+', world, -0.1)]) )), fail]) :-
    above_s(a, b).

:- end_tests(axiom_21_above_s).

:- begin_tests(axiom_28_above).

test(in_order, [setup(( given([pair(a, b, 0.3, 0.3, 1.0, 0.0, 0.0, 0.1, -1.0), figure_reference(a, b), strict(a, b, 'Z+', world, -0.1)]) )), nondet]) :-
    above(a, b).

test(not_the_other_way_round, [setup(( given([pair(a, b, 0.3, 0.3, 1.0, 0.0, 0.0, 0.1, -1.0)]) )), fail]) :-
    above(a, b).

:- end_tests(axiom_28_above).

:- begin_tests(axiom_27_below_r).

test(reaches_in, [setup(( given([pair(a, b, 0.3, 0.3, 1.0, 0.0, 0.0, -1.0, 0.0), figure_reference(a, b), strict(a, b, 'Z-', world, -0.1)]) )), nondet]) :-
    below_r(a, b).

test(misses, [setup(( given([pair(a, b, 0.3, 0.3, 1.0, 0.0, 0.0, -1.0, -0.001), figure_reference(a, b), strict(a, b, 'Z-', world, -0.1)]) )), fail]) :-
    below_r(a, b).

:- end_tests(axiom_27_below_r).

:- begin_tests(axiom_21_below_s).

test(wholly_in, [setup(( given([pair(a, b, 0.3, 0.3, 1.0, 0.0, 0.0, -1.0, 0.1), figure_reference(a, b), strict(a, b, 'Z-', world, 0.0)]) )), nondet]) :-
    below_s(a, b).

test(in_part, [setup(( given([pair(a, b, 0.3, 0.3, 1.0, 0.0, 0.0, -1.0, 0.1), figure_reference(a, b), strict(a, b, 'Z-', world, -0.1)]) )), fail]) :-
    below_s(a, b).

:- end_tests(axiom_21_below_s).

:- begin_tests(axiom_29_below).

test(in_order, [setup(( given([pair(a, b, 0.3, 0.3, 1.0, 0.0, 0.0, -1.0, 0.1), figure_reference(a, b), strict(a, b, 'Z-', world, -0.1)]) )), nondet]) :-
    below(a, b).

test(not_the_other_way_round, [setup(( given([pair(a, b, 0.3, 0.3, 1.0, 0.0, 0.0, -1.0, 0.1)]) )), fail]) :-
    below(a, b).

:- end_tests(axiom_29_below).

:- begin_tests(axiom_31_right_of).

test(in_the_view, [setup(( given([aspect(v0, a, b, -1.0, -1.0, -1.0, 0.0), figure_reference(a, b), strict(a, b, 'Y-', v0, -0.1)]) )), nondet]) :-
    right_of(a, b, V), V == v0.

test(misses, [setup(( given([aspect(v0, a, b, -1.0, -1.0, -1.0, -0.001), figure_reference(a, b), strict(a, b, 'Y-', v0, -0.1)]) )), fail]) :-
    right_of(a, b, v0).

test(the_world_is_no_view, [setup(( given([aspect(world, a, b, -1.0, -1.0, -1.0, 0.5), figure_reference(a, b), strict(a, b, 'Y-', world, -0.1)]) )), fail]) :-
    right_of(a, b, _).

:- end_tests(axiom_31_right_of).

:- begin_tests(axiom_32_left_of).

test(in_the_view, [setup(( given([aspect(v0, a, b, -1.0, -1.0, 0.0, -1.0), figure_reference(a, b), strict(a, b, 'Y+', v0, -0.1)]) )), nondet]) :-
    left_of(a, b, V), V == v0.

test(misses, [setup(( given([aspect(v0, a, b, -1.0, -1.0, -0.001, -1.0), figure_reference(a, b), strict(a, b, 'Y+', v0, -0.1)]) )), fail]) :-
    left_of(a, b, v0).

test(the_world_is_no_view, [setup(( given([aspect(world, a, b, -1.0, -1.0, 0.5, -1.0), figure_reference(a, b), strict(a, b, 'Y+', world, -0.1)]) )), fail]) :-
    left_of(a, b, _).

:- end_tests(axiom_32_left_of).

:- begin_tests(axiom_33_in_front_of).

test(in_the_view, [setup(( given([aspect(v0, a, b, -1.0, 0.0, -1.0, -1.0), figure_reference(a, b), strict(a, b, 'X-', v0, -0.1)]) )), nondet]) :-
    in_front_of(a, b, V), V == v0.

test(misses, [setup(( given([aspect(v0, a, b, -1.0, -0.001, -1.0, -1.0), figure_reference(a, b), strict(a, b, 'X-', v0, -0.1)]) )), fail]) :-
    in_front_of(a, b, v0).

test(the_world_is_no_view, [setup(( given([aspect(world, a, b, -1.0, 0.5, -1.0, -1.0), figure_reference(a, b), strict(a, b, 'X-', world, -0.1)]) )), fail]) :-
    in_front_of(a, b, _).

:- end_tests(axiom_33_in_front_of).

:- begin_tests(axiom_34_behind).

test(in_the_view, [setup(( given([aspect(v0, a, b, 0.0, -1.0, -1.0, -1.0), figure_reference(a, b), strict(a, b, 'X+', v0, -0.1)]) )), nondet]) :-
    behind(a, b, V), V == v0.

test(misses, [setup(( given([aspect(v0, a, b, -0.001, -1.0, -1.0, -1.0), figure_reference(a, b), strict(a, b, 'X+', v0, -0.1)]) )), fail]) :-
    behind(a, b, v0).

test(the_world_is_no_view, [setup(( given([aspect(world, a, b, 0.5, -1.0, -1.0, -1.0), figure_reference(a, b), strict(a, b, 'X+', world, -0.1)]) )), fail]) :-
    behind(a, b, _).

:- end_tests(axiom_34_behind).

:- begin_tests(axiom_35_beside).

test(right, [setup(( given([aspect(v0, a, b, -1.0, -1.0, -1.0, 0.1), figure_reference(a, b), strict(a, b, 'Y-', v0, 0.0)]) )), nondet]) :-
    beside(a, b, v0).

test(left, [setup(( given([aspect(v0, a, b, -1.0, -1.0, 0.1, -1.0), figure_reference(a, b), strict(a, b, 'Y+', v0, 0.0)]) )), nondet]) :-
    beside(a, b, v0).

test(in_front, [setup(( given([aspect(v0, a, b, -1.0, 0.1, -1.0, -1.0), figure_reference(a, b), strict(a, b, 'X-', v0, 0.0)]) )), fail]) :-
    beside(a, b, v0).

:- end_tests(axiom_35_beside).

:- begin_tests(axiom_36_on_top_of).

test(above_and_touching, [setup(( on(cup, table, 0.0, F), given([figure_reference(cup, table)|F]) )), nondet]) :-
    on_top_of(cup, table).

test(above_only, [setup(( on(cup, table, 0.06, F), given([figure_reference(cup, table)|F]) )), fail]) :-
    on_top_of(cup, table).

test(touching_only, [setup(( gap(cup, table, 0.0, F), given([figure_reference(cup, table)|F]) )), fail]) :-
    on_top_of(cup, table).

:- end_tests(axiom_36_on_top_of).

:- begin_tests(axiom_37_leans_on).

test(with_a_floor_below, [setup(( gap(board, wall, 0.0, W), on(board, floor, 0.0, G), all([W, G, [figure_reference(board, wall), figure_reference(board, floor)]], F), given(F) )), nondet]) :-
    leans_on(board, wall).

test(without_support, [setup(( gap(board, wall, 0.0, W), on(board, floor, 0.1, G), all([W, G, [figure_reference(board, wall), figure_reference(board, floor)]], F), given(F) )), fail]) :-
    leans_on(board, wall).

test(on_top_is_not_leaning, [setup(( on(cup, table, 0.0, A), on(cup, floor, 0.0, G), all([A, G, [figure_reference(cup, table)]], F), given(F) )), fail]) :-
    leans_on(cup, table).

:- end_tests(axiom_37_leans_on).

:- begin_tests(axiom_38_affixed_on).

test(nothing_else_touches, [setup(( gap(board, wall, 0.0, W), gap(board, floor, 0.1, G), all([W, G, [figure_reference(board, wall), figure_reference(board, floor)]], F), given(F) )), nondet]) :-
    affixed_on(board, wall).

test(something_else_does, [setup(( gap(board, wall, 0.0, W), on(board, floor, 0.0, G), all([W, G, [figure_reference(board, wall), figure_reference(board, floor)]], F), given(F) )), fail]) :-
    affixed_on(board, wall).

test(not_from_above, [setup(( on(cup, table, 0.0, A), given([figure_reference(cup, table)|A]) )), fail]) :-
    affixed_on(cup, table).

:- end_tests(axiom_38_affixed_on).

:- begin_tests(axiom_39_adj_sr_card).

test(of_each, [setup(( given([pair(jar, cabinet, 0.0, -0.15, -0.01, 0.01, 0.0, -0.3, -0.3), pair(cabinet, jar, 0.0, -0.15, 0.8, 0.01, 0.002, -0.3, -0.3), figure_reference(jar, cabinet)]) )), nondet]) :-
    adj_sr_card(jar, cabinet, A), adj_sr_card(cabinet, jar, B), A =:= 0.0, B =:= 0.002.

test(none_measured, [setup(( given([]) )), fail]) :-
    adj_sr_card(jar, cabinet, _).

:- end_tests(axiom_39_adj_sr_card).

:- begin_tests(axiom_40_part_in).

test(less_of_the_figure, [setup(( given([pair(jar, cabinet, 0.0, -0.15, 0.3, 0.01, 0.0019, -0.3, -0.3), pair(cabinet, jar, 0.0, -0.15, 0.8, 0.01, 0.002, -0.3, -0.3), figure_reference(jar, cabinet)]) )), nondet]) :-
    part_in(jar, cabinet).

test(equal_is_not_less, [setup(( given([pair(jar, cabinet, 0.0, -0.15, 0.3, 0.01, 0.002, -0.3, -0.3), pair(cabinet, jar, 0.0, -0.15, 0.8, 0.01, 0.002, -0.3, -0.3), figure_reference(jar, cabinet)]) )), fail]) :-
    part_in(jar, cabinet).

test(contact_is_not_enough, [setup(( given([pair(a, b, 0.0, -0.01, 0.1, 0.0, 0.0, -1.0, -1.0), pair(b, a, 0.0, -0.01, 0.1, 0.0, 1.0, -1.0, -1.0), figure_reference(a, b)]) )), fail]) :-
    part_in(a, b).

:- end_tests(axiom_40_part_in).

:- begin_tests(axiom_15_near).

test(in_order, [setup(( gap(a, b, 0.5, F), given([figure_reference(a, b)|F]) )), nondet]) :-
    near(a, b).

test(not_the_other_way_round, [setup(( gap(a, b, 0.5, F), given([figure_reference(a, b)|F]) )), fail]) :-
    near(b, a).

:- end_tests(axiom_15_near).
