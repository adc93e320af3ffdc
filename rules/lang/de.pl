:- module(de,
          [ sentence/2,                 % ?Goal, ?Template
            no_other/3,                 % ?Goal, ?Exception, ?Template
            none/2,                     % ?Goal, ?Template
            differs/3,                  % ?A, ?B, ?Template
            hindered/2,                 % ?What, ?Template
            called/2,                   % ?Before, ?After
            side/3,                     % ?Side, ?Before, ?After
            place/2,                    % ?Place, ?Words
            said/2,                     % ?Name, ?Format
            connective/2                % ?Name, ?Words
          ]).
:- use_module(library(lists), [append/3]).
:- use_module('../facts').

:- multifile words:speaks/1.
:- dynamic words:speaks/1.

words:speaks(de).

/** <module> German

The same predicates as in en.pl. A label is a word of any language and of unknown gender, so it stands in
quotation marks, without an article, and in constructions where neither it nor what refers to it is inflected.
*/

%!  sentence(?Goal, ?Template) is nondet.
%
%   Template says Goal in German.

sentence(spatial_obj(O), [the(O), v(ist, 'ist nicht'), 'in dieser Szene']).
sentence(surface(O), [the(O), v('ist eine', 'ist keine'), 'Fläche']).
sentence(figure_reference(_, R), [the(R), v('ist der Bezug, denn es ist eine Fläche', 'ist nicht der Bezug')]) :-
    nonvar(R), surface(R), !.
sentence(figure_reference(F, R),
         [the(R), v('ist der Bezug, denn', 'ist nicht der Bezug von'), the(F), v('ist nicht größer', '')]).
sentence(viewpoint(V), [v('es gibt einen', 'es gibt keinen'), 'Blick', view(V)]).
sentence(distance(A, B, N), [the(A), und, the(B), v(sind, 'sind nicht'), metres(N), 'voneinander entfernt']).
sentence(separation(A, B, N),
         ['die Lücke zwischen', the(A), und, the(B), v(beträgt, 'beträgt nicht'), metres(N)]) :-
    ( var(N) ; N >= 0 ), !.
sentence(separation(A, B, N),
         [the(A), und, the(B), v('überschneiden sich', 'überschneiden sich nicht'), um, metres(Depth)]) :-
    Depth is -N.
sentence(is_close(A, B), [the(A), v('ist nahe bei', 'ist nicht nahe bei'), the(B)]).
sentence(touches(A, B), [the(A), berührt, the(B), v('', nicht)]).
sentence(intersects(A, B), [the(A), und, the(B), v('teilen Raum', 'teilen keinen Raum')]).
sentence(intersection(A, B, N), [the(A), und, the(B), v(teilen, 'teilen nicht'), cubic_metres(N)]).
sentence(protrusion(A, B, N), [the(A), v(ragt, 'ragt nicht'), metres(N), 'aus', the(B), heraus]) :-
    ( var(N) ; N >= 0 ), !.
sentence(protrusion(A, B, N), [the(A), v(liegt, 'liegt nicht'), metres(Depth), 'tief in', the(B)]) :-
    Depth is -N.
sentence(compl_cont(A, B), [the(A), enthält, the(B), v(ganz, 'nicht ganz')]).
sentence(halfspace(A, B, Axis, V, N), [the(A), v('ragt in', 'ragt nicht in')|Rest]) :-
    ( var(N) ; N >= 0 ), !, space_of(Axis, V, B, ['mit', metres(N), 'Spielraum'], Rest).
sentence(halfspace(A, B, Axis, V, N), [the(A), v(verfehlt, 'verfehlt nicht')|Rest]) :-
    By is -N, space_of(Axis, V, B, [um, metres(By)], Rest).
sentence(strict(A, B, Axis, V, N), [the(A), v(liegt, 'liegt nicht'), metres(Within), Where|Rest]) :-
    ( ( var(N) ; N >= 0 ) -> Within = N, Where = 'tief in' ; Within is -N, Where = 'neben' ),
    in_space_of(Axis, V, B, Rest).
sentence(int_hs(A, B, Axis, V), [the(A), v('ragt in', 'ragt nicht in')|Rest]) :-
    space_of(Axis, V, B, [], Rest).
sentence(cont_hs(A, B, Axis, V), [the(A), v('liegt ganz in', 'liegt nicht ganz in')|Rest]) :-
    in_space_of(Axis, V, B, Rest).
