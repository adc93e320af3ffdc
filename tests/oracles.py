"""Second opinions on geometry: point sets, counted and compared without any closed form.

A region is what it is in the paper: the points of a lattice. Everything here is found by looking at points
(or, for the way out of an overlap, by trying directions), so it is exact up to a part of the pitch, and the
tolerances say which. The readings of the axioms (decisions 0001, 0004, 0009, 0010) are written anew.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from bench.job import Frame, Thing
from deixis.frames import Array, Mask
from deixis.scene import BoxRegion, Label, Scene, SpatialObject, View
from deixis.thresholds import SNAP, Thresholds

PITCH = 0.005
"""Metres between points of a lattice: a quarter of the default D."""

DISTANCE_TOLERANCE = math.sqrt(2.0) * PITCH
"""The nearest points of two faces are each half a lattice square's diagonal from a lattice point, at most."""

DEPTH_TOLERANCE = 0.001
"""Directions are tried every quarter of a degree, on things of less than half a metre."""

SIDE_TOLERANCE = 2.0 * PITCH
"""Halfspaces: a point's place in a lattice, along and across."""

PART = 0.3
"""Points adjacent to inter are compared where one count is smaller than the other by more than this part."""

_RING = np.linspace(0.0, 2.0 * math.pi, 1440, endpoint=False)
_LEVEL = np.column_stack([np.cos(_RING), np.sin(_RING), np.zeros_like(_RING)])
"""Directions parallel to the floor."""


def _slanted(count: int = 500) -> Array:
    """Return directions spread evenly over the sphere."""
    turn = math.pi * (1.0 + math.sqrt(5.0)) * np.arange(count)
    z = 1.0 - (2.0 * np.arange(count) + 1.0) / count
    flat = np.sqrt(1.0 - z * z)
    return np.column_stack([flat * np.cos(turn), flat * np.sin(turn), z])


_DIRECTIONS = np.concatenate([_LEVEL, [[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]], _slanted()])


