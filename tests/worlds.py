"""Random small worlds for property tests: whole millimetres, all kinds of turns, many things at a bound."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from hypothesis import strategies as st

from deixis.scene import Scene
from deixis.thresholds import Thresholds
from scenes import scene, turned

Data = dict[str, Any]
Point = tuple[float, float, float]

TRIPLES = ((3, 4, 5), (5, 12, 13), (8, 15, 17), (20, 21, 29), (81, 3280, 3281))
"""Turns whose cosine and sine are fractions; the last is all but a quarter turn."""

LIMITS = (
    {"granularity": 0.02, "penetration": 0.04, "closeness": 1.0, "halfspace_scale": 1.2, "pose_noise": 0.05},
    {"granularity": 0.01, "penetration": 0.04, "closeness": 1.0, "halfspace_scale": 1.2, "pose_noise": 0.0},
    {"granularity": 0.02, "penetration": 0.02, "closeness": 0.3, "halfspace_scale": 2.0, "pose_noise": 0.05},
)


@dataclass(frozen=True)
class World:
    """A scene as data, with all thresholds written out."""

    things: tuple[Data, ...]
    views: tuple[Data, ...]
    limits: Mapping[str, float]

    def scene(self) -> Scene:
        return scene(*self.things, views=self.views, thresholds=dict(self.limits))

    @property
    def names(self) -> list[str]:
        return [thing["id"] for thing in self.things]

    def each(self, change: Callable[[Data], Data]) -> World:
        """Change every thing and every view."""
        return replace(self, things=tuple(map(change, self.things)), views=tuple(map(change, self.views)))

    def without(self, name: str) -> World:
        return replace(self, things=tuple(thing for thing in self.things if thing["id"] != name))


def moved(world: World, angle: float, shift: Sequence[float]) -> World:
    """Turn the world about the vertical, then shift it."""
    return world.each(lambda data: turned(data, angle, shift))


def mirrored(world: World) -> World:
    """Exchange left and right: y becomes -y."""
    return world.each(lambda data: _mapped(data, lambda p: [p[0], -p[1], p[2]], 1.0, -1.0))


def scaled(world: World, factor: float) -> World:
    """Make everything larger, the thresholds that are lengths too."""
    larger = world.each(lambda data: _mapped(data, lambda p: [factor * c for c in p], factor, 1.0))
    limits = {
        name: value if name == "halfspace_scale" else round(factor * value, 9)
        for name, value in world.limits.items()
    }
    return replace(larger, limits=limits)


def _mapped(data: Data, point: Callable[[Sequence[float]], list[float]], factor: float, sense: float) -> Data:
    result = dict(data)
    if "box" in data:
        one = data["box"]
        size = [factor * extent for extent in one["size"]]
        result["box"] = {"center": point(one["center"]), "size": size, "yaw": sense * one["yaw"]}
    if "polygon" in data:
        result["polygon"] = [point(corner) for corner in data["polygon"]]
    if "position" in data:
        result["position"] = point(data["position"])
        result["heading"] = sense * data["heading"]
    return result


@dataclass(frozen=True)
class Block:
    """A box to be: metres for where it is, millimetres for how large."""

    center: Point
    half: Point
    yaw: float
    surface: bool = False

    def at(self, x: float, y: float, z: float) -> Point:
        """Return the world coordinates of a point given in millimetres in the block's own frame."""
        cos, sin = math.cos(self.yaw), math.sin(self.yaw)
        x, y, z = x / 1000, y / 1000, z / 1000
        return (
            self.center[0] + cos * x - sin * y,
            self.center[1] + sin * x + cos * y,
            self.center[2] + z,
        )

    def data(self, name: str) -> Data:
        kind = {"kind": "surface"} if self.surface else {}
        thin = [axis for axis in (2, 0, 1) if self.half[axis] == 0]
        if self.surface and thin:
            one, other = (axis for axis in (0, 1, 2) if axis != thin[0])
            ring = []
            for a, b in ((1, 1), (-1, 1), (-1, -1), (1, -1)):
                corner = [0.0, 0.0, 0.0]
                corner[one], corner[other] = a * self.half[one], b * self.half[other]
                ring.append(list(self.at(*corner)))
            return {"id": name, "label": name, **kind, "polygon": ring}
        size = [2 * extent / 1000 for extent in self.half]
        return {
            "id": name,
            "label": name,
            **kind,
            "box": {"center": list(self.center), "size": size, "yaw": self.yaw},
        }


def yaws() -> st.SearchStrategy[float]:
    """Square, half-way, by a Pythagorean triple, or any."""
    exact = [sign * math.atan2(s, c) for c, s, _ in TRIPLES for sign in (1, -1)]
    quarters = st.sampled_from([0.0, math.pi / 2, math.pi, -math.pi / 2])
    return st.one_of(
        quarters,
        st.builds(lambda turn, rest: turn + rest, quarters, st.sampled_from([math.pi / 4, *exact])),
        st.floats(-math.pi, math.pi),
    )


