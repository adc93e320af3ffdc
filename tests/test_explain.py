"""Reasons: a proof is of what was asked, and rests on measured facts and on the rules as they stand."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from deixis import KnowledgeBase, Scene
from deixis.explain import Answer, Proof
from deixis.facts import Facts
from deixis.vocabulary import BASE, BY_NAME, RELATIONS
from scenes import box, floor, scene, wall

AXES = ("X+", "X-", "Y+", "Y-")


@pytest.fixture(scope="module")
def kb(figure_3: Scene) -> Iterator[KnowledgeBase]:
    """Return Figure 3 with a jar in a cabinet, a lamp under a ceiling, a crate amid balls: every relation."""
    data = figure_3.to_dict()
    data["objects"] += [
        box("cabinet", (-2.0, 0.2, 0.5), (0.6, 0.5, 1.0)),
        box("jar", (-1.95, 0.2, 0.4), (0.1, 0.1, 0.2)),
        {**floor("ceiling", half=3.0, z=2.6), "label": "ceiling"},
        box("lamp", (0.3, 1.5, 2.4), (0.3, 0.3, 0.4)),
        box("crate", (0.2, -0.4, 0.2), (0.4, 0.4, 0.4)),
        *(
            box(f"ball{x}{y}", (0.2 + 0.3 * x, -0.4 + 0.3 * y, 0.05), (0.1, 0.1, 0.1))
            for x, y in ((1, 0), (-1, 0), (0, 1), (0, -1))
        ),
    ]
    with KnowledgeBase(Scene.from_dict(data)) as running:
        yield running


@pytest.fixture(scope="module")
def proofs(kb: KnowledgeBase) -> Mapping[tuple[str, ...], Proof]:
    """Return the proof of every relation that holds, spoken and base."""
    found = {}
    for one in kb.relations(relation=[term.name for term in (*RELATIONS, *BASE)]):
        answer = kb.why(one.to_prolog())
        assert answer.proof is not None
        found[(one.relation, *answer.proof.args)] = answer.proof
    return found


def steps(proof: Proof) -> Iterator[Proof]:
    yield proof
    for child in proof.children:
        yield from steps(child)


def holding(proof: Proof) -> Iterator[Proof]:
    """Yield the steps that hold: below a negation stands what does not."""
    yield proof
    if proof.kind != "negation":
        for child in proof.children:
            yield from holding(child)


# What a proof says


def test_what_is_proved_is_what_was_asked(kb: KnowledgeBase, proofs: Mapping[tuple[str, ...], Proof]) -> None:
    everything = kb.relations(relation=[term.name for term in (*RELATIONS, *BASE)])
    assert len(proofs) == len(everything)
    assert {name for name, *_ in proofs} == {term.name for term in (*RELATIONS, *BASE)}
    for (name, *args), proof in proofs.items():
        assert (proof.kind, proof.predicate, proof.shown) == ("rule", name, True)
        assert len(args) == BY_NAME[name].arity


def test_a_margin_is_that_of_the_weakest_step(proofs: Mapping[tuple[str, ...], Proof]) -> None:
    for proof in proofs.values():
        for step in holding(proof):
            below = [child.margin for child in step.children if child.margin is not None]
            if step.kind in ("rule", "conjunction"):
                assert step.margin == min(below, default=None)
            elif step.kind == "negation":
                assert step.margin == (-below[0] if below else None)
            elif step.kind == "fact":
                assert (step.margin, step.children) == (None, ())
            assert step.margin is None or step.margin >= 0.0


def test_a_relation_has_the_margin_of_its_best_proof(
    kb: KnowledgeBase, proofs: Mapping[tuple[str, ...], Proof]
) -> None:
    for one in kb.relations(relation=[term.name for term in (*RELATIONS, *BASE)]):
        proof = proofs[(one.relation, one.figure, one.reference, *([one.view] if one.view else []))]
        assert one.margin is not None
        assert one.margin == proof.margin


def test_a_comparison_has_the_difference_of_its_numbers(proofs: Mapping[tuple[str, ...], Proof]) -> None:
    compared = {step for proof in proofs.values() for step in steps(proof) if step.kind == "comparison"}
    assert {step.predicate for step in compared} >= {"=<", ">=", "<", "\\=="}
    for step in compared:
        first, second = step.args
        if step.predicate == "\\==":
            assert (step.margin, first == second) == (None, False)
        elif step.margin is not None:
            assert isinstance(first, float)
            assert isinstance(second, float | int)
            spare = second - first if step.predicate in ("=<", "<") else first - second
            assert step.margin == round(spare, 9)


def test_every_leaf_is_a_measured_fact(kb: KnowledgeBase, proofs: Mapping[tuple[str, ...], Proof]) -> None:
    leaves = {step for proof in proofs.values() for step in steps(proof) if step.kind == "fact"}
    kinds = {step.predicate for step in leaves}
    assert kinds == {"pair", "aspect", "strict", "threshold", "viewpoint", "figure_reference"}
    for leaf in leaves:
        assert_measured(kb, leaf)


def assert_measured(kb: KnowledgeBase, leaf: Proof) -> None:
    """Check a leaf's numbers against the facts they were measured as."""
    facts: Facts = kb.facts
    match leaf.predicate, leaf.args:
        case "pair", (str(figure), str(reference), *numbers):
            row = facts.rows()[facts.row(figure, reference)]
            names = ("distance", "separation", "protrusion", "intersection", "frontier", "above", "below")
            assert numbers == [row[name] for name in names]
        case "aspect", (str(view), str(figure), str(reference), *numbers):
            assert numbers == margins(facts, view, figure, reference, "int_hs")
        case "strict", (str(figure), str(reference), str(axis), str(view), float(number)):
            if axis in AXES:
                assert number == margins(facts, view, figure, reference, "cont_hs")[AXES.index(axis)]
            else:
                assert number == facts.vertical_strict[facts.row(figure, reference), ("Z+", "Z-").index(axis)]
        case "threshold", (str(name), float(number)):
            assert number == dict(facts.thresholds.items())[name]
        case "viewpoint", (str(view),):
            assert view in {one.id for one in kb.scene.views}
        case "figure_reference", (str(figure), str(reference)):
            assert facts.ordered[facts.row(figure, reference)]
        case other:
            pytest.fail(f"{other} is no base fact")


