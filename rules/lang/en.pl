:- module(en,
          [ sentence/2,                 % ?Goal, ?Template
            no_other/3,                 % ?Goal, ?Exception, ?Template
            none/2,                     % ?Goal, ?Template
            hindered/2,                 % ?What, ?Template
            space/3,                    % ?Axis, ?View, ?Words
            called/2,                   % ?Before, ?After
            side/3,                     % ?Side, ?Before, ?After
            place/2,                    % ?Place, ?Words
            phrase/2,                   % ?Name, ?Format
            connective/2                % ?Name, ?Words
          ]).

:- use_module('../facts').

:- multifile words:speaks/1.
:- dynamic words:speaks/1.

words:speaks(en).

/** <module> English

One template for each predicate. In a template the(X) names an object, name(X) is a name as it stands,
view(V) says whose view it is, metres(N) a length, is and v(Yes, No) are the verb, which negation turns round;
anything else stands for itself. Another language is another file with the same predicates.
*/

%!  sentence(?Goal, ?Template) is nondet.
%
%   Template says Goal in English.

sentence(spatial_obj(O), [the(O), is, 'an object of this scene']).
sentence(surface(O), [the(O), is, 'a surface']).
sentence(figure_reference(_, R), [the(R), is, 'the reference, being a surface']) :-
    nonvar(R), surface(R), !.
sentence(figure_reference(F, R), [the(R), is, 'the reference, being not smaller than', the(F)]).
sentence(viewpoint(V), ['there', is, 'a view', view(V)]).
sentence(distance(A, B, N), [the(A), 'and', the(B), v(are, 'are not'), metres(N), 'apart']).
sentence(separation(A, B, N), ['the gap between', the(A), 'and', the(B), is, metres(N)]) :-
    ( var(N) ; N >= 0 ), !.
sentence(separation(A, B, N), [the(A), 'and', the(B), v(overlap, 'do not overlap'), 'by', metres(Depth)]) :-
    Depth is -N.
sentence(is_close(A, B), [the(A), is, 'close to', the(B)]).
sentence(touches(A, B), [the(A), v(touches, 'does not touch'), the(B)]).
sentence(intersects(A, B), [the(A), 'and', the(B), v('share room', 'share no room')]).
sentence(intersection(A, B, N), [the(A), 'and', the(B), v(share, 'do not share'), cubic_metres(N)]).
sentence(protrusion(A, B, N), [the(A), v('sticks out of', 'does not stick out of'), the(B), 'by', metres(N)]) :-
    ( var(N) ; N >= 0 ), !.
sentence(protrusion(A, B, N), [the(A), v(lies, 'does not lie'), metres(Depth), 'within', the(B)]) :-
    Depth is -N.
sentence(compl_cont(A, B), [the(A), v('wholly contains', 'does not wholly contain'), the(B)]).
sentence(halfspace(A, B, Axis, V, N), [the(A), 'reaches into the space', Space, the(B), 'with', metres(N), 'to spare']) :-
    ( var(N) ; N >= 0 ), !, space(Axis, V, Space).
sentence(halfspace(A, B, Axis, V, N), [the(A), 'misses the space', Space, the(B), 'by', metres(By)]) :-
    By is -N, space(Axis, V, Space).
sentence(strict(A, B, Axis, V, N), [the(A), is, metres(N), 'within the space', Space, the(B)]) :-
    space(Axis, V, Space).
sentence(int_hs(A, B, Axis, V), [the(A), v('reaches into', 'does not reach into'), 'the space', Space, the(B)]) :-
    space(Axis, V, Space).
sentence(cont_hs(A, B, Axis, V), [the(A), v('lies wholly in', 'does not lie wholly in'), 'the space', Space, the(B)]) :-
    space(Axis, V, Space).
sentence(east_s(A, B), [the(A), is, 'wholly east of', the(B)]).
sentence(west_s(A, B), [the(A), is, 'wholly west of', the(B)]).
sentence(north_s(A, B), [the(A), is, 'wholly north of', the(B)]).
sentence(south_s(A, B), [the(A), is, 'wholly south of', the(B)]).
sentence(above_s(A, B), [the(A), is, 'wholly over', the(B)]).
sentence(below_s(A, B), [the(A), is, 'wholly under', the(B)]).
sentence(east_r(A, B), [the(A), is, 'east of', the(B)]).
sentence(west_r(A, B), [the(A), is, 'west of', the(B)]).
sentence(north_r(A, B), [the(A), is, 'north of', the(B)]).
sentence(south_r(A, B), [the(A), is, 'south of', the(B)]).
sentence(above_r(A, B), [the(A), is, 'over', the(B)]).
sentence(below_r(A, B), [the(A), is, 'under', the(B)]).
sentence(above(A, B), [the(A), is, 'above', the(B)]).
sentence(below(A, B), [the(A), is, 'below', the(B)]).
sentence(right_of(A, B, V), [the(A), is, 'right of', the(B), view(V)]).
sentence(left_of(A, B, V), [the(A), is, 'left of', the(B), view(V)]).
sentence(in_front_of(A, B, V), [the(A), is, 'in front of', the(B), view(V)]).
sentence(behind(A, B, V), [the(A), is, 'behind', the(B), view(V)]).
sentence(beside(A, B, V), [the(A), is, 'beside', the(B), view(V)]).
sentence(on_top_of(A, B), [the(A), is, 'on top of', the(B)]).
sentence(leans_on(A, B), [the(A), v('leans on', 'does not lean on'), the(B)]).
sentence(affixed_on(A, B), [the(A), is, 'affixed on', the(B)]).
sentence(adj_sr_card(A, B, N), [the(A), v(has, 'does not have'), cubic_metres(N), 'next to what it shares with', the(B)]).
sentence(part_in(A, B), [the(A), is, 'partly in', the(B)]).
sentence(inside(A, B), [the(A), is, 'inside', the(B)]).
sentence(near(A, B), [the(A), is, 'near', the(B)]).
sentence(label(O, Name, _), [the(O), is, 'recognised as', Name]).