sentence(east_s(A, B), [the(A), v('ist ganz', 'ist nicht ganz'), 'östlich von', the(B)]).
sentence(west_s(A, B), [the(A), v('ist ganz', 'ist nicht ganz'), 'westlich von', the(B)]).
sentence(north_s(A, B), [the(A), v('ist ganz', 'ist nicht ganz'), 'nördlich von', the(B)]).
sentence(south_s(A, B), [the(A), v('ist ganz', 'ist nicht ganz'), 'südlich von', the(B)]).
sentence(above_s(A, B), [the(A), v('ist ganz', 'ist nicht ganz'), 'oberhalb von', the(B)]).
sentence(below_s(A, B), [the(A), v('ist ganz', 'ist nicht ganz'), 'unterhalb von', the(B)]).
sentence(east_r(A, B), [the(A), v(ist, 'ist nicht'), 'östlich von', the(B)]).
sentence(west_r(A, B), [the(A), v(ist, 'ist nicht'), 'westlich von', the(B)]).
sentence(north_r(A, B), [the(A), v(ist, 'ist nicht'), 'nördlich von', the(B)]).
sentence(south_r(A, B), [the(A), v(ist, 'ist nicht'), 'südlich von', the(B)]).
sentence(above_r(A, B), [the(A), v(ist, 'ist nicht'), 'oberhalb von', the(B)]).
sentence(below_r(A, B), [the(A), v(ist, 'ist nicht'), 'unterhalb von', the(B)]).
sentence(above(A, B), [the(A), v(ist, 'ist nicht'), 'über', the(B)]).
sentence(below(A, B), [the(A), v(ist, 'ist nicht'), 'unter', the(B)]).
sentence(right_of(A, B, V), [the(A), v(ist, 'ist nicht'), 'rechts von', the(B), view(V)]).
sentence(left_of(A, B, V), [the(A), v(ist, 'ist nicht'), 'links von', the(B), view(V)]).
sentence(in_front_of(A, B, V), [the(A), v(ist, 'ist nicht'), 'vor', the(B), view(V)]).
sentence(behind(A, B, V), [the(A), v(ist, 'ist nicht'), 'hinter', the(B), view(V)]).
sentence(beside(A, B, V), [the(A), v(ist, 'ist nicht'), 'neben', the(B), view(V)]).
sentence(on_top_of(A, B), [the(A), v(ist, 'ist nicht'), 'auf', the(B)]).
sentence(leans_on(A, B), [the(A), v('lehnt an', 'lehnt nicht an'), the(B)]).
sentence(affixed_on(A, B), [the(A), v(ist, 'ist nicht'), 'an', the(B), 'befestigt']).
sentence(adj_sr_card(A, B, N),
         [the(A), v(hat, 'hat nicht'), cubic_metres(N), 'neben dem gemeinsamen Raum mit', the(B)]).
sentence(part_in(A, B), [the(A), v(ist, 'ist nicht'), 'teilweise in', the(B)]).
sentence(inside(A, B), [the(A), v(ist, 'ist nicht'), 'in', the(B), 'enthalten']).
sentence(near(A, B), [the(A), v(ist, 'ist nicht'), 'in der Nähe von', the(B)]).
sentence(label(O, Name, Score),
         [the(O), v('wurde als', 'wurde nicht als'), name(Name), 'erkannt mit der Bewertung', number(Score)]).
sentence(measured_as(O, Model), [the(O), v('wurde als', 'wurde nicht als'), name(Model), gemessen]).
sentence(view_label(V, Name), ['der Blick', name(V), v(heißt, 'heißt nicht'), name(Name)]).
sentence(withheld(R, V, _),
         ['von den Seiten von', the(R), v('wird nichts gesagt', 'wird etwas gesagt'), view(V)]).
sentence(threshold(Name, N), ['der Schwellwert', name(Name), v(ist, 'ist nicht'), number(N)]).
sentence(pair(A, B, D, _, _, _, _, _, _),
         [the(A), und, the(B), v(sind, 'sind nicht'), 'gemessen: Abstand', metres(D)]).
sentence(aspect(V, A, B, _, _, _, _),
         ['die Seiten von', the(A), und, the(B), v('sind gemessen', 'sind nicht gemessen')|Seen]) :-
    seen(V, Seen).

%   support.pl

sentence(held_by(A, B), [the(A), v('wird von', 'wird nicht von'), the(B), 'gehalten']).
sentence(supported_by(A, B), [the(A), v('wird von', 'wird nicht von'), the(B), 'getragen']).
sentence(supports(A, B), [the(A), trägt, the(B), v('', nicht)]).

