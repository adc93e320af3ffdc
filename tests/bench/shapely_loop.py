"""The job as one would first write it: a loop over pairs, with shapely for the plan views."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
import shapely
from shapely.geometry import Polygon

from bench.job import Answers, Frame, Thing, frames, ordered, solid_things
from deixis.scene import Scene
from deixis.thresholds import SNAP, Thresholds

FAR = 1.0e4
"""Metres: longer than any scene."""

Corners = list[tuple[float, float]]


@dataclass(frozen=True)
class Solid:
    """A thing with its plan view, and its frame in each view that speaks of it."""

    thing: Thing
    corners: Corners
    plan: Polygon
    bottom: float
    top: float
    frames: dict[str, Frame] = field(default_factory=dict)


def answers(scene: Scene) -> Answers:
    """Return the answers to the job, pair by pair."""
    limits = scene.thresholds
    solids = [_solid(thing) for thing in solid_things(scene)]
    for view, index, frame in frames(scene):
        solids[index].frames[view] = frame
    views = ("world", *(view.id for view in scene.views))
    pairs, separation, volume, touches, contained, vertical = [], [], [], [], [], []
    sides: dict[str, list[list[bool]]] = {view: [] for view in views}
    for i, a in enumerate(solids):
        for j, b in enumerate(solids):
            if i == j:
                continue
            spoken = ordered(a.thing, b.thing)
            distance = _distance(a, b)
            if distance > (max(limits.closeness, b.thing.reach) if spoken else limits.closeness):
                continue
            measured, lateral, up, down = _separation(a, b, distance, limits)
            pairs.append((i, j))
            separation.append(measured)
            apart = round(measured, 9)
            height = min(a.top, b.top) - max(a.bottom, b.bottom)
            volume.append(a.plan.intersection(b.plan).area * height if apart < 0.0 else 0.0)
            touches.append(-limits.penetration <= apart <= limits.granularity)
            contained.append(apart < -limits.penetration and _sticks_out(a, b) <= limits.granularity)
            vertical.append(_vertical(a, b, apart, lateral, up, down, limits))
            for view in views:
                framed = b.frames.get(view) if spoken else None
                sides[view].append(_sides(a, b, framed, apart, limits) if framed else [False] * 4)
    return Answers(
        np.array(pairs, dtype=np.int64).reshape(-1, 2),
        np.array(separation),
        np.array(volume),
        np.array(touches, dtype=bool),
        np.array(contained, dtype=bool),
        np.array(vertical, dtype=bool).reshape(-1, 2),
        {view: np.array(rows, dtype=bool).reshape(-1, 4) for view, rows in sides.items()},
    )


def _solid(thing: Thing) -> Solid:
    corners = _rectangle(thing.x, thing.y, thing.yaw, -thing.hx, -thing.hy, thing.hx, thing.hy)
    return Solid(thing, corners, Polygon(corners), thing.z - thing.hz, thing.z + thing.hz)


def _rectangle(x: float, y: float, yaw: float, left: float, low: float, right: float, high: float) -> Corners:
    """Return the corners, in the world, of a rectangle given in a frame."""
    cos, sin = math.cos(yaw), math.sin(yaw)
    own = ((left, low), (right, low), (right, high), (left, high))
    return [(x + cos * u - sin * v, y + sin * u + cos * v) for u, v in own]


def _distance(a: Solid, b: Solid) -> float:
    """Return the distance of two solids: that of their plan views and that of their heights, combined."""
    return math.hypot(a.plan.distance(b.plan), max(b.bottom - a.top, a.bottom - b.top, 0.0))


def _separation(a: Solid, b: Solid, distance: float, limits: Thresholds) -> tuple[float, float, float, float]:
    """Return the signed separation, the overlap of the plan views, and the ways out up and down."""
    lateral = min(_overlap(a, b, side) for solid in (a, b) for side in (solid.thing.yaw, _across(solid)))
    # What lies within a container does not leave it through the bottom (decision 0004).
    content, container = _lies_in(a, b, limits), _lies_in(b, a, limits)
    up = math.inf if container and not content else b.top - a.bottom
    down = math.inf if content and not container else a.top - b.bottom
    return distance if distance > 0.0 else -min(lateral, up, down), lateral, up, down


def _lies_in(a: Solid, b: Solid, limits: Thresholds) -> bool:
    """Return whether a lies in b up to D, its middle at all; nothing lies in a surface."""
    inside = not b.thing.surface and _sticks_out(a, b) <= limits.granularity
    return inside and b.bottom + SNAP < a.thing.z < b.top - SNAP


def _across(solid: Solid) -> float:
    return solid.thing.yaw + math.pi / 2


def _overlap(a: Solid, b: Solid, direction: float) -> float:
    """Return by how much the shadows of two plan views on a line overlap, the shorter way out."""
    cos, sin = math.cos(direction), math.sin(direction)
    one, two = ([cos * x + sin * y for x, y in solid.corners] for solid in (a, b))
    return min(max(one) - min(two), max(two) - min(one))


def _sticks_out(a: Solid, b: Solid) -> float:
    """Return how far a sticks out of b."""
    cos, sin = math.cos(b.thing.yaw), math.sin(b.thing.yaw)
    out = max(a.top - b.top, b.bottom - a.bottom)
    for corner in a.corners:
        x, y = corner[0] - b.thing.x, corner[1] - b.thing.y
        out = max(out, abs(cos * x + sin * y) - b.thing.hx, abs(cos * y - sin * x) - b.thing.hy)
    return out


def _vertical(
    a: Solid, b: Solid, apart: float, lateral: float, up: float, down: float, limits: Thresholds
) -> list[bool]:
    """Return whether a is above b, and whether it is below."""
    d, deep = limits.granularity, apart < -limits.penetration
    depth = math.inf if b.thing.normal == 2 else 2.0 * limits.halfspace_scale * b.thing.hz
    found = []
    spans = ((a.bottom, a.top, b.top, up, down), (-a.top, -a.bottom, -b.bottom, down, up))
    for near, far, face, escape, other in spans:
        if not deep and apart <= d and math.isinf(escape):
            beyond = near >= face
        elif not deep and apart <= d:
            beyond = escape <= min(lateral, limits.penetration, other)
        else:
            beyond = far >= face + d or (not deep and near >= face - d)
        found.append(lateral >= 0.5 * d and beyond and near <= face + depth)
    return found


def _sides(a: Solid, b: Solid, frame: Frame, apart: float, limits: Thresholds) -> list[bool]:
    """Return which horizontal halfspaces of b, aligned with a frame, a meets."""
    d, deep = limits.granularity, apart < -limits.penetration
    level = min(a.top, b.top) - max(a.bottom, b.bottom) >= 0.5 * d
    found = []
    for axis, (along, across) in enumerate(((frame.hx, frame.hy), (frame.hy, frame.hx))):
        yaw = frame.yaw + axis * math.pi / 2
        width = across - 0.5 * d
        strip = Polygon(_rectangle(b.thing.x, b.thing.y, yaw, -FAR, -width, FAR, width))
        common = a.plan.intersection(strip)
        if not level or common.is_empty:
            found += [False, False]
            continue
        x, y = (shapely.get_coordinates(common) - (b.thing.x, b.thing.y)).T
        reached = math.cos(yaw) * x + math.sin(yaw) * y
        middle = math.cos(yaw) * (a.thing.x - b.thing.x) + math.sin(yaw) * (a.thing.y - b.thing.y)
        depth = math.inf if frame.normal == axis else 2.0 * limits.halfspace_scale * along
        for near, far, center in (
            (reached.min(), reached.max(), middle),
            (-reached.max(), -reached.min(), -middle),
        ):
            flush = not deep and near >= along - d and center >= 0.0
            found.append(bool((flush or far >= along + d) and near <= along + depth))
    return found
