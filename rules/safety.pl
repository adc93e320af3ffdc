/** <module> Safety: what a Health and Safety inspector looks for

The rules of HanS, the robot inspector in the introduction of Chiatti et al. (KR 2021): a sweater left to dry
on an electric heater is a fire hazard, because it touches it, is made of cloth, and cloth burns; a fire
extinguisher hangs on a wall with its sign near. `deixis check SCENE` runs them.

A file of your own works the same way. Each breach of a rule is a clause of violation/2 or violation/3:

  - the first argument is the name of the rule, which `deixis check` lists and counts;
  - the second is the thing at fault, the third another thing that is needed to see why.

The comment in front of the first clause of a rule says what is wrong. Such a file has no module header,
since several files may state violations and be given together.
*/

:- use_module(facts).
:- use_module(topology).
:- use_module(direction).
:- use_module(commonsense).
:- use_module('../kb/background').

%!  recognised_as(?Thing, ?Name) is nondet.
%
%   Name is the best label of Thing: none has a higher score.

recognised_as(Thing, Name) :-
    label(Thing, Name, Score),
    \+ ( label(Thing, _, Better),
         Better > Score
       ).

%!  is_a(?Thing, ?Kind) is nondet.
%
%   Thing is called Kind, or what it is called is a kind of it.

is_a(Thing, Kind) :-
    recognised_as(Thing, Kind).
is_a(Thing, Kind) :-
    recognised_as(Thing, Name),
    a_kind_of(Name, Kind).

%!  burnable(?Thing, ?Material) is nondet.
%
%   Thing is made of Material, which burns.

burnable(Thing, Material) :-
    is_a(Thing, Kind),
    made_of(Kind, Material),
    burns(Material).

%!  hot(?Thing) is nondet.
%
%   Thing gives off heat.

hot(Thing) :-
    is_a(Thing, Kind),
    heats(Kind).

%!  in_contact(?Thing, ?Other) is nondet.
%
%   Thing touches Other or, as cloth that clogs a heater may, reaches into it.

in_contact(Thing, Other) :-
    touches(Thing, Other).
in_contact(Thing, Other) :-
    intersects(Thing, Other).

%!  on_wall(?Thing, ?Wall) is nondet.
%
%   Thing is affixed on Wall, which is one.

on_wall(Thing, Wall) :-
    affixed_on(Thing, Wall),
    is_a(Wall, wall).

%!  has_near(?Thing, ?Kind, ?Companion) is nondet.
%
%   Companion is a Kind and close to Thing, whichever of the two is the larger.

has_near(Thing, Kind, Companion) :-
    is_close(Thing, Companion),
    is_a(Companion, Kind).

%!  leans_against(?Thing, ?Door) is nondet.
%
%   Thing leans on Door as in axiom 37, whichever of the two is the larger: a wardrobe that is larger than
%   the door blocks it all the same. Walls and floors lean on nothing.

leans_against(Thing, Door) :-
    touches(Thing, Door),
    \+ surface(Thing),
    \+ above_r(Thing, Door),
    \+ below_r(Thing, Door),
    touches(Thing, Support),
    below_r(Support, Thing),
    Support \== Door.

%!  in_area(?Thing, ?Area) is nondet.
%
%   Thing is in Area: it shares room with it or, where Area is marked out on a floor, is over it, at most a
%   storey's height.

in_area(Thing, Area) :-
    intersects(Thing, Area).
in_area(Thing, Area) :-
    surface(Area),
    above_r(Thing, Area),
    distance(Thing, Area, Distance),
    Distance =< 2.5.

%!  violation(?Rule, ?Thing) is nondet.
%
%   Thing breaks Rule.

%   A fire extinguisher must be affixed on a wall.

violation(extinguisher_off_wall, Extinguisher) :-
    is_a(Extinguisher, 'fire extinguisher'),
    \+ on_wall(Extinguisher, _).

%   A fire extinguisher must have its sign near.

violation(extinguisher_without_sign, Extinguisher) :-
    is_a(Extinguisher, 'fire extinguisher'),
    needs_near('fire extinguisher', Sign),
    \+ has_near(Extinguisher, Sign, _).

%!  violation(?Rule, ?Thing, ?Other) is nondet.
%
%   Thing breaks Rule, because of Other.

%   Nothing that burns may be on or against a heater.

violation(fire_hazard, Thing, Heater) :-
    hot(Heater),
    in_contact(Thing, Heater),
    burnable(Thing, _).

%   Nothing may lean on a fire door.

violation(fire_door_leant_on, Thing, Door) :-
    is_a(Door, 'fire door'),
    leans_against(Thing, Door).

%   No heater may be in a heater-free area.

violation(heater_in_free_area, Heater, Area) :-
    is_a(Area, 'heater-free area'),
    in_area(Heater, Area),
    hot(Heater).
