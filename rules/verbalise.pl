:- module(verbalise,
          [ node_text/2,                % +Node, -Text
            denied_text/2,              % +Goal, -Text
            subject/2,                  % +Goal, -Subject
            going_on/4,                 % +Goal, :Making, +Subject, -Next
            template_text/3,            % +Template, +Polarity, -Text
            comparison_text/3,          % +Goal, +Margin, -Text
            short_text/2,               % +Margin, -Text
            plain/2                     % +Marked, -Goal
          ]).
:- use_module(library(lists), [append/3, member/2, nth1/3]).
:- use_module(library(apply)).
:- use_module(facts).
:- use_module(axioms).
:- use_module(amounts).
:- use_module(naming).
:- use_module(words).

:- meta_predicate going_on(+, 0, +, -).

/** <module> Proofs in words

Turns the nodes of explain.pl into sentences by templates: those of the language that is spoken, and those
that a user's rule files give for their own predicates. Numbers are rounded for people.

A rule file gives a template as a fact says(Predicate, Yes, No), where {1} stands for the first argument:

```
says(rests_on, '{1} rests on {2}', '{1} does not rest on {2}').
```

Of a violation/2 or violation/3, Predicate is the name of the rule and {1} is what comes after it.
*/

%!  node_text(+Node, -Text:string) is det.
%
%   Text says what Node says, in one sentence without its reasons.

node_text(node(negation, \+ Goal, _, _, Near), Text) :-
    !,
    negation_text(Goal, Core),
    near_text(Goal, Near, Tail),
    string_concat(Core, Tail, Text).
node_text(node(comparison, Goal, Margin, _, _), Text) :-
    !,
    comparison_text(Goal, Margin, Text).
node_text(node(_, Goal, _, _, _), Text) :-
    goal_text(Goal, yes, Text).

%   goal_text(+Goal, +Polarity, -Text): by template, else as it stands.

goal_text(Goal, Polarity, Text) :-
    template(Goal, Template),
    ( Polarity == yes ; term_variables(Goal, []) ),
    !,
    template_text(Template, Polarity, Text).
goal_text(Goal, no, Text) :-
    none_template(Goal, Template),
    !,
    template_text(Template, yes, Text).
goal_text(Goal, no, Text) :-
    !,
    goal_text(Goal, yes, Core),
    saying(not_so, [Core], Text).
goal_text((A, B), yes, Text) :-
    !,
    goal_text(A, yes, TextA),
    goal_text(B, yes, TextB),
    saying(both, [TextA, TextB], Text).
goal_text(\+ Goal, yes, Text) :-
    !,
    goal_text(Goal, no, Text).
goal_text(Marked, yes, Text) :-
    plain(Marked, Goal),
    format(string(Text), "~W", [Goal, [quoted(true), numbervars(true), max_depth(20)]]).

%   template(+Goal, -Template): the user's own, or that of the language.

template((_, _), _) :- !, fail.
template(Goal, Template) :-
    nonvar(Goal),
    ( Goal = (A \== B) -> Sign = yes ; Goal = (A \= B) -> Sign = yes
    ; Goal = (A == B) -> Sign = no ; Goal = (A = B), Sign = no
    ),
    !,
    language(Words),
    Words:differs(A, B, Yes),
    Template = signed(Sign, Yes).
template(Goal, own(Yes, No, Args)) :-
    callable(Goal),
    Goal =.. [Name|All],
    (   Name == violation, All = [Rule|Rest], atom(Rule)
    ->  Said = Rule,
        Args = Rest
    ;   Said = Name,
        Args = All
    ),
    own_template(Goal, Said, Yes, No),
    !.
template(Marked, Template) :-
    plain(Marked, Goal),
    language(Words),
    copy_term(Goal, Copy),
    Words:sentence(Copy, Template),
    Copy =@= Goal,                              % a template must not fill in what is open
    Copy = Goal,
    !.

%   none_template(+Goal, -Template): that there is nothing of which Goal holds, where its last argument only is
%   open.

none_template(Goal, Template) :-
    compound(Goal),
    (   Goal = (First, _)
    ->  arg(1, First, Thing),
        nonvar(Thing)
    ;   Goal =.. [_|Args],
        append(Known, [Last], Args),
        var(Last),
        ground(Known)
    ),
    language(Words),
    Words:none(Goal, Template),
    !.

own_template(Goal, Name, Yes, No) :-
    member(Loaded, [question, user]),
    (   Module = Loaded
    ;   predicate_property(Loaded:Goal, imported_from(Module))
    ),
    current_predicate(Module:says/3),
    clause(Module:says(Name, Yes, No), true),
    atom(Yes),
    atom(No).

