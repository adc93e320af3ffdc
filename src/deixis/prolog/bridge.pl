/** <module> The Prolog side of the bridge: one request as text in, one reply as JSON text out

A request is the text of one term, written by quote.py and text.py. A reply is one JSON object,
`{"ok": ...}` or `{"error": Kind, "message": ..., ...}`; terms in it are typed as terms.py describes.

  | rules(Files, Tabled)         | true: the rule files are loaded                   |
  | load(Lists)                  | replace all facts; how many there are             |
  | load_files(Files)            | the same, by files with lists of them             |
  | ask(Text, Limit, Inferences) | rows of bindings, whether cut short, its output   |
  | relations([Name/Arity, ...]) | all answers of these predicates, sorted, distinct |
  | call(Operation, Arguments)   | what the operation of a rule file returns         |

A rule file adds an operation with a clause of the multifile predicate `bridge:operation/3`:

  ==
  :- multifile bridge:operation/3.
  bridge:operation(why, [Text], JSON) :-
      bridge:question(Text, Goal, _Names),
      ...
  ==

See json_text.pl for what JSON may be.
*/

:- module(bridge, [request/2]).

:- multifile operation/3, user:message_hook/3.
:- dynamic operation/3, complaint/1, loading/0, base/2.

%   Nothing is printed: until the rules are loaded, each warning and error is a complaint that fails them;
%   later nobody reads it.

loading.

user:message_hook(Message, Kind, Lines) :-
    memberchk(Kind, [error, warning]),
    (   bridge:loading
    ->  bridge:complain(Message, Lines)
    ;   true
    ).

complain(Message, Lines) :-
    lines_text(Lines, Text0),
    (   Message = error(_, Context),
        nonvar(Context),
        Context = file(_, _, _, _)              % its lines begin with the place
    ->  Text = Text0
    ;   source_location(File, Line)
    ->  format(string(Text), "~w:~d: ~s", [File, Line, Text0])
    ;   Text = Text0
    ),
    assertz(complaint(Text)).

lines_text(Lines, Text) :-
    with_output_to(string(Whole), print_message_lines(current_output, '', Lines)),
    split_string(Whole, "", " \n", [Text]).

:- use_module(library(apply), [maplist/2, maplist/3]).
:- use_module(library(error), [must_be/2]).
:- use_module(library(lists), [member/2, sum_list/2]).
:- use_module(json_text).
:- use_module(questions).
:- use_module(operations).

:- set_prolog_flag(encoding, utf8).    % of rule files, whatever the locale is

%!  request(+Text:string, -Reply:string) is det.
%
%   Do one request. Whatever goes wrong within is told in the reply.

request(Text, Reply) :-
    (   catch(reply(Text, Reply0), Error, error_reply(Error, Reply0))
    ->  Reply = Reply0
    ;   error_reply(bridge(engine, "the request failed", []), Reply)
    ).

reply(Text, Reply) :-
    read_one(Text, bridge, Request, _),
    perform(Request, Result),
    json_text(json([ok = Result]), Reply).

perform(rules(Files, Tabled), true) :-
    maplist(load_rules, Files),
    maplist(keep_answers, Tabled),
    retractall(loading),
    findall(Complaint, retract(complaint(Complaint)), Complaints),
    (   Complaints == []
    ->  remember_vocabulary,
        remember_base
    ;   throw(bridge(rules, "the rule files do not load without complaint", [complaints = Complaints]))
    ).
perform(load(Lists), Count) :-
    forget_facts,
    maplist(add_list, Lists, Counts),
    abolish_all_tables,
    sum_list(Counts, Count).
perform(load_files(Files), Count) :-
    forget_facts,
    maplist(reading, Files, Threads),
    maplist(read_by, Threads, Counts),
    abolish_all_tables,
    sum_list(Counts, Count).
perform(ask(Text, Limit, Inferences), Answers) :-
    ask(Text, Limit, Inferences, Answers).
perform(relations(Indicators), Tables) :-
    relations(Indicators, Tables).
perform(call(Operation, Arguments), Result) :-
    (   clause(operation(Operation, _, _), _)
    ->  true
    ;   format(string(Message), "no rule file defines the operation ~q", [Operation]),
        throw(bridge(engine, Message, []))
    ),
    (   with_output_to(string(_), operation(Operation, Arguments, Result0))
    ->  Result = Result0
    ;   Result = null
    ).


                 /*******************************
                 *       RULES AND FACTS        *
                 *******************************/

%   Module files are imported into `question`, others define their predicates there: so a rule file
%   needs no header to see the whole vocabulary, and a question sees what the files offer.

