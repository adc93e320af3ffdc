"""What a question cannot do: change the knowledge, reach outside, print into the protocol, or last."""

from __future__ import annotations

import time
from collections.abc import Iterator

import pytest

from deixis.errors import EngineError, QueryError, QueryTimeout
from deixis.prolog import PrologEngine
from deixis.prolog.quote import atom

FACTS = """
:- module(facts, [on/2]).
:- dynamic on/2, leaked/1.
"""

RULES = """
:- use_module(library(process)).
:- dynamic leaked/1.
:- forall(member(Name, ['DEIXIS_SECRET', 'HOME', 'PATH']),
          ( getenv(Name, _) -> assertz(leaked(Name)) ; true )).
loop(X) :- loop(X).
left(X) :- left(X), on(X, _).
grow(X) :- grow(f(X, X)).
run(Command) :- shell(Command).
forget :- retractall(facts:on(_, _)).
"""

MEMORY = 1 << 29


@pytest.fixture(scope="module")
def shared(tmp_path_factory: pytest.TempPathFactory) -> Iterator[PrologEngine]:
    """Return an engine started where every trap for the user's settings is set."""
    here = tmp_path_factory.mktemp("trap")
    trap = f":- open('{here / 'sprung'}', write, S), close(S), halt.\n"
    for place in (here, here / "swi-prolog", here / ".config" / "swi-prolog"):
        place.mkdir(parents=True, exist_ok=True)
        (place / "init.pl").write_text(trap)
        (place / ".swiplrc").write_text(trap)
    rules = here / "rules"
    rules.mkdir()
    (rules / "facts.pl").write_text(FACTS)
    (rules / "traps.pl").write_text(RULES)
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(here)
        patch.setenv("HOME", str(here))
        patch.setenv("XDG_CONFIG_HOME", str(here))
        patch.setenv("XDG_CONFIG_DIRS", str(here))
        patch.setenv("DEIXIS_SECRET", "hunter2")
        with PrologEngine([rules / "facts.pl", rules / "traps.pl"], memory_bytes=MEMORY) as engine:
            engine.load("[on(cup, table)]")
            yield engine
            assert not (here / "sprung").exists()


@pytest.fixture
def prolog(shared: PrologEngine) -> Iterator[PrologEngine]:
    """Return that engine, and see afterwards that it knows what it knew."""
    yield shared
    assert shared.relations([("on", 2)]) == {"on": [("cup", "table")]}


def test_no_settings_and_no_environment(prolog: PrologEngine) -> None:
    assert not prolog.ask("leaked(X)")


ESCAPES = r"""
halt
halt(0)
shell(id)
shell('touch /tmp/x', S)
open('/etc/passwd', read, S)
see('/etc/passwd')
consult('/etc/passwd')
['/etc/passwd']
[user]
load_files(x)
use_module(library(process))
process_create(path(id), [], [])
tcp_connect(localhost:80, S, [])
getenv('HOME', X)
setenv(a, b)
thread_create(halt, X)
thread_self(X)
message_queue_create(X)
prolog_load_context(directory, X)
current_prolog_flag(home, X)
working_directory(X, X)
exists_file('/etc/passwd')
delete_file(x)
absolute_file_name(x, X)
read(X)
read_term(X, [])
get_char(X)
current_output(S)
stream_property(S, file_name(X))
write(user_error, x)
format(user_error, x, [])
format(atom(X), '~w', [a])
print_message(error, format(x, []))
nb_setval(a, b)
b_setval(a, b)
nb_getval(a, X)
flag(a, X, 1)
gensym(a, X)
recorda(a, b)
setarg(1, f(a), b)
assertz(on(a, b))
asserta(on(a, b))
assert(on(a, b))
retract(on(cup, table))
retractall(on(_, _))
retractall(facts:on(_, _))
facts:on(X, Y)
abolish(on/2)
erase(x)
clause(on(X, Y), B)
abolish_all_tables
dynamic(foo/1)
set_prolog_flag(double_quotes, atom)
set_prolog_stack(global, limit(1000000000))
op(700, xfx, =>)
sleep(1000000)
abort
prolog
trace
spy(on/2)
garbage_collect
tnot(on(a, b))
undefined
call_with_time_limit(1, on(X, Y))
catch(on(X, Y), _, true)
throw(x)
snapshot(on(X, Y))
transaction(on(X, Y))
term_to_atom(X, 'halt')
read_term_from_atom(halt, X, [])
phrase(on, [])
on --> []
a :- b
:- halt
engine_create(X, on(X, _), E)
freeze(X, halt), X = 1
when(ground(X), halt)
prompt(X, Y)
wait_for_input([], X, 0)
bridge:request(a, X)
request("load([])", X)
perform(load([]), X)
load([])
predsort(halt, [a, b], X)
thread_send_message(main, x)
""".strip().splitlines()


@pytest.mark.parametrize("goal", ESCAPES)
def test_refused(prolog: PrologEngine, goal: str) -> None:
    with pytest.raises(QueryError):
        prolog.ask(goal, timeout=5.0)


