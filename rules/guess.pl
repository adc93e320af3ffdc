:- module(guess,
          [ unknown_name/3,             % +What, +Name, +Known
            unknown_predicate/2,        % +Predicate, +Known
            close_name/3                % +Name, +Known, -Close
          ]).
:- use_module(library(apply)).
:- use_module(library(lists)).
:- use_module(library(pairs)).

/** <module> What may have been meant

For names that nothing has: the known name that is most alike.
*/

%!  unknown_name(+What, +Name, +Known) is det.
%
%   Tell that there is no Name among the Known ones, and what may have been meant.

unknown_name(What, Name, Known) :-
    (   close_name(Name, Known, Close)
    ->  print_message(help, format("~w ~q: did you mean ~q?", [What, Name, Close]))
    ;   length(Known, Count),
        Count =< 10,
        Count > 0
    ->  print_message(help, format("~w ~q: known are ~q", [What, Name, Known]))
    ;   print_message(help, format("~w ~q", [What, Name]))
    ).

%!  unknown_predicate(+Predicate, +Known) is det.
%
%   The same for a Predicate, as Name/Arity, of which the Known names are names only.

unknown_predicate(Name/Arity, Known) :-
    findall(Name/Other, ( current_predicate(user:Name/Other), Other =\= Arity ), Same),
    (   Same = [Meant|_]
    ->  print_message(help, format("no rule or fact is called ~q: did you mean ~q?", [Name/Arity, Meant]))
    ;   close_name(Name, Known, Close),
        once(( current_predicate(user:Close/Arity), Count = Arity ; current_predicate(user:Close/Count) ))
    ->  print_message(help, format("no rule or fact is called ~q: did you mean ~q?", [Name/Arity, Close/Count]))
    ;   print_message(help, format("no rule or fact is called ~q: axioms lists what there is",
                                   [Name/Arity]))
    ).

%!  close_name(+Name, +Known, -Close) is semidet.
%
%   Close is the one of the Known names that is most like Name: one letter off, else with the most pairs of
%   letters in common, and half of them at least.

close_name(Name, Known, Close) :-
    member(Close, Known),
    Close \== Name,
    dwim_match(Name, Close),
    !.
close_name(Name, Known, Close) :-
    letter_pairs(Name, Pairs),
    findall(Likeness-One, ( member(One, Known), One \== Name, likeness(Pairs, One, Likeness) ), Found),
    keysort(Found, Sorted),
    last(Sorted, Best-Close),
    Best >= 0.5.

likeness(Pairs, Name, Likeness) :-
    letter_pairs(Name, Others),
    common(Pairs, Others, 0, Common),
    length(Pairs, A),
    length(Others, B),
    A + B > 0,
    Likeness is 2 * Common / (A + B).

letter_pairs(Name, Pairs) :-
    downcase_atom(Name, Lower),
    findall(Pair, sub_atom(Lower, _, 2, _, Pair), Pairs0),
    msort(Pairs0, Pairs).

common([], _, N, N) :- !.
common(_, [], N, N) :- !.
common([A|As], [B|Bs], N0, N) :-
    compare(Order, A, B),
    common(Order, A, As, B, Bs, N0, N).

common(=, _, As, _, Bs, N0, N) :- N1 is N0 + 1, common(As, Bs, N1, N).
common(<, _, As, B, Bs, N0, N) :- common(As, [B|Bs], N0, N).
common(>, A, As, _, Bs, N0, N) :- common([A|As], Bs, N0, N).