%   Only what breaks a rule, and how things are put in words, may be said by several files.

:- multifile question:violation/2, question:violation/3, question:says/3.

load_rules(File) :-
    catch(load_files(question:File, [if(not_loaded), must_be_module(false)]),
          Error,
          print_message(error, Error)).

%   keep_answers(+Indicator): table a predicate wherever a rule file defines it, so that recursion ends.

keep_answers(Name/Arity) :-
    functor(Head, Name, Arity),
    forall(( current_module(Module),
             module_property(Module, class(user)),
             current_predicate(Module:Name/Arity),
             \+ predicate_property(Module:Head, imported_from(_))
           ),
           table(Module:Name/Arity)).

%   Base facts are what module `facts` declares dynamic, and nothing else can be loaded.

remember_base :-
    forall(( predicate_property(facts:Head, dynamic),
             \+ predicate_property(facts:Head, imported_from(_))
           ),
           ( functor(Head, Name, Arity),
             assertz(base(Name, Arity))
           )).

forget_facts :-
    forall(base(Name, Arity),
           ( functor(Head, Name, Arity),
             retractall(facts:Head)
           )).

%   reading(+File, -Thread), read_by(+Thread, -Count): files are read side by side. An error costs the engine, so
%   that no half of the facts stays.

reading(File, Thread) :-
    thread_self(Self),
    thread_create(read_file(File, Self), Thread).

read_file(File, Asker) :-
    setup_call_cleanup(
        open(File, read, In, [encoding(utf8)]),
        add_lists(In, Count),
        close(In)),
    thread_self(Self),
    thread_send_message(Asker, read(Self, Count)).

read_by(Thread, Count) :-
    thread_join(Thread, Status),
    (   Status == true
    ->  thread_get_message(read(Thread, Count))
    ;   Status = exception(Error)
    ->  throw(Error)
    ).

%   add_lists(+Stream, -Count): list after list, so that no more than one of them needs memory.

add_lists(In, Count) :-
    Added = added(0),
    repeat,
    read_term(In, Facts, [module(bridge)]),
    (   Facts == end_of_file
    ->  !,
        arg(1, Added, Count)
    ;   add_list(Facts, More),
        arg(1, Added, Before),
        After is Before + More,
        nb_setarg(1, Added, After),
        fail
    ).

add_list(Facts, Count) :-
    must_be(list, Facts),
    (   ground(Facts)
    ->  true
    ;   throw(bridge(facts, "a base fact holds a variable", []))
    ),
    add_facts(Facts),
    length(Facts, Count).

add_facts([]).
add_facts([Fact|Facts]) :-
    (   callable(Fact),
        functor(Fact, Name, Arity),
        base(Name, Arity)
    ->  assertz(facts:Fact)
    ;   format(string(Message), "no base fact has the form ~p", [Fact]),
        throw(bridge(facts, Message, []))
    ),
    add_facts(Facts).


                 /*******************************
                 *            ERRORS            *
                 *******************************/

error_reply(Error, Reply) :-
    described(Error, Kind, Message, Details),
    !,
    json_text(json([error = Kind, message = Message|Details]), Reply).

described(bridge(Kind, Message, Details0), Kind, Message, Details) :-
    (   is_dict(Details0)
    ->  dict_pairs(Details0, _, Details)
    ;   Details = Details0
    ).
described(error(syntax_error(What), Context), syntax, Message, [position = Position]) :-
    message_text(error(syntax_error(What), _), Message),
    (   nonvar(Context),
        Context = stream(_, _, _, Position)
    ->  true
    ;   Position = null
    ).
described(error(resource_error(c_stack), _), query, "a term is nested too deeply", []).
described(error(resource_error(_), _), memory, "more memory is needed than the engine may use", []).
described(error(representation_error(code_point), _), query,
          "an answer holds a code that is no Unicode character", []).
described(error(existence_error(procedure, Called), _), rules, "a rule calls what no rule file defines",
          [complaints = [Complaint]]) :-
    strip_module(Called, _, Goal),
    (   Goal = Name/Arity                       % safe_goal/1 gives the goal itself
    ->  true
    ;   functor(Goal, Name, Arity)
    ),
    format(string(Complaint), "~q is not defined", [Name/Arity]).
described(error(permission_error(Action, Type, Culprit), _), permission, Message, []) :-
    format(string(Message), "the question leads to ~q, which is not allowed (~w ~w)",
           [Culprit, Action, Type]).
described(Error, query, Message, []) :-
    message_text(Error, Message).

message_text(Term, Text) :-
    '$messages':translate_message(Term, Lines, []),
    lines_text(Lines, Text).