%!  template_text(+Template, +Polarity, -Text) is det.
%
%   Text is Template filled in, or turned round where Polarity is `no`.

template_text(signed(Sign, Template), Polarity, Text) :-
    !,
    (   Sign == Polarity
    ->  template_text(Template, yes, Text)
    ;   template_text(Template, no, Text)
    ).
template_text(own(Yes, No, Args), Polarity, Text) :-
    !,
    (   Polarity == yes
    ->  Written = Yes
    ;   Written = No
    ),
    split_string(Written, "{", "", [First|Parts]),
    ( member(View, Args), nonvar(View), viewpoint(View) -> Said = View ; Said = unsaid ),
    maplist(filled(Args, Said), Parts, Filled),
    atomic_list_concat([First|Filled], Atom),
    atom_string(Atom, Text).
template_text(Template, Polarity, Text) :-
    (   memberchk(view(View), Template), nonvar(View)
    ->  Said = View
    ;   Said = unsaid
    ),
    maplist(item_text(Polarity, Said), Template, Items),
    exclude(==(''), Items, Shown),
    atomic_list_concat(Shown, ' ', Atom),
    atom_string(Atom, Text).

%   filled(+Args, +Said, +Part, -Text): Part begins with the number of an argument and a bracket.

filled(Args, Said, Part, Text) :-
    (   sub_string(Part, Before, 1, After, "}"),
        sub_string(Part, 0, Before, _, Digits),
        number_string(N, Digits),
        integer(N),
        nth1(N, Args, Arg)
    ->  sub_string(Part, _, After, 0, Rest),
        argument_text(Arg, Said, Filler),
        string_concat(Filler, Rest, Text)
    ;   string_concat("{", Part, Text)
    ).

argument_text(X, _, Text) :- var(X), !, saying(something, [], Text).
argument_text(no_length(N), _, Text) :- number(N), !, number_text(N, Text).
argument_text(no_length(X), Said, Text) :- !, argument_text(X, Said, Text).
argument_text(N, _, Text) :- number(N), !, length_text(N, Text).
argument_text(X, Said, Text) :- atom(X), spatial_obj(X), !, the(X, Said, Text).
argument_text(X, _, Text) :- atom(X), viewpoint(X), !, view_text(X, Text).
argument_text(X, _, Text) :- format(string(Text), "~w", [X]).

item_text(_, Said, the(X), Text) :- !, the(X, Said, Text).
item_text(yes, _, v(Yes, _), Yes) :- !.
item_text(no, _, v(_, No), No) :- !.
item_text(_, _, metres(N), Text) :- !, length_text(N, Text).
item_text(_, _, cubic_metres(N), Text) :- !, volume_text(N, Text).
item_text(_, _, number(N), Text) :- !, ( var(N) -> saying(something, [], Text) ; number_text(N, Text) ).
item_text(_, _, view(V), Text) :- !, view_text(V, Text).
item_text(_, _, name(X), Text) :- !, ( var(X) -> saying(something, [], Text) ; called(X, Text) ).
item_text(_, _, Word, Word).

%   called(+Name, -Text): a kind or a material, marked as the language marks names in the midst of words.

called(Name, Text) :- saying(name, [Name], Text).

%   the(+Thing, +Said, -Text): Said is the view that the sentence speaks of, or `unsaid`.

the(X, _, Text) :- var(X), !, saying(something, [], Text).
the(X, _, Text) :- spoken_of(X), saying(it, [], Text), !.
the(X, unsaid, Text) :- !, thing_name(X, Text).
the(X, Said, Text) :- thing_name(X, Said, Text).

negation_text((Goal, Other \== Exception), Text) :-
    var(Other),
    language(Words),
    Words:no_other(Goal, Exception, Template),
    !,
    template_text(Template, yes, Text).
negation_text(Goal, Text) :-
    none_template(Goal, Template),
    !,
    template_text(Template, yes, Text).
negation_text(Goal, Text) :-
    goal_text(Goal, no, Text).

%   near_text(+Goal, +Near, -Tail): the witness of a negation is what came closest to refuting it, by name
%   where the goal leaves open which thing it is.

near_text(Goal, [], Tail) :-
    !,
    (   open(Goal)
    ->  saying(none_close, [], Tail)
    ;   Tail = ""
    ).
