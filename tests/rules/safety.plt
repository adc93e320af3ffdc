/** <module> Tests of safety.pl and background.pl: each rule broken and kept

The scenes are written as base facts, as in axioms.plt, whose given/1, gap/4, on/4 and all/2 are used.
*/

:- use_module(deixis(facts)).

%   called(+Names, -Facts): things with one label each, Thing-Label.

called(Names, Facts) :-
    findall(label(Thing, Label, 1.0), member(Thing-Label, Names), Facts).

:- begin_tests(background).

test(over_several_steps, nondet) :-
    background:a_kind_of(sweater, textile).

test(no_kind_of_itself, fail) :-
    background:a_kind_of(Name, Name).

test(what_is_made_of_something_is_made_of_what_is_known, [set(M == [cardboard, cloth, paper, plastic, wood])]) :-
    background:made_of(_, M).

:- end_tests(background).

:- begin_tests(fire_hazard).

test(cloth_on_a_heater, [setup(( on(s, h, 0.0, A), called([s-sweater, h-radiator], B), all([A, B], F), given(F) )),
                         nondet]) :-
    violation(fire_hazard, s, h).

test(clogging_it, [setup(( gap(s, h, -0.1, A), called([s-towel, h-heater], B), all([A, B], F), given(F) )), nondet]) :-
    violation(fire_hazard, s, h).

test(beside_it, [setup(( gap(s, h, 0.05, A), called([s-towel, h-heater], B), all([A, B], F), given(F) )), fail]) :-
    violation(fire_hazard, s, h).

test(a_mug_does_not_burn, [setup(( on(s, h, 0.0, A), called([s-mug, h-heater], B), all([A, B], F), given(F) )), fail]) :-
    violation(fire_hazard, _, _).

test(the_best_label_counts, [setup(( on(s, h, 0.0, A), called([h-heater], B),
                                     all([A, B, [label(s, mug, 0.8), label(s, towel, 0.2)]], F), given(F) )),
                             fail]) :-
    violation(fire_hazard, _, _).

:- end_tests(fire_hazard).

:- begin_tests(extinguisher).

hung(Facts) :-
    gap(e, w, 0.0, A),
    called([e-'fire extinguisher', w-wall], B),
    all([A, B, [surface(w), figure_reference(e, w)]], Facts).

test(off_the_wall, [setup(( called([e-'fire extinguisher'], F), given(F) )), nondet]) :-
    violation(extinguisher_off_wall, e).

test(on_the_wall, [setup(( hung(F), given(F) )), fail]) :-
    violation(extinguisher_off_wall, e).

test(on_something_else, [setup(( hung(F0), exclude([label(w, _, _)]>>true, F0, F), given([label(w, door, 1.0)|F]) )),
                         nondet]) :-
    violation(extinguisher_off_wall, e).

test(without_sign, [setup(( hung(F), given(F) )), nondet]) :-
    violation(extinguisher_without_sign, e).

test(sign_too_far, [setup(( gap(e, s, 1.2, A), called([e-'fire extinguisher', s-'fire extinguisher sign'], B),
                            all([A, B], F), given(F) )), nondet]) :-
    violation(extinguisher_without_sign, e).

test(sign_near, [setup(( gap(e, s, 0.4, A), called([e-'fire extinguisher', s-'extinguisher sign'], B),
                         all([A, B], F), given(F) )), fail]) :-
    violation(extinguisher_without_sign, e).

:- end_tests(extinguisher).

:- begin_tests(fire_door).

leaning(Facts) :-
    gap(b, d, 0.0, A),
    on(b, floor, 0.0, B),
    on(d, floor, 0.0, C),
    called([b-broom, d-'fire door', floor-floor], D),
    all([A, B, C, D, [surface(floor)]], Facts).

test(leant_on, [setup(( leaning(F), given(F) )), nondet]) :-
    violation(fire_door_leant_on, b, d).

test(the_floor_does_not_lean, [setup(( leaning(F), given(F) )), fail]) :-
    violation(fire_door_leant_on, floor, d).

test(another_door, [setup(( leaning(F0), exclude([label(d, _, _)]>>true, F0, F), given([label(d, door, 1.0)|F]) )), fail]) :-
    violation(fire_door_leant_on, _, _).

test(a_sign_on_the_door, [setup(( gap(s, d, 0.0, A), called([s-sign, d-'fire door'], B), all([A, B], F), given(F) )),
                          fail]) :-
    violation(fire_door_leant_on, _, _).

:- end_tests(fire_door).

:- begin_tests(heater_free_area).

test(over_a_floor_area, [setup(( on(h, a, 0.0, A), called([h-'fan heater', a-'heater-free area'], B),
                                 all([A, B, [surface(a)]], F), given(F) )), nondet]) :-
    violation(heater_in_free_area, h, a).

test(in_a_region, [setup(( gap(h, a, -0.3, A), called([h-heater, a-'heater-free area'], B), all([A, B], F), given(F) )),
                   nondet]) :-
    violation(heater_in_free_area, h, a).

test(beside_it, [setup(( gap(h, a, 0.1, A), called([h-heater, a-'heater-free area'], B),
                         all([A, B, [surface(a)]], F), given(F) )), fail]) :-
    violation(heater_in_free_area, _, _).

test(a_storey_above, [setup(( on(h, a, 3.0, A), called([h-heater, a-'heater-free area'], B),
                              all([A, B, [surface(a)]], F), given(F) )), fail]) :-
    violation(heater_in_free_area, _, _).

test(no_heater, [setup(( on(h, a, 0.0, A), called([h-chair, a-'heater-free area'], B),
                         all([A, B, [surface(a)]], F), given(F) )), fail]) :-
    violation(heater_in_free_area, _, _).

:- end_tests(heater_free_area).
