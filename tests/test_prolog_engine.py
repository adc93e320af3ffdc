"""The engine: questions and typed answers, facts as one unit, threads, and a child that comes back."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from fractions import Fraction
from pathlib import Path

import pytest

from deixis.errors import EngineError, QueryError, QueryTimeout, RuleError
from deixis.prolog import Atom, Compound, PrologEngine, Term, Variable

FACTS = """
:- module(facts, [on/2, heavy/1]).
:- dynamic on/2, heavy/1.
"""

RULES = """
:- module(stack, [over/2, free/1, wins/1, deeper/3, anything/1]).
:- use_module(facts).
:- table over/2, wins/1.

over(A, B) :- on(A, B).
over(A, B) :- on(A, C), over(C, B).
free(A) :- on(A, _), \\+ on(_, A).
wins(A) :- on(A, B), tnot(wins(B)).
deeper(_, T, s(T)).
anything(_).

:- multifile bridge:operation/3.
bridge:operation(report, [Id], _{id: Id, free: Free, none: null, heights: [1, 2.5], terms: [term(Id)]}) :-
    (   free(Id) -> Free = true ; Free = false ).
bridge:operation(silent, [], _) :- fail.
bridge:operation(print, [], printed) :- write("where does this go").
bridge:operation(ask, [Text], Count) :-
    questions:question(Text, Goal, _),
    aggregate_all(count, question:Goal, Count).
