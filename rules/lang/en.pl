:- module(en,
          [ sentence/2,                 % ?Goal, ?Template
            no_other/3,                 % ?Goal, ?Exception, ?Template
            none/2,                     % ?Goal, ?Template
            differs/3,                  % ?A, ?B, ?Template
            hindered/2,                 % ?What, ?Template
            called/2,                   % ?Before, ?After
            side/3,                     % ?Side, ?Before, ?After
            place/2,                    % ?Place, ?Words
            said/2,                     % ?Name, ?Format
            connective/2                % ?Name, ?Words
          ]).

:- use_module(library(lists), [append/3]).
:- use_module('../facts').

:- multifile words:speaks/1.
:- dynamic words:speaks/1.

words:speaks(en).

/** <module> English

One template for each predicate. In a template the(X) names an object, name(X) is a name as it stands,
view(V) says whose view it is, metres(N), cubic_metres(N) and number(N) are amounts, v(Yes, No) is what
negation turns round; anything else stands for itself. Another language is another file with the same
predicates, see words.pl.
*/

%!  sentence(?Goal, ?Template) is nondet.
%
%   Template says Goal in English.

sentence(spatial_obj(O), [the(O), v(is, 'is not'), 'an object of this scene']).
sentence(surface(O), [the(O), v(is, 'is not'), 'a surface']).
sentence(figure_reference(_, R), [the(R), v('is the reference, being a surface', 'is not the reference')]) :-
    nonvar(R), surface(R), !.
sentence(figure_reference(F, R), [the(R), v('is the reference, being not smaller than', 'is not the reference of'), the(F)]).
sentence(viewpoint(V), ['there', v(is, 'is not'), 'a view', view(V)]).
sentence(distance(A, B, N), [the(A), 'and', the(B), v(are, 'are not'), metres(N), 'apart']).
sentence(separation(A, B, N), ['the gap between', the(A), 'and', the(B), v(is, 'is not'), metres(N)]) :-
    ( var(N) ; N >= 0 ), !.
sentence(separation(A, B, N), [the(A), 'and', the(B), v(overlap, 'do not overlap'), 'by', metres(Depth)]) :-
    Depth is -N.
sentence(is_close(A, B), [the(A), v(is, 'is not'), 'close to', the(B)]).
sentence(touches(A, B), [the(A), v(touches, 'does not touch'), the(B)]).
sentence(intersects(A, B), [the(A), 'and', the(B), v('share room', 'share no room')]).
sentence(intersection(A, B, N), [the(A), 'and', the(B), v(share, 'do not share'), cubic_metres(N)]).
sentence(protrusion(A, B, N),
         [the(A), v('sticks out of', 'does not stick out of'), the(B), 'by', metres(N)]) :-
    ( var(N) ; N >= 0 ), !.
sentence(protrusion(A, B, N), [the(A), v(lies, 'does not lie'), metres(Depth), 'within', the(B)]) :-
    Depth is -N.
sentence(compl_cont(A, B), [the(A), v('wholly contains', 'does not wholly contain'), the(B)]).
sentence(halfspace(A, B, Axis, V, N), [the(A), v('reaches into', 'does not reach into')|Rest]) :-
    ( var(N) ; N >= 0 ), !, space_of(Axis, V, B, ['with', metres(N), 'to spare'], Rest).
sentence(halfspace(A, B, Axis, V, N), [the(A), v(misses, 'does not miss')|Rest]) :-
    By is -N, space_of(Axis, V, B, ['by', metres(By)], Rest).
sentence(strict(A, B, Axis, V, N), [the(A), v(is, 'is not'), metres(Within), Where|Rest]) :-
    ( ( var(N) ; N >= 0 ) -> Within = N, Where = 'within' ; Within is -N, Where = 'outside' ),
    space_of(Axis, V, B, [], Rest).
sentence(int_hs(A, B, Axis, V), [the(A), v('reaches into', 'does not reach into')|Rest]) :-
    space_of(Axis, V, B, [], Rest).
