:- module(background,
          [ kind_of/2,                  % ?Name, ?Kind
            a_kind_of/2,                % ?Name, ?Kind
            made_of/2,                  % ?Kind, ?Material
            burns/1,                    % ?Material
            heats/1,                    % ?Kind
            needs_near/2                % ?Kind, ?Companion
          ]).

/** <module> Background knowledge: what no camera sees

What kinds of things there are, what they are made of, what burns, what is hot, what must be near what. All
of it is about labels, as the scene gives them: the names in lower case, several words in quotes. It is in
the subset that every engine runs; a file of your own may be put in its place.
*/

%!  kind_of(?Name, ?Kind) is nondet.
%
%   What is called Name is a Kind.

kind_of('electric heater', heater).
kind_of('portable heater', heater).
kind_of('fan heater', heater).
kind_of('space heater', heater).
kind_of(radiator, heater).
kind_of('electric radiator', heater).
kind_of('stove burner', hob).
kind_of('fire exit', 'fire door').
kind_of('emergency exit', 'fire door').
kind_of('extinguisher sign', 'fire extinguisher sign').
kind_of(sweater, clothes).
kind_of(jumper, clothes).
kind_of(shirt, clothes).
kind_of(coat, clothes).
kind_of(jacket, clothes).
kind_of(trousers, clothes).
kind_of(scarf, clothes).
kind_of(towel, textile).
kind_of('hand towel', textile).
kind_of(cloth, textile).
kind_of(blanket, textile).
kind_of(curtain, textile).
kind_of(rug, textile).
kind_of(pillow, textile).
kind_of(cushion, textile).
kind_of(clothes, textile).
kind_of(book, paperwork).
kind_of(newspaper, paperwork).
kind_of(magazine, paperwork).
kind_of('paper towel roll', paperwork).
kind_of('toilet paper', paperwork).

%!  a_kind_of(?Name, ?Kind) is nondet.
%
%   What is called Name is a Kind, over any number of steps: a sweater is clothes, and so textile.

a_kind_of(Name, Kind) :-
    kind_of(Name, Kind).
a_kind_of(Name, Kind) :-
    kind_of(Name, Between),
    a_kind_of(Between, Kind).

%!  made_of(?Kind, ?Material) is nondet.
%
%   A Kind is made of Material, or has enough of it to burn where that burns.

made_of(textile, cloth).
made_of(paperwork, paper).
made_of(carton, cardboard).
made_of(cardboard, cardboard).
made_of(broom, wood).
made_of('garbage bag', plastic).

%!  burns(?Material) is nondet.
%
%   Material catches fire when it gets hot.

burns(cloth).
burns(paper).
burns(cardboard).
burns(wood).
burns(plastic).

%!  heats(?Kind) is nondet.
%
%   A Kind gives off heat.

heats(heater).
heats(hob).

%!  needs_near(?Kind, ?Companion) is nondet.
%
%   A Kind must have a Companion near.

needs_near('fire extinguisher', 'fire extinguisher sign').