%   support.pl

sentence(held_by(A, B), [the(A), is, 'held up by', the(B)]).
sentence(supported_by(A, B), [the(A), is, 'supported by', the(B)]).
sentence(supports(A, B), [the(A), v(supports, 'does not support'), the(B)]).

%   background.pl

sentence(kind_of(Name, Kind), [name(Name), is, 'a kind of', name(Kind)]).
sentence(a_kind_of(Name, Kind), [name(Name), is, 'a kind of', name(Kind)]).
sentence(made_of(Kind, Material), [name(Kind), is, 'made of', name(Material)]).
sentence(burns(Material), [name(Material), v(burns, 'does not burn')]).
sentence(heats(Kind), ['a', name(Kind), v('gives off', 'gives off no'), 'heat']).
sentence(needs_near(Kind, Other), ['a', name(Kind), v('must have', 'need not have'), 'a', name(Other), 'near']).

%   safety.pl

sentence(recognised_as(T, Name), [the(T), is, 'best recognised as', name(Name)]).
sentence(is_a(T, Kind), [the(T), v('counts as', 'does not count as'), name(Kind)]).
sentence(burnable(T, Material), [the(T), is, 'made of', name(Material), 'which burns']).
sentence(hot(T), [the(T), v('gives off', 'gives off no'), 'heat']).
sentence(in_contact(A, B), [the(A), is, 'in contact with', the(B)]).
sentence(on_wall(T, Wall), [the(T), v('hangs on', 'does not hang on'), the(Wall)]).
sentence(has_near(T, _, Other), [the(T), v(has, 'does not have'), the(Other), 'near']).
sentence(leans_against(T, Door), [the(T), v('leans against', 'does not lean against'), the(Door)]).
sentence(in_area(T, Area), [the(T), is, 'in', the(Area)]).
sentence(violation(extinguisher_off_wall, T), [the(T), v('must hang on a wall', 'hangs on a wall as it must')]).
sentence(violation(extinguisher_without_sign, T), [the(T), v('must have its sign near', 'has its sign near as it must')]).
sentence(violation(fire_hazard, T, Heater), [the(T), v('is a fire hazard', 'is no fire hazard'), 'on or against', the(Heater)]).
sentence(violation(fire_door_leant_on, T, Door), [the(T), v('must not lean on', 'does not lean on'), the(Door)]).
sentence(violation(heater_in_free_area, T, Area), [the(T), v('must not be in', 'is not in'), the(Area)]).
sentence(violation(Rule, T), [the(T), v(breaks, 'does not break'), 'the rule', name(Rule)]).
sentence(violation(Rule, T, Other), [the(T), v(breaks, 'does not break'), 'the rule', name(Rule), 'because of', the(Other)]).

%!  no_other(?Goal, ?Exception, ?Template) is nondet.
%
%   Template says that Goal holds of nothing other than Exception.

no_other(touches(_, F), R, ['nothing other than', the(R), 'touches', the(F)]).

%!  none(?Goal, ?Template) is nondet.
%
%   Template says that there is nothing of which Goal holds.

none(on_wall(T, _), ['no wall holds', the(T)]).
none(has_near(T, Kind, _), ['no', name(Kind), 'is near', the(T)]).
none((label(T, _, _), _ > _), ['no label of', the(T), 'scores higher']).

%!  hindered(?What, ?Template) is nondet.
%
%   Template says what keeps a relation from being stated at all.

hindered(order(F, R), [the(F), is, 'the reference of the two, so people say where', the(R), is]).
hindered(apart(F, R), [the(F), 'and', the(R), 'are beyond the reach of any relation']).

%!  space(?Axis, ?View, ?Words) is nondet.
%
%   Words for the halfspace along Axis: in the world's frame, and in a view's.

space('Z+', _, 'above').
space('Z-', _, 'below').
space('X+', world, 'east of') :- !.
space('X-', world, 'west of') :- !.
space('Y+', world, 'north of') :- !.
space('Y-', world, 'south of') :- !.
space('X+', _, 'behind').
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
%   Formats of format/2 for what is said around sentences; each ~w is filled in.

said(seen_from, 'as seen from the ~w').
said(seen_by_you, 'from where you stand').
said(seen_somehow, 'from some view').

%!  connective(?Name, ?Words) is nondet.
%
%   The small words that join sentences.

connective(because, 'because').
connective(and, 'and').
connective(at_most, 'at most').
connective(at_least, 'at least').
connective(less, 'less than').
connective(more, 'more than').
connective(equal, 'equal to').
connective(unequal, 'other than').
connective(to_spare, 'to spare').
connective(short_by, 'short by').
connective(no_way, 'it is not so that').
connective(closest, 'the closest is').
connective(none_close, 'nothing within reach comes close').
