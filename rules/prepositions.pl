:- module(prepositions,
          [ fits/3,                     % ?Word, ?Figure, ?Ground
            fits/4,                     % ?Word, ?Figure, ?Ground, ?View
            movable/1,                  % ?Thing
            over_some/2,                % ?Upper, ?Lower
            one_ground/3,               % ?Figure, ?Other, ?Support
            as_high/2,                  % ?Ground, ?Figure
            stands_by/2,                % ?Figure, ?Ground
            rests_on/2,                 % ?Figure, ?Ground
            sideways/2,                 % ?Figure, ?Ground
            enters/2,                   % ?Figure, ?Ground
            heaped_in/2,                % ?Figure, ?Ground
            hovers/2,                   % ?Figure, ?Ground
            lower/2,                    % ?Figure, ?Ground
            apart/2,                    % ?Figure, ?Ground
            aside/2                     % ?Figure, ?Ground
          ]).
:- use_module(facts).
:- use_module(topology).
:- use_module(direction).
:- use_module(commonsense).

/** <module> Which words a person would accept

A relation is one thing, the word for it another: people say "above" only of what does not rest there, and
"on" of a clock on a wall as of a cup on a table. They also place a larger thing by a smaller one ("the table
is below the balloon"), which the theory's conclusions never do. So these rules read the base relations, which
stand for both orders of a pair, in the order in which people are asked: figure, ground.

kb/lexicon.ttl says which words there are and which relations of the theory they stand for.

```
?- fits(Word, sweater, heater).
Word = on ;
Word = 'on top of'.
```
*/

%!  movable(?Thing) is nondet.
%
%   Thing is no wall, floor or ceiling: of those nobody says where they are.

movable(Thing) :-
    spatial_obj(Thing),
    \+ surface(Thing).

%!  over_some(?Upper, ?Lower) is nondet.
%
%   A part of Upper is over a part of Lower: Upper reaches into the space above Lower, or Lower into the
%   space below Upper. How far these spaces reach depends on how large a thing is, so one may be short of
%   what the other meets.

over_some(Upper, Lower) :-
    above_r(Upper, Lower).
over_some(Upper, Lower) :-
    below_r(Lower, Upper).

%!  as_high(?Ground, ?Figure) is nondet.
%
%   Ground, on which Figure rests, reaches at least as high. To meet the space above Figure it would have to be
%   D higher than Figure, so it is short of that by D at most.

as_high(Ground, Figure) :-
    halfspace(Ground, Figure, 'Z+', world, Margin),
    threshold(granularity, D),
    Margin >= -D.

%!  one_ground(?Figure, ?Other, ?Support) is nondet.
%
%   Figure and Other stand on the same Support: both touch it from above.

one_ground(Figure, Other, Support) :-
    touches(Figure, Support),
    below_r(Support, Figure),
    touches(Other, Support),
    below_r(Support, Other).

%!  stands_by(?Figure, ?Ground) is nondet.
%
%   Figure touches Ground and stands on what Ground stands on, which is closer to it than Ground is: a pencil
%   that leans on the foot of a mug is over some of the mug but does not rest on it. An apple on a thin plate
%   is within the contact band of the table too, but closer to the plate.

stands_by(Figure, Ground) :-
    touches(Figure, Ground),
    one_ground(Figure, Ground, Support),
    separation(Figure, Support, ToSupport),
    separation(Figure, Ground, ToGround),
    ToSupport < ToGround.

%!  rests_on(?Figure, ?Ground) is nondet.
%
%   Figure touches Ground from above.

rests_on(Figure, Ground) :-
    movable(Figure),
    above_r(Figure, Ground),
    touches(Figure, Ground),
    \+ stands_by(Figure, Ground).

%!  sideways(?Figure, ?Ground) is nondet.
%
%   Figure touches Ground, and neither is over the other.

sideways(Figure, Ground) :-
    movable(Figure),
    touches(Figure, Ground),
    \+ over_some(Figure, Ground),
    \+ over_some(Ground, Figure).

%!  enters(?Figure, ?Ground) is nondet.
%
%   Figure is within Ground, or partly (axioms 19 and 40): nobody says that the shelf is in the vase.

enters(Figure, Ground) :-
    movable(Figure),
    inside(Figure, Ground).
enters(Figure, Ground) :-
    movable(Figure),
    part_in(Figure, Ground).

%!  heaped_in(?Figure, ?Ground) is nondet.
%
%   Figure touches Ground and something that is in it, and rests on one of the two: fruit on the fruit in a
%   bowl is in the bowl, also where it is higher than the rim. A chair that is pushed into a table's box
%   stands on the same floor, and makes nothing be in the table.

