"""The laws on a million pairs: exact integer coordinates, Pythagorean turns, and things just at a bound.

Every pair is moved, turned, mirrored and scaled in ways that must not change what holds of it, or must change
it in a known way; not one pair may disagree.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from deixis.boxes import NO_NORMAL, Boxes, contextualise
from deixis.grounding import measure_pairs, meets_halfspaces
from deixis.thresholds import SNAP, Thresholds

# Angles of right triangles with whole sides: their sines and cosines are rational.
TURNS = np.array(
    [
        k * math.pi / 2 + math.atan2(a, b)
        for k in range(4)
        for a, b in ((0, 1), (3, 4), (5, 12), (8, 15), (20, 21))
    ]
)
LIMITS = Thresholds()
NUMBERS = np.array([0, 20, -40, 1000, 1, 21, 19, -39, -41, 999, 1001])
"""Gaps in millimetres at which something changes, and a millimetre to either side."""

BACK, FRONT, LEFT, RIGHT = range(4)


@dataclass(frozen=True)
class Pairs:
    """m pairs of boxes: the first of each is the figure, the second the reference; the robot is at 0, 0."""

    figure: Boxes
    reference: Boxes

    def moved(self, angle: Any, about: Any = 0.0, shift: Any = 0.0) -> Pairs:
        """Return the pairs, each turned by its angle about its own point, then shifted."""
        return Pairs(*(turned(one, angle, about, shift) for one in (self.figure, self.reference)))

    def each(self, change: Callable[[Boxes], Boxes]) -> Pairs:
        return Pairs(change(self.figure), change(self.reference))


def turned(boxes: Boxes, angle: Any, about: Any, shift: Any) -> Boxes:
    cos, sin = np.cos(angle), np.sin(angle)
    x, y, z = (boxes.center - about).T
    center = np.stack([cos * x - sin * y, sin * x + cos * y, z], axis=1) + about + shift
    return replace(boxes, center=center, yaw=boxes.yaw + angle)


def box_pairs(m: int, seed: int) -> Pairs:
    """Return random pairs: many touch, overlap or miss each other by just a threshold along some face."""
    rng = np.random.default_rng(seed)
    half = rng.integers(0, 400, (2, m, 3)) / 1000.0
    yaw = rng.choice(TURNS, (2, m))
    yaw[1] = np.where(rng.random(m) < 0.5, yaw[0], yaw[1])
    at = rng.integers(-6000, 6000, (m, 3)) / 1000.0
    at[:, 2] = rng.integers(0, 1500, m) / 1000.0
    offset = rng.integers(-1200, 1200, (m, 3)) / 1000.0
    # Four in ten stand along a common axis with one of the telling gaps between their faces.
    chosen = np.flatnonzero(rng.random(m) < 0.4)
    axis = rng.integers(0, 3, len(chosen))
    yaw[1, chosen] = yaw[0, chosen]
    local = rng.integers(-300, 300, (len(chosen), 3)) / 1000.0
    gap = rng.choice(NUMBERS, len(chosen)) / 1000.0
    side = rng.choice([-1.0, 1.0], len(chosen))
    pick = np.arange(len(chosen))
    local[pick, axis] = side * (half[0, chosen, axis] + half[1, chosen, axis] + gap)
    cos, sin = np.cos(yaw[1, chosen]), np.sin(yaw[1, chosen])
    offset[chosen] = np.stack(
        [cos * local[:, 0] - sin * local[:, 1], sin * local[:, 0] + cos * local[:, 1], local[:, 2]], axis=1
    )
    # One in ten lies within the other, or sticks out of it by just D.
    nested = np.flatnonzero(rng.random(m) < 0.1)
    half[0, nested] = np.round(half[1, nested] * rng.choice([0.1, 0.5, 0.9], len(nested))[:, None], 3)
    room = half[1, nested] - half[0, nested] + rng.choice([0.0, 0.02, -0.02], len(nested))[:, None]
    local = np.round(room * rng.choice([-1.0, 0.0, 0.5, 1.0], (len(nested), 3)), 3)
    cos, sin = np.cos(yaw[1, nested]), np.sin(yaw[1, nested])
    yaw[0, nested] = yaw[1, nested]
    offset[nested] = np.stack(
        [cos * local[:, 0] - sin * local[:, 1], sin * local[:, 0] + cos * local[:, 1], local[:, 2]], axis=1
    )
    none, plain = np.full(m, NO_NORMAL), np.zeros(m, dtype=bool)
    return Pairs(Boxes(at + offset, half[0], yaw[0], none, plain), Boxes(at, half[1], yaw[1], none, plain))


def answers(pairs: Pairs, limits: Thresholds = LIMITS, robot: Any = (0.0, 0.0, 0.0)) -> dict[str, Any]:
    """Return the truth of everything grounded about (figure, reference); the sides as columns, all false
    where the view says nothing.
    """
    m = len(pairs.figure)
    both = [np.concatenate([getattr(pairs.figure, n), getattr(pairs.reference, n)])
            for n in ("center", "half", "yaw", "normal", "ambiguous")]  # fmt: skip
    boxes = Boxes(*both)
    figure, reference = np.arange(m), np.arange(m, 2 * m)
    # A reach beyond every pair here, so that no row is left out.
    wide = replace(limits, closeness=1000.0)
    columns = measure_pairs(boxes, figure, reference, wide)
    assert len(columns.figure) == m
    facts = SimpleNamespace(
        figure=figure, reference=reference, separation=columns.separation, thresholds=limits
    )
    framed, clearance, _ = contextualise(boxes, np.array(robot))
    relaxed, strict = meets_halfspaces(boxes, framed, facts, np.arange(m))
    seen = (clearance[m:] > SNAP)[:, None]
    apart, p, d = columns.separation, limits.penetration, limits.granularity
    lengths = [apart - limits.closeness, apart + p, apart - d, columns.protrusion - d]
    margins = np.column_stack([*lengths, columns.vertical, columns.vertical_strict, relaxed, strict])
    return {
        "is_close": apart <= limits.closeness,
        "touches": (apart >= -p) & (apart <= d),
        "intersects": apart < -p,
        "compl_cont": (apart < -p) & (columns.protrusion <= d),
        "vertical": columns.vertical >= 0.0,
        "vertical_strict": columns.vertical_strict >= 0.0,
        "ordered": columns.ordered,
        "sides": (relaxed >= 0.0) & seen,
        "sides_strict": (strict >= 0.0) & seen,
        "frontier": columns.frontier,
        "narrow": ((margins != 0.0) & (np.abs(margins) < 5.0 * SNAP)).any(axis=1),
    }


def disagreements(one: dict[str, Any], other: dict[str, Any], order: Any = (BACK, FRONT, LEFT, RIGHT)) -> int:
    """Return in how many pairs two sets of answers differ; ``order`` says which side became which."""
    wrong = np.zeros(len(one["touches"]), dtype=bool)
    for name, value in one.items():
        if name in ("frontier", "narrow"):
            continue
        then = other[name][:, order] if name.startswith("sides") else other[name]
        different = value != then
        wrong |= different.any(axis=1) if different.ndim == 2 else different
    return int(wrong.sum())


def some(found: dict[str, Any], rows: Any) -> dict[str, Any]:
    """Return the answers about some of the pairs."""
    return {name: value[rows] for name, value in found.items()}


def campaign(m: int, seed: int) -> None:
    pairs = box_pairs(m, seed)
    rng = np.random.default_rng(seed + 1)
    angle = rng.choice(TURNS, m)
    base = answers(pairs)
    counts = {name: int(base[name].sum()) for name in ("touches", "intersects", "compl_cont", "is_close")}
    assert min(counts.values()) > m // 500, counts
    assert (base["sides"].sum(axis=0) > m // 500).all()

    # The world turns about the robot, and is shifted together with it.
    assert disagreements(base, answers(pairs.moved(angle))) == 0
    shift = np.array([12.0, -7.0, 3.0])
    assert disagreements(base, answers(pairs.moved(0.0, shift=shift), robot=shift)) == 0

    # Lengths in another unit.
    unit = Thresholds(
        **{name: 4.0 * value if name != "halfspace_scale" else value for name, value in LIMITS.items()}
    )
    larger = pairs.each(lambda one: replace(one, center=4.0 * one.center, half=4.0 * one.half))
    scaled = answers(larger, unit)
    # Lengths are rounded to a nanometre in any unit: what misses a bound by less is another matter in each.
    wide = ~scaled["narrow"]
    assert wide.sum() > 0.999 * m
    assert disagreements(some(base, wide), some(scaled, wide)) == 0

    # A mirror swaps left and right.
    mirror = np.array([1.0, -1.0, 1.0])
    mirrored = pairs.each(lambda one: replace(one, center=one.center * mirror, yaw=-one.yaw))
    assert disagreements(base, answers(mirrored), (BACK, FRONT, RIGHT, LEFT)) == 0

    # Turned about the reference, as if the robot had gone round it: to the other side, and a quarter.
    centre = pairs.reference.center
    assert disagreements(base, answers(pairs.moved(math.pi, centre)), (FRONT, BACK, RIGHT, LEFT)) == 0
    aside = pairs.moved(-math.pi / 2, centre)
    quarter = answers(aside)
    # Seen at exactly 45 degrees a box turns so that its longer side faces the robot: marked, not a law. And a
    # quarter of the way round the robot may come to stand in the footprint, or out of it.
    _, clear, tie = contextualise(pairs.reference, np.zeros(3))
    plain = ~tie & (clear > SNAP) & (contextualise(aside.reference, np.zeros(3))[1] > SNAP)
    assert plain.sum() > 0.98 * m
    assert disagreements(some(base, plain), some(quarter, plain), (RIGHT, LEFT, BACK, FRONT)) == 0

    # The robot goes back along its line of sight, away from the reference.
    away = centre * np.array([0.5, 0.5, 0.0])
    beyond = answers(pairs.moved(0.0, shift=away))
    further = contextualise(pairs.reference, np.zeros(3))[1] > SNAP
    assert disagreements(some(base, further), some(beyond, further)) == 0

    # Contact and overlap are the same from the other thing's side.
    swapped = answers(Pairs(pairs.reference, pairs.figure))
    for name in ("is_close", "touches", "intersects"):
        assert (base[name] == swapped[name]).all()


def test_a_million_pairs() -> None:
    for seed in range(10):
        campaign(100_000, seed)


@pytest.mark.long
def test_a_hundred_million_pairs() -> None:
    for seed in range(1000, 2000):
        campaign(100_000, seed)


def test_a_million_contacts_turned_by_any_angle() -> None:
    """Faces, edges and corners that meet exactly are found to touch, whatever angle the pair is turned by."""
    rng = np.random.default_rng(5)
    m = 1_000_000
    half = rng.uniform(0.05, 0.5, (2, m, 3))
    sides = rng.integers(-1, 2, (m, 3)).astype(float)
    sides[(sides == 0.0).all(axis=1), 2] = 1.0
    slack = rng.uniform(-0.9, 0.9, (m, 3)) * np.where(sides == 0.0, 1.0, 0.0)
    local = (sides + slack) * (half[0] + half[1])
    none, plain = np.full(m, NO_NORMAL), np.zeros(m, dtype=bool)
    at = rng.uniform(-5.0, 5.0, (m, 3))
    pairs = Pairs(
        Boxes(at + local, half[0], np.zeros(m), none, plain), Boxes(at, half[1], np.zeros(m), none, plain)
    )
    assert answers(pairs.moved(rng.uniform(-math.pi, math.pi, m)))["touches"].all()
