"""Cavities: what lies in the hollow of a thing, and how deep, and what lies within its matter.

A hollow thing contains what lies within its hull with some of its own matter beneath it: a pencil in a mug,
not a box under a table. And with its matter all around, or a cat on a chair would be in the chair
(decision 0017).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Final
from weakref import WeakKeyDictionary

import numpy as np

from deixis.frames import Array, Mask
from deixis.solids.profiles import CellProfile, cell_width
from deixis.solids.sampling import Single
from deixis.solids.solid import Pose, Solid
from deixis.thresholds import Thresholds

WAYS: Final = 16
"""Level directions in which one looks around, evenly spread."""

_ANGLES: Final = tuple(2.0 * math.pi * number / WAYS for number in range(WAYS))

AROUND: Final = 14
"""With matter in so many of them a place is in a hollow that is open above: a bowl with a spout."""

ROOFED: Final = 9
"""With matter above as well, so many are enough: a cupboard without its door."""

_CELLS: Final = 96
"""The most cells along a side of the grid that tells what is within matter."""

_SKIN: Final = 1.0e-3
"""Metres: what is nearer than this to a hull may be within it."""

_SLOPE: Final = 1.0e-6
"""A plane that faces a direction by less does not stop what moves along it."""

_PLACES: Final = 24
"""The most places along a side of the box in which a hollow is looked for."""

_MOST: Final = 256
"""Points looked at on their way out sideways."""


@dataclass(frozen=True, slots=True)
class _Hollow:
    """A solid as seen from within: from below, and along level lines of half as many directions as ways."""

    column: CellProfile
    rows: tuple[tuple[float, float, CellProfile], ...]


_HOLLOWS: WeakKeyDictionary[Solid, _Hollow] = WeakKeyDictionary()
_IS_HOLLOW: WeakKeyDictionary[Solid, bool] = WeakKeyDictionary()
_GRIDS: WeakKeyDictionary[Solid, _Grid] = WeakKeyDictionary()


def dip(content: Solid, container: Solid, pose: Pose, limits: Thresholds) -> tuple[float, bool]:
    """Return how deep a content dips into the hollow of a container, and whether the least way out is up.

    The depth is the least translation that brings it out of the container's hull, up or sideways, through
    an opening where there is one. The bottom is no way out (decision 0004). The content's lowest part has
    to be in the hollow, or no more than D over its opening.

    Parameters
    ----------
    content, container : Solid
    pose : Pose
        The content's in the container's frame.
    limits : Thresholds

    Returns
    -------
    depth : float
        Metres; negative over the opening, minus infinity where the content is not in it at all.
    up : bool
        Whether the way is up; if not, it is sideways.
    """
    hull, granularity = container.hull, limits.granularity
    corners = pose.place(content.hull.corners)
    lowest = corners[corners[:, 2].argmin()]
    # Its lowest part is where it lies: that has to be over the container, above its bottom.
    if (lowest > hull.high + granularity).any() or (lowest < hull.low - granularity).any():
        return -np.inf, True
    points = pose.place(content.probes.within(*pose.back.around(hull, granularity)).points)
    inside = ((points <= hull.high + granularity) & (points >= hull.low - granularity)).all(axis=1)
    points = points[inside]
    if not len(points):
        return -np.inf, True
    top = _top(container, points)
    # What is over the opening is looked up a little below it: is there a hollow to be over?
    within = points.copy()
    below = min(2.0 * granularity, 0.5 * float(hull.high[2] - hull.low[2]))
    within[:, 2] = np.minimum(points[:, 2], top - np.float32(below))
    enclosed, walls = _enclosed(container, within)
    inside = (points[:, 2] <= top + granularity) & enclosed
    if not inside.any():
        return -np.inf, True
    points, top, walls = points[inside], top[inside], walls[inside]
    if points[:, 2].min() > corners[:, 2].min() + granularity:
        return -np.inf, True
    up = float((top - points[:, 2]).max())
    if up <= 0.0:
        return up, True
    level = _level_ways(container, points)
    if level.min() <= granularity:
        # Along the hull's side: in the wall, or at it, but not in the hollow.
        return -np.inf, True
    ways = np.array([*level, up])
    # A way that most of it would have to go through a wall is none, as long as there is another.
    open_ways = walls.mean(axis=0) < 0.5
    if open_ways.any():
        ways = np.where(open_ways, ways, np.inf)
    return float(ways.min()), bool(ways[-1] <= ways.min())


def is_hollow(solid: Solid) -> bool:
    """Return whether a solid that does not fill its hull has a hollow that something could lie in."""
    found = _IS_HOLLOW.get(solid)
    if found is None:
        low, high = solid.hull.low, solid.hull.high
        count = np.clip((high - low) / solid.granularity, 1, _PLACES).astype(np.int64)
        axes = [np.linspace(low[k], high[k], 2 * count[k] + 1)[1::2] for k in range(3)]
        places = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3).astype(np.float32)
        found = _IS_HOLLOW[solid] = bool(_enclosed(solid, places)[0].any())
    return found


def _top(container: Solid, points: Single) -> Single:
    """Return the height of the hull's upper side over or under points, metres, (q,)."""
    planes = container.hull.planes.astype(np.float32)
    planes = planes[planes[:, 2] > _SLOPE]
    heights = -(points[:, :2] @ planes[:, :2].T + planes[:, 3]) / planes[:, 2]
    return np.asarray(heights.min(axis=1))


