"""Evidence: every leaf of a proof is measured again, and what it shows is what it says."""

from __future__ import annotations

import json
from collections.abc import Iterator

import numpy as np
import pytest

from deixis.evidence import Evidence
from deixis.explain import Answer, Proof
from deixis.facts import RegionModel
from deixis.grounding import ground
from deixis.knowledge import KnowledgeBase
from deixis.scene import Scene
from deixis.witnesses import measured_segments
from regions.golden import golden
from scenes import ROBOT, box, floor, scene, wall
from test_golden import SCENES

NEAR = 2.0e-9

LEAVES = ("comparison", "negation")


def steps(proof: Proof) -> Iterator[Proof]:
    yield proof
    for child in proof.children:
        yield from steps(child)


def length(of: Evidence) -> float:
    assert of.witness is not None
    assert of.witness.points is not None
    one, other = of.witness.points
    return float(np.linalg.norm(np.subtract(one, other)))


def check(kb: KnowledgeBase, proof: Proof) -> None:
    limits = dict(kb.facts.thresholds.items())
    for step in steps(proof):
        leaf = step.kind in LEAVES or not step.children
        assert not leaf or step.evidence is not None or step.kind == "rule", step
        if step.evidence is None:
            continue
        found = step.evidence
        assert found.margin == step.margin
        for one in found.thresholds:
            assert one.name == "constant" or limits[one.name] == one.value
        seen = found.witness
        if seen is None:
            continue
        assert all(name in kb.facts.ids for name in seen.things)
        assert set(seen.measured_as) == set(seen.things)
        if seen.points is None:
            continue
        row = kb.facts.row(*seen.things)
        assert row is not None
        for one in found.values:
            if one.name in ("separation", "distance", "protrusion"):
                assert one.value == getattr(kb.facts, one.name)[row]
        if seen.plane is None:
            assert abs(length(found) - abs(kb.facts.separation[row])) <= NEAR
            assert seen.measured_as == {name: kb.measured_as[name] for name in seen.things}
            continue
        offset = np.subtract(*seen.points) @ np.array(seen.plane.normal)
        margins = [one.value for one in found.values if one.name in ("margin", "strict margin")]
        if margins and kb.region == "box":
            assert abs(offset - margins[0]) <= NEAR


@pytest.mark.parametrize("name", SCENES)
def test_every_leaf_says_and_shows_what_was_measured(name: str) -> None:
    with KnowledgeBase.from_scene(SCENES[name], rules=["safety"]) as kb:
        for proof in kb.proofs().values():
            check(kb, kb.evidence(proof))
        for one in kb.relations():
            swapped = one.to_dict() | {"figure": one.reference, "reference": one.figure}
            goal = type(one)(**swapped).to_prolog()  # type: ignore[arg-type]
            for miss in kb.evidence(kb.why_not(goal)).misses:
                check(kb, miss.derivation)
        for violation in kb.evidence(kb.check()).violations:
            assert violation.proof is not None
            check(kb, violation.proof)


def test_a_comparison_names_what_it_compares() -> None:
    with KnowledgeBase(
        scene(box("cup", [0, 0, 0.82], [0.1, 0.1, 0.1]), box("table", [0, 0, 0.38], [1, 1, 0.76]))
    ) as kb:
        proof = kb.evidence(kb.why("touches(cup, table)")).proof
    assert proof is not None
    compared = [step.evidence for step in steps(proof) if step.kind == "comparison"]
    assert [
        [(one.name, one.unit) for one in (*found.values, *found.thresholds)] for found in compared if found
    ] == [[("separation", "m"), ("granularity", "m")], [("separation", "m"), ("penetration", "m")]]


def test_an_absence_shows_what_came_closest() -> None:
    lamp, picture = (
        box("lamp", [1.5, 0.6, 1.5], [0.2, 0.2, 0.2]),
        box("picture", [1.98, 0, 1.5], [0.04, 0.6, 0.4]),
    )
    with KnowledgeBase(scene(wall(), picture, lamp)) as kb:
        proof = kb.evidence(kb.why("affixed_on(picture, wall)")).proof
    assert proof is not None
    absent = proof.children[-1]
    assert absent.kind == "negation"
    assert absent.evidence is not None
    assert absent.evidence.witness is not None
    assert absent.evidence.witness.things == ("lamp", "picture")
    gap = next(one.value for one in absent.evidence.values if one.name == "separation")
    assert length(absent.evidence) == pytest.approx(gap, abs=NEAR)


def test_a_view_is_named_where_it_matters() -> None:
    cup, crate = box("cup", [0, 1.0, 0.1], [0.1, 0.1, 0.2]), box("crate", [0, 0, 0.3], [0.6, 0.6, 0.6])
    with KnowledgeBase(scene(floor(), cup, crate, views=[ROBOT])) as kb:
        proof = kb.evidence(kb.why("left_of(cup, crate, v0)")).proof
    assert proof is not None
    planes = [step.evidence.witness for step in steps(proof) if step.evidence and step.evidence.witness]
    assert {seen.view for seen in planes if seen.plane} == {"v0"}
    # The robot looks along X, so the halfspace on its left begins at the crate's face towards +Y.
    assert all(seen.plane.normal[1] > 0.9 for seen in planes if seen.plane and seen.plane.bound == "face")


def test_evidence_travels_as_json() -> None:
    with KnowledgeBase.from_scene(SCENES["figure_3"]) as kb:
        answer = kb.evidence(kb.why("leans_on(extinguisher2, wall)"))
    assert Answer.from_dict(json.loads(json.dumps(answer.to_dict(), allow_nan=False))) == answer


@pytest.mark.parametrize("region", ["hull", "mesh"])
def test_hulls_and_meshes_show_the_points_they_were_measured_between(region: RegionModel) -> None:
    from deixis.solids import Solids

    for case in golden():
        made: Scene = case.scene()
        facts = ground(made, region=region)
        points = measured_segments(made, facts, np.arange(len(facts)))
        away = points[:, 0] - points[:, 1]
        length = np.linalg.norm(away, axis=1)
        assert np.abs(length - np.abs(facts.separation)).max(initial=0.0) <= NEAR
        things = Solids.of(made, region)
        for side, column, certain in (
            (0, facts.figure, np.ones(len(facts), dtype=bool)),
            (1, facts.reference, facts.separation >= 0.0),
        ):
            for row in np.flatnonzero(certain).tolist():
                index, boxes = int(column[row]), made.boxes
                x, y, z = points[row, side] - boxes.center[index]
                cos, sin = boxes.cos[index], boxes.sin[index]
                local = np.array([[cos * x + sin * y, cos * y - sin * x, z]])
                planes = things[index].hull.facets
                assert (local @ planes[:, :3].T + planes[:, 3]).max() <= 1.0e-4, (case.name, row, side)


def test_evidence_of_meshes_says_so() -> None:
    case = next(one for one in golden() if "bowl" in one.name)
    with KnowledgeBase(case.scene(), region="mesh") as kb:
        for proof in kb.proofs().values():
            check(kb, kb.evidence(proof))