sentence(cont_hs(A, B, Axis, V), [the(A), v('lies wholly in', 'does not lie wholly in')|Rest]) :-
    space_of(Axis, V, B, [], Rest).
sentence(east_s(A, B), [the(A), v(is, 'is not'), 'wholly east of', the(B)]).
sentence(west_s(A, B), [the(A), v(is, 'is not'), 'wholly west of', the(B)]).
sentence(north_s(A, B), [the(A), v(is, 'is not'), 'wholly north of', the(B)]).
sentence(south_s(A, B), [the(A), v(is, 'is not'), 'wholly south of', the(B)]).
sentence(above_s(A, B), [the(A), v(is, 'is not'), 'wholly over', the(B)]).
sentence(below_s(A, B), [the(A), v(is, 'is not'), 'wholly under', the(B)]).
sentence(east_r(A, B), [the(A), v(is, 'is not'), 'east of', the(B)]).
sentence(west_r(A, B), [the(A), v(is, 'is not'), 'west of', the(B)]).
sentence(north_r(A, B), [the(A), v(is, 'is not'), 'north of', the(B)]).
sentence(south_r(A, B), [the(A), v(is, 'is not'), 'south of', the(B)]).
sentence(above_r(A, B), [the(A), v(is, 'is not'), 'over', the(B)]).
sentence(below_r(A, B), [the(A), v(is, 'is not'), 'under', the(B)]).
sentence(above(A, B), [the(A), v(is, 'is not'), 'above', the(B)]).
sentence(below(A, B), [the(A), v(is, 'is not'), 'below', the(B)]).
sentence(right_of(A, B, V), [the(A), v(is, 'is not'), 'right of', the(B), view(V)]).
sentence(left_of(A, B, V), [the(A), v(is, 'is not'), 'left of', the(B), view(V)]).
sentence(in_front_of(A, B, V), [the(A), v(is, 'is not'), 'in front of', the(B), view(V)]).
sentence(behind(A, B, V), [the(A), v(is, 'is not'), 'behind', the(B), view(V)]).
sentence(beside(A, B, V), [the(A), v(is, 'is not'), 'beside', the(B), view(V)]).
sentence(on_top_of(A, B), [the(A), v(is, 'is not'), 'on top of', the(B)]).
sentence(leans_on(A, B), [the(A), v('leans on', 'does not lean on'), the(B)]).
sentence(affixed_on(A, B), [the(A), v(is, 'is not'), 'affixed on', the(B)]).
sentence(adj_sr_card(A, B, N),
         [the(A), v(has, 'does not have'), cubic_metres(N), 'next to what it shares with', the(B)]).
sentence(part_in(A, B), [the(A), v(is, 'is not'), 'partly in', the(B)]).
sentence(inside(A, B), [the(A), v(is, 'is not'), 'inside', the(B)]).
sentence(near(A, B), [the(A), v(is, 'is not'), 'near', the(B)]).
sentence(label(O, Name, Score),
         [the(O), v(is, 'is not'), 'recognised as', name(Name), 'with a score of', number(Score)]).
sentence(measured_as(O, Model), [the(O), v(is, 'is not'), 'measured as its', name(Model)]).
sentence(view_label(V, Name), ['the view', name(V), v(is, 'is not'), 'called', name(Name)]).
sentence(withheld(R, V, _), ['the sides of', the(R), v('are not told', 'are told'), view(V)]).
sentence(threshold(Name, N), ['the threshold', name(Name), v(is, 'is not'), number(N)]).
sentence(pair(A, B, D, _, _, _, _, _, _),
         [the(A), 'and', the(B), v('were measured', 'were not measured'), metres(D), 'apart']).
sentence(aspect(V, A, B, _, _, _, _),
         ['the sides of', the(A), 'and', the(B), v('were measured', 'were not measured')|Seen]) :-
    seen(V, Seen).

%   support.pl

