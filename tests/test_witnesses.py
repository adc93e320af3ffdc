"""Witnesses: the points that a separation is measured between, and the planes that decide a halfspace."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings

import oracles
from deixis import bounds, measures
from deixis._files import kb_dir
from deixis.boxes import Boxes, align_with_world
from deixis.facts import Facts
from deixis.frames import AXES, WORLD, Array, Index
from deixis.grounding import frame, ground
from deixis.scene import Scene
from deixis.witnesses import segments
from worlds import World, worlds

NEAR = 2.0e-9
"""Metres: a nanometre for the facts' own rounding, and one for ours."""


def _outside(points: Array, boxes: Boxes, index: Index, least: float = 0.0) -> float:
    """Return how far the farthest of the points lies outside its box, none of which is thinner than that."""
    some = boxes.take(index)
    x, y, z = (points - some.center).T
    local = np.stack([some.cos * x + some.sin * y, some.cos * y - some.sin * x, z], axis=1)
    return float((np.abs(local) - some.effective_half(least)).max(initial=0.0))


def _check_segments(scene: Scene, facts: Facts) -> None:
    figure, reference = facts.figure.astype(np.int64), facts.reference.astype(np.int64)
    points = segments(scene.boxes, figure, reference, scene.thresholds.granularity)
    away = points[:, 0] - points[:, 1]
    length = np.linalg.norm(away, axis=1)
    assert np.abs(length - np.abs(facts.separation)).max(initial=0.0) <= NEAR
    a, b = scene.boxes.take(figure), scene.boxes.take(reference)
    there = measures.place(a, b)
    escapes = measures.vertical_escapes(
        there, a.half, b.half, a.surface, b.surface, scene.thresholds.granularity
    )
    apart, local = measures.separation(there, a.half, b.half, *escapes)
    normal = np.stack(
        [b.cos * local[:, 0] - b.sin * local[:, 1], b.sin * local[:, 0] + b.cos * local[:, 1], local[:, 2]],
        axis=1,
    )
    assert np.abs(away - apart[:, None] * normal).max(initial=0.0) <= NEAR
    for side, index in ((0, figure), (1, reference)):
        assert _outside(points[:, side], scene.boxes, index) <= NEAR


def _check_planes(scene: Scene, facts: Facts) -> None:
    boxes, limits = scene.boxes, scene.thresholds
    tables = []
    for view in facts.views:
        framed = (
            align_with_world(boxes)[0]
            if view.view == WORLD
            else frame(boxes, next(one for one in scene.views if one.id == view.view))[0]
        )
        tables += [
            (axis, framed, view.rows, view.int_hs[:, k], view.cont_hs[:, k])
            for k, axis in enumerate(AXES[:4])
        ]
    everything = np.arange(len(facts))
    tables += [
        (axis, boxes, everything, facts.vertical[:, k], facts.vertical_strict[:, k])
        for k, axis in enumerate(AXES[4:])
    ]
    for axis, framed, rows, relaxed, strictly in tables:
        figure, reference = (column[rows].astype(np.int64) for column in (facts.figure, facts.reference))
        for strict, margins in ((False, relaxed), (True, strictly)):
            found = bounds.planes(
                boxes.take(figure),
                framed.take(reference),
                facts.separation[rows],
                axis,
                limits,
                strict=strict,
            )
            assert np.abs(found.margin - margins).max(initial=0.0) <= NEAR, (axis, strict)
            offset = found.witness - found.point
            assert np.abs((found.normal * offset).sum(axis=1) - margins).max(initial=0.0) <= NEAR
            assert np.abs(np.linalg.norm(found.normal, axis=1) - 1.0).max(initial=0.0) <= NEAR
            if not strict:
                holds = margins >= 0.0
                assert _outside(found.witness[holds], boxes, figure[holds], limits.granularity) <= NEAR


@given(worlds())
@settings(max_examples=150, deadline=None)
def test_witnesses_and_planes_say_what_was_measured(world: World) -> None:
    scene = world.scene()
    facts = ground(scene)
    _check_segments(scene, facts)
    _check_planes(scene, facts)


@pytest.mark.parametrize("name", sorted(path.stem for path in (kb_dir() / "scenes").glob("*.json")))
def test_witnesses_and_planes_of_sample_scenes(name: str) -> None:
    scene = Scene.load(kb_dir() / "scenes" / f"{name}.json")
    facts = ground(scene)
    _check_segments(scene, facts)
    _check_planes(scene, facts)


def test_points_of_pairs_of_all_kinds_lie_on_both() -> None:
    for scene in oracles.scenes(400, seed=5):
        facts = ground(scene)
        _check_segments(scene, facts)
        _check_planes(scene, facts)
