:- module(explain,
          [ proof/2,                    % :Goal, -Node
            best_proof/2,               % :Goal, -Node
            truth_margin/2,             % :Goal, -Margin
            nearest_miss/2,             % :Goal, -Node
            misses/2,                   % :Goal, -Nodes
            refusal/2,                  % :Goal, -Node
            all_proofs/4,               % :Goal, +Most, -Nodes, -More
            opposed/3,                  % :Goal, :Other, -Text
            why/1,                      % :Goal
            contrast/2                  % :Goal, :Other
          ]).
:- use_module(library(lists), [append/3, member/2, last/2]).
:- use_module(library(apply)).
:- use_module(library(aggregate)).
:- use_module(library(solution_sequences)).
:- use_module(facts).
:- use_module(margins).
:- use_module(outline).
:- use_module(refusals).
:- use_module(verbalise).
:- use_module(words).

/** <module> Why a relation holds: proofs with margins

One small meta-interpreter over the rules as they stand in their files. It gives each conclusion its proof
and each step its margin: the number of metres by which a measured length would have to change for the
step to change its answer. A conjunction has the margin of its weakest part, alternatives that of the
strongest, and a negation turns the sign round, so any rule a user adds has margins too.

A node is node(Kind, Goal, Margin, Clause, Children) where Kind is one of rule, fact, comparison, negation, conjunction;
Clause is a clause reference or `none`; Margin is a number, or `inf` where no length is involved.
*/

:- meta_predicate
    proof(0, -),
    best_proof(0, -),
    truth_margin(0, -),
    nearest_miss(0, -),
    misses(0, -),
    refusal(0, -),
    all_proofs(0, +, -, -),
    opposed(0, 0, -),
    why(0),
    contrast(0, 0).

%!  proof(:Goal, -Node) is nondet.
%
%   Node is a proof of Goal; on backtracking, the others.

proof(M:Goal, Node) :-
    derive(holds, Goal, M, [], Node).

%!  best_proof(:Goal, -Node) is semidet.
%
%   Node is the shortest proof of Goal and among those the one with the widest margin. Binds Goal.

best_proof(Goal, Node) :-
    findall(Goal-N, proof(Goal, N), [First|Rest]),
    foldl(better, Rest, First, Goal-Node).

%!  all_proofs(:Goal, +Most, -Nodes:list, -More:boolean) is det.
%
%   Nodes are at most Most different proofs of Goal, the best of all first; More tells whether there are
%   others.

all_proofs(Goal, Most, Nodes, More) :-
    Enough is Most + 1,
    findall(N, limit(Enough, distinct(N, proof(Goal, N))), Found),
    (   length(Found, Enough)
    ->  More = true,
        copy_term(Goal, Any),
        best_proof(Any, Best),
        exclude(=@=(Best), Found, Others),
        Rest is Most - 1,
        length(Kept, Rest),
        append(Kept, _, Others),
        predsort(sooner, Kept, Ordered),
        Nodes = [Best|Ordered]
    ;   More = false,
        predsort(sooner, Found, Nodes)
    ).

%   The better first, none left out.

sooner(Order, A, B) :-
    (   better(a-A, b-B, a-_)
    ->  Order = (<)
    ;   Order = (>)
    ).

better(GoalA-A, GoalB-B, Best) :-
    size(A, SizeA),
    size(B, SizeB),
    margin(A, MarginA),
    margin(B, MarginB),
    (   ( SizeA < SizeB ; SizeA =:= SizeB, less(MarginB, MarginA) )
    ->  Best = GoalA-A
    ;   Best = GoalB-B
    ).

%!  truth_margin(:Goal, -Margin) is semidet.
%
%   Goal holds and keeps holding while every length changes by less than Margin metres.

truth_margin(Goal, Margin) :-
    findall(M, ( proof(Goal, N), margin(N, M) ), [First|Rest]),
    foldl(larger, Rest, First, Margin).

