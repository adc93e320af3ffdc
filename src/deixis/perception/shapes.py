"""Shapes: the region of a thing from its points, without what noise adds to its extent.

The extremes of a noisy cloud are noise: of a thousand points off by a centimetre one is off by three. So
along each axis of its box a thing reaches as far as the points that are beyond doubt: each counts less as
many of its standard errors, along that axis, as the extreme of many is worth. Silhouettes, which noise along
the ray does not move, lose nothing.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from deixis.boxes import min_bound_box
from deixis.frames import QUARTER, Array, Index, Mask
from deixis.pieces import one_piece
from deixis.regions import BoxRegion, MeshRegion, Region
from deixis.thresholds import Thresholds

DRAWN: Final = 2.0
"""Standard errors that a point counts less: about the greatest of the fifty or so independent ones."""

DIRECTIONS: Final = 120
"""Directions in space in which a hull is looked for, some twenty degrees apart."""

AROUND: Final = 72
"""Directions in the plan: of what a box's base hangs on, nothing may be lost."""

DECIMALS: Final = 4
"""Tenths of a millimetre: finer than any camera sees."""

CHUNK: Final = 1 << 10
"""Points looked at together."""

ENOUGH: Final = 2048
"""Points that tell the shape of a hull; how far it reaches all of them tell."""

SAMPLE: Final = 500
"""Points by which the sides of a box are told."""

TOP: Final = 0.025
"""Metres from the highest, and from the lowest, within which points are of the top or the underside."""

SIDES: Final = 0.8
"""Share of a box's flank that lies along its sides."""

FEW: Final = 60
"""Points of a flank that tell its shape."""

SLICES: Final = 8
"""Heights at which a round thing may have different radii."""

SLICE: Final = 0.01
"""Metres: the thinnest slice."""

SECTORS: Final = 24
"""Parts of a turn in which points of a round thing are looked for."""

ARC: Final = 0.4
"""Share of a turn that must be seen of a round thing."""

ROUND: Final = 0.06
"""Part of the radius by which most points may be off it."""

ROUGH: Final = 0.004
"""Metres: and at least this."""

WIDEST: Final = 0.5
"""Metres: the largest radius of a round thing that is completed."""

LARGER: Final = 1.15
"""How much more of the plan such a box may take than the hull's."""

OUT: Final = 1.25
"""Radii from the axis beyond which a point of the flank is no part of a round thing."""

FEW_OUT: Final = 0.02
"""Share of such points from which on they are a handle, and the thing is not round."""

CLEARLY: Final = 0.15
"""By how much larger that share must be than at the hull's own yaw."""


def _directions() -> Array:
    """Return unit vectors spread evenly over the sphere, then over the plan's circle."""
    turn = np.pi * (3.0 - np.sqrt(5.0)) * np.arange(DIRECTIONS)
    z = 1.0 - (2.0 * np.arange(DIRECTIONS) + 1.0) / DIRECTIONS
    ring = np.sqrt(1.0 - z * z)
    sphere = np.stack([ring * np.cos(turn), ring * np.sin(turn), z], axis=1)
    angle = 2.0 * np.pi * np.arange(AROUND) / AROUND
    circle = np.stack([np.cos(angle), np.sin(angle), np.zeros(AROUND)], axis=1)
    return np.concatenate([sphere, circle, [[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]]])


_DIRECTIONS: Final = _directions().astype(np.float32)