%   background.pl

sentence(kind_of(Name, Kind), [name(Name), v(ist, 'ist nicht'), 'eine Art von', name(Kind)]).
sentence(a_kind_of(Name, Kind), [name(Name), v(ist, 'ist nicht'), 'eine Art von', name(Kind)]).
sentence(made_of(Kind, Material), [name(Kind), v(besteht, 'besteht nicht'), 'aus', name(Material)]).
sentence(burns(Material), [name(Material), v(brennt, 'brennt nicht')]).
sentence(heats(Kind), [name(Kind), v('gibt Wärme ab', 'gibt keine Wärme ab')]).
sentence(needs_near(Kind, Other), [name(Kind), v('muss', 'muss nicht'), name(Other), 'in der Nähe haben']).

%   safety.pl

sentence(recognised_as(T, Name), [the(T), v('ist am ehesten', 'ist nicht am ehesten'), name(Name)]).
sentence(is_a(T, Kind), [the(T), v('gilt als', 'gilt nicht als'), name(Kind)]).
sentence(burnable(T, Material),
         [the(T), v('besteht aus', 'besteht nicht aus'), name(Material), 'und ist brennbar']).
sentence(hot(T), [the(T), v('gibt Wärme ab', 'gibt keine Wärme ab')]).
sentence(in_contact(A, B), [the(A), v('hat', 'hat keinen'), 'Kontakt mit', the(B)]).
sentence(on_wall(T, Wall), [the(T), v('hängt an', 'hängt nicht an'), the(Wall)]).
sentence(has_near(T, _, Other), [the(T), v('hat', 'hat nicht'), the(Other), 'in der Nähe']).
sentence(leans_against(T, Door), [the(T), v('lehnt gegen', 'lehnt nicht gegen'), the(Door)]).
sentence(in_area(T, Area), [the(T), v('ist im Bereich', 'ist nicht im Bereich'), the(Area)]).
sentence(violation(extinguisher_off_wall, T),
         [the(T), v('muss an einer Wand hängen', 'hängt vorschriftsmäßig an einer Wand')]).
sentence(violation(extinguisher_without_sign, T),
         [the(T), v('muss ein Schild in der Nähe haben', 'hat vorschriftsmäßig ein Schild in der Nähe')]).
sentence(violation(fire_hazard, T, Heater),
         [the(T), v('ist eine Brandgefahr', 'ist keine Brandgefahr'), 'auf oder an', the(Heater)]).
sentence(violation(fire_door_leant_on, T, Door),
         [the(T), v('darf nicht gegen', 'lehnt nicht gegen'), the(Door), v(lehnen, '')]).
sentence(violation(heater_in_free_area, T, Area),
         [the(T), v('darf nicht im Bereich', 'ist nicht im Bereich'), the(Area), v(sein, '')]).
sentence(violation(Rule, T), [the(T), verletzt, 'die Regel', name(Rule), v('', nicht)]).
sentence(violation(Rule, T, Other),
         [the(T), verletzt, 'die Regel', name(Rule), v('', nicht), 'wegen', the(Other)]).

%!  no_other(?Goal, ?Exception, ?Template) is nondet.
%
%   Template says that Goal holds of nothing other than Exception.

no_other(touches(_, F), R, ['nichts außer', the(R), 'berührt', the(F)]).

%!  none(?Goal, ?Template) is nondet.
%
%   Template says that there is nothing of which Goal holds.

none(on_wall(T, _), ['keine Wand hält', the(T)]).
none((touches(F, S), below_r(S, F)), ['nichts, was', the(F), 'berührt, ist unter', the(F)]).
none(has_near(T, Kind, _), ['nichts, was als', name(Kind), 'gilt, ist in der Nähe von', the(T)]).
none(burnable(T, _), [the(T), 'besteht aus nichts Brennbarem']).
none((label(T, _, _), _ > _), ['keine andere Bezeichnung von', the(T), 'hat eine höhere Bewertung']).

%!  differs(?A, ?B, ?Template) is det.
%
%   Template says that A is not B.

differs(A, B, [the(A), v('ist etwas anderes als', 'ist nichts anderes als'), the(B)]).

%!  hindered(?What, ?Template) is nondet.
%
%   Template says what keeps a relation from being stated at all.

hindered(order(F, R), [the(F), 'ist der Bezug von beiden, also sagt man, wo', the(R), 'ist']).
hindered(withheld(R, V, _), ['von den Seiten von', the(R), 'wird nichts gesagt', view(V), '(der Blick ist zu nahe)']).
hindered(apart(F, R), [the(F), und, the(R), 'sind für jede Beziehung zu weit voneinander entfernt']).

