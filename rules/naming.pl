:- module(naming,
          [ thing_name/2,               % +Thing, -Name
            thing_name/3,               % +Thing, +View, -Name
            thing_name_in/3,            % +Thing, +View, -Name
            view_text/2,                % +View, -Text
            names/2                     % +View, -Pairs
          ]).
:- use_module(library(lists), [member/2]).
:- use_module(library(solution_sequences)).
:- use_module(facts).
:- use_module(direction).
:- use_module(commonsense).
:- use_module(words).

/** <module> What a thing is called

A name picks out one thing of the scene. It is the label where no other thing bears it; else what tells the
thing from the others of that label: that it is the upper one, that it alone is on the shelf, that it is the
left one as seen from somewhere; else the label with the id; and the id alone where there is no label. Which
words say that is the language's business.

The descriptions rest on relations of the theory. No name costs more than a bounded number of questions to
them, however many things share a label.
*/

:- table description/3.

most_alike(128).        % more things of one label than this are told apart by their ids only
most_in_a_row(6).       % "the leftmost" of more than this takes too long to find with the eyes
most_landmarks(8).      % tried for one thing and word

%!  thing_name(+Thing, -Name:string) is det.
%
%   Name is what Thing is called whoever looks: if only its side tells it from others, it says whose view that
%   is, which is the only one of the scene.

thing_name(Thing, Name) :-
    description(Thing, any, Description),
    spoken(Description, unsaid, Name).

%!  thing_name(+Thing, +View, -Name:string) is det.
%
%   The same in a sentence that speaks of View anyway, so that the name need not.

thing_name(Thing, View, Name) :-
    description(Thing, any, Description),
    spoken(Description, View, Name).

%!  thing_name_in(+Thing, +View, -Name:string) is det.
%
%   Name is what Thing is called by one who looks from View and has said so: left and right come first.

thing_name_in(Thing, View, Name) :-
    description(Thing, from(View), Description),
    spoken(Description, View, Name).

%!  names(+View, -Pairs:list) is det.
%
%   Pairs are Thing-Name for all things of the scene, as they are called from View or, if that is `any`,
%   whoever looks.

names(View, Pairs) :-
    findall(Thing-Name,
            ( spatial_obj(Thing),
              (   View == any
              ->  thing_name(Thing, Name)
              ;   thing_name_in(Thing, View, Name)
              )
            ),
            Pairs).

%   description(+Thing, +View, -Description): the first description that no other thing claims. View is
%   `any` or from(V). Ids come first of all claims, then labels that are unique.

description(Thing, View, Description) :-
    (   candidate(Thing, View, Description0),
        free(Description0, Thing)
    ->  Description = Description0
    ;   Description = bare(Thing)
    ).

candidate(Thing, View, Description) :-
    best_label(Thing, Label),
    alike(Thing, Label, Others),
    (   Others == []
    ->  Description = plain(Label)
    ;   distinct_by(Others, Thing, Label, View, Description)
    ).

distinct_by(Others, Thing, Label, View, Description) :-
    is_list(Others),
    \+ wild(Label),
    (   View = from(V)
    ->  ( by_side(Thing, Others, Label, V, Description) ; by_place(Thing, Others, Label, Description) )
    ;   by_place(Thing, Others, Label, Description)
    ;   only_view(V),
        by_side(Thing, Others, Label, V, Description)
    ).
distinct_by(_, Thing, Label, _, numbered(Label, Thing)) :-
    \+ bracketed(Label),
    \+ bracketed(Thing).

only_view(View) :- findall(V, viewpoint(V), [View]).

%   best_label(+Thing, -Label): what it was recognised as, if anything.

best_label(Thing, Label) :-
    label(Thing, Label0, _),
    !,
    Label0 \== '',
    Label = Label0.

%   alike(+Thing, +Label, -Others): the other things that bear Label; `many` where there are too many.

alike(Thing, Label, Others) :-
    most_alike(Most),
    findall(Other, limit(Most, bears(Other, Label, Thing)), Found),
    (   length(Found, Most)
    ->  Others = many
    ;   Others = Found
    ).

bears(Other, Label, Thing) :-
    label(Other, Label, _),
    Other \== Thing,
    best_label(Other, Label).

%   by_side(+Thing, +Others, +Label, +View, -Description): of two things one is left and one right, of some
%   one is the leftmost. Relations are drawn in one order of a pair only, so both ways are asked.

by_side(Thing, Others, Label, View, side(Side, Label, View)) :-
    length(Others, Count),
    most_in_a_row(Most),
    Count < Most,
    member(Which, [left, right]),
    forall(member(Other, Others), beyond(Which, Thing, Other, View)),
    (   Count =:= 1
    ->  Side = Which
    ;   utmost(Which, Side)
    ).

utmost(left, leftmost).
utmost(right, rightmost).
utmost(upper, top).
utmost(lower, bottom).

beyond(Which, Thing, Other, View) :-
    on_side(Which, Thing, Other, View),
    opposite(Which, Against),
    \+ on_side(Against, Thing, Other, View).

opposite(left, right).
opposite(right, left).
opposite(upper, lower).
opposite(lower, upper).

on_side(left, A, B, View) :- left_of(A, B, View), !.
on_side(left, A, B, View) :- right_of(B, A, View), !.
on_side(right, A, B, View) :- on_side(left, B, A, View), !.
on_side(upper, A, B, _) :- above_r(A, B), !.
on_side(upper, A, B, _) :- below_r(B, A), !.
on_side(lower, A, B, _) :- on_side(upper, B, A, _), !.