def corners(points: Array) -> Array:
    """Return the points that lie furthest in some hundred directions, (k, 3): what the hull hangs on.

    Examples
    --------
    >>> corners(np.array([[0, 0, 0], [1, 0, 0], [0.5, 0.1, 0.2], [1, 1, 0], [0, 1, 0], [0, 0, 1.0]])).shape
    (5, 3)
    """
    points = points[:: -(-len(points) // ENOUGH)]
    middle = points.mean(axis=0)
    best = np.zeros(len(_DIRECTIONS), dtype=np.int64)
    most = np.full(len(_DIRECTIONS), -np.inf, dtype=np.float32)
    rows = np.arange(len(_DIRECTIONS))
    toward_x, toward_y, toward_z = (column[:, None] for column in _DIRECTIONS.T)
    for start in range(0, len(points), CHUNK):
        # Not by a matrix product, whose threads wait for each other longer than this takes.
        x, y, z = (points[start : start + CHUNK] - middle).T.astype(np.float32)
        along = toward_x * x + toward_y * y + toward_z * z
        here = along.argmax(axis=1)
        value = along[rows, here]
        better = value > most
        best[better], most[better] = here[better] + start, value[better]
    return np.asarray(points[np.unique(best)])


def hull(points: Array) -> tuple[Array, Index] | None:
    """Return the convex hull of points as vertices (m, 3) and triangles (k, 3), or None where it is flat."""
    from scipy.spatial import ConvexHull, QhullError

    if len(points) < 4:
        return None
    try:
        found = ConvexHull(points)
    except QhullError:
        return None
    vertices, faces = np.unique(found.simplices, return_inverse=True)
    faces = faces.reshape(-1, 3)
    # Qhull's triangles look either way: outwards they shall.
    a, b, c = points[vertices][faces].transpose(1, 0, 2)
    inwards = (np.cross(b - a, c - a) * found.equations[:, :3]).sum(axis=1) < 0.0
    faces[inwards] = faces[inwards][:, ::-1]
    return points[vertices], faces.astype(np.int64)


def region_of(points: Array, wobble: Array, limits: Thresholds) -> tuple[Region, str]:
    """Return a thing's region from its points, and a note on those left out.

    It is the convex hull, as a mesh, of the points in one piece; their box where they are flat, or where
    they lie along the sides of a box that the hull does not tell: of a box seen from the front and one side
    the plan is a triangle. Of a round thing it is the hull with the side that was not seen.

    Parameters
    ----------
    points : (n, 3) float
        Metres, world frame, n >= 1.
    wobble : (n, 3) float
        By how much noise moves each point: one standard error along its ray, metres.
    limits : Thresholds
    """
    keep, note = one_piece(points, max(limits.piece_gap, limits.granularity))
    if keep is not None:
        points, wobble = points[keep], wobble[keep]
    flank = _flank(points)
    axis, lone = upright_axis(points, flank)
    if axis is not None:
        points, wobble = points[~lone], wobble[~lone]
    outer = corners(points)
    if axis is not None:
        # The same from the other side.
        outer = np.concatenate([outer, [*2.0 * axis, 0.0] + outer * [-1.0, -1.0, 1.0]])
    yaw = min_bound_box(outer)[2]
    better = along_sides(flank, yaw) if axis is None else None
    yaw = yaw if better is None else better
    cos, sin = np.cos(yaw), np.sin(yaw)
    turn = np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])
    low, high = _beyond_doubt(points @ turn, np.abs(wobble @ turn))
    if axis is not None:
        spoke = points[:, :2] - axis
        length = np.maximum(np.hypot(spoke[:, 0], spoke[:, 1]), 1.0e-9)
        radius = _beyond_doubt(
            length[:, None], np.abs((wobble[:, :2] * spoke).sum(axis=1) / length)[:, None]
        )[1]
        low[:2], high[:2] = axis @ turn[:2, :2] - radius, axis @ turn[:2, :2] + radius
    middle = turn @ (0.5 * (low + high))
    solid = hull(_fitted(outer @ turn, low, high) @ turn.T) if better is None else None
    if solid is None:
        return BoxRegion(np.round(middle, DECIMALS), np.round(high - low, DECIMALS), yaw), note
    return MeshRegion(np.round(solid[0], DECIMALS), solid[1]), note


def _beyond_doubt(own: Array, error: Array) -> tuple[Array, Array]:
    """Return how far a cloud reaches along each axis, down and up, beyond the doubt of its points."""
    low = (own + DRAWN * error).min(axis=0)
    high = (own - DRAWN * error).max(axis=0)
    if (low < high).all():
        return low, high
    middle = np.median(own, axis=0)
    return np.where(low < high, low, middle), np.where(low < high, high, middle)


def _fitted(own: Array, low: Array, high: Array) -> Array:
    """Return points stretched along each axis to reach from one end to the other."""
    least, most = own.min(axis=0), own.max(axis=0)
    scale = (high - low) / np.maximum(most - least, 1.0e-9)
    return np.asarray((own - least) * scale + low)