EXTENTS = st.one_of(
    st.sampled_from([0, 0.5, 5, 10, 11, 20, 25, 40, 50, 100, 250, 500, 900]), st.integers(1, 700)
)
"""Half extents, millimetres: points, sheets, rods, blocks."""

ROOMS = (
    (),
    (),
    (Block((0.0, 0.0, 0.0), (2000, 1500, 0), 0.0, True),),
    (
        Block((0.0, 0.0, 0.0), (2000, 2000, 0), 0.0, True),
        Block((2.0, 0.0, 1.25), (0, 2000, 1250), 0.0, True),
    ),
    (Block((0.0, 2.0, 1.25), (2000, 0, 1250), 0.0, True),),
    (Block((0.0, 0.0, 1.0), (500, 500, 0), 0.0, True),),
    (Block((0.0, 0.0, 1.0), (500, 20, 300), 0.0, True),),
)
"""Floors, walls and shelves, some with a thickness."""


@st.composite
def placed(draw: st.DrawFn, anchor: Block, limits: Mapping[str, float]) -> Block:
    """Return a block near another: facing it, lying across it, in it, or where it is."""
    if not anchor.surface and draw(st.integers(0, 9)) == 0:
        return anchor
    half = draw(st.tuples(EXTENTS, EXTENTS, EXTENTS))
    yaw = draw(yaws())
    cos, sin = abs(math.cos(yaw)), abs(math.sin(yaw))
    own = (half[0] * cos + half[1] * sin, half[0] * sin + half[1] * cos, half[2])
    d, p, t = (round(1000 * limits[name]) for name in ("granularity", "penetration", "closeness"))
    facing = draw(st.sampled_from((0, 1, 2, 2, None)))
    offset = []
    for axis in range(3):
        whole, side = anchor.half[axis] + own[axis], draw(st.sampled_from((1, -1)))
        if axis == facing:
            depth = 2 * limits["halfspace_scale"] * max(anchor.half[axis], d / 2)
            bound = draw(st.sampled_from((0, 0, d, -p, d / 2, -d, t, depth, 3 * d)))
            gap = draw(
                st.one_of(st.just(bound + draw(st.sampled_from((0, 0, 1, -1)))), st.integers(-200, 900))
            )
            offset.append(side * (whole + gap))
        else:
            flush, across = anchor.half[axis] - own[axis], whole
            bound = draw(st.sampled_from((0, flush, flush, flush - d, flush + d, flush - d / 2, across)))
            if bound == across:
                # The cross-sections share nothing, a corner, or just enough to count.
                bound -= draw(st.sampled_from((0, 0, d / 2, d / 2 + 1, d / 2 - 1, -d / 2)))
            free = st.integers(-round(whole) - 1, round(whole) + 1)
            offset.append(draw(st.one_of(st.just(side * bound), free)))
    return Block(anchor.at(*offset), half, anchor.yaw + yaw)


@st.composite
def standpoints(draw: st.DrawFn, blocks: Sequence[Block]) -> Point:
    """Return where a view is: anywhere, or square to, askew of, at the edge of, within or over a block."""
    if not blocks or draw(st.booleans()):
        x, y, z = (draw(st.integers(-6000, 6000)) for _ in range(3))
        return x / 1000, y / 1000, z / 1000
    block = draw(st.sampled_from(blocks))
    far, side = draw(st.integers(1, 5000)), draw(st.sampled_from((1, -1)))
    local = draw(
        st.sampled_from(
            (
                (far, 0),
                (0, far),
                (far, far),
                (far, -far),
                (block.half[0], far % 100),
                (far % 100, block.half[1]),
                (0, 0),
            )
        )
    )
    return block.at(side * local[0], side * local[1], 400)


@st.composite
def worlds(draw: st.DrawFn, least: int = 2, most: int = 5, views: int = 2, surfaces: bool = True) -> World:
    """Return a world of a few things, each near an earlier one, and some views of it."""
    limits = draw(st.sampled_from(LIMITS))
    turn = draw(yaws())
    base = Block((0.0, 0.0, 0.0), (0, 0, 0), turn)
    room = draw(st.sampled_from(ROOMS)) if surfaces else ()
    blocks = [
        replace(part, center=base.at(*(1000 * c for c in part.center)), yaw=part.yaw + turn) for part in room
    ]
    count = draw(st.integers(least, most))
    while len(blocks) < count:
        if blocks:
            blocks.append(draw(placed(draw(st.sampled_from(blocks)), limits)))
        else:
            blocks.append(Block((0.1, -0.2, 0.5), draw(st.tuples(EXTENTS, EXTENTS, EXTENTS)), turn))
    things = tuple(block.data(name) for block, name in zip(blocks, "abcdefgh", strict=False))
    seen = [
        {"id": f"v{number}", "label": "robot", "position": list(draw(standpoints(blocks))), "heading": 0.0}
        for number in range(views)
    ]
    return World(things, tuple(seen), {**dict(Thresholds().items()), **limits})
