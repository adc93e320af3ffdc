"""The job that is compared: scenes, the question put to each competitor, and what counts as the same answer.

The question, for each ordered pair (figure, reference) within reach: the signed separation; the volume of
inter; whether they touch; whether the reference completely contains the figure; and which halfspaces of the
reference the figure meets, above and below, and in front, behind, left and right in each view. Margins,
strict halfspaces and the areas of PartIn are not asked for; the kernel and PostGIS measure them all the same.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from deixis.broadphase import reach
from deixis.facts import Facts
from deixis.frames import WORLD, Array, Index, Mask
from deixis.scene import BoxRegion, Label, Scene, SpatialObject, View
from deixis.thresholds import Thresholds

RELATIVE = 1.0e-9
"""How far two answers to the same question may differ, as a part of the number."""

LENGTH_ROUNDING, VOLUME_ROUNDING = 0.5e-9, 0.5e-12
"""Facts are rounded to a nanometre and to a thousandth of a cubic millimetre; by half of that at most."""


def scattered(count: int, seed: int = 0, closeness: float = 2.0) -> Scene:
    """Return things strewn about at indoor density: one per square metre, up to two metres high, turned."""
    rng = np.random.default_rng(seed)
    side = math.sqrt(count)
    low = rng.uniform([0.0, 0.0, 0.0], [side, side, 1.6], (count, 3))
    size = rng.uniform(0.08, 0.9, (count, 3))
    yaw = rng.uniform(-math.pi, math.pi, count)
    standing = rng.random(count) < 0.5
    low[standing, 2] = 0.0
    center = low + size * [0.0, 0.0, 0.5]
    label = (Label("thing"),)
    things = [
        SpatialObject(f"o{i}", label, "object", BoxRegion(center[i], size[i], float(yaw[i])))
        for i in range(count)
    ]
    views = (View("robot", "robot", np.array([-2.0, 0.4 * side, 0.5])),)
    return Scene(f"scattered-{count}", tuple(things), views, Thresholds(closeness=closeness))


def room(count: int = 100, seed: int = 0) -> Scene:
    """Return a room of so many things: a floor and two walls among them, the rest strewn about in it."""
    side = math.sqrt(count)
    walls = (
        ("floor", BoxRegion([side / 2, side / 2, -0.05], [side + 4.0, side + 4.0, 0.1])),
        ("wall-1", BoxRegion([-0.31, side / 2, 1.3], [0.1, side + 3.0, 2.6])),
        ("wall-2", BoxRegion([side / 2, side + 0.37, 1.3], [side + 3.0, 0.12, 2.6])),
    )
    surfaces = [SpatialObject(name, (Label(name[:5]),), "surface", region) for name, region in walls]
    scene = scattered(count - len(surfaces), seed, Thresholds().closeness)
    views = (View("robot", "robot", np.array([0.45 * side, -1.5, 0.5])),)
    return Scene(f"room-{count}", (*surfaces, *scene.objects), views, scene.thresholds)


@dataclass(frozen=True)
class Answers:
    """What was found of the p ordered pairs within reach, in lexicographic order.

    ``vertical`` (p, 2) says above and below; ``sides`` (p, 4) says X+, X-, Y+, Y- for each view, false for
    pairs out of figure-reference order and where the view is withheld.
    """

    pairs: Index
    separation: Array
    volume: Array
    touches: Mask
    contained: Mask
    vertical: Mask
    sides: dict[str, Mask]

    @classmethod
    def of(cls, facts: Facts) -> Answers:
        """Return what the kernel found."""
        sides = {}
        for view in facts.views:
            sides[view.view] = np.zeros((len(facts), 4), dtype=bool)
            sides[view.view][view.rows] = view.int_hs >= 0.0
        return cls(
            np.column_stack([facts.figure, facts.reference]),
            facts.separation,
            facts.intersection,
            facts.touches,
            facts.compl_cont,
            facts.vertical >= 0.0,
            sides,
        )

    def differences(self, other: Answers) -> list[str]:
        """Return what the other found otherwise, none where all is the same."""
        if not np.array_equal(self.pairs, other.pairs):
            mine, theirs = ({tuple(pair) for pair in one.pairs.tolist()} for one in (self, other))
            return [f"pairs within reach: {sorted(mine ^ theirs)[:5]}"]
        found = []
        for name, rounding in (("separation", LENGTH_ROUNDING), ("volume", VOLUME_ROUNDING)):
            one, two = getattr(self, name), getattr(other, name)
            wrong = np.flatnonzero(~(np.abs(one - two) <= RELATIVE * np.abs(one) + rounding))
            found += [f"{name} {self.pairs[row]}: {one[row]!r}, {two[row]!r}" for row in wrong]
        columns = [(name, getattr(self, name), getattr(other, name)) for name in ("touches", "contained")]
        columns.append(("vertical", self.vertical, other.vertical))
        columns += [(view, mask, other.sides[view]) for view, mask in self.sides.items()]
        for name, one, two in columns:
            found += [f"{name} {self.pairs[at[0]]} {at[1:]}" for at in np.argwhere(one != two)]
        return found


class Thing(NamedTuple):
    """A box as plain numbers; ``normal`` is the axis of a surface's normal, -1 for other things."""

    x: float
    y: float
    z: float
    hx: float
    hy: float
    hz: float
    yaw: float
    normal: int
    reach: float

    @property
    def surface(self) -> bool:
        return self.normal >= 0

    @property
    def volume(self) -> float:
        return 8.0 * self.hx * self.hy * self.hz


