"""Support and safety: the shipped rules in all engines, deixis check, violations of one's own."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

import pytest

from commands import call, run
from deixis import KnowledgeBase, Scene
from deixis.errors import QueryError, RuleError
from deixis.ruleset import SHIPPED, locate, shipped

ENGINES = ("duckdb", "prolog", "sparql")

BROKEN = [
    ("extinguisher_off_wall", ("extinguisher2",)),
    ("extinguisher_without_sign", ("extinguisher2",)),
    ("fire_hazard", ("sweater", "heater1")),
    ("fire_door_leant_on", ("broom", "door")),
    ("heater_in_free_area", ("heater2", "store")),
]


@pytest.fixture(scope="module")
def path(root: Path) -> Path:
    return root / "kb" / "scenes" / "inspection.json"


@pytest.fixture(scope="module")
def kb(path: Path) -> Iterator[KnowledgeBase]:
    with KnowledgeBase.from_scene(path) as opened:
        yield opened


@pytest.mark.parametrize("engine", ENGINES)
def test_each_rule_of_safety_is_broken_once(kb: KnowledgeBase, engine: str) -> None:
    found = kb.check(engine=engine)
    assert [(one.rule, one.things) for one in found.violations] == BROKEN
    assert [one.rule for one in found.checked] == [rule for rule, _ in BROKEN]
    assert not found.passed
    assert found.summary() == "5 rules checked on 13 things: 5 violations"
    # What is right is not among them: the extinguisher on the wall with its sign, the towel on the shelf.
    assert not {"extinguisher1", "towel"} & {name for one in found.violations for name in one.things}
    assert all(one.proof is not None and one.proof.predicate == "violation" for one in found.violations)


def test_reasons_name_the_witness(kb: KnowledgeBase) -> None:
    texts = {one.rule: one.proof.outline() for one in kb.check().violations}
    assert "(the closest is the wall, short by 2 cm)" in texts["extinguisher_off_wall"]
    assert "the sweater touches the electric heater" in texts["fire_hazard"]
    assert "cloth burns" in texts["fire_hazard"]


def test_a_sign_just_too_far_is_named(path: Path) -> None:
    given = json.loads(path.read_text(encoding="utf-8"))
    things = {one["id"]: one for one in given["objects"]}
    things["sign"]["box"]["center"] = [2.0, 2.98, 2.3]
    given["thresholds"] = {"closeness": 0.3}
    with KnowledgeBase(Scene.from_dict(given)) as moved:
        found = {
            one.things: one for one in moved.check().violations if one.rule == "extinguisher_without_sign"
        }
    assert set(found) == {("extinguisher1",), ("extinguisher2",)}


@pytest.mark.parametrize("engine", ENGINES)
def test_support_runs_through_others(path: Path, engine: str) -> None:
    with KnowledgeBase.from_scene(path, rules=["support"]) as kb:
        found = kb.relations(relation=["supported_by"], engine=engine)
        rows = {(one.figure, one.reference) for one in found}
        assert {("sweater", "heater1"), ("sweater", "floor"), ("towel", "shelf"), ("towel", "floor")} <= rows
        assert not any(figure == reference for figure, reference in rows)
        turned = kb.relations(relation=["supports"], engine=engine)
        assert {(one.reference, one.figure) for one in turned} == rows


def test_why_supported(path: Path) -> None:
    with KnowledgeBase.from_scene(path, rules=["support"]) as kb:
        answer = kb.why("supported_by(sweater, floor)")
    assert answer.proof is not None
    assert answer.proof.outline().startswith("the sweater is supported by the floor\n")


def test_from_one_view_only(root: Path, tmp_path: Path) -> None:
    rules = tmp_path / "mine.pl"
    rules.write_text("violation(blocked, X, Y) :- left_of(X, Y, _).\n", encoding="utf-8")
    with KnowledgeBase.from_scene(root / "kb" / "scenes" / "hans.json", rules=[rules]) as kb:
        every = {one.things for one in kb.check(reasons=False).violations}
        each = [{one.things for one in kb.check(view=v, reasons=False).violations} for v in ("v0", "v1")]
        assert each[0] != each[1]
        assert each[0] | each[1] == every
        with pytest.raises(QueryError, match="no view 'v9'"):
            kb.check(view="v9")


# Rule files


def test_several_files_may_state_violations(path: Path, tmp_path: Path) -> None:
    for number in (1, 2):
        text = f"% Rule {number}.\nviolation(rule{number}, X) :- on_top_of(X, floor), label(X, shelf, _).\n"
        (tmp_path / f"{number}.pl").write_text(text, encoding="utf-8")
    files = [tmp_path / "1.pl", tmp_path / "2.pl"]
    with KnowledgeBase.from_scene(path, rules=[*files, "safety"]) as kb:
        for engine in ENGINES:
            found = kb.check(engine=engine)
            assert [(one.rule, one.things) for one in found.violations] == [
                ("rule1", ("shelf",)),
                ("rule2", ("shelf",)),
                *BROKEN,
            ]
        assert found.checked[0].says == "Rule 1."
        assert found.violations[0].text == "the shelf breaks the rule rule1"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("p(X) :- surface(X).", "no rule file states a violation"),
        ("violation(R, X) :- label(X, R, _).", "mine.pl:1:11: a violation begins with the name of its rule"),
        (
            ":- module(mine, [violation/2]).\n:- use_module(facts).\nviolation(r, X) :- surface(X).",
            "defined in a module",
        ),
        ("violation(r, X) :- surfac(X).", "did you mean surface/1?"),
        ("violation(r, X) :- surface(Y).", "X is bound by no goal"),
    ],
)
def test_files_that_state_none_or_badly(path: Path, tmp_path: Path, text: str, words: str) -> None:
    rules = tmp_path / "mine.pl"
    rules.write_text(text + "\n", encoding="utf-8")
    with KnowledgeBase.from_scene(path, rules=[rules]) as kb, pytest.raises(RuleError) as error:
        kb.check()
    assert words in str(error.value)
    assert call("check", path, "--rules", rules).code == 2


def test_shipped_files_are_found_by_name() -> None:
    assert all(shipped(name).is_file() for name in SHIPPED)
    assert [one.stem for one in locate(["safety"], [])][-2:] == ["background", "safety"]
    with pytest.raises(RuleError, match=r"no rule file safty: did you mean 'safety'\?"):
        locate(["safty"], [])
    with pytest.raises(RuleError, match=r"no rule file .*none\.pl"):
        locate(["none.pl"], [])


def test_a_file_of_that_name_comes_first(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "safety").write_text("p(X) :- surface(X).\n", encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    assert locate(["safety"], []) == (Path("safety"),)


def test_imports_in_a_circle_end(tmp_path: Path) -> None:
    (tmp_path / "a.pl").write_text(":- use_module(b).\np(X) :- q(X).\n", encoding="utf-8")
    (tmp_path / "b.pl").write_text(":- use_module(a).\nq(X) :- surface(X).\n", encoding="utf-8")
    assert [one.name for one in locate([tmp_path / "a.pl"], [])] == ["b.pl", "a.pl"]


# The command


def test_check_exits_with_1_and_says_what_was_checked(path: Path) -> None:
    told = call("check", path)
    assert (told.code, told.err) == (1, "")
    assert told.out.endswith("\n\n5 rules checked on 13 things: 5 violations\n")
    assert (
        "fire_hazard: Nothing that burns may be on or against a heater.\n  the sweater is a fire" in told.out
    )
    assert call("check", path, "--rules", "safety") == told
    assert call("check", path, "--rules", shipped("safety")) == told


def test_check_in_json(path: Path) -> None:
    told = call("check", path, "--format", "json", "--engine", "prolog")
    said = json.loads(told.out)
    assert (told.code, [(one["rule"], tuple(one["things"])) for one in said["violations"]]) == (1, BROKEN)
    assert said["checked"]["things"] == 13
    assert said["checked"]["rules"][0]["file"] == "safety.pl"
    assert said["violations"][0]["proof"]["children"]


def test_check_of_what_is_right(root: Path) -> None:
    told = call("check", root / "kb" / "scenes" / "kitchen.json")
    assert (told.code, told.out) == (0, "5 rules checked on 77 things: no violation\n")


def test_check_needs_prolog_for_reasons_only(path: Path, tmp_path: Path) -> None:
    nowhere = {"PATH": str(tmp_path), "SWI_HOME_DIR": "", "LIBSWIPL_PATH": ""}
    told = run("check", path, "--brief", env=nowhere)
    assert (told.code, told.err) == (1, "")
    assert "\n  violation(fire_hazard, sweater, heater1)\n" in told.out
    assert run("check", path, env=nowhere).code == 2


def test_check_takes_hostile_names(path: Path) -> None:
    given = json.loads(path.read_text(encoding="utf-8"))
    names = {"sweater": "'). halt. %", "heater1": 'x"))),shell("id"),assertz((obj("y', "broom": "null"}
    for one in given["objects"]:
        one["id"] = names.get(one["id"], one["id"])
    with KnowledgeBase(Scene.from_dict(given)) as kb:
        found = [kb.check(engine=engine) for engine in ENGINES]
    assert [one.things for one in found[0].violations][2:4] == [
        (names["sweater"], names["heater1"]),
        ("null", "door"),
    ]
    assert found[0] == found[1] == found[2]