near_text(Goal, [node(_, Found, Margin, _, _)], Tail) :-
    number(Margin),
    !,
    short_text(Margin, Short),
    copy_term(Goal, Copy),
    term_variables(Copy, Variables),
    plain(Found, Copy),
    include(spatial, Variables, Objects),
    (   Objects = [Object|_]
    ->  thing_name(Object, Name),               % "the closest is it" is no English
        saying(closest, [Name, Short], Tail)
    ;   saying(aside, [Short], Tail)
    ).
near_text(_, _, "").

%   open(+Goal): it asks for a thing, which measured facts may bring close; labels and kinds do not.

open((label(_, _, _), _)) :- !, fail.
open(burnable(_, _)) :- !, fail.
open((Goal, _)) :- !, open(Goal).
open(Goal) :-
    term_variables(Goal, [_|_]),
    functor(Goal, Name, Arity),
    (   relation(Name/Arity)
    ->  true
    ;   base(Name/Arity)
    ->  true
    ;   language(Words),
        copy_term(Goal, Copy),
        Words:none(Copy, _)
    ->  true
    ).

spatial(X) :- atom(X), spatial_obj(X).

%!  short_text(+Margin, -Text) is det.
%
%   Text says by how much something with a negative Margin fails.

short_text(Margin, Text) :-
    By is -Margin,
    length_text(By, Length),
    saying(short_by, [Length], Text).

%!  comparison_text(+Goal, +Margin, -Text) is det.
%
%   Text says how two amounts compare, and what is to spare or missing where Margin is a length.

comparison_text(Marked, Margin, Text) :-
    plain(Marked, Goal),
    Goal =.. [Op, A0, B0],
    language(Words),
    (   catch(( A is A0, B is B0 ), error(type_error(_, _), _), fail),
        Words:connective(Op, Operator)
    ->  (   number(Margin)
        ->  length_text(A, X),
            length_text(B, Y),
            (   Margin < 0
            ->  short_text(Margin, Tail)
            ;   length_text(Margin, Length),
                saying(to_spare, [Length], Tail)
            ),
            saying(compared, [X, Operator, Y], Core),
            saying(aside, [Tail], Aside),
            string_concat(Core, Aside, Text)
        ;   number_text(A, X),
            number_text(B, Y),
            saying(compared, [X, Operator, Y], Core),
            (   call(Goal)
            ->  Text = Core
            ;   saying(not_so, [Core], Text)
            )
        )
    ;   goal_text(Goal, yes, Text)
    ).

%!  denied_text(+Goal, -Text) is det.
%
%   Text says that Goal does not hold.

denied_text(Goal, Text) :-
    goal_text(Goal, no, Text).

%!  subject(+Goal, -Subject) is det.
%
%   Subject is it(Thing) for the thing that a sentence about Goal is about, its first; `none` where there is
%   none, or no template says Goal: it stands there as Prolog then, which names nothing.

subject(Goal, Subject) :-
    (   about(Goal, Core, Thing),
        template(Core, _)
    ->  Subject = it(Thing)
    ;   Subject = none
    ).

about(Goal, _, _) :- \+ compound(Goal), !, fail.
about(\+ Goal, Core, Thing) :- !, about(Goal, Core, Thing).
about((Goal, _), Core, Thing) :- !, about(Goal, Core, Thing).
about(Goal, Goal, Thing) :-
    arg(_, Goal, Thing),
    atom(Thing),
    spatial_obj(Thing),
    !.

%!  going_on(+Goal, :Making, +Subject, -Next) is semidet.
%
%   Making, once, makes a text about Goal for a sentence that has said what its Subject is. While that is
%   it(Thing), a pronoun stands for it, in a language that has one. After a clause about another thing it is
%   named(Thing): "it" would be taken for that one, so Thing is named again. Next is for the clause that follows.

going_on(Goal, Making, Subject, Next) :-
    (   Subject = it(Thing)
    ->  setup_call_cleanup(asserta(spoken_of(Thing), Said), once(Making), erase(Said))
    ;   once(Making)
    ),
    (   Subject == none
    ->  Next = none
    ;   \+ about(Goal, _, _)
    ->  Next = Subject
    ;   arg(1, Subject, Thing),
        (   subject(Goal, it(Thing))
        ->  Next = it(Thing)
        ;   Next = named(Thing)
        )
    ).

:- thread_local spoken_of/1.

%!  plain(+Marked, -Goal) is det.
%
%   Goal is Marked with numbers free of the mark that they are no lengths.

plain(X, X) :- var(X), !.
plain(no_length(N), N) :- !.
plain(X, Y) :-
    compound(X),
    !,
    X =.. [F|Args],
    maplist(plain, Args, Plain),
    Y =.. [F|Plain].
plain(X, X).