def things(scene: Scene) -> list[Thing]:
    """Return the boxes of a scene."""
    boxes = scene.boxes
    columns = (*boxes.center.T, *boxes.half.T, boxes.yaw, boxes.normal, reach(boxes, scene.thresholds))
    return [Thing(*row) for row in zip(*(column.tolist() for column in columns), strict=True)]


def solid_things(scene: Scene) -> list[Thing]:
    """Return the boxes of a scene, none of which may be thinner than D: the competitors know none."""
    listed = things(scene)
    if any(min(thing.hx, thing.hy, thing.hz) < 0.5 * scene.thresholds.granularity for thing in listed):
        raise ValueError("give a scene without things thinner than D")
    return listed


class Frame(NamedTuple):
    """The box of a reference in the frame its halfspaces are aligned with; ``normal`` counts in it."""

    yaw: float
    hx: float
    hy: float
    normal: int


def frames(scene: Scene) -> Iterator[tuple[str, int, Frame]]:
    """Yield the view, the reference and its frame, but for what the view does not speak of.

    Written anew from decisions 0003, 0005, 0007 and 0014, one thing at a time; without ties, which random
    scenes do not have.
    """
    for index, thing in enumerate(things(scene)):
        turns, framed = _turned(thing, 0.0)
        yield WORLD, index, Frame(thing.yaw + turns * math.pi / 2 if thing.surface else 0.0, *framed)
        for view in scene.views:
            x, y = thing.x - view.position[0], thing.y - view.position[1]
            turns, framed = _turned(thing, math.atan2(y, x))
            cos, sin = math.cos(thing.yaw), math.sin(thing.yaw)
            own = (abs(cos * x + sin * y) - thing.hx, abs(cos * y - sin * x) - thing.hy)
            if thing.normal in (0, 1):
                if own[thing.normal] <= 0.0:
                    continue
                yaw = thing.yaw + thing.normal * math.pi / 2
                away = math.cos(yaw) * x + math.sin(yaw) * y >= 0.0
                halves = (thing.hx, thing.hy) if thing.normal == 0 else (thing.hy, thing.hx)
                yield view.id, index, Frame(yaw if away else yaw + math.pi, *halves, 0)
            elif max(own) > 0.0:
                yaw = thing.yaw + turns * math.pi / 2 if thing.surface else math.atan2(y, x)
                yield view.id, index, Frame(yaw, *framed)


def _turned(thing: Thing, target: float) -> tuple[int, tuple[float, float, int]]:
    """Return the least number of quarter turns to a direction, and the box's halves and normal after them."""
    turns = round((target - thing.yaw) / (math.pi / 2))
    if turns % 2 == 0:
        return turns, (thing.hx, thing.hy, thing.normal)
    return turns, (thing.hy, thing.hx, {0: 1, 1: 0}.get(thing.normal, thing.normal))


def ordered(figure: Thing, reference: Thing) -> bool:
    """Return whether a pair stands in figure-reference order (decision 0006)."""
    return not figure.surface and (reference.surface or reference.volume >= figure.volume)
