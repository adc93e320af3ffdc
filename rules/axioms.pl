:- module(axioms,
          [ axiom/2,                    % ?Predicate, ?Number
            base/1,                     % ?Predicate
            relation/1                  % ?Predicate
          ]).

/** <module> Which axiom of the paper each predicate encodes

The numbers are the paper's, counted through the equations of its section 3. kb/axioms.md says the same at
length, with what we read differently.
*/

%!  axiom(?Predicate, ?Number) is nondet.
%
%   Predicate, as Name/Arity, encodes the axiom with this Number.

axiom(spatial_obj/1, 1).
axiom(distance/3, 14).
axiom(is_close/2, 15).
axiom(touches/2, 16).
axiom(intersects/2, 17).
axiom(intersection/3, 18).
axiom(compl_cont/2, 19).
axiom(halfspace/5, 20).
axiom(east_s/2, 21).
axiom(west_s/2, 21).
axiom(north_s/2, 21).
axiom(south_s/2, 21).
axiom(above_s/2, 21).
axiom(below_s/2, 21).
axiom(east_r/2, 22).
axiom(west_r/2, 23).
axiom(north_r/2, 24).
axiom(south_r/2, 25).
axiom(above_r/2, 26).
axiom(below_r/2, 27).
axiom(above/2, 28).
axiom(below/2, 29).
axiom(int_hs/4, 30).
axiom(cont_hs/4, 30).
axiom(right_of/3, 31).
axiom(left_of/3, 32).
axiom(in_front_of/3, 33).
axiom(behind/3, 34).
axiom(beside/3, 35).
axiom(on_top_of/2, 36).
axiom(leans_on/2, 37).
axiom(affixed_on/2, 38).
axiom(adj_sr_card/3, 39).
axiom(part_in/2, 40).
axiom(inside/2, 19).
axiom(near/2, 15).

%!  relation(?Predicate) is nondet.
%
%   Predicate is one that people speak in, drawn in figure-reference order.

relation(above/2).
relation(below/2).
relation(right_of/3).
relation(left_of/3).
relation(in_front_of/3).
relation(behind/3).
relation(beside/3).
relation(on_top_of/2).
relation(leans_on/2).
relation(affixed_on/2).
relation(part_in/2).
relation(inside/2).
relation(near/2).

%!  base(?Predicate) is nondet.
%
%   Predicate is a relation of the theory that the spoken ones are made of. It stands for both orders of a
%   pair, but for the horizontal cardinal ones, which are measured in figure-reference order only.

base(is_close/2).
base(touches/2).
base(intersects/2).
base(compl_cont/2).
base(east_s/2).
base(west_s/2).
base(north_s/2).
base(south_s/2).
base(above_s/2).
base(below_s/2).
base(east_r/2).
base(west_r/2).
base(north_r/2).
base(south_r/2).
base(above_r/2).
base(below_r/2).