heaped_in(Figure, Ground) :-
    figure_reference(Figure, Ground),
    enters(Content, Ground),
    \+ one_ground(Content, Ground, _),
    touches(Figure, Content),
    touches(Figure, Ground),
    rests_on(Figure, Ground).
heaped_in(Figure, Ground) :-
    figure_reference(Figure, Ground),
    enters(Content, Ground),
    \+ one_ground(Content, Ground, _),
    rests_on(Figure, Content),
    touches(Figure, Ground).

%!  hovers(?Figure, ?Ground) is nondet.
%
%   Figure is over some of Ground and does not touch it from above: a lamp over a table, and a balloon at the
%   edge of a table that it overhangs.

hovers(Figure, Ground) :-
    apart(Figure, Ground),
    above_r(Figure, Ground).
hovers(Figure, Ground) :-
    movable(Figure),
    below_r(Ground, Figure),
    \+ above_r(Figure, Ground),
    \+ intersects(Figure, Ground).

%!  lower(?Figure, ?Ground) is nondet.
%
%   Some of Ground is over Figure, be it on it, and the two do not overlap.

lower(Figure, Ground) :-
    movable(Figure),
    over_some(Ground, Figure),
    \+ intersects(Figure, Ground).

%!  apart(?Figure, ?Ground) is nondet.
%
%   Figure is within reach of Ground, and neither touches nor overlaps it.

apart(Figure, Ground) :-
    movable(Figure),
    separation(Figure, Ground, Separation),
    threshold(granularity, D),
    Separation > D.

%!  fits(?Word, ?Figure, ?Ground) is nondet.
%
%   A person would accept Word for where Figure is by Ground, wherever one stands.

fits(in, Figure, Ground) :-
    enters(Figure, Ground).
fits(in, Figure, Ground) :-
    heaped_in(Figure, Ground).
fits(inside, Figure, Ground) :-
    enters(Figure, Ground).
fits(on, Figure, Ground) :-
    rests_on(Figure, Ground).
fits(on, Figure, Ground) :-             % a clock on a wall, a lamp on a ceiling
    affixed_on(Figure, Ground),
    \+ over_some(Figure, Ground).
fits('on top of', Figure, Ground) :-     % a mug within a shelf is on it
    rests_on(Figure, Ground),
    \+ as_high(Ground, Figure).
fits(against, Figure, Ground) :-
    sideways(Figure, Ground).
fits(against, Figure, Ground) :-        % a pencil at the foot of a mug
    movable(Figure),
    stands_by(Figure, Ground),
    \+ over_some(Ground, Figure).
fits('leaning on', Figure, Ground) :-
    leans_on(Figure, Ground).
fits('affixed to', Figure, Ground) :-
    affixed_on(Figure, Ground).
fits(touching, Figure, Ground) :-
    movable(Figure),
    touches(Figure, Ground).
fits(above, Figure, Ground) :-
    hovers(Figure, Ground).
fits(over, Figure, Ground) :-
    hovers(Figure, Ground).
fits(below, Figure, Ground) :-
    lower(Figure, Ground).
fits(under, Figure, Ground) :-
    lower(Figure, Ground).
fits(near, Figure, Ground) :-
    apart(Figure, Ground),
    is_close(Figure, Ground).
fits('north of', Figure, Ground) :-
    north_r(Figure, Ground),
    aside(Figure, Ground).
fits('south of', Figure, Ground) :-
    south_r(Figure, Ground),
    aside(Figure, Ground).
fits('east of', Figure, Ground) :-
    east_r(Figure, Ground),
    aside(Figure, Ground).
fits('west of', Figure, Ground) :-
    west_r(Figure, Ground),
    aside(Figure, Ground).

%!  fits(?Word, ?Figure, ?Ground, ?View) is nondet.
%
%   A person would accept Word for where Figure is by Ground as seen from View: what is on, in, over or
%   under Ground is not beside it.

fits('left of', Figure, Ground, View) :-
    left_of(Figure, Ground, View),
    aside(Figure, Ground).
fits('right of', Figure, Ground, View) :-
    right_of(Figure, Ground, View),
    aside(Figure, Ground).
fits('in front of', Figure, Ground, View) :-
    in_front_of(Figure, Ground, View),
    aside(Figure, Ground).
fits(behind, Figure, Ground, View) :-
    behind(Figure, Ground, View),
    aside(Figure, Ground).
fits(beside, Figure, Ground, View) :-
    beside(Figure, Ground, View),
    aside(Figure, Ground).

%!  aside(?Figure, ?Ground) is nondet.
%
%   Figure is apart from Ground or at its side, and neither is over the other.

aside(Figure, Ground) :-
    apart(Figure, Ground),
    \+ over_some(Figure, Ground),
    \+ over_some(Ground, Figure).
aside(Figure, Ground) :-
    sideways(Figure, Ground).
