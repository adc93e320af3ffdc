:- module(margins,
          [ comparison/1,               % +Goal
            compares/3,                 % +Comparison, -Plain, -Margin
            margin/2,                   % +Node, -Margin
            negated/2,                  % +Margin, -Opposite
            less/2,                     % +A, +B
            larger/3,                   % +A, +B, -C
            weakest/2                   % +Nodes, -Margin
          ]).
:- use_module(library(apply)).

/** <module> Margins of proof steps

A margin is the number of metres by which a measured length would have to change for a step to change its
answer: a number, `inf` where nothing measured could, `minus_inf` for what fails whatever is measured. Numbers
that are not lengths come marked as no_length(N).
*/

%!  comparison(+Goal) is semidet.
%
%   Goal compares two values.

comparison(_ < _).
comparison(_ =< _).
comparison(_ > _).
comparison(_ >= _).
comparison(_ =:= _).
comparison(_ =\= _).
comparison(_ \== _).
comparison(_ == _).
comparison(_ = _).
comparison(_ \= _).

%!  compares(+Comparison, -Plain, -Margin) is semidet.
%
%   Plain can be called; Margin is the length to spare, negative when the comparison fails, `inf` when no
%   length is compared.

compares(Goal, Goal, inf) :-
    names(Goal),
    !.
compares(Goal, Plain, Margin) :-
    Goal =.. [Op, A, B],
    value(A, X, Length),
    value(B, Y, Length),
    Plain =.. [Op, X, Y],
    (   Length == none
    ->  Margin = inf
    ;   spare(Op, X, Y, Margin)
    ).

names(_ \== _).
names(_ == _).
names(_ = _).
names(_ \= _).

spare(=<, X, Y, M) :- M is Y - X.
spare(<, X, Y, M) :- M is Y - X.
spare(>=, X, Y, M) :- M is X - Y.
spare(>, X, Y, M) :- M is X - Y.
spare(=:=, X, Y, M) :- M is -abs(X - Y).
spare(=\=, X, Y, M) :- M is abs(X - Y).

value(X, X, _) :- number(X), !.
value(no_length(X), X, none) :- !.
value(-A, X, L) :- !, value(A, Y, L), X is -Y.
value(A + B, X, L) :- !, value(A, Y, L), value(B, Z, L), X is Y + Z.
value(A - B, X, L) :- !, value(A, Y, L), value(B, Z, L), X is Y - Z.
value(A * B, X, L) :- !, value(A, Y, L), value(B, Z, L), X is Y * Z.

%!  margin(+Node, -Margin) is det.
%
%   Margin is that of Node.

margin(node(_, _, Margin, _, _), Margin).

%!  negated(+Margin, -Opposite) is det.
%
%   Opposite is the margin of a denial.

negated(inf, minus_inf) :- !.
negated(minus_inf, inf) :- !.
negated(M, N) :- N is -M.

%!  less(+A, +B) is semidet.
%
%   Margin A is smaller than B.

less(minus_inf, B) :- !, B \== minus_inf.
less(_, minus_inf) :- !, fail.
less(inf, _) :- !, fail.
less(_, inf) :- !.
less(A, B) :- A < B.

%!  larger(+A, +B, -C) is det.
%
%   C is the larger of two margins.

larger(A, B, C) :- ( less(A, B) -> C = B ; C = A ).

%!  weakest(+Nodes, -Margin) is det.
%
%   Margin is the least of those of Nodes.

weakest(Nodes, Margin) :-
    foldl(weaker, Nodes, inf, Margin).

weaker(Node, B, C) :-
    margin(Node, A),
    (   less(A, B)
    ->  C = A
    ;   C = B
    ).