%!  nearest_miss(:Goal, -Node) is semidet.
%
%   Node is the derivation of Goal that comes closest to holding: its margin tells by how much it fails.
%   Fails where nothing within reach could make Goal true.

nearest_miss(M:Goal, Node) :-
    findall(N, near_whole(Goal, M, N), [First|Rest]),
    foldl(closer, Rest, First, Node).

%!  misses(:Goal, -Nodes:list) is det.
%
%   Nodes are the derivations that come closest to Goal, one for each rule that could conclude it, nearest
%   first, and last those that more keeps from holding than a length.

misses(M:Goal, Nodes) :-
    findall(Clause-Node, ( near_whole(Goal, M, Node), Node = node(_, _, _, Clause, _) ), Pairs),
    findall(Clause, member(Clause-_, Pairs), Found),
    sort(Found, Clauses),
    findall(Best,
            ( member(Clause, Clauses),
              findall(Node, member(Clause-Node, Pairs), [First|Rest]),
              foldl(plainer, Rest, First, Best)
            ),
            Bests),
    findall(Node, blocked(Goal, M, Clauses, Node), Others),
    predsort(nearer, Bests, Measured),
    append(Measured, Others, Nodes).

%   blocked(+Goal, +Module, +Clauses, -Node): the derivation of Goal by a rule that is not among Clauses, since
%   something other than a measured length keeps it from holding: a label, the order of figure and reference,
%   a number that is no length. As many of its first goals as can be derived are; then each that cannot fails.

blocked(Goal, M, Clauses, node(rule, Goal, minus_inf, Clause, Children)) :-
    step(Goal, M, rule(Def)),
    clause(Def:Goal, Body, Clause),
    \+ memberchk(Clause, Clauses),
    phrase(goals(Body), Goals),
    begun(Goals, Goal, Def, Done, Rest),
    foldl(part(Def, Goal), Rest, More, []),
    append(Done, More, Children).

goals(true) --> !.
goals((A, B)) --> !, goals(A), goals(B).
goals(Goal) --> [Goal].

%   begun(+Goals, +Above, +Module, -Done, -Rest): Done derives as many of the first Goals as can be, in the way
%   that comes closest to holding; of the rest the first cannot be derived after them.

begun(Goals, Above, M, Done, Rest) :-
    length(Goals, All),
    between(1, All, Left),
    length(Rest, Left),
    append(First, Rest, Goals),
    closest(Goals-Above, derive_list(First, M, Above), Done),
    !.

derive_list([], _, _, []).
derive_list([Goal|Goals], M, Above, [Node|Nodes]) :-
    derive(nears, Goal, M, [Above], Node),
    derive_list(Goals, M, Above, Nodes).

%   closest(+Bound, :Goal, -Nodes): of the first ways in which Goal derives Nodes, binding what is Bound, that
%   with the widest margin.

closest(Bound, Goal, Nodes) :-
    most_ways(Most),
    findall(Margin-way(Bound, Ways), limit(Most, ( call(Goal, Ways), weakest(Ways, Margin) )), [First|Rest]),
    foldl(wider, Rest, First, _-way(Bound, Nodes)).

wider(A-X, B-Y, C) :-
    (   less(B, A)
    ->  C = A-X
    ;   C = B-Y
    ).

most_ways(1000).

%   part(+Module, +Above, +Goal, ?Nodes, ?Tail): a goal after one that cannot be derived. What that one would
%   have bound is open, so of comparisons and denials only those are told that do without.

part(_, _, Goal, Nodes, Nodes) :-
    \+ ground(Goal),
    ( comparison(Goal) ; Goal = (\+ _) ),
    !.
part(M, Above, Goal, [Node|Nodes], Nodes) :-
    closest(Goal, derive_list([Goal], M, Above), [Node]),
    !.
part(_, _, Goal, [node(Kind, Goal, minus_inf, none, [])|Nodes], Nodes) :-
    (   comparison(Goal)
    ->  Kind = comparison
    ;   Kind = rule
    ).

