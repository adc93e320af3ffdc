"""Every proof of the golden scenes checks, and says what is written down; no refusal names what holds.

The sentences are ``sentences/NAME.txt``, a line for each relation: the goal, a tab, its reasons in a
sentence. ``DEIXIS_BLESS=1 pytest tests/test_proofs.py`` writes the files anew: read the difference.
"""

from __future__ import annotations

import math
import os
from pathlib import Path

import pytest

from deixis import KnowledgeBase
from deixis.prolog.quote import atom
from deixis.ruleset.model import Atom, Negation, variables
from replay import Measured, Truth, aligned, head_bound, leaves, random_goals
from test_golden import NAMES, SCENES

HERE = Path(__file__).resolve().parent / "sentences"

KITCHEN = Path(__file__).resolve().parent.parent / "kb" / "scenes" / "kitchen.json"

WORLDS = {**SCENES, "kitchen": KITCHEN}


@pytest.mark.parametrize("name", SCENES)
def test_proofs_check_and_say_what_is_written_down(name: str) -> None:
    with KnowledgeBase.from_scene(SCENES[name]) as kb:
        holding = kb.relations(relation=NAMES)
        proofs = kb.proofs(relation=NAMES)
        assert len(proofs) == len(holding)
        truth, measured = Truth(kb), Measured(kb)
        for proof in proofs.values():
            truth.apply(proof)
            for leaf in leaves(proof):
                measured.leaf(leaf)
        told = [
            f"{goal}\t{proof.sentence()}\n" for goal, proof in sorted((_goal(key), one)
                                                                      for key, one in proofs.items())
        ]  # fmt: skip
        one = kb.why(told[0].split("\t")[0]).proof
        assert one is not None
        assert one.sentence() == told[0].split("\t")[1].strip()
    path = HERE / f"{name}.txt"
    if os.environ.get("DEIXIS_BLESS") == "1":
        path.parent.mkdir(exist_ok=True)
        path.write_text("".join(told), encoding="utf-8")
    assert "".join(told) == path.read_text(encoding="utf-8")


def _goal(key: tuple[str, ...]) -> str:
    name, *args = key
    return f"{name}({','.join(map(atom, args))})"


def refused(kb: KnowledgeBase, count: int, seed: int) -> int:
    """Ask why random relations do not hold; check each answer, and return how many did not."""
    truth, asked = Truth(kb), 0
    for name, args in random_goals(kb, count, seed):
        goal = _goal((name, *args))
        refusal = kb.why_not(goal)
        assert refusal.holds == truth.holds(name, args), goal
        if refusal.holds:
            continue
        asked += 1
        assert refusal.misses, goal
        margins = [miss.derivation.margin for miss in refusal.misses]
        assert margins == sorted(margins, key=lambda one: math.inf if one is None else -one), goal
        for miss in refusal.misses:
            step = miss.derivation
            bound = truth.bindings(step)
            rule, fails = truth.rule_of(step), 0
            outer = head_bound(rule, step.args)
            assert outer is not None
            sought = []
            if any(one.startswith("nothing that ") for one in miss.obstacles):
                # One obstacle for all the goals that ask for something: there is nothing of the kind.
                sought = [
                    one
                    for one in rule.body
                    if isinstance(one, Atom) and {it.name for it in variables(one)} - outer.keys()
                ]
                assert next(truth.solve(sought, outer), None) is None
                fails = 1
            for part, child in aligned(rule, step):
                holds = next(truth.step(part, bound), None) is not None
                fails += not holds and part not in sought
                if child.margin is not None and child.margin != 0.0:
                    assert holds == (child.margin > 0.0), f"{goal}: {child.text}"
                if isinstance(part, Negation) and not holds:
                    # Of a denial that fails, what refutes it is named, and holds.
                    assert any(True for _ in truth.solve(part.goals, bound))
            assert len(miss.obstacles) == fails > 0, f"{goal}: {miss.obstacles}"
    return asked


@pytest.mark.parametrize("name", WORLDS)
def test_a_refusal_names_only_what_fails(name: str) -> None:
    with KnowledgeBase.from_scene(WORLDS[name]) as kb:
        assert refused(kb, 60, seed=1) > 10


@pytest.mark.long
def test_ten_thousand_refusals() -> None:
    asked, seed = 0, 100
    share = {name: 3000 if name == "kitchen" else 600 for name in WORLDS}
    opened = {name: KnowledgeBase.from_scene(path) for name, path in WORLDS.items()}
    try:
        while asked < 10_000:
            asked += sum(refused(kb, share[name], seed) for name, kb in opened.items())
            seed += 1
    finally:
        for kb in opened.values():
            kb.close()
