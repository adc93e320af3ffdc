/** <module> What Deixis asks of the rules beyond plain questions

Operations of the bridge, each one request and one JSON reply.
*/

:- module(operations, []).
:- use_module(library(apply), [maplist/3]).
:- use_module(library(lists), [append/3, member/2]).

:- multifile bridge:operation/3.

%   why(Text): the best proof of the goal that Text is; where it does not hold, what comes nearest. Names of
%   nothing in the scene are reported instead.

bridge:operation(why, [Text], Reply) :-
    answered(Text, reason, Reply).

reason(Goal, Reply) :-
    (   explain:best_proof(question:Goal, Node)
    ->  outline:node_dict(Node, Proof),
        verbalise:node_text(Node, Sentence),
        Reply = _{ proof: Proof, nearest: null, text: Sentence }
    ;   explain:refusal(question:Goal, Node),
        Node = node(_, _, _, _, Near),
        verbalise:node_text(Node, Sentence0),
        (   hindered(Goal, Hindrance)
        ->  words:saying(hindered, [Sentence0, Hindrance], Sentence)
        ;   Sentence = Sentence0
        ),
        (   Near = [Miss]
        ->  outline:node_dict(Miss, Nearest)
        ;   Nearest = null
        ),
        Reply = _{ proof: null, nearest: Nearest, text: Sentence }
    ).

%   why_all(Text, Most): at most that many proofs, the best first, and whether there are more.

bridge:operation(why_all, [Text, Most], Reply) :-
    answered(Text, reasons(Most), Reply).

reasons(Most, Goal, _{ proofs: Proofs, truncated: More }) :-
    explain:all_proofs(question:Goal, Most, Nodes, More),
    maplist(outline:node_dict, Nodes, Proofs).

%   why_not(Text): whether the goal holds and, if it does not, what keeps each rule from concluding it.

bridge:operation(why_not, [Text], Reply) :-
    answered(Text, no_reason, Reply).

no_reason(Goal, Reply) :-
    (   explain:best_proof(question:Goal, Node)
    ->  verbalise:node_text(Node, Sentence),
        Reply = _{ holds: true, text: Sentence, misses: [], hindrance: null, because: [] }
    ;   verbalise:denied_text(Goal, Sentence),
        (   refusals:hindrance(Goal, Hindrance) -> true ; Hindrance = null ),
        explain:misses(question:Goal, Nodes),
        maplist(miss, Nodes, Misses),
        clauses(Goal, Nodes, Clauses),
        Reply = _{ holds: false, text: Sentence, misses: Misses, hindrance: Hindrance, because: Clauses }
    ).

%   clauses(+Goal, +Misses, -Texts): what keeps Goal from holding, said after the sentence that it does not.

clauses(Goal, _, [Text]) :-
    hindered(Goal, Text),
    !.
clauses(Goal, [Nearest|_], Texts) :-
    !,
    verbalise:subject(Goal, Subject),
    refusals:obstacles(Nearest, Subject, Texts).
clauses(_, [], []).

hindered(Goal, Text) :-
    verbalise:subject(Goal, Subject),
    verbalise:going_on(Goal, refusals:hindrance(Goal, Text), Subject, _).

miss(Node, _{ derivation: Dict, obstacles: Texts }) :-
    outline:node_dict(Node, Dict),
    refusals:obstacles(Node, none, Texts).

%   contrast(Text, Other): why the one holds, why the other does not, and both in a sentence.

bridge:operation(contrast, [Text, Other], Reply) :-
    asked(Text, Goal),
    asked(Other, OtherGoal),
    (   ( stranger(Goal, Name) ; stranger(OtherGoal, Name) )
    ->  Reply = _{ unknown: Name }
    ;   reason(Goal, Fact),
        no_reason(OtherGoal, Refusal),
        explain:opposed(question:Goal, question:OtherGoal, Sentence),
        Reply = _{ fact: Fact, other: Refusal, text: Sentence }
    ).

%   words(): the small words of the language that is spoken.

bridge:operation(words, [], Reply) :-
    words:language(Language),
    findall(Name-Text,
            ( member(Name, [because, and, no, nor, closest, margin, axiom, fails]),
              Language:connective(Name, Words),
              atom_string(Words, Text)
            ),
            Pairs),
    dict_pairs(Reply, _, Pairs).

%   answered(+Text, :Answer, -Reply): what Answer replies of the goal that Text is, unless it names a stranger.

answered(Text, Answer, Reply) :-
    asked(Text, Goal),
    (   stranger(Goal, Name)
    ->  Reply = _{ unknown: Name }
    ;   call(Answer, Goal, Reply)
    ).

asked(Text, Goal) :-
    questions:question(Text, Goal, _),
    one_relation(Goal).

one_relation(Goal) :-
    functor(Goal, Name, Arity),
    (   questions:vocabulary(Name, Arity)
    ->  true
    ;   throw(bridge(query, "ask for the reasons of one relation, such as on_top_of(cup, table)", []))
    ).

%   stranger(+Goal, -Text): the first name in it that is no thing and no view here.

stranger(Goal, Text) :-
    questions:stranger(Goal, Name),
    !,
    atom_string(Name, Text).

%   margins([Name, Arity], ...): all answers of these predicates, each with its margin, as rows
%   [Name, Argument ..., Margin]; the margin is null where no length is involved.

bridge:operation(margins, Predicates, Rows) :-
    findall(Row,
            ( member([Name, Arity], Predicates), answer(Name, Arity, Row) ),
            Rows).

answer(Name, Arity, Row) :-
    functor(Goal, Name, Arity),
    distinct_answer(Goal),
    Goal =.. [_|Args],
    explain:truth_margin(question:Goal, Margin),
    (   number(Margin) -> Metres = Margin ; Metres = null ),
    maplist(as_text, [Name|Args], Texts),
    append(Texts, [Metres], Row).

%   Ids go as strings: an object may be called null.

as_text(Id, Text) :- atom_string(Id, Text).

distinct_answer(Goal) :-
    findall(Goal, question:Goal, Bag),
    sort(Bag, Distinct),
    member(Goal, Distinct).

%   proofs([Name, Arity], ...): the best proof of each answer of these predicates.

bridge:operation(proofs, Predicates, Proofs) :-
    findall(Proof,
            ( member([Name, Arity], Predicates), proved(Name, Arity, Proof) ),
            Proofs).

proved(Name, Arity, Proof) :-
    functor(Goal, Name, Arity),
    distinct_answer(Goal),
    explain:best_proof(question:Goal, Node),
    outline:node_dict(Node, Proof).

%   names(View), names(): what each thing is called, as rows [Thing, Name]; from View, or whoever looks.

bridge:operation(names, Views, Rows) :-
    (   Views = [View]
    ->  true
    ;   View = any
    ),
    naming:names(View, Pairs),
    findall([Id, Name], ( member(Thing-Name, Pairs), atom_string(Thing, Id) ), Rows).