nearer(Order, A, B) :-
    margin(A, MA),
    margin(B, MB),
    (   less(MA, MB)
    ->  Order = (>)
    ;   Order = (<)
    ).

near_whole(Goal, M, Node) :-
    derive_all(Goal, nears, M, [], Nodes),
    (   Nodes = [Node]
    ->  true
    ;   weakest(Nodes, Margin),
        Node = node(conjunction, Goal, Margin, none, Nodes)
    ).

%!  refusal(:Goal, -Node) is semidet.
%
%   Node says that Goal does not hold, with the nearest miss below it.

refusal(M:Goal, Node) :-
    derive(holds, \+ Goal, M, [], Node).

%   plainer(+A, +B, -C): the closer of two derivations; of two that are as close, that in which fewer parts fail.

plainer(A, B, C) :-
    margin(A, Margin),
    margin(B, Margin),
    !,
    failing(A, FailingA),
    failing(B, FailingB),
    (   FailingB < FailingA
    ->  C = B
    ;   C = A
    ).
plainer(A, B, C) :- closer(A, B, C).

failing(node(_, _, _, _, Children), Count) :-
    aggregate_all(count, ( member(Child, Children), fails(Child) ), Count).

closer(A, B, C) :-
    margin(A, MA),
    margin(B, MB),
    (   less(MB, MA)
    ->  C = A
    ;   C = B
    ).

%   derive(+Mode, +Goal, +Module, +Ancestors, -Node): in mode `holds` only what holds; in mode `nears` every
%   derivation, whether its comparisons hold or not.

derive(Mode, Goal, M, Above, Node) :-
    step(Goal, M, Kind),
    derive(Kind, Mode, Goal, M, Above, Node).

derive(negation(Inner), Mode, _, M, _, node(negation, \+ Inner, Margin, none, Near)) :-
    (   Mode == holds
    ->  without_marks(Inner, Plain),
        \+ call(M:Plain)
    ;   true
    ),
    (   nearest_miss(M:Inner, Miss)
    ->  margin(Miss, Short),
        negated(Short, Margin),
        Near = [Miss]
    ;   Margin = inf,
        Near = []
    ).
derive(comparison, Mode, Goal, _, _, node(comparison, Goal, Margin, none, [])) :-
    compares(Goal, Plain, Margin),
    (   ( Mode == holds ; Margin == inf )
    ->  call(Plain)
    ;   true
    ).
derive(fact(Def), _, Goal, _, _, Node) :-
    recall(Goal, Def, Node).
derive(rule(Def), Mode, Goal, _, Above, node(rule, Goal, Margin, Clause, Children)) :-
    (   Mode == holds,
        predicate_property(Def:Goal, tabled)
    ->  without_marks(Goal, Plain),             % so that no proof stops at a goal like itself
        call(Def:Plain)
    ;   true
    ),
    \+ ( member(Seen, Above), Seen =@= Goal ),
    clause(Def:Goal, Body, Clause),
    derive_all(Body, Mode, Def, [Goal|Above], Children),
    weakest(Children, Margin).

derive_all(true, _, _, _, []) :- !.
derive_all((A, B), Mode, M, Above, Nodes) :-
    !,
    derive_all(A, Mode, M, Above, First),
    derive_all(B, Mode, M, Above, Rest),
    append(First, Rest, Nodes).
derive_all(Goal, Mode, M, Above, [Node]) :-
    derive(Mode, Goal, M, Above, Node).

%   step(+Goal, +Module, -Kind): what kind of thing a goal is, and where it is defined.

step(\+ Inner, _, negation(Inner)) :- !.
step(Goal, _, comparison) :-
    comparison(Goal),
    !.
step(Goal, M, Kind) :-
    (   predicate_property(M:Goal, imported_from(Def))
    ->  true
    ;   Def = M
    ),
    (   predicate_property(Def:Goal, dynamic),
        Def == facts
    ->  Kind = fact(Def)
    ;   Kind = rule(Def)
    ).