def scenes(count: int, seed: int = 0, together: int = 100) -> Iterator[Scene]:
    """Yield scenes of random pairs of things, each well away from the next: figure, reference, figure ...

    Blocks, rods, sheets; walls and floors as references; apart, in contact, overlapping, one in the other.
    """
    rng = np.random.default_rng(seed)
    for start in range(0, count, together):
        listed: list[SpatialObject] = []
        for pair in range(min(together, count - start)):
            place = np.array([5.0 * (pair % 10), 5.0 * (pair // 10), 1.0])
            listed += _pair(rng, f"{start + pair}", place)
        views = (View("robot", "robot", np.append(rng.uniform(0.0, 45.0, 2), 0.4)),)
        yield Scene(f"pairs-{start}", tuple(listed), views)


def _pair(rng: np.random.Generator, name: str, place: Array) -> list[SpatialObject]:
    half = np.sort(rng.uniform(0.01, 0.12, (2, 3)), axis=0)[:, rng.permutation(3)]
    if rng.random() < 0.15:
        half[0, rng.integers(3)] = rng.choice([0.0, 0.0005, 0.004])
    surface = bool(rng.random() < 0.15)
    if surface:
        half[1] *= 1.5
        half[1, rng.integers(3)] = rng.choice([0.0, 0.002, 0.01])
    elif half[0].prod() > half[1].prod():
        half = half[::-1]
    yaw = rng.uniform(-math.pi, math.pi, 2)
    room = half[1] + half[0] + rng.choice([0.0, 0.03, 0.3])
    aside = rng.uniform(-1.0, 1.0, 3) * np.where(rng.random(3) < 0.3, np.abs(half[1] - half[0]), room)
    if rng.random() < 0.2:
        # About where a halfspace ends, or begins.
        axis = rng.integers(3)
        face = half[1, axis] + half[0, axis]
        aside *= 0.7
        aside[axis] = rng.choice([-1.0, 1.0]) * (
            face + (rng.choice([0.0, 2.4]) + rng.uniform(-0.4, 0.4)) * half[1, axis]
        )
    cos, sin = math.cos(yaw[1]), math.sin(yaw[1])
    shift = np.array([cos * aside[0] - sin * aside[1], sin * aside[0] + cos * aside[1], aside[2]])
    label = (Label("thing"),)
    return [
        SpatialObject(f"a{name}", label, "object", BoxRegion(place + shift, 2.0 * half[0], yaw[0])),
        SpatialObject(
            f"b{name}", label, "surface" if surface else "object", BoxRegion(place, 2.0 * half[1], yaw[1])
        ),
    ]


@dataclass(frozen=True)
class Seen:
    """What point sets say of a figure and a reference, lengths in metres and volumes in cubic metres."""

    separation: float
    contained: bool
    volume: float
    frontier: tuple[float, float]
    vertical: tuple[bool, bool]
    sides: dict[str, list[bool]]


def look(a: Thing, b: Thing, frames: dict[str, Frame], limits: Thresholds) -> Seen:
    """Return what point sets say of a figure a and a reference b, given b's frame in each view."""
    # Near the origin, or the lattice's own rounding would count.
    a = a._replace(x=a.x - b.x, y=a.y - b.y, z=a.z - b.z)
    b = b._replace(x=0.0, y=0.0, z=0.0)
    d = limits.granularity
    held, holds = _within(_corners(a), b, d).all(), _within(_corners(b), a, d).all()
    content = bool(held and not b.surface and abs(a.z) < b.hz - SNAP)
    container = bool(holds and not a.surface and abs(a.z) < a.hz - SNAP)
    bottom_closed, top_closed = content and not container, container and not content
    parting = _parting(a, b, bottom_closed, top_closed)
    apart = -parting if parting > 0.0 else _distance(a, b)
    inter, volume = _common(a, b)
    frontier = (_adjacent(a, b, inter, d), _adjacent(b, a, inter, d)) if len(inter) else (0.0, 0.0)
    deep = apart < -limits.penetration
    return Seen(
        apart,
        bool(deep and held),
        volume,
        frontier,
        _vertical(a, b, apart, bottom_closed, top_closed, limits),
        {view: _sides(a, b, frame, deep, limits) for view, frame in frames.items()},
    )


def _axis(half: float, pitch: float = PITCH) -> Array:
    """Return points from end to end, at most a pitch apart."""
    return np.linspace(-half, half, 1 + math.ceil(2.0 * half / pitch))


def _to_world(points: Array, thing: Thing) -> Array:
    cos, sin = math.cos(thing.yaw), math.sin(thing.yaw)
    x, y, z = points.T
    return np.column_stack([thing.x + cos * x - sin * y, thing.y + sin * x + cos * y, thing.z + z])


def _corners(thing: Thing) -> Array:
    ends = [(-half, half) for half in (thing.hx, thing.hy, thing.hz)]
    return _to_world(np.stack(np.meshgrid(*ends), axis=-1).reshape(-1, 3), thing)


def _shell(thing: Thing) -> Array:
    """Return the points of a lattice on the thing's surface."""
    grid = np.stack(np.meshgrid(*map(_axis, thing[3:6]), indexing="ij"), axis=-1)
    inner = np.zeros(grid.shape[:3], dtype=bool)
    inner[1:-1, 1:-1, 1:-1] = True
    return _to_world(grid[~inner], thing)


def _within(points: Array, thing: Thing, grown: float = 0.0) -> Mask:
    """Return which points lie in a thing, or no farther out than it is grown by."""
    cos, sin = math.cos(thing.yaw), math.sin(thing.yaw)
    x, y, z = (points - thing[:3]).T
    within = np.abs(cos * x + sin * y) <= thing.hx + grown
    within &= np.abs(cos * y - sin * x) <= thing.hy + grown
    within &= np.abs(z) <= thing.hz + grown
    return np.asarray(within)


def _distance(a: Thing, b: Thing) -> float:
    one, two = sorted((_shell(a), _shell(b)), key=len)
    return float(_tree(two).query(one)[0].min())


def _tree(points: Array) -> cKDTree:
    """Return an index that is quick to build: it is asked once."""
    return cKDTree(points, balanced_tree=False, compact_nodes=False)


def _parting(a: Thing, b: Thing, bottom_closed: bool, top_closed: bool) -> float:
    """Return the least translation of a, of all directions tried, that parts it from b; negative if apart."""
    allowed = _DIRECTIONS
    if bottom_closed:
        allowed = allowed[allowed[:, 2] >= 0.0]
    if top_closed:
        allowed = allowed[allowed[:, 2] <= 0.0]
    return _way_out(a, b, allowed)


def _way_out(a: Thing, b: Thing, directions: Array) -> float:
    return float(((directions @ _corners(b).T).max(axis=1) - (directions @ _corners(a).T).min(axis=1)).min())


def _cells(thing: Thing) -> tuple[Array, float]:
    """Return the middles of the cells of a lattice that fills a thing, and the volume of a cell."""
    axes, volume = [], 1.0
    for half in thing[3:6]:
        edges = _axis(half)
        axes.append(0.5 * (edges[1:] + edges[:-1]) if len(edges) > 1 else edges)
        volume *= 2.0 * half / len(axes[-1])
    return _to_world(np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3), thing), volume


def _common(a: Thing, b: Thing) -> tuple[Array, float]:
    """Return points of inter, none thinner than D, and its volume as the two are."""
    cells, volume = _cells(a)
    shared = float(_within(cells, b).sum()) * volume
    thick_cells, _ = _cells(_thick(a))
    return thick_cells[_within(thick_cells, _thick(b))], shared


def _thick(thing: Thing, granularity: float = Thresholds().granularity) -> Thing:
    least = 0.5 * granularity
    return thing._replace(hx=max(thing.hx, least), hy=max(thing.hy, least), hz=max(thing.hz, least))


def _adjacent(a: Thing, b: Thing, inter: Array, granularity: float) -> float:
    """Return the volume of a's points outside b that are no more than D from a point of inter."""
    cells, volume = _cells(_thick(a))
    other = _thick(b)
    # Points farther out, or deeper in, have no part in it: left out only to be quick.
    around = cells[_within(cells, other, granularity) & ~_within(cells, other)]
    edge = inter[~_within(inter, other, -1.01 * granularity)]
    if not len(around) or not len(edge):
        return 0.0
    near = _tree(edge).query(around, distance_upper_bound=granularity)[0] <= granularity
    return float(near.sum()) * volume


def _vertical(
    a: Thing, b: Thing, apart: float, bottom_closed: bool, top_closed: bool, limits: Thresholds
) -> tuple[bool, bool]:
    """Return whether a is above b, and whether it is below."""
    d, p = limits.granularity, limits.penetration
    lateral = _way_out(_thick(a), _thick(b), _LEVEL)
    deep, contact = apart < -p, -p <= apart <= d
    height_a, height_b = a.z + _axis(a.hz), b.z + _axis(b.hz)
    up, down = height_b.max() - height_a.min(), height_a.max() - height_b.min()
    found = []
    for sign, closed, escape, other in (
        (1.0, top_closed, up, math.inf if bottom_closed else down),
        (-1.0, bottom_closed, down, math.inf if top_closed else up),
    ):
        near, far = (sign * height_a).min(), (sign * height_a).max()
        face = (sign * height_b).max()
        depth = math.inf if b.normal == 2 else 2.0 * limits.halfspace_scale * max(b.hz, 0.5 * d)
        if contact and closed:
            beyond = near >= face
        elif contact:
            beyond = escape <= min(lateral, p, other)
        else:
            beyond = far >= face + d or (not deep and near >= face - d)
        found.append(bool(lateral >= 0.5 * d and beyond and near <= face + depth))
    return found[0], found[1]


def _sides(a: Thing, b: Thing, frame: Frame, deep: bool, limits: Thresholds) -> list[bool]:
    """Return whether a meets the halfspaces X+, X-, Y+, Y- of b aligned with a frame."""
    d = limits.granularity
    wide, a = _thick(b), _thick(a)
    found = []
    heights = _axis(wide.hz - 0.5 * d)
    level = (np.abs(heights - (a.z - b.z)) <= a.hz).any() or abs(a.z - b.z) <= a.hz + heights[-1]
    for axis, (half, other) in enumerate(((frame.hx, frame.hy), (frame.hy, frame.hx))):
        # A lattice of the strip itself, so that its borders are sharp.
        yaw = frame.yaw + axis * math.pi / 2
        cos, sin = math.cos(yaw), math.sin(yaw)
        middle = cos * a.x + sin * a.y
        size = math.hypot(a.hx, a.hy)
        along = middle + _axis(size)
        across = _axis(max(other, 0.5 * d) - 0.5 * d)
        u, v = (grid.ravel() for grid in np.meshgrid(along, across))
        points = np.column_stack([cos * u - sin * v, sin * u + cos * v, np.full(len(u), a.z)])
        reached = u[_within(points, a)]
        depth = math.inf if frame.normal == axis else 2.0 * limits.halfspace_scale * max(half, 0.5 * d)
        for sign in (1.0, -1.0):
            if not level or not len(reached):
                found.append(False)
                continue
            near, far = (sign * reached).min(), (sign * reached).max()
            flush = not deep and near >= half - d and sign * middle >= 0.0
            found.append(bool((flush or far >= half + d) and near <= half + depth))
    return found