def along_sides(flank: Array, yaw: float) -> float | None:
    """Return another yaw at which many more points of a flank lie along the sides of their box, or None."""
    if len(flank) < FEW:
        return None
    plan = flank[:, :2] - flank[:, :2].mean(axis=0)
    angle = np.append(np.radians(np.arange(0.0, 90.0, 2.0)), yaw)
    cos, sin = np.cos(angle)[:, None], np.sin(angle)[:, None]
    x, y = plan.T
    along, across = cos * x + sin * y, cos * y - sin * x
    gaps = np.full(along.shape, np.inf)
    smallest, area = np.full(len(angle), np.inf), np.ones(len(angle))
    for one in (along, across):
        low, high = np.quantile(one, [0.01, 0.99], axis=1)
        gaps = np.minimum(gaps, np.minimum(np.abs(one - low[:, None]), np.abs(high[:, None] - one)))
        smallest, area = np.minimum(smallest, high - low), area * (high - low)
    close = np.maximum(0.1 * smallest, 0.01)
    share = (gaps <= close[:, None]).mean(axis=1)
    best = int(np.where(area <= LARGER * area[-1], share, 0.0).argmax())
    turned = abs((angle[best] - yaw + QUARTER / 2.0) % QUARTER - QUARTER / 2.0)
    clear = share[best] >= SIDES and share[best] >= share[-1] + CLEARLY and turned > np.radians(5.0)
    return float(angle[best]) if clear else None


def _flank(points: Array) -> Array:
    """Return some of the points, without those of a top or of an underside, which say nothing of sides."""
    some = points[:: max(1, len(points) // SAMPLE)]
    low, high = np.quantile(some[:, 2], [0.02, 0.98])
    margin = min(TOP, 0.25 * float(high - low))
    return np.asarray(some[(some[:, 2] > low + margin) & (some[:, 2] < high - margin)])


def upright_axis(points: Array, flank: Array) -> tuple[Array | None, Mask]:
    """Return the upright axis that a thing is round about, (2,) metres in the plan, or None where it is not.

    Beside it, which points are none of such a thing: a few of its flank that are far out.

    At each height all points of a round thing are as far from the axis; the squares of their distances from
    the origin are then linear in the plan, with a constant for each height: least squares tell the axis.
    """
    lone = np.zeros(len(points), dtype=np.bool_)
    if len(flank) < FEW:
        return None, lone
    middle = flank[:, :2].mean(axis=0)
    plan = flank[:, :2] - middle
    low, high = flank[:, 2].min(), flank[:, 2].max()
    level = np.minimum(((flank[:, 2] - low) / max((high - low) / SLICES, SLICE)).astype(np.int64), SLICES - 1)
    count = np.maximum(np.bincount(level, minlength=SLICES), 1)

    def centred(value: Array) -> Array:
        return np.asarray(value - (np.bincount(level, value, SLICES) / count)[level])

    x, y, square = centred(plan[:, 0]), centred(plan[:, 1]), centred((plan * plan).sum(axis=1))
    matrix = np.array([[x @ x, x @ y], [x @ y, y @ y]])
    if np.linalg.det(matrix) < 1.0e-12 * np.trace(matrix) ** 2:
        return None, lone
    axis = 0.5 * np.linalg.solve(matrix, np.array([x @ square, y @ square]))
    spoke = plan - axis
    radius = np.hypot(spoke[:, 0], spoke[:, 1])
    off = np.abs(centred(radius))
    size = float(np.quantile(radius, 0.9))
    most = max(ROUND * size, ROUGH)
    sector = ((np.arctan2(spoke[:, 1], spoke[:, 0]) + np.pi) * (SECTORS / (2.0 * np.pi))).astype(
        np.int64
    ) % SECTORS
    seen = np.bincount(sector, minlength=SECTORS)
    # In every direction, for the legs of a square table are all as far from its middle.
    good = np.bincount(sector, off <= most, SECTORS) >= 0.6 * seen
    round_ = float(np.quantile(off, 0.8)) <= most and size <= WIDEST and good[seen > 0].mean() >= 0.85
    level_with = (points[:, 2] >= low) & (points[:, 2] <= high)
    lone = level_with & (np.hypot(*(points[:, :2] - middle - axis).T) > OUT * size)
    round_ = round_ and np.count_nonzero(lone) <= FEW_OUT * len(points)
    return (middle + axis if round_ and np.count_nonzero(seen) >= ARC * SECTORS else None), lone
