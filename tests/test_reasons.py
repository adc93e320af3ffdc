"""The questions of Figure 3, asked in every way there is; and how long an answer takes."""

from __future__ import annotations

import random
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from urllib.parse import quote

import pytest

from commands import call, run
from deixis import KnowledgeBase
from deixis.explain import Proof
from endpoint import HANS, Server, serving
from scenes import box, floor, scene

LEANS, AFFIXED = "leans_on(extinguisher2, wall)", "affixed_on(extinguisher2, wall)"

FIGURE_3 = (
    "The fire extinguisher on the floor leans on the wall, but it is not affixed on the wall, "
    "because the floor touches it."
)

HAZARD = "violation(fire_hazard, sweater, heater)"

MATERIAL, CONTACT = "the sweater is made of cloth which burns", "the sweater touches the electric heater"


@pytest.fixture(scope="module")
def kb() -> Iterator[KnowledgeBase]:
    with KnowledgeBase.from_scene(HANS, rules=["safety"]) as opened:
        yield opened


@pytest.fixture(scope="module")
def server() -> Iterator[Server]:
    with serving(HANS, "--timeout", "20") as running:
        yield running


def texts(proof: Proof) -> set[str]:
    return {proof.text}.union(*map(texts, proof.children))


def test_leaning_and_not_affixed_in_python(kb: KnowledgeBase) -> None:
    assert kb.contrast(LEANS, AFFIXED).sentence() == FIGURE_3


def test_leaning_and_not_affixed_at_the_command_line() -> None:
    assert call("contrast", HANS, LEANS, "--rather-than", AFFIXED).out == FIGURE_3 + "\n"


def test_leaning_and_not_affixed_at_the_shell() -> None:
    told = run(
        "shell", HANS, stdin=f"contrast({LEANS}, {AFFIXED}).\nhelp(contrast).\ncontrast(nearr(a, b), true).\n"
    )
    assert FIGURE_3.lower() in told.out.lower()
    assert "Print in a sentence why Goal holds rather than Other." in told.out
    assert "did you mean near/2?" in told.err


def test_leaning_and_not_affixed_over_http(server: Server) -> None:
    path = f"/scenes/hans/contrast?goal={quote(LEANS)}&rather_than={quote(AFFIXED)}"
    assert server.send("GET", path).json["sentence"] == FIGURE_3


def test_the_fire_hazard_in_python(kb: KnowledgeBase) -> None:
    proof = kb.why(HAZARD).proof
    assert proof is not None
    assert {MATERIAL, CONTACT} <= texts(proof)
    assert proof.sentence() == (
        "The sweater is a fire hazard on or against the electric heater, because the electric heater gives "
        "off heat, the sweater touches the electric heater and it is made of cloth which burns."
    )


def test_the_fire_hazard_at_the_command_line() -> None:
    for told in (call("why", HANS, HAZARD, "--rules", "safety").out, call("check", HANS).out):
        assert MATERIAL in told
        assert CONTACT in told


def test_the_fire_hazard_at_the_shell() -> None:
    told = run("shell", HANS, "--rules", "safety", stdin=f"why({HAZARD}).\n")
    assert MATERIAL in told.out
    assert CONTACT in told.out


def test_the_fire_hazard_over_http(server: Server) -> None:
    told = server.send("GET", f"/scenes/hans/why?goal={quote(HAZARD)}").json
    assert told["text"] == "the sweater is a fire hazard on or against the electric heater"
    proof = Proof.from_dict(told["proof"])
    assert {MATERIAL, CONTACT} <= texts(proof)


def test_why_something_is_no_hazard(kb: KnowledgeBase) -> None:
    """What is no length keeps a rule from holding too: the sign does not burn, the radiator is apart."""
    told = kb.why_not("violation(fire_hazard, sign, heater)").sentence()
    assert "because it is not in contact with the electric heater" in told
    assert "it is not made of anything which burns" in told
    assert kb.why_not("violation(fire_hazard, sweater, radiator)").misses


def test_every_rule_is_named(kb: KnowledgeBase) -> None:
    """Beside has two rules; of each the failing literal is named."""
    refusal = kb.why_not("beside(extinguisher2, radiator, v1)")
    assert len(refusal.misses) == 2
    assert len(refusal.others()) == 1
    assert all("from where you stand" in " ".join(miss.obstacles) for miss in refusal.misses)


def big(alike: int) -> KnowledgeBase:
    pick = random.Random(1)  # noqa: S311 - no secret
    things = [floor(half=12.0)]
    for number in range(999):
        size = [pick.uniform(0.05, 0.8) for _ in range(3)]
        height = size[2] / 2 if pick.random() < 0.7 else pick.uniform(0.3, 2.0)
        center = (pick.uniform(-12, 12), pick.uniform(-12, 12), height)
        things.append(box(f"o{number}", center, size, label="cup" if number < alike else f"thing {number}"))
    return KnowledgeBase(scene(*things))


@pytest.mark.parametrize("alike", [0, 100, 1000])
def test_an_answer_takes_no_time_in_a_scene_of_a_thousand(alike: int) -> None:
    """Warm: 50 ms for why, 100 ms for why-not; the least of some, since others use the machine too."""
    with big(alike) as kb:
        pick = random.Random(2)  # noqa: S311 - no secret
        holding = kb.relations()
        for one in pick.sample(holding, 15):
            assert least(kb.why, one.to_prolog()) <= 0.05
        rows = range(len(kb.facts))
        for row in pick.sample(rows, 15):
            figure, reference = kb.facts.ids[kb.facts.figure[row]], kb.facts.ids[kb.facts.reference[row]]
            name = pick.choice(["on_top_of", "leans_on", "affixed_on", "part_in", "inside", "below"])
            assert least(kb.why_not, f"{name}({figure}, {reference})") <= 0.1


def least(ask: Callable[[str], object], goal: str) -> float:
    taken = []
    for _ in range(12):
        start = time.perf_counter()
        ask(goal)
        taken.append(time.perf_counter() - start)
    return min(taken)


def test_what_is_told_stays_in_the_repository(root: Path) -> None:
    """No answer holds a path of this machine."""
    told = call("why", HANS, LEANS, "--length", "full").out
    assert str(root) not in told
    assert "commonsense.pl:" in told
