:- module(direction,
          [ halfspace/5,                % ?Figure, ?Reference, ?Axis, ?View, ?Margin
            int_hs/4,                   % ?Figure, ?Reference, ?Axis, ?View
            cont_hs/4,                  % ?Figure, ?Reference, ?Axis, ?View
            east_s/2,                   % ?Figure, ?Reference
            west_s/2,                   % ?Figure, ?Reference
            north_s/2,                  % ?Figure, ?Reference
            south_s/2,                  % ?Figure, ?Reference
            above_s/2,                  % ?Figure, ?Reference
            below_s/2,                  % ?Figure, ?Reference
            east_r/2,                   % ?Figure, ?Reference
            west_r/2,                   % ?Figure, ?Reference
            north_r/2,                  % ?Figure, ?Reference
            south_r/2,                  % ?Figure, ?Reference
            above_r/2,                  % ?Figure, ?Reference
            below_r/2,                  % ?Figure, ?Reference
            above/2,                    % ?Figure, ?Reference
            below/2,                    % ?Figure, ?Reference
            right_of/3,                 % ?Figure, ?Reference, ?View
            left_of/3,                  % ?Figure, ?Reference, ?View
            in_front_of/3,              % ?Figure, ?Reference, ?View
            behind/3                    % ?Figure, ?Reference, ?View
          ]).
:- use_module(facts).

/** <module> Directional relations, axioms 20 to 34

A halfspace of a reference is its box swept outwards along one of its axes. Along the vertical the box is
the minimum bounding box, the same for every view. Along the horizontal axes it is the contextualised box,
turned to the line of sight: X+ points away from the viewer, Y+ to the viewer's left. In the view `world`
the axes are the world's, X+ for east and Y+ for north.

Relaxed relations (_r) ask for a common part, strict ones (_s) for complete containment.
*/

%!  halfspace(?Figure, ?Reference, ?Axis, ?View, ?Margin) is nondet.
%
%   Axioms 20 and 30. Figure would have to move by Margin metres for "it meets the halfspace of Reference
%   along Axis, seen from View" to change; the margin is not negative iff it does meet it.

halfspace(Figure, Reference, 'X+', View, Margin) :-
    aspect(View, Figure, Reference, Margin, _, _, _).
halfspace(Figure, Reference, 'X-', View, Margin) :-
    aspect(View, Figure, Reference, _, Margin, _, _).
halfspace(Figure, Reference, 'Y+', View, Margin) :-
    aspect(View, Figure, Reference, _, _, Margin, _).
halfspace(Figure, Reference, 'Y-', View, Margin) :-
    aspect(View, Figure, Reference, _, _, _, Margin).
halfspace(Figure, Reference, 'Z+', world, Margin) :-
    pair(Figure, Reference, _, _, _, _, _, Margin, _).
halfspace(Figure, Reference, 'Z-', world, Margin) :-
    pair(Figure, Reference, _, _, _, _, _, _, Margin).

%!  int_hs(?Figure, ?Reference, ?Axis, ?View) is nondet.
%
%   Axiom 30. Figure meets the halfspace of Reference along Axis, seen from View: Int(hs, sReg).

int_hs(Figure, Reference, Axis, View) :-
    halfspace(Figure, Reference, Axis, View, Margin),
    Margin >= 0.

%!  cont_hs(?Figure, ?Reference, ?Axis, ?View) is nondet.
%
%   Axiom 30. Figure lies completely in the halfspace of Reference along Axis, seen from View:
%   ComplCont(hs, sReg).

cont_hs(Figure, Reference, Axis, View) :-
    strict(Figure, Reference, Axis, View, Margin),
    Margin >= 0.

%!  east_s(?Figure, ?Reference) is nondet.
%
%   Axiom 21. Figure lies completely east of Reference, by the axes of the world.

east_s(Figure, Reference) :-
    cont_hs(Figure, Reference, 'X+', world).

%!  west_s(?Figure, ?Reference) is nondet.
%
%   Axiom 21, for the axis of axiom 23. Figure lies completely west of Reference, by the axes of the world.

west_s(Figure, Reference) :-
    cont_hs(Figure, Reference, 'X-', world).

%!  north_s(?Figure, ?Reference) is nondet.
%
%   Axiom 21, for the axis of axiom 24. Figure lies completely north of Reference, by the axes of the world.

