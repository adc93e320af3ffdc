:- module(support,
          [ held_by/2,                  % ?Held, ?Holder
            supported_by/2,             % ?Upper, ?Lower
            supports/2                  % ?Lower, ?Upper
          ]).
:- use_module(facts).
:- use_module(topology).
:- use_module(commonsense).

/** <module> What holds what up

An example of rules of one's own, and recursive ones: load it with `--rules support`. A thing is held by
what it is on top of, leans on, hangs on, or is in; and by whatever holds that.

```
?- supported_by(sweater, What).
What = heater ;
What = floor.
```
*/

%!  held_by(?Held, ?Holder) is nondet.
%
%   Holder holds Held up by itself: Held is on top of it, leans on it, is affixed on it, is inside it or
%   partly in it. Take Holder away, and Held may fall.

held_by(Held, Holder) :-
    on_top_of(Held, Holder).
held_by(Held, Holder) :-
    leans_on(Held, Holder).
held_by(Held, Holder) :-
    affixed_on(Held, Holder).
held_by(Held, Holder) :-
    inside(Held, Holder).
held_by(Held, Holder) :-
    part_in(Held, Holder).

%!  supported_by(?Upper, ?Lower) is nondet.
%
%   Lower holds Upper up, by itself or through other things: a cup on a tray on a table is supported by the
%   tray, the table and the floor. No thing is supported by itself.

supported_by(Upper, Lower) :-
    held_by(Upper, Lower).
supported_by(Upper, Lower) :-
    held_by(Upper, Between),
    supported_by(Between, Lower),
    Lower \== Upper.

%!  supports(?Lower, ?Upper) is nondet.
%
%   The same, the other way round.

supports(Lower, Upper) :-
    supported_by(Upper, Lower).