WRAPPINGS = r"""
call({})
call(call, {})
call(call, call, {})
on(X, Y), {}
({} ; true)
(true -> {} ; true)
(on(a, b) -> true ; {})
(on(X, Y) *-> {} ; true)
\+ {}
\+ \+ {}
not({})
once({})
ignore({})
forall(on(_, _), {})
forall({}, true)
findall(X, {}, L)
findall(X, {}, L, [])
bagof(X, {}, L)
setof(X, Y^{}, L)
aggregate_all(count, {}, N)
aggregate_all(max(1, 2), {}, N)
distinct({})
limit(1, {})
offset(1, {})
order_by([asc(X)], {})
maplist(call, [{}])
foldl([X, A, B]>>{}, [a], 0, S)
maplist([X]>>{}, [a])
G = {}, call(G)
G = {}, G
catch({}, _, true)
catch(throw(a), a, {})
user:{}
question:{}
system:{}
@({}, user)
call(({}, true))
phrase(({{}}, []), [])
format("~@", [{}])
F = "~@", format(F, [{}])
findall(G, G = {}, [H]), H
setup_call_cleanup(true, {}, true)
call_cleanup(true, {})
freeze(X, {}), X = 1
apply({}, [])
yall:({})
?- {}
tnot({})
call_delays({}, D)
X = f({}), arg(1, X, G), call(G)
include([_]>>{}, [a], L)
call([]>>{})
call(/(X, []>>{}))
""".strip().splitlines()


@pytest.mark.parametrize("wrapping", WRAPPINGS)
def test_refused_however_it_is_wrapped(prolog: PrologEngine, wrapping: str) -> None:
    for goal in ("halt", "retractall(on(_, _))", "shell(id)"):
        with pytest.raises(QueryError):
            prolog.ask(wrapping.replace("{}", goal), timeout=5.0)


def test_closures_with_missing_arguments_are_seen_through(prolog: PrologEngine) -> None:
    for goal in (
        "maplist(shell, [id])",
        "maplist(on(cup), [X]), call(shell, id)",
        "foldl(retract, [a], b, X)",
        "call(assertz, on(a, b))",
    ):
        with pytest.raises(QueryError, match=r"not allowed|is called"):
            prolog.ask(goal)
    assert prolog.ask("maplist(on(cup), [X])").bindings == ({"X": "table"},)
    assert prolog.ask("foldl(plus, [1, 2, 3], 0, X)").bindings == ({"X": 6},)


def test_rules_are_looked_through_as_well(prolog: PrologEngine) -> None:
    for goal in ("run(id)", "on(X, Y), run(id)", "maplist(run, [id])"):
        with pytest.raises(QueryError, match=r"leads to .*shell"):
            prolog.ask(goal)
    with pytest.raises(QueryError):
        prolog.ask("forget")


@pytest.mark.parametrize(
    "goal",
    [
        "between(1, inf, X), X < 0",
        "loop(X)",
        "between(1, inf, _), write(x), fail",
        "length(L, X), X < 0",
        "numlist(1, 100000, L), permutation(L, P), P = [b|_]",
        "forall(between(1, inf, X), X > 0)",
        "findall(X, between(1, inf, X), L)",
        'format("~*c", [1000000000, 0\'x])',
        "tab(10000000000)",
        "X is 7 ** 20000000, atom_length(X, L)",
        "X is 7 ** (7 ** 7), Y is X ** X",
    ],
)
def test_endless_and_enormous_questions_end(prolog: PrologEngine, goal: str) -> None:
    start = time.monotonic()
    with pytest.raises((QueryTimeout, QueryError, EngineError)):
        prolog.ask(goal, timeout=0.4)
    assert time.monotonic() - start < 1.2


@pytest.mark.parametrize(
    "goal",
    [
        "left(X)",
        "grow(a)",
        "length(L, 100000000)",
        "X is 3 ** (10 ** 10)",
        "numlist(1, 100000000, L)",
    ],
)
def test_memory_is_bounded(prolog: PrologEngine, goal: str) -> None:
    with pytest.raises((QueryError, EngineError), match="memory"):
        prolog.ask(goal, timeout=30.0)


@pytest.mark.parametrize("text", ["(", "f(", "[", "{", "'", "/*", "- ", "X = [", "a:-", "0'", "\\+"])
def test_long_and_deep_texts_are_only_wrong(prolog: PrologEngine, text: str) -> None:
    with pytest.raises(QueryError):
        prolog.ask((text * 60_000)[:60_000], timeout=5.0)


HOSTILE_IDS = (
    "x'))),shell('touch SPRUNG'),assertz((obj('y",
    'x"))),shell("touch SPRUNG"),assertz((obj("y',
    "'). halt. %",
    "\\'). halt. %",
    "\n?- halt.\n",
    "a\0b",
    "X",
    "_",
    "[]",
    "true",
    "%p",
    "~w",
    "\u202e\u2028",
)


def test_ids_are_never_read_as_anything_else(shared: PrologEngine) -> None:
    facts = ",".join(f"on({atom(one)},{atom(other)})" for one in HOSTILE_IDS for other in HOSTILE_IDS)
    assert shared.load(f"[{facts}]") == len(HOSTILE_IDS) ** 2
    expected = sorted((one, other) for one in HOSTILE_IDS for other in HOSTILE_IDS)
    assert shared.relations([("on", 2)])["on"] == expected
    for one in HOSTILE_IDS:
        answers = shared.ask(f"on({atom(one)}, X)")
        assert [row["X"] for row in answers.bindings] == list(HOSTILE_IDS)
    shared.load("[on(cup, table)]")


def test_a_nul_does_not_end_a_question(prolog: PrologEngine) -> None:
    with pytest.raises(QueryError):
        prolog.ask("on(X, Y)\0, halt")
    assert prolog.ask("X = 'a\\x0\\b', atom_length(X, Length)").bindings == ({"X": "a\0b", "Length": 3},)