north_s(Figure, Reference) :-
    cont_hs(Figure, Reference, 'Y+', world).

%!  south_s(?Figure, ?Reference) is nondet.
%
%   Axiom 21, for the axis of axiom 25. Figure lies completely south of Reference, by the axes of the world.

south_s(Figure, Reference) :-
    cont_hs(Figure, Reference, 'Y-', world).

%!  above_s(?Figure, ?Reference) is nondet.
%
%   Axiom 21, for the axis of axiom 26. Figure lies completely above Reference, by the axes of the world.

above_s(Figure, Reference) :-
    cont_hs(Figure, Reference, 'Z+', world).

%!  below_s(?Figure, ?Reference) is nondet.
%
%   Axiom 21, for the axis of axiom 27. Figure lies completely below Reference, by the axes of the world.

below_s(Figure, Reference) :-
    cont_hs(Figure, Reference, 'Z-', world).

%!  east_r(?Figure, ?Reference) is nondet.
%
%   Axiom 22. A part of Figure lies east of Reference, by the axes of the world.

east_r(Figure, Reference) :-
    int_hs(Figure, Reference, 'X+', world).

%!  west_r(?Figure, ?Reference) is nondet.
%
%   Axiom 23. A part of Figure lies west of Reference, by the axes of the world.

west_r(Figure, Reference) :-
    int_hs(Figure, Reference, 'X-', world).

%!  north_r(?Figure, ?Reference) is nondet.
%
%   Axiom 24. A part of Figure lies north of Reference, by the axes of the world.

north_r(Figure, Reference) :-
    int_hs(Figure, Reference, 'Y+', world).

%!  south_r(?Figure, ?Reference) is nondet.
%
%   Axiom 25. A part of Figure lies south of Reference, by the axes of the world.

south_r(Figure, Reference) :-
    int_hs(Figure, Reference, 'Y-', world).

%!  above_r(?Figure, ?Reference) is nondet.
%
%   Axiom 26. A part of Figure lies above Reference, by the axes of the world.

above_r(Figure, Reference) :-
    int_hs(Figure, Reference, 'Z+', world).

%!  below_r(?Figure, ?Reference) is nondet.
%
%   Axiom 27. A part of Figure lies below Reference, by the axes of the world.

below_r(Figure, Reference) :-
    int_hs(Figure, Reference, 'Z-', world).

%!  above(?Figure, ?Reference) is nondet.
%
%   Axiom 28. Figure is above Reference iff a part of it meets the halfspace on top of Reference. All
%   vertical axes coincide, so the view does not matter.

above(Figure, Reference) :-
    figure_reference(Figure, Reference),
    above_r(Figure, Reference).

%!  below(?Figure, ?Reference) is nondet.
%
%   Axiom 29. Figure is below Reference iff a part of it meets the halfspace under Reference.

below(Figure, Reference) :-
    figure_reference(Figure, Reference),
    below_r(Figure, Reference).

%!  right_of(?Figure, ?Reference, ?View) is nondet.
%
%   Axiom 31. Seen from View, a part of Figure meets the halfspace on Reference's right side.

right_of(Figure, Reference, View) :-
    viewpoint(View),
    figure_reference(Figure, Reference),
    int_hs(Figure, Reference, 'Y-', View).

%!  left_of(?Figure, ?Reference, ?View) is nondet.
%
%   Axiom 32. Seen from View, a part of Figure meets the halfspace on Reference's left side.

left_of(Figure, Reference, View) :-
    viewpoint(View),
    figure_reference(Figure, Reference),
    int_hs(Figure, Reference, 'Y+', View).

%!  in_front_of(?Figure, ?Reference, ?View) is nondet.
%
%   Axiom 33. Seen from View, a part of Figure meets the halfspace on Reference's side towards the viewer.

in_front_of(Figure, Reference, View) :-
    viewpoint(View),
    figure_reference(Figure, Reference),
    int_hs(Figure, Reference, 'X-', View).

%!  behind(?Figure, ?Reference, ?View) is nondet.
%
%   Axiom 34. Seen from View, a part of Figure meets the halfspace on Reference's side away from the viewer.

behind(Figure, Reference, View) :-
    viewpoint(View),
    figure_reference(Figure, Reference),
    int_hs(Figure, Reference, 'X+', View).
