:- module(commonsense,
          [ beside/3,                   % ?Figure, ?Reference, ?View
            on_top_of/2,                % ?Figure, ?Reference
            leans_on/2,                 % ?Figure, ?Reference
            affixed_on/2,               % ?Figure, ?Reference
            adj_sr_card/3,              % ?Figure, ?Reference, ?Cardinality
            part_in/2,                  % ?Figure, ?Reference
            inside/2,                   % ?Figure, ?Reference
            near/2                      % ?Figure, ?Reference
          ]).
:- use_module(facts).
:- use_module(topology).
:- use_module(direction).

/** <module> Commonsense relations, axioms 35 to 40

What people say of where things are, from what was measured of them. Each rule is one axiom of Chiatti et
al. (KR 2021); the conclusions are drawn in figure-reference order.

```
?- on_top_of(sweater, What).
What = heater.
```
*/

%!  beside(?Figure, ?Reference, ?View) is nondet.
%
%   Axiom 35. Figure is beside Reference iff it is right or left of it.

beside(Figure, Reference, View) :-
    right_of(Figure, Reference, View).
beside(Figure, Reference, View) :-
    left_of(Figure, Reference, View).

%!  on_top_of(?Figure, ?Reference) is nondet.
%
%   Axiom 36. Figure is on top of Reference iff it is above it and touches it.

on_top_of(Figure, Reference) :-
    above(Figure, Reference),
    touches(Figure, Reference).

%!  leans_on(?Figure, ?Reference) is nondet.
%
%   Axiom 37. Figure leans on Reference iff it touches it, is neither above nor below it, and touches
%   something that is below Figure. The support may be larger than Figure, hence below_r/2 (axiom 29 read
%   in either order).

leans_on(Figure, Reference) :-
    figure_reference(Figure, Reference),
    touches(Figure, Reference),
    \+ above(Figure, Reference),
    \+ below(Figure, Reference),
    touches(Figure, Support),
    below_r(Support, Figure).

%!  affixed_on(?Figure, ?Reference) is nondet.
%
%   Axiom 38. Figure is affixed on Reference if it touches it, is not above it, and nothing other than
%   Reference touches Figure. The axiom as printed forgets "other than", and would never hold.

affixed_on(Figure, Reference) :-
    figure_reference(Figure, Reference),
    touches(Figure, Reference),
    \+ above(Figure, Reference),
    \+ ( touches(Other, Figure),
         Other \== Reference
       ).

%!  adj_sr_card(?Figure, ?Reference, ?Cardinality) is nondet.
%
%   Axiom 39. Cardinality is the measure of the points of Figure that are adjacent to the region common
%   to Figure and Reference.

adj_sr_card(Figure, Reference, Cardinality) :-
    pair(Figure, Reference, _, _, _, _, Cardinality, _, _).

%!  part_in(?Figure, ?Reference) is nondet.
%
%   Axiom 40. Figure is partly in Reference iff they intersect and less of Figure than of Reference is
%   adjacent to what they have in common.

part_in(Figure, Reference) :-
    figure_reference(Figure, Reference),
    intersects(Figure, Reference),
    adj_sr_card(Figure, Reference, OfFigure),
    adj_sr_card(Reference, Figure, OfReference),
    OfFigure < OfReference.

%!  inside(?Figure, ?Reference) is nondet.
%
%   Axiom 19 as people say it: Figure is inside Reference iff Reference completely contains it.

inside(Figure, Reference) :-
    figure_reference(Figure, Reference),
    compl_cont(Reference, Figure).

%!  near(?Figure, ?Reference) is nondet.
%
%   Axiom 15 as people say it: Figure is near Reference iff it is close to it.

near(Figure, Reference) :-
    figure_reference(Figure, Reference),
    is_close(Figure, Reference).