def margins(facts: Facts, view: str, figure: str, reference: str, column: str) -> list[float]:
    (seen,) = (one for one in facts.views if one.view == view)
    (at,) = np.flatnonzero(seen.rows == facts.row(figure, reference))
    return [float(margin) for margin in getattr(seen, column)[at]]


def test_every_rule_points_at_its_clause(root: Path, proofs: Mapping[tuple[str, ...], Proof]) -> None:
    lines = {
        path.name: path.read_text(encoding="utf-8").splitlines() for path in (root / "rules").glob("*.pl")
    }
    used = {step for proof in proofs.values() for step in steps(proof) if step.kind == "rule"}
    for step in used:
        assert step.rule is not None
        assert lines[step.rule.file][step.rule.line - 1].startswith(f"{step.predicate}(")
        term = BY_NAME.get(step.predicate)
        assert step.axiom == (term.axiom if term else None)
    for proof in proofs.values():
        assert all(step.rule is None for step in steps(proof) if step.kind != "rule")


def test_each_step_follows_by_itself(kb: KnowledgeBase, proofs: Mapping[tuple[str, ...], Proof]) -> None:
    """Replay: every conclusion in a proof is an answer of the rules when it is asked alone."""
    from deixis.prolog.quote import atom

    asked = set()
    for proof in proofs.values():
        for step in holding(proof):
            if step.kind in ("rule", "fact") and None not in step.args:
                args = ",".join(atom(one) if isinstance(one, str) else repr(one) for one in step.args)
                asked.add(f"{step.predicate}({args})")
    assert len(asked) > 100
    assert kb.ask(", ".join(sorted(asked)))


# What is said


def test_a_negation_names_its_witness(kb: KnowledgeBase) -> None:
    proof = kb.why("affixed_on(extinguisher1, wall)").proof
    assert proof is not None
    only = next(step for step in proof.children if step.kind == "negation" and step.predicate == "touches")
    assert only.text == (
        "nothing other than the wall touches the fire extinguisher on the wall "
        "(the closest is the fire extinguisher sign, short by 27 cm)"
    )
    (witness,) = only.children
    assert witness.margin == pytest.approx(-0.27)
    gap = kb.facts.rows()[kb.facts.row("sign", "extinguisher1")]["separation"]
    assert gap == pytest.approx(0.27 + kb.scene.thresholds.granularity)


def test_sentences_say_whose_view_it_is(proofs: Mapping[tuple[str, ...], Proof]) -> None:
    for (name, *args), proof in proofs.items():
        if BY_NAME[name].view:
            words = {"v0": "as seen from the robot", "v1": "from where you stand"}
            assert proof.text.endswith(words[args[2]])


def test_what_a_person_is_shown_is_english(proofs: Mapping[tuple[str, ...], Proof]) -> None:
    for proof in proofs.values():
        assert not {"_", "\\"} & set(proof.outline())
        assert not re.search(r"\w\(", proof.outline())


