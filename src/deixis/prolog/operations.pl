/** <module> What Deixis asks of the rules beyond plain questions

Operations of the bridge, each one request and one JSON reply.
*/

:- module(operations, []).
:- use_module(library(lists)).

:- multifile bridge:op/3.

%   why(Text): the best proof of the goal that Text is; where it does not hold, what comes nearest.

bridge:op(why, [Text], _{ proof: Proof, nearest: Nearest, text: Sentence }) :-
    bridge:question(Text, Goal, _),
    one_relation(Goal),
    (   explain:best_proof(question:Goal, Node)
    ->  verbalise:node_dict(Node, Proof),
        verbalise:node_text(Node, Sentence),
        Nearest = null
    ;   Proof = null,
        explain:refusal(question:Goal, Node),
        Node = node(_, _, _, _, Near),
        verbalise:node_text(Node, Sentence),
        (   Near = [Miss]
        ->  verbalise:node_dict(Miss, Nearest)
        ;   Nearest = null
        )
    ).

one_relation(Goal) :-
    (   predicate_property(question:Goal, file(_))
    ->  true
    ;   throw(bridge(query, "ask for the reasons of one relation, such as on_top_of(cup, table)", _{}))
    ).

%   margins([Name, Arity], ...): all answers of these predicates, each with its margin, as rows
%   [Name, Argument ..., Margin]; the margin is null where no length is involved.

bridge:op(margins, Predicates, Rows) :-
    findall(Row,
            ( member([Name, Arity], Predicates), answer(Name, Arity, Row) ),
            Rows).

answer(Name, Arity, Row) :-
    functor(Goal, Name, Arity),
    distinct_answer(Goal),
    Goal =.. [_|Args],
    explain:truth_margin(question:Goal, Margin),
    (   number(Margin) -> Metres = Margin ; Metres = null ),
    append([Name|Args], [Metres], Row).

distinct_answer(Goal) :-
    findall(Goal, question:Goal, Bag),
    sort(Bag, Distinct),
    member(Goal, Distinct).