def _level_ways(container: Solid, points: Single) -> Array:
    """Return how far points have to move to leave the hull, in each of the level directions, metres."""
    planes = container.hull.planes.astype(np.float32)
    points = points[:: len(points) // _MOST + 1]
    depth = np.maximum(-(points @ planes[:, :3].T + planes[:, 3]), 0.0)
    ways = np.empty(WAYS)
    for number, angle in enumerate(_ANGLES):
        facing = planes[:, 0] * np.cos(angle) + planes[:, 1] * np.sin(angle)
        ahead = facing > _SLOPE
        ways[number] = (depth[:, ahead] / facing[ahead]).min(axis=1).max()
    return ways


def _enclosed(container: Solid, points: Single) -> tuple[Mask, Mask]:
    """Return which points lie in the hull with the container's matter beneath and around them, (q,).

    What lies within that matter is in no hollow. Besides, (q, 17): in which level directions there is
    matter, and whether there is above.
    """
    found = np.asarray(container.hull.depth(points) >= -_SKIN)
    walls = np.zeros((len(points), WAYS + 1), dtype=np.bool_)
    if container.convex or not found.any():
        return found, walls
    hollow = _hollow(container)
    x, y, z = points[found].T
    # Matter no wider than D, such as a handle, is nothing to lie on; nor what is nearer than cells can tell.
    fine = container.samples.spacing <= 0.5 * container.granularity
    aside = 0.5 * container.granularity if fine else cell_width(container)
    beneath = np.ones(len(x), dtype=np.bool_)
    for shift_x, shift_y in ((0.0, 0.0), (aside, 0.0), (-aside, 0.0), (0.0, aside), (0.0, -aside)):
        first, _ = hollow.column.at(x + np.float32(shift_x), y + np.float32(shift_y))
        beneath &= first <= z + container.granularity
    seen = np.empty((len(x), WAYS + 1), dtype=np.bool_)
    seen[:, WAYS] = hollow.column.at(x, y)[1] > z + container.granularity
    for number, (cos, sin, row) in enumerate(hollow.rows):
        along = cos * x + sin * y
        # A little higher up: the board that a thing lies on is all around its underside.
        first, last = row.at(cos * y - sin * x, z + np.float32(container.granularity))
        seen[:, number], seen[:, number + WAYS // 2] = last > along, first < along
    walls[found] = seen
    blocked = seen[:, :WAYS].sum(axis=1)
    around = (blocked >= AROUND) | (seen[:, WAYS] & (blocked >= ROOFED))
    found[found] = beneath & around & ~_grid(container).holds(points[found])
    return found, walls


def _hollow(container: Solid) -> _Hollow:
    found = _HOLLOWS.get(container)
    if found is None:
        x, y, z = container.samples.points.T
        cell = cell_width(container)
        rows = []
        for angle in _ANGLES[: WAYS // 2]:
            cos, sin = float(np.cos(angle)), float(np.sin(angle))
            rows.append((cos, sin, CellProfile.of(cos * y - sin * x, z, cos * x + sin * y, cell)))
        found = _HOLLOWS[container] = _Hollow(CellProfile.of(x, y, z, cell), tuple(rows))
    return found


@dataclass(frozen=True, slots=True)
class _Grid:
    """Cells that lie within the matter of a mesh: walled in by cells that its surface runs through."""

    low: Array
    cell: float
    within: Any

    @classmethod
    def of(cls, solid: Solid) -> _Grid:
        """Return the grid of a solid."""
        from scipy.ndimage import binary_fill_holes

        points = solid.samples.points
        low, high = points.min(axis=0), points.max(axis=0)
        cell = max(cell_width(solid), float((high - low).max()) / _CELLS)
        at = ((points - low) / cell).astype(np.int64)
        taken = np.zeros(tuple(at.max(axis=0) + 1), dtype=np.bool_)
        taken[tuple(at.T)] = True
        return cls(low.astype(np.float64), cell, binary_fill_holes(taken) & ~taken)

    def holds(self, points: Single) -> Mask:
        """Return which points lie in cells within matter, (q,)."""
        at = np.floor((points - self.low) / self.cell).astype(np.int64)
        found = ((at >= 0) & (at < self.within.shape)).all(axis=1)
        found[found] = self.within[tuple(at[found].T)]
        return np.asarray(found)


def _grid(solid: Solid) -> _Grid:
    found = _GRIDS.get(solid)
    if found is None:
        found = _GRIDS[solid] = _Grid.of(solid)
    return found


def matter_depth(solid: Solid, points: Single) -> Single:
    """Return how deep points lie within the matter of a solid, metres, (q,); 0 for those outside.

    Of a mesh that is not convex it is an estimate: what lies in cells that its surface runs through counts
    as outside, so that the walls of a mug have no depth.
    """
    if solid.convex:
        return np.maximum(solid.hull.depth(points), 0.0)
    grid = _grid(solid)
    result = np.zeros(len(points), dtype=np.float32)
    inside = grid.holds(points)
    if inside.any():
        result[inside] = solid.tree.query(points[inside])[0]
    return result