"""

PLAIN = """
lower(A, B) :- over(B, A).
"""

TOWER = "[on('a','b'),on('b','c'),on('c','table'),heavy('b')]"

Write = Callable[..., list[Path]]


@pytest.fixture(scope="module")
def rules(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    directory = tmp_path_factory.mktemp("rules")
    for name, text in (("facts.pl", FACTS), ("stack.pl", RULES), ("my rules.pl", PLAIN)):
        (directory / name).write_text(text)
    return [directory / "facts.pl", directory / "stack.pl", directory / "my rules.pl"]


@pytest.fixture(scope="module")
def shared(rules: list[Path]) -> Iterator[PrologEngine]:
    with PrologEngine(rules) as engine:
        yield engine


@pytest.fixture
def prolog(shared: PrologEngine) -> PrologEngine:
    shared.load(TOWER)
    return shared


@pytest.fixture
def write(tmp_path: Path) -> Write:
    """Return a function that writes rule files and returns their paths."""

    def files(**texts: str) -> list[Path]:
        for name, text in texts.items():
            (tmp_path / f"{name}.pl").write_text(text, encoding="utf-8")
        return [tmp_path / f"{name}.pl" for name in texts]

    return files


def values(engine: PrologEngine, goal: str) -> list[Term]:
    """Return what X may be."""
    return [row["X"] for row in engine.ask(goal).bindings]


# --------------------------------------------------------------------------------------------- questions


@pytest.mark.parametrize(
    "goal", ["on(X, Y)", "on(X, Y).", "?- on(X, Y).", "  on(X,\n Y) .  ", "on(X, Y) % why"]
)
def test_bindings_in_the_order_of_the_proofs(prolog: PrologEngine, goal: str) -> None:
    answers = prolog.ask(goal)
    assert answers.bindings == ({"X": "a", "Y": "b"}, {"X": "b", "Y": "c"}, {"X": "c", "Y": "table"})
    assert not answers.truncated


def test_a_question_without_variables_is_yes_or_no(prolog: PrologEngine) -> None:
    assert prolog.ask("over(a, table)").bindings == ({},)
    assert prolog.ask("over(a, _Anything)").bindings == ({},)
    assert not prolog.ask("over(table, a)")


def test_rules_of_files_with_and_without_a_header(prolog: PrologEngine) -> None:
    assert set(values(prolog, "lower(X, b)")) == {"c", "table"}
    assert values(prolog, "free(X)") == ["a"]
    assert values(prolog, "over(X, table), heavy(X)") == ["b"]


def test_answers_are_distinct_and_limited(prolog: PrologEngine) -> None:
    assert values(prolog, "member(X, [1, 2, 1, 2.0])") == [1, 2, 2.0]
    for limit, truncated in ((1, True), (2, True), (3, False), (4, False)):
        answers = prolog.ask("on(X, _)", limit=limit)
        assert (len(answers.bindings), answers.truncated) == (min(limit, 3), truncated)
    assert prolog.ask("between(1, inf, X)", limit=2).bindings == ({"X": 1}, {"X": 2})
    with pytest.raises(QueryError, match="the limit is 0"):
        prolog.ask("on(X, _)", limit=0)


def test_answers_are_typed(prolog: PrologEngine) -> None:
    goal = (
        "X = f(cup, 'Cup', \"cup\", [], '[]', [1, g(_, Y, Y)|Z], "
        "-3, 36893488147419103232, 0.5, 1r3, 'a b'(), {c})"
    )
    (row,) = prolog.ask(goal).bindings
    assert row["X"] == Compound(
        "f",
        (
            Atom("cup"),
            Atom("Cup"),
            "cup",
            [],
            Atom("[]"),
            Compound(
                "[|]",
                (
                    1,
                    Compound(
                        "[|]", (Compound("g", (Variable("_1"), Variable("Y"), Variable("Y"))), Variable("Z"))
                    ),
                ),
            ),
            -3,
            2**65,
            0.5,
            Fraction(1, 3),
            Compound("a b", ()),
            Compound("{}", (Atom("c"),)),
        ),
    )
    assert isinstance(row["X"], Compound)
    assert [type(arg) for arg in row["X"].args[:5]] == [Atom, Atom, str, list, Atom]
    assert (row["Y"], row["Z"]) == (Variable("Y"), Variable("Z"))
    (row,) = prolog.ask("X = Y, Z = 7 ** 8000").bindings
    assert row == {"X": Variable("X"), "Y": Variable("X"), "Z": Compound("**", (7, 8000))}
    (row,) = prolog.ask("X is 7 ** 8000, Y is -(7 ** 8000)").bindings
    assert row == {"X": 7**8000, "Y": -(7**8000)}


def test_what_a_question_prints_is_kept_apart(prolog: PrologEngine) -> None:
    answers = prolog.ask('on(X, table), write("{\\"ok\\": 1}"), nl, format("~w at ~2f m~n", [X, 0.5])')
    assert answers.bindings == ({"X": "c"},)
    assert answers.output == '{"ok": 1}\nc at 0.50 m\n'


@pytest.mark.parametrize(
    ("goal", "words"),
    [
        ("", "the question is empty"),
        (" . \n", "the question is empty"),
        ("on(X, Y), foo(X", "at character"),
        ("on(X table)", "operator expected at character 6\n  on(X table)\n       ^"),
        ("on(a, b),\non(X table)", "at character 16\n  on(X table)\n       ^"),
        ("'on(X", "end of file in quoted"),
        ("on(X, Y). on(Y, X).", "more than one question"),
        ("on(X, Y, Z)", "no rule or fact is called on/3: did you mean on/2"),
        ("heavi(X)", "no rule or fact is called heavi/1: did you mean heavy/1?"),
        ("\\+ quite_unlike(X)", "no rule or fact is called quite_unlike/1"),
        ("X", "a variable is called"),
        ("on(a, b), call(X)", "a variable is called"),
        ("3", "3 is no goal"),
        ("X > 1", "not sufficiently instantiated"),
        ("X is cup + 1", "cup"),
        ("X = f(X)", "cyclic"),
        ("dif(X, a)", "constrained, not known"),
        ("length(X, 300), foldl(deeper, X, z, Y)", "nested more than 200 deep"),
        ("atom_codes(X, [0'a, 0xd800])", "no Unicode character"),
        ("on(X, Y), a" + "a" * 70_000, "longer than 65536"),
        ("on(X, '\ud800')", "surrogate"),
    ],
)
def test_a_wrong_question_says_what_is_wrong(prolog: PrologEngine, goal: str, words: str) -> None:
    before = pid(prolog)
    with pytest.raises(QueryError) as caught:
        prolog.ask(goal)
    assert words in str(caught.value)
    assert values(prolog, "free(X)") == ["a"]
    assert pid(prolog) == before


def test_an_answer_that_depends_on_its_own_negation(prolog: PrologEngine) -> None:
    assert set(values(prolog, "wins(X)")) == {"a", "c"}
    prolog.load("[on(a, a)]")
    with pytest.raises(QueryError, match="neither true nor false"):
        prolog.ask("wins(X)")
    with pytest.raises(QueryError, match="neither true nor false"):
        prolog.relations([("wins", 1)])


def test_steps_can_be_limited(prolog: PrologEngine) -> None:
    before = pid(prolog)
    with pytest.raises(QueryTimeout, match="more than 10,000 steps"):
        prolog.ask("between(1, inf, X), X < 0", inferences=10_000, timeout=None)
    assert prolog.ask("on(X, _)", inferences=10_000, limit=1).truncated
    assert pid(prolog) != before  # the limit may have struck while a library was loading


# ---------------------------------------------------------------------------------- relations, operations


def test_relations_are_sorted_distinct_and_typed(prolog: PrologEngine) -> None:
    prolog.load("[on(b, 1), on(a, \"text\"), on(b, 1), on(a, 0.5), on('B', f(x)), heavy(b)]")
    found = prolog.relations([("heavy", 1), ("on", 2), ("over", 2)])
    assert list(found) == ["heavy", "on", "over"]
    assert found["heavy"] == [("b",)]
    assert found["on"] == [("B", Compound("f", (Atom("x"),))), ("a", 0.5), ("a", "text"), ("b", 1)]
    assert set(map(repr, found["over"])) == set(map(repr, found["on"]))
    assert isinstance(found["on"][0][0], Atom)
    prolog.load("[]")
    assert prolog.relations([("on", 2), ("free", 1)]) == {"on": [], "free": []}
    assert prolog.relations([]) == {}


def test_relations_refuse_what_they_cannot_give(prolog: PrologEngine) -> None:
    with pytest.raises(QueryError, match="no rule or fact is called onn/2: did you mean on/2"):
        prolog.relations([("onn", 2)])
    with pytest.raises(QueryError, match="halt/1 is not allowed"):
        prolog.relations([("halt", 1)])
    with pytest.raises(QueryError, match="once"):
        prolog.relations([("on", 2), ("on", 2)])
    with pytest.raises(RuleError, match="leaves a variable unbound"):
        prolog.relations([("anything", 1)])


def test_operations_of_rule_files(prolog: PrologEngine) -> None:
    told = prolog.call("report", Atom("a"))
    assert told == {"id": "a", "free": True, "none": None, "heights": [1, 2.5], "terms": [["a", "a"]]}
    assert prolog.call("report", "null") | {"terms": None} == {
        "id": "null", "free": False, "none": None, "heights": [1, 2.5], "terms": None,
    }  # fmt: skip
    assert prolog.call("silent") is None
    assert prolog.call("print") == "printed"
    assert prolog.call("ask", "over(X, table).") == 3
    with pytest.raises(EngineError, match="no rule file defines the operation nothing"):
        prolog.call("nothing")
    with pytest.raises(QueryError, match="halt/0 is not allowed"):
        prolog.call("ask", "halt")


# ------------------------------------------------------------------------------------------- rules, facts


def test_facts_are_replaced_as_a_whole(prolog: PrologEngine) -> None:
    assert prolog.load("[on(x, y), heavy(x)]") == 2
    assert values(prolog, "over(X, _)") == ["x"]
    for wrong in (
        "[on(q, r), on(",
        "[on(q, r)|_]",
        "[on(q, r), on(q, _)]",
        "[on(q, r), over(q, r)]",
        "[on(q, r), on(q, r, s)]",
        "[on(q, r), 7]",
        "[on(q, r)]), halt, ([",
        "[on(q, r)]). halt. ([",
        "on(q, r)",
    ):
        with pytest.raises(EngineError):
            prolog.load(wrong)
        assert values(prolog, "over(X, _)") == ["x"]


def test_rule_files_must_load_without_complaint(write: Write) -> None:
    cases = {
        "p(X) :- q(Y).": "Singleton variables",
        "p(X :- q(X).": "bad.pl:1:",
        ":- use_module(nowhere).": "nowhere",
        ":- fail.": "failed",
        "p(a). q(a). p(b).": "not together",
        "append(a, b, c). :- initialization(throw(oops)).": "oops",
        "atom_length(a, b).": "No permission",
    }
    for text, words in cases.items():
        with PrologEngine(write(bad=f"{text}\n")) as engine:
            for _ in range(2):  # it does not get better by asking again
                with pytest.raises(RuleError, match=words) as caught:
                    engine.ask("true")
                assert "bad.pl" in str(caught.value)
    with pytest.raises(RuleError, match=r"there is no rule file .*missing\.pl"):
        PrologEngine([Path("missing.pl")])


def test_rules_that_call_what_is_not_defined(write: Write) -> None:
    with PrologEngine(write(gap="p(X) :- q(X).\n")) as engine:
        with pytest.raises(RuleError, match="q/1 is not defined"):
            engine.ask("p(X)")
        with pytest.raises(RuleError, match="q/1 is not defined"):
            engine.relations([("p", 1)])


def test_rule_files_are_utf8_and_may_print(write: Write) -> None:
    text = ":- write(hello), write(user_error, oops), read(X), writeln(X).\np('Stühle', \"机\").\n"
    with PrologEngine(write(chairs=text)) as engine:
        assert engine.ask("p(X, Y)").bindings == ({"X": Atom("Stühle"), "Y": "机"},)


# -------------------------------------------------------------------------------- threads and lost children


def pid(engine: PrologEngine) -> int:
    """Return the process id of the child."""
    child = engine._child
    assert child is not None
    return child.pid


def gone(process: int) -> bool:
    """Return whether a process ends within two seconds."""
    for _ in range(200):
        try:
            if Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] == "Z":
                return True
            os.kill(process, 0)
        except (FileNotFoundError, ProcessLookupError):
            return True
        time.sleep(0.01)
    return False


def test_many_threads_get_their_own_answers(prolog: PrologEngine) -> None:
    def question(n: int) -> list[Term]:
        return values(prolog, f"numlist({n}, {n + 2}, L), member(X, L)")

    with ThreadPoolExecutor(8) as pool:
        assert list(pool.map(question, range(200))) == [[n, n + 1, n + 2] for n in range(200)]


def test_a_timeout_ends_the_child_and_the_next_question_has_another(prolog: PrologEngine) -> None:
    before = pid(prolog)
    start = time.monotonic()
    with pytest.raises(QueryTimeout, match=r"no answer within 0\.3 s"):
        prolog.ask("between(1, inf, X), X < 0", timeout=0.3)
    assert time.monotonic() - start < 1.0
    assert gone(before)
    assert values(prolog, "free(X)") == ["a"]
    assert pid(prolog) != before


def test_a_killed_child_is_replaced(prolog: PrologEngine) -> None:
    before = pid(prolog)
    os.kill(before, signal.SIGKILL)
    child = prolog._child
    while child is not None and child.usable:
        time.sleep(0.01)
    assert values(prolog, "free(X)") == ["a"]
    assert pid(prolog) != before


def test_a_child_lost_in_the_midst_of_a_question(prolog: PrologEngine) -> None:
    threading.Timer(0.2, os.kill, (pid(prolog), signal.SIGKILL)).start()
    with pytest.raises(EngineError, match="SIGKILL"):
        prolog.ask("between(1, inf, X), X < 0", timeout=10.0)
    assert values(prolog, "free(X)") == ["a"]


def test_an_interrupted_question_leaves_no_answer_behind(prolog: PrologEngine) -> None:
    def interrupt(*_: object) -> None:
        raise KeyboardInterrupt

    before = signal.signal(signal.SIGALRM, interrupt)
    try:
        signal.setitimer(signal.ITIMER_REAL, 0.2)
        with pytest.raises(KeyboardInterrupt):
            prolog.ask("between(1, 100000000, X), X < 0", timeout=10.0)
    finally:
        signal.signal(signal.SIGALRM, before)
    assert values(prolog, "free(X)") == ["a"]


def test_closing_ends_even_a_running_question(rules: list[Path]) -> None:
    engine = PrologEngine(rules)
    child = pid(engine)
    with ThreadPoolExecutor(1) as pool:
        running = pool.submit(engine.ask, "between(1, inf, X), X < 0", timeout=None)
        time.sleep(0.4)
        engine.close()
        with pytest.raises(EngineError, match="closed"):
            running.result(timeout=5)
    assert gone(child)
    engine.close()
    with pytest.raises(EngineError, match="closed"):
        engine.ask("true")


def test_a_forgotten_engine_leaves_no_process(rules: list[Path]) -> None:
    engine = PrologEngine(rules)
    child = pid(engine)
    del engine
    assert gone(child)


SCRIPT = """
import os, sys
from pathlib import Path
from deixis.prolog import PrologEngine
engine = PrologEngine([])
engine.ask("true")
print(engine._child.pid, flush=True)
"""


def run(code: str) -> subprocess.Popen[str]:
    """Start a Python that has an engine and prints its child's process id."""
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)}
    return subprocess.Popen(
        [sys.executable, "-c", SCRIPT + code], env=environment, stdout=subprocess.PIPE, text=True
    )


@pytest.mark.parametrize(
    ("code", "end"),
    [
        ("", None),
        ("raise SystemExit(3)", None),
        ("engine.ask('between(1, inf, X), X < 0', timeout=None)", signal.SIGKILL),
        ("engine.ask('between(1, inf, X), X < 0', timeout=None)", signal.SIGTERM),
    ],
)
def test_the_child_ends_with_its_parent_however_that_ends(code: str, end: int | None) -> None:
    with run(code) as parent:
        assert parent.stdout is not None
        child = int(parent.stdout.readline())
        if end is not None:
            time.sleep(0.1)
            parent.send_signal(end)
        parent.wait(timeout=10)
    assert gone(child)


def test_a_fork_does_not_share_the_child() -> None:
    code = """
before = engine._child.pid
fork = os.fork()
if not fork:
    engine.ask("true")
    os._exit(0 if engine._child.pid != before else 1)
print(os.waitstatus_to_exitcode(os.waitpid(fork, 0)[1]))
print(bool(engine.ask("true")), engine._child.pid == before)
"""
    with run(code) as parent:
        out, _ = parent.communicate(timeout=20)
    assert out.splitlines()[1:] == ["0", "True True"]
