"""The catalogue of hostile input, sections B and E, as far as Prolog, the shell and rule files are concerned.

Beside these: test_prolog_safety.py (85 to 90), test_prolog_text.py (37 to 46), test_shell.py (94).
"""

from __future__ import annotations

import random
import threading
from pathlib import Path

import pytest

from commands import call, run
from deixis import KnowledgeBase, Scene
from deixis.errors import QueryError, QueryTimeout, SceneError
from deixis.prolog import PrologEngine
from deixis.prolog.quote import id_atom

BOX = {"center": [0.0, 0.0, 0.5], "size": [1.0, 1.0, 1.0]}


def scene(*names: str, **rest: object) -> Scene:
    objects = [{"id": name, "label": name, "box": BOX} for name in names]
    return Scene.from_dict({"deixis": 1, "id": "s", "objects": objects, **rest})


@pytest.mark.parametrize(
    "name",
    [
        'x"))),shell("id"),assertz((obj("y', "'). halt. %", "a> <b> <c> .", "'; DROP TABLE semantic_map;--",
        "%p", "~w", "{0}", "\\", "wall", "floor", "_", "X", "[]", "-1", "true", "None", "\u0430",
    ],
)  # fmt: skip
@pytest.mark.parametrize("engine", ["duckdb", "prolog", "sparql"])
def test_case_37_to_44_an_id_is_a_name_in_every_engine(name: str, engine: str, tmp_path: Path) -> None:
    rules = tmp_path / "mine.pl"
    rules.write_text(
        "violation(seen, X, Y) :- touches(X, Y), X \\== Y.\nviolation(seen, X, Y) :- intersects(X, Y).\n"
    )
    with KnowledgeBase(scene(name, "other"), rules=[rules]) as kb:
        rows = {one.things for one in kb.check(engine=engine, reasons=False).violations}
    assert rows == {(name, "other"), ("other", name)}


@pytest.mark.parametrize(
    "name", ["", "x" * 1_000_000, "a\ud800", "a\nb", "a\tb", "a\0b", "a\u202eb", "\x1b[31m"]
)
def test_case_41_to_44_what_is_no_name_is_refused(name: str) -> None:
    with pytest.raises(SceneError):
        scene(name)


def test_case_45_twenty_thousand_ids_make_the_round_trip() -> None:
    """Ids that are written without quotes, and those that look almost like them."""
    chance = random.Random(45)  # noqa: S311 - the same each time
    words = [
        "is",
        "mod",
        "rem",
        "xor",
        "rdiv",
        "div",
        "table",
        "dynamic",
        "e",
        "inf",
        "nan",
        "x",
        "o",
        "end_of_file",
        "a_b",
    ]
    tails = ["", "0", "1", "12", "007", "_1", "1_", "e5", ".0", "\u0661", "\u00b2", "'", "A"]
    names = sorted({chance.choice(words) + chance.choice(tails) + str(k) * (k % 3) for k in range(20_000)})
    with PrologEngine([Path(__file__).parent.parent / "rules" / "facts.pl"]) as engine:
        assert engine.load(f"[{','.join(f'spatial_obj({id_atom(name)})' for name in names)}]") == len(names)
        found = engine.relations([("spatial_obj", 1)])["spatial_obj"]
    assert sorted(name for (name,) in found) == names


@pytest.mark.parametrize("value", ["NaN", "Infinity", "None", "null", "_", "X"])
def test_case_46_a_number_is_never_a_variable(value: str, tmp_path: Path) -> None:
    path = tmp_path / "scene.json"
    box = f'{{"center": [0, 0, {value}], "size": [1, 1, 1]}}'
    path.write_text(f'{{"deixis": 1, "id": "s", "objects": [{{"id": "a", "box": {box}}}]}}')
    told = call("check", path)
    assert (told.code, told.out) == (2, "")


def test_case_86_refused_changes_change_nothing() -> None:
    with KnowledgeBase(scene("a", "b")) as kb:
        before = kb.relations(engine="prolog")
        for goal in (
            "assertz(facts:surface(a))",
            "retractall(facts:pair(_,_,_,_,_,_,_,_,_))",
            "abolish_all_tables",
        ):
            for wrapped in (
                goal,
                f"once({goal})",
                f"forall(true, {goal})",
                f"\\+ {goal}",
                f"catch({goal}, _, true)",
            ):
                with pytest.raises(QueryError):
                    kb.ask(wrapped)
        assert kb.relations(engine="prolog") == before