def test_the_outline_shows_the_shown(kb: KnowledgeBase) -> None:
    proof = kb.why("leans_on(extinguisher2, wall)").proof
    assert proof is not None
    lines = proof.outline().splitlines()
    assert lines[0] == f"{proof.text}  [axiom 37]"
    texts = {step.text for step in holding(proof) if step.shown}
    assert {line.strip().split("  [axiom")[0] for line in lines} == texts
    assert proof.sentence().startswith("The fire extinguisher on the floor leans on the wall, because ")
    assert "the reference" not in proof.sentence()


def test_an_answer_travels_as_json(kb: KnowledgeBase) -> None:
    for goal in ("affixed_on(sign, wall)", "left_of(extinguisher2, radiator, v1)", "near(sign, heater)"):
        answer = kb.why(goal)
        told: dict[str, Any] = json.loads(json.dumps(answer.to_dict(), allow_nan=False))
        assert told["holds"] == bool(answer)
        assert Answer.from_dict(told) == answer


# What holds, what does not, what is not known


def test_a_goal_with_variables_is_proved_for_one_thing(kb: KnowledgeBase) -> None:
    answer = kb.why("on_top_of(Something, heater)")
    assert answer
    assert answer.proof is not None
    assert answer.proof.args == ("sweater", "heater")
    assert answer.text == "the sweater is on top of the electric heater"


def test_what_does_not_hold_comes_with_how_much_is_missing(kb: KnowledgeBase) -> None:
    answer = kb.why("left_of(extinguisher2, radiator, v1)")
    assert not answer
    assert answer.proof is None
    assert answer.nearest is not None
    missing = answer.nearest.margin
    assert missing == margins(kb.facts, "v1", "extinguisher2", "radiator", "int_hs")[2] < 0.0
    assert f"(short by {-100 * missing:.0f} cm)" in answer.text


def test_what_is_missing_is_what_must_change() -> None:
    """Lowered by a little less than it is short by, the cup is not on the table; by a little more, it is."""

    def hanging(height: float) -> KnowledgeBase:
        cup = box("cup", (0.2, 0.1, 0.77 + height), (0.08, 0.08, 0.1))
        return KnowledgeBase(scene(floor(), box("table", (0, 0, 0.36), (1.2, 0.8, 0.72)), cup))

    with hanging(0.3) as kb:
        nearest = kb.why("on_top_of(cup, table)").nearest
    assert nearest is not None
    assert nearest.margin == pytest.approx(-0.28)
    for nudge, holds in ((-0.001, False), (0.001, True)):
        with hanging(0.3 + nearest.margin - nudge) as kb:
            assert bool(kb.why("on_top_of(cup, table)")) == holds


def test_what_is_out_of_reach_has_no_nearest(kb: KnowledgeBase) -> None:
    answer = kb.why("near(sign, heater)")
    assert (bool(answer), answer.nearest) == (False, None)
    assert answer.text == (
        "the fire extinguisher sign is not near the electric heater; "
        "it and the electric heater are beyond the reach of any relation"
    )


def test_the_wrong_way_round_is_so_however_far_away(kb: KnowledgeBase) -> None:
    """The sweater is larger than the sign: by no move would it be near it, as people say it."""
    said = kb.why_not("near(sweater, sign)").sentence()
    assert said.endswith("the reference of the two, so people say where the fire extinguisher sign is.")
    assert "beyond the reach" in kb.why_not("near(sign, sweater)").sentence()
    assert "beyond the reach" not in kb.why("near(sweater, sign)").text


def test_the_wrong_way_round_does_not_hold(kb: KnowledgeBase) -> None:
    for goal in ("on_top_of(heater, sweater)", "leans_on(wall, extinguisher2)", "near(floor, heater)"):
        assert not kb.why(goal)


def test_the_best_of_several_reasons_counts() -> None:
    """The board leans on the wall thanks to the floor, 1.5 cm below it, and to the brick that it touches."""
    leaning = scene(
        floor(),
        wall(),
        box("board", (1.98, 0.5, 0.615), (0.04, 0.8, 1.2)),
        box("brick", (1.9, 0.5, 0.0), (0.2, 0.1, 0.03)),
    )
    with KnowledgeBase(leaning) as kb:
        (found,) = (one for one in kb.relations(relation=["leans_on"]) if one.figure == "board")
        proof = kb.why("leans_on(board, wall)").proof
    assert found.margin == pytest.approx(0.02)
    assert proof is not None
    assert "the board touches the brick" in {step.text for step in proof.children}