sentence(held_by(A, B), [the(A), v(is, 'is not'), 'held up by', the(B)]).
sentence(supported_by(A, B), [the(A), v(is, 'is not'), 'supported by', the(B)]).
sentence(supports(A, B), [the(A), v(supports, 'does not support'), the(B)]).

%   background.pl

sentence(kind_of(Name, Kind), [name(Name), v(is, 'is not'), 'a kind of', name(Kind)]).
sentence(a_kind_of(Name, Kind), [name(Name), v(is, 'is not'), 'a kind of', name(Kind)]).
sentence(made_of(Kind, Material), [name(Kind), v(is, 'is not'), 'made of', name(Material)]).
sentence(burns(Material), [name(Material), v(burns, 'does not burn')]).
sentence(heats(Kind), ['a', name(Kind), v('gives off', 'gives off no'), 'heat']).
sentence(needs_near(Kind, Other),
         ['a', name(Kind), v('must have', 'need not have'), 'a', name(Other), 'near']).

%   safety.pl

sentence(recognised_as(T, Name), [the(T), v(is, 'is not'), 'best recognised as', name(Name)]).
sentence(is_a(T, Kind), [the(T), v('counts as', 'does not count as'), name(Kind)]).
sentence(burnable(T, Material), [the(T), v(is, 'is not'), 'made of', name(Material), 'which burns']).
sentence(hot(T), [the(T), v('gives off', 'gives off no'), 'heat']).
sentence(in_contact(A, B), [the(A), v(is, 'is not'), 'in contact with', the(B)]).
sentence(on_wall(T, Wall), [the(T), v('hangs on', 'does not hang on'), the(Wall)]).
sentence(has_near(T, _, Other), [the(T), v(has, 'does not have'), the(Other), 'near']).
sentence(leans_against(T, Door), [the(T), v('leans against', 'does not lean against'), the(Door)]).
sentence(in_area(T, Area), [the(T), v(is, 'is not'), 'in', the(Area)]).
sentence(violation(extinguisher_off_wall, T),
         [the(T), v('must hang on a wall', 'hangs on a wall as it must')]).
sentence(violation(extinguisher_without_sign, T),
         [the(T), v('must have its sign near', 'has its sign near as it must')]).
sentence(violation(fire_hazard, T, Heater),
         [the(T), v('is a fire hazard', 'is no fire hazard'), 'on or against', the(Heater)]).
sentence(violation(fire_door_leant_on, T, Door),
         [the(T), v('must not lean on', 'does not lean on'), the(Door)]).
sentence(violation(heater_in_free_area, T, Area), [the(T), v('must not be in', 'is not in'), the(Area)]).
sentence(violation(Rule, T), [the(T), v(breaks, 'does not break'), 'the rule', name(Rule)]).
sentence(violation(Rule, T, Other),
         [the(T), v(breaks, 'does not break'), 'the rule', name(Rule), 'because of', the(Other)]).

%!  no_other(?Goal, ?Exception, ?Template) is nondet.
%
%   Template says that Goal holds of nothing other than Exception.

no_other(touches(_, F), R, ['nothing other than', the(R), 'touches', the(F)]).

%!  none(?Goal, ?Template) is nondet.
%
%   Template says that there is nothing of which Goal holds.

none(on_wall(T, _), ['no wall holds', the(T)]).
none((touches(F, S), below_r(S, F)), ['nothing that', the(F), 'touches is under', the(F)]).
none(has_near(T, Kind, _), ['no', name(Kind), 'is near', the(T)]).
none(burnable(T, _), [the(T), 'is not made of anything which burns']).
none((label(T, _, _), _ > _), ['no label of', the(T), 'scores higher']).

%!  differs(?A, ?B, ?Template) is det.
%
%   Template says that A is not B.

differs(A, B, [the(A), v('is other than', 'is no other than'), the(B)]).

%!  hindered(?What, ?Template) is nondet.
%
%   Template says what keeps a relation from being stated at all.

hindered(order(F, R), [the(F), v(is, 'is not'), 'the reference of the two, so people say where', the(R), v(is, 'is not')]).
hindered(withheld(_, _, Reason), [Reason]).
hindered(apart(F, R), [the(F), 'and', the(R), 'are beyond the reach of any relation']).

