:- module(facts,
          [ spatial_obj/1,              % ?Object
            surface/1,                  % ?Object
            label/3,                    % ?Object, ?Name, ?Score
            measured_as/2,              % ?Object, ?Model
            viewpoint/1,                % ?View
            view_label/2,               % ?View, ?Label
            threshold/2,                % ?Name, ?Value
            figure_reference/2,         % ?Figure, ?Reference
            pair/9,                     % ?Figure, ?Reference, measures ...
            aspect/7,                   % ?View, ?Figure, ?Reference, margins ...
            strict/5,                   % ?Figure, ?Reference, ?Axis, ?View, ?Margin
            withheld/3                  % ?Reference, ?View, ?Reason
          ]).

/** <module> The contract between geometry and logic

These are the base facts that a scene is grounded to. Geometry asserts them, rules read them, and nothing
else passes between the two. Every truth value of the theory is a comparison of one of these numbers with
another, made by a rule; so an explanation ends in numbers.

Lengths are metres, volumes cubic metres, in the world frame (right-handed, Z up). Arguments come in the
order figure, reference, view; only aspect/7, one row of a view's table, begins with its view.

```
?- pair(cup, table, Distance, Separation, _, _, _, _, _).
Distance = 0.0, Separation = -0.005.
```
*/

:- dynamic
    spatial_obj/1,
    surface/1,
    label/3,
    measured_as/2,
    viewpoint/1,
    view_label/2,
    threshold/2,
    figure_reference/2,
    pair/9,
    aspect/7,
    strict/5,
    withheld/3,
    box_volume/2.

%!  spatial_obj(?Object) is nondet.
%
%   Axioms 1-3. Object is a spatial object of the scene: it has a region, not empty and of one piece.

%!  surface(?Object) is nondet.
%
%   Object is a wall, floor or ceiling: a region of negligible thickness, always a reference.

%!  label(?Object, ?Name, ?Score) is nondet.
%
%   Object was recognised as a Name with a Score in [0, 1]; the best label comes first.

%!  measured_as(?Object, ?Model) is nondet.
%
%   What Object was measured as: its `box`, convex `hull` or `mesh`, or the `outline` of a flat surface. A
%   thing that has only a box is that box, whatever was asked for.

%!  viewpoint(?View) is nondet.
%
%   View is a pose that the scene is seen from: the robot's, or anyone's.

%!  view_label(?View, ?Label) is nondet.
%
%   Whose view it is, as in "as seen from the robot".

%!  threshold(?Name, ?Value) is nondet.
%
%   The numbers that the scene is read with: granularity (D, axiom 5), penetration (P), closeness (T,
%   axiom 15), halfspace_scale (s, axiom 20), pose_noise.

%!  figure_reference(?Figure, ?Reference) is nondet.
%
%   Section 4.2. People say where the figure is by the reference, which is a surface or the larger of the
%   two by the volume of its box. Conclusions are drawn in this order only.

%!  pair(?Figure, ?Reference, ?Distance, ?Separation, ?Protrusion, ?Intersection, ?Frontier, ?Up, ?Down) is nondet.
%
%   What was measured of two things within reach, in both orders:
%
%     - Distance, axiom 14
%     - Separation: the distance, or minus the least translation that parts the two
%     - Protrusion: how far Figure sticks out of Reference
%     - Intersection: the volume of inter, axiom 18
%     - Frontier: the measure of Figure's points adjacent to inter, axiom 39
%     - Up, Down: margins by which Figure meets Reference's halfspaces along Z+ and Z-

%!  aspect(?View, ?Figure, ?Reference, ?Away, ?Toward, ?Left, ?Right) is nondet.
%
%   Margins by which Figure meets Reference's halfspaces along X+, X-, Y+, Y- of the contextualised frame
%   of View; for the View `world`, of the world's axes.

%!  strict(?Figure, ?Reference, ?Axis, ?View, ?Margin) is nondet.
%
%   The Margin by which Figure, which meets Reference's halfspace along Axis, also lies completely in it.

%!  withheld(?Reference, ?View, ?Reason) is nondet.
%
%   Nothing is said of what is in front of, behind or beside Reference in View, for a Reason.

%   box_volume(?Object, ?Volume): the volume of Object's box. Not exported, since it is for sentences alone: they say
%   the order of figure and reference of things out of each other's reach too.