%   space_of(+Axis, +View, +Reference, +Tail, -Items): the halfspace as where something goes to, and whose
%   view makes it so; in_space_of/4 as where something is.

space_of(Axis, View, Reference, Tail, ['den Raum', Space, the(Reference)|Items]) :-
    place_of(Axis, View, Space, Seen),
    append(Seen, Tail, Items).

in_space_of(Axis, View, Reference, ['dem Raum', Space, the(Reference)|Seen]) :-
    place_of(Axis, View, Space, Seen).

place_of(Axis, View, Space, Seen) :-
    (   var(Axis)
    ->  Space = neben
    ;   once(space(Axis, View, Space))
    ),
    (   nonvar(Axis), memberchk(Axis, ['Z+', 'Z-'])
    ->  Seen = []
    ;   seen(View, Seen)
    ).

seen(View, Seen) :-
    (   View == world
    ->  Seen = []
    ;   Seen = [view(View)]
    ).

space('Z+', _, über).
space('Z-', _, unter).
space('X+', View, 'östlich von') :- View == world.
space('X-', View, 'westlich von') :- View == world.
space('Y+', View, 'nördlich von') :- View == world.
space('Y-', View, 'südlich von') :- View == world.
space('X+', _, hinter).
space('X-', _, vor).
space('Y+', _, 'links von').
space('Y-', _, 'rechts von').

%!  called(?Before, ?After) is det.
%
%   What stands before and after a label that names a thing.

called('„', '“').

%!  side(?Side, ?Before, ?After) is nondet.
%
%   The same where Side tells the thing from others of that label: left and right of two, leftmost and
%   rightmost of more; upper and lower, top and bottom.

side(left, '„', '“ links').
side(right, '„', '“ rechts').
side(leftmost, '„', '“ ganz links').
side(rightmost, '„', '“ ganz rechts').
side(upper, '„', '“ oben').
side(lower, '„', '“ unten').
side(top, '„', '“ ganz oben').
side(bottom, '„', '“ ganz unten').

%!  place(?Place, ?Words) is nondet.
%
%   Words between two names, as in "the cup on the shelf"; no Words end in others.

place(on, ' auf ').
place(in, ' in ').
place(against, ' gelehnt an ').
place(under, ' unter ').
place(near, ' nahe bei ').

%!  said(?Name, ?Format) is nondet.
%
%   Formats of format/2 for what is said in and around sentences; each ~w is filled in.

said(something, etwas).
said(some_distance, 'einem Abstand').
said(some_room, 'etwas Raum').
said(name, '„~w“').
said(centimetres, '~w cm').
said(metres, '~w m').
said(litres, '~w Liter').
said(cubic_centimetres, '~w Kubikzentimeter').
said(seen_from, 'von „~w“ aus gesehen').
said(seen_by_you, 'von dir aus gesehen').
said(seen_somehow, 'von irgendwo aus gesehen').
said(both, '~w und ~w').
said(not_so, 'es trifft nicht zu: ~w').
said(short_by, 'es fehlen ~w').
said(to_spare, '~w Spielraum').
said(aside, ' (~w)').
said(closest, ' (am nächsten kommt ~w, ~w)').
said(none_close, ' (nichts kommt dem nahe)').
said(compared, '~w ist ~w ~w').
said(hindered, '~w; ~w').
said(but, '~w, aber ~w').
said(but_because, '~w, aber ~w, denn ~w').
said(both_hold, 'beides gilt: ~w, und ~w').
said(nothing_to_contrast, '~w: da gibt es nichts gegenüberzustellen').
said(it_holds, 'Es gilt doch: ~w').
said(comes_closest, 'Am nächsten kommt:').

%!  connective(?Name, ?Words) is nondet.
%
%   Words without a place to fill in: between numbers by the operator of a comparison, and those that join
%   sentences, which are the fields of Words in deixis/wording.py.

connective(decimal_mark, ',').
connective(=<, 'höchstens').
connective(>=, 'mindestens').
connective(<, 'weniger als').
connective(>, 'mehr als').
connective(=:=, 'gleich').
connective(=\=, 'ungleich').
connective(because, denn).
connective(and, und).
connective(no, 'Nein').
connective(nor, 'Auch nicht nach').
connective(closest, 'am nächsten kommt').
connective(margin, 'Spielraum').
connective(fails, 'gilt nicht').
connective(axiom, 'Axiom').