%   space_of(+Axis, +View, +Reference, +Tail, -Items): the halfspace, and whose view makes it so.

space_of(Axis, View, Reference, Tail, ['the space', Space, the(Reference)|Items]) :-
    (   var(Axis)
    ->  Space = beside
    ;   once(space(Axis, View, Space))
    ),
    (   nonvar(Axis), memberchk(Axis, ['Z+', 'Z-'])
    ->  Seen = []
    ;   seen(View, Seen)
    ),
    append(Seen, Tail, Items).

seen(View, Seen) :-
    (   View == world
    ->  Seen = []
    ;   Seen = [view(View)]
    ).

space('Z+', _, above).
space('Z-', _, below).
space('X+', View, 'east of') :- View == world.
space('X-', View, 'west of') :- View == world.
space('Y+', View, 'north of') :- View == world.
space('Y-', View, 'south of') :- View == world.
space('X+', _, behind).
space('X-', _, 'in front of').
space('Y+', _, 'left of').
space('Y-', _, 'right of').

%!  called(?Before, ?After) is det.
%
%   What stands before and after a label that names a thing.

called('the ', '').

%!  side(?Side, ?Before, ?After) is nondet.
%
%   The same where Side tells the thing from others of that label: left and right of two, leftmost and
%   rightmost of more; upper and lower, top and bottom.

side(left, 'the left ', '').
side(right, 'the right ', '').
side(leftmost, 'the leftmost ', '').
side(rightmost, 'the rightmost ', '').
side(upper, 'the upper ', '').
side(lower, 'the lower ', '').
side(top, 'the top ', '').
side(bottom, 'the bottom ', '').

%!  place(?Place, ?Words) is nondet.
%
%   Words between two names, as in "the cup on the shelf"; no Words end in others.

place(on, ' on ').
place(in, ' in ').
place(against, ' against ').
place(under, ' under ').
place(near, ' near ').

%!  said(?Name, ?Format) is nondet.
%
%   Formats of format/2 for what is said in and around sentences; each ~w is filled in. A language in which no
%   one pronoun stands for each thing in each place has none: its sentences name the thing again.

said(something, 'something').
said(it, 'it').
said(some_distance, 'some distance').
said(some_room, 'some room').
said(name, '~w').
said(centimetres, '~w cm').
said(metres, '~w m').
said(litres, '~w litres').
said(cubic_centimetres, '~w cubic centimetres').
said(seen_from, 'as seen from the ~w').
said(seen_by_you, 'from where you stand').
said(seen_somehow, 'from some view').
said(both, '~w and ~w').
said(not_so, 'it is not so that ~w').
said(short_by, 'short by ~w').
said(to_spare, '~w to spare').
said(aside, ' (~w)').
said(closest, ' (the closest is ~w, ~w)').
said(none_close, ' (nothing comes close)').
said(compared, '~w is ~w ~w').
said(hindered, '~w; ~w').
said(but, '~w, but ~w').
said(but_because, '~w, but ~w, because ~w').
said(both_hold, 'both hold: ~w, and ~w').
said(nothing_to_contrast, '~w: there is nothing to contrast').
said(it_holds, 'It does hold: ~w').
said(comes_closest, 'What comes closest:').

%!  connective(?Name, ?Words) is nondet.
%
%   Words without a place to fill in: between numbers by the operator of a comparison, and those that join
%   sentences, which are the fields of Words in deixis/wording.py.

connective(decimal_mark, '.').
connective(=<, 'at most').
connective(>=, 'at least').
connective(<, 'less than').
connective(>, 'more than').
connective(=:=, 'equal to').
connective(=\=, 'other than').
connective(because, 'because').
connective(and, 'and').
connective(no, 'No').
connective(nor, 'Nor by').
connective(closest, 'what comes closest').
connective(margin, 'margin').
connective(fails, 'fails').
connective(axiom, 'axiom').