def test_case_88_a_recursive_rule_ends_and_an_endless_question_is_stopped(tmp_path: Path) -> None:
    rules = tmp_path / "mine.pl"
    rules.write_text(
        "linked(X, Y) :- linked(Y, X).\n"
        "linked(X, Y) :- linked(X, Z), linked(Z, Y).\n"
        "linked(X, Y) :- intersects(X, Y).\n"
    )
    with KnowledgeBase(scene("a", "b", "c"), rules=[rules]) as kb:
        assert len(kb.ask("linked(X, Y)").bindings) == 9
        with pytest.raises(QueryTimeout):
            kb.ask("between(1, inf, X), X < 0", timeout=0.3)
        assert kb.why("linked(a, c)").proof is not None


def test_case_91_endless_answers_are_cut_and_say_so() -> None:
    with KnowledgeBase(scene("a")) as kb:
        found = kb.ask("between(1, inf, X)", limit=3)
    assert ([row["X"] for row in found.bindings], found.truncated) == ([1, 2, 3], True)


def test_case_92_sessions_do_not_hear_each_other() -> None:
    """Eight at once, five rounds each: whoever asks hears of his own scene only."""
    heard: dict[str, set[str]] = {}

    def session(name: str) -> None:
        with KnowledgeBase(scene(f"thing_{name}")) as kb:
            rounds = [kb.ask("spatial_obj(X)").bindings for _ in range(5)]
        heard[name] = {str(row["X"]) for found in rounds for row in found}

    threads = [threading.Thread(target=session, args=(str(k),)) for k in range(8)]
    for one in threads:
        one.start()
    for one in threads:
        one.join(60)
    assert heard == {str(k): {f"thing_{k}"} for k in range(8)}


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (":- initialization(shell('touch SPRUNG')).", "mine.pl:1:4: the directive 'initialization'"),
        (":- shell('touch SPRUNG').", "mine.pl:1:4: the directive 'shell'"),
        ("violation(r, X) :- surface(X), shell('touch SPRUNG').", "1:32: 'shell' is not in the subset"),
        ("violation(r, X) :- surface(X), \\+ shell('touch SPRUNG').", "1:35: 'shell' is not in the subset"),
        ("user:portray(_) :- halt.", "mine.pl:1:"),
        ("term_expansion(_, X) :- surface(X).", "mine.pl:1:"),
        ("violation(r, X) :- surface(X), \\+ violation(r, X).", "rests on its own denial"),
        ("violation(r, X) :- \\+ surface(X), spatial_obj(X).", "1:31: X is denied before it is bound"),
        ("violation(r, X) :- surfaces(X).", "did you mean surface/1?"),
        ("violation(r, X) :- surface(X", "mine.pl:1:1: the clause has no end"),
        ("violation(r, '" + "x" * 100_000, "mine.pl:1:"),
        ("violation(r, X) :- " + "(" * 100_000, "mine.pl:1:"),
        ("view(X) :- viewpoint(X).", "view/1 belongs to the theory, in shell.pl"),
        ("on_top_of(X, Y) :- surface(X), surface(Y).", "on_top_of/2 belongs to the theory"),
        ("\0", "mine.pl:1:1"),
    ],
    ids=lambda value: value[:30],
)  # fmt: skip
def test_case_93_a_hostile_rule_file_is_an_error_with_its_place(
    text: str, words: str, tmp_path: Path
) -> None:
    rules = tmp_path / "mine.pl"
    rules.write_text(text + "\n", encoding="utf-8")
    path = tmp_path / "scene.json"
    scene("a").save(path)
    for command in (["check"], ["relations"], ["ask", "spatial_obj(X)"], ["shell"]):
        told = call(command[0], path, *command[1:], "--rules", rules)
        assert (told.code, told.out) == (2, ""), command
        assert words in told.err
    assert not (tmp_path / "SPRUNG").exists()
    assert not Path("SPRUNG").exists()


def test_a_rule_file_that_is_no_text_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "scene.json"
    scene("a").save(path)
    for content in (b"\xff\xfe\x00", b"p(\xc3\x28) :- q."):
        (tmp_path / "mine.pl").write_bytes(content)
        assert "is no UTF-8 text" in call("check", path, "--rules", tmp_path / "mine.pl").err
    assert "there is no rule file" in run("check", path, "--rules", tmp_path / "none.pl").err
