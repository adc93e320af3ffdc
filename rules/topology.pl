:- module(topology,
          [ distance/3,                 % ?A, ?B, ?Distance
            separation/3,               % ?A, ?B, ?Separation
            is_close/2,                 % ?A, ?B
            touches/2,                  % ?A, ?B
            intersects/2,               % ?A, ?B
            intersection/3,             % ?A, ?B, ?Volume
            protrusion/3,               % ?Content, ?Container, ?Protrusion
            compl_cont/2                % ?Container, ?Content
          ]).
:- use_module(facts).

/** <module> Metric and topological relations, axioms 14 to 19

Relations that hold whichever way one looks: how far, touching, overlapping, containing. They stand for
both orders of a pair.
*/

%!  distance(?A, ?B, ?Distance) is nondet.
%
%   Axiom 14. Distance is the least distance between a point of A and a point of B.

distance(A, B, Distance) :-
    pair(A, B, Distance, _, _, _, _, _, _).

%!  separation(?A, ?B, ?Separation) is nondet.
%
%   Separation is the distance of A and B or, where they overlap, minus the least translation that parts
%   them.

separation(A, B, Separation) :-
    pair(A, B, _, Separation, _, _, _, _, _).

%!  is_close(?A, ?B) is nondet.
%
%   Axiom 15. A is close to B iff their distance is at most T.

is_close(A, B) :-
    distance(A, B, Distance),
    threshold(closeness, T),
    Distance =< T.

%!  touches(?A, ?B) is nondet.
%
%   Axiom 16. A touches B iff the gap between them is at most D, or they overlap by at most P: sensed
%   regions are never exact, and the paper's "distance = D" would almost never hold.

touches(A, B) :-
    separation(A, B, Separation),
    threshold(granularity, D),
    Separation =< D,
    threshold(penetration, P),
    Separation >= -P.

%!  intersects(?A, ?B) is nondet.
%
%   Axiom 17. A intersects B iff they overlap by more than contact does.

intersects(A, B) :-
    separation(A, B, Separation),
    threshold(penetration, P),
    Separation < -P.

%!  intersection(?A, ?B, ?Volume) is nondet.
%
%   Axiom 18. Volume is that of inter, the region common to A and B.

intersection(A, B, Volume) :-
    pair(A, B, _, _, _, Volume, _, _, _).

%!  protrusion(?Content, ?Container, ?Protrusion) is nondet.
%
%   Protrusion is how far Content sticks out of Container; it is negative well within.

protrusion(Content, Container, Protrusion) :-
    pair(Content, Container, _, _, Protrusion, _, _, _, _).

%!  compl_cont(?Container, ?Content) is nondet.
%
%   Axiom 19. Container completely contains Content iff they intersect and Content sticks out by at most
%   D. Container comes first, as in the paper.

compl_cont(Container, Content) :-
    intersects(Container, Content),
    protrusion(Content, Container, Protrusion),
    threshold(granularity, D),
    Protrusion =< D.