%   recall(+Goal, +Module, -Node): a base fact. Numbers that are not lengths come back marked, so that no
%   comparison of theirs is taken for a margin in metres.

recall(Goal, Def, node(fact, Plain, inf, none, [])) :-
    copy_unmarked(Goal, Plain),
    call(Def:Plain),
    marked(Plain, Marked),
    Goal = Marked.

copy_unmarked(Goal, Plain) :-
    Goal =.. [Name|Args],
    maplist(unmarked, Args, PlainArgs),
    Plain =.. [Name|PlainArgs].

%   without_marks(+Goal, -Plain): Goal as Prolog can call it, with the same variables.

without_marks(Goal, Goal) :- \+ compound(Goal), !.
without_marks(no_length(N), N) :- !.
without_marks(Goal, Plain) :-
    Goal =.. [Name|Args],
    maplist(without_marks, Args, PlainArgs),
    Plain =.. [Name|PlainArgs].

unmarked(Arg, _) :- var(Arg), !.
unmarked(no_length(N), N) :- !.
unmarked(Arg, Arg).

marked(label(O, N, S), label(O, N, no_length(S))) :- !.
marked(threshold(halfspace_scale, S), threshold(halfspace_scale, no_length(S))) :- !.
marked(pair(A, B, D, S, P, V, F, U, W), pair(A, B, D, S, P, no_length(V), no_length(F), U, W)) :- !.
marked(Goal, Goal).

size(node(_, _, _, _, Children), Size) :-
    foldl([Child, S0, S]>>( size(Child, S1), S is S0 + S1 ), Children, 1, Size).

%!  opposed(:Goal, :Other, -Text:string) is det.
%
%   Text says why Goal holds rather than Other, in a sentence: that it does, and what keeps Other from it.

opposed(Goal, M:Other, Text) :-
    (   best_proof(Goal, Node)
    ->  node_text(Node, Fact),
        (   best_proof(M:Other, Holding)
        ->  node_text(Holding, OtherText),
            saying(both_hold, [Fact, OtherText], Text)
        ;   strip_module(Goal, _, Said),
            subject(Said, Subject),
            after_fact(Subject, Other, Before),
            going_on(Other, denied_text(Other, Denied), Before, Next),
            hindrances(M:Other, Next, Reasons),
            (   Reasons == []
            ->  saying(but, [Fact, Denied], Text)
            ;   joined(Reasons, Reason),
                saying(but_because, [Fact, Denied, Reason], Text)
            )
        )
    ;   strip_module(Goal, _, Plain),
        denied_text(Plain, Fact),
        saying(nothing_to_contrast, [Fact], Text)
    ).

%   after_fact(+Subject, +Other, -Before): "the cup is near the jug, but the mug is not near it" is of the jug.

after_fact(it(Thing), Other, named(Thing)) :-
    \+ subject(Other, it(Thing)),
    !.
after_fact(Subject, _, Subject).

%   hindrances(:Goal, +Subject, -Texts): what keeps Goal from holding, by the rule that comes closest, as clauses
%   about Subject.

hindrances(M:Goal, Subject, Texts) :-
    (   going_on(Goal, hindrance(Goal, Text), Subject, _)
    ->  Texts = [Text]
    ;   misses(M:Goal, [Miss|_])
    ->  obstacles(Miss, Subject, Texts)
    ;   Texts = []
    ).

joined([Text], Text) :- !.
joined([Text|Texts], Whole) :-
    joined(Texts, Rest),
    saying(both, [Text, Rest], Whole).

%!  why(:Goal) is det.
%
%   Print why Goal holds, down to the measured numbers; or that it does not, and by how much.

why(Goal) :-
    (   best_proof(Goal, Node)
    ->  print_proof(Node)
    ;   refusal(Goal, Node),
        print_proof(Node)
    ).

%!  contrast(:Goal, :Other) is det.
%
%   Print in a sentence why Goal holds rather than Other.

contrast(Goal, Other) :-
    opposed(Goal, Other, Text),
    format("~s.~n", [Text]).