%   by_place(+Thing, +Others, +Label, -Description): one of things one over the other; or the only one that
%   stands so to a landmark, a thing with a name of its own.

by_place(Thing, Others, Label, side(Side, Label, none)) :-
    length(Others, Count),
    most_in_a_row(Most),
    Count < Most,
    member(Which, [upper, lower]),
    forall(member(Other, Others), beyond(Which, Thing, Other, none)),
    (   Count =:= 1
    ->  Side = Which
    ;   utmost(Which, Side)
    ).
by_place(Thing, Others, Label, at(Place, Label, Landmark)) :-
    member(Place, [on, in, against, under, near]),
    most_landmarks(Most),
    limit(Most, landmark(Place, Thing, Landmark)),
    \+ ( member(Other, Others),
         placed(Place, Other, Landmark)
       ).

landmark(Place, Thing, Landmark) :-
    distinct(Landmark, placed(Place, Thing, Landmark)),
    best_label(Landmark, Label),
    \+ wild(Label),
    plainly(Landmark, Label).

plainly(Landmark, Label) :-
    \+ bears(_, Label, Landmark),
    free(plain(Label), Landmark).

%   placed(?Place, ?Thing, ?Landmark): a word for where things are. One word may stand for several relations:
%   of two cups one of which is on top of the shelf and one affixed on it, none is "the cup on the shelf".

placed(on, Thing, Landmark) :- on_top_of(Thing, Landmark).
placed(on, Thing, Landmark) :- affixed_on(Thing, Landmark).
placed(in, Thing, Landmark) :- inside(Thing, Landmark).
placed(in, Thing, Landmark) :- part_in(Thing, Landmark).
placed(against, Thing, Landmark) :- leans_on(Thing, Landmark).
placed(under, Thing, Landmark) :- below(Thing, Landmark).
placed(near, Thing, Landmark) :- near(Thing, Landmark), \+ surface(Landmark).

%   free(+Description, +Thing): no other thing can have this name. Ids and unique labels are claims that come
%   before all others. Among descriptions no two are the same, since no label that looks like one is used in
%   them, see wild/1, and since brackets hold an id and nothing else.

free(Description, Thing) :-
    forall(member(View, [unsaid, said]),
           ( spoken(Description, View, Name),
             atom_string(Text, Name),
             \+ claimed(Description, Text, Thing)
           )).

claimed(_, Text, Thing) :-
    spatial_obj(Text),
    Text \== Thing.
claimed(Description, Text, Thing) :-
    Description \= plain(_),
    language(Words),
    Words:called(Before, After),
    atom_concat(Before, Rest, Text),
    atom_concat(Label, After, Rest),
    bears(_, Label, Thing).

%   wild(+Label): put into a description it may be misread, as the label 'cup on the shelf' would be.

wild(Label) :- bracketed(Label), !.
wild(Label) :-
    language(Words),
    atomic_list_concat([' ', Label, ' '], Padded),
    Words:called(Before, After),
    (   Words:place(_, Text),
        sub_atom(Padded, _, _, _, Text)
    ;   Words:side(_, Left, Right),
        (   atom_concat(Before, Word, Left), Word \== '', sub_atom(Label, 0, _, _, Word)
        ;   atom_concat(After, Word, Right), Word \== '', sub_atom(Padded, _, _, _, Word)
        )
    ;   member(Mark, [Before, After]),
        Mark \== '',
        sub_atom(Label, _, _, _, Mark)
    ),
    !.

bracketed(Text) :- sub_atom(Text, _, _, _, '('), !.

%   spoken(+Description, +View, -Name): in words. A side says whose view it is unless that is View.

spoken(bare(Thing), _, Name) :-
    format(string(Name), "~w", [Thing]).
spoken(plain(Label), _, Name) :-
    language(Words),
    Words:called(Before, After),
    format(string(Name), "~w~w~w", [Before, Label, After]).
spoken(numbered(Label, Thing), View, Name) :-
    spoken(plain(Label), View, Plain),
    format(string(Name), "~s (~w)", [Plain, Thing]).
spoken(at(Place, Label, Landmark), View, Name) :-
    spoken(plain(Label), View, Plain),
    best_label(Landmark, Other),
    spoken(plain(Other), View, There),
    language(Words),
    Words:place(Place, Text),
    format(string(Name), "~s~w~s", [Plain, Text, There]).
spoken(side(Side, Label, Seen), View, Name) :-
    language(Words),
    Words:side(Side, Before, After),
    format(string(Plain), "~w~w~w", [Before, Label, After]),
    (   ( Seen == none ; View == Seen ; View == said )
    ->  Name = Plain
    ;   view_text(Seen, Text),
        format(string(Name), "~s ~s", [Plain, Text])
    ).

%!  view_text(+View, -Text:string) is det.
%
%   Text says whose view View is.

view_text(View, Text) :- var(View), !, saying(seen_somehow, [], Text).
view_text(View, Text) :- view_label(View, you), !, saying(seen_by_you, [], Text).
view_text(View, Text) :- view_label(View, Label), Label \== '', !, saying(seen_from, [Label], Text).
view_text(View, Text) :- saying(seen_from, [View], Text).
