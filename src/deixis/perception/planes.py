"""Planes: level and upright ones found in a cloud by random sampling (RANSAC), fitted by least squares.

Which way is up is known, so of the planes through three random points only those are tried that are
nearly level or nearly upright. The one with the most points is fitted anew to all its points, taken out,
and the rest is searched again.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from deixis.frames import Array, Index, Mask
from deixis.regions import LEVEL_WITHIN

TRIPLES: Final = 4096
"""Sets of three points drawn for each plane."""

TRIED: Final = 192
"""Planes through them that are compared."""

SAMPLE: Final = 1200
"""Points they are compared with."""

MOST: Final = 24
"""Planes that are looked for in one cloud."""

_SIN: Final = float(np.sin(np.radians(LEVEL_WITHIN)))
_COS: Final = float(np.cos(np.radians(LEVEL_WITHIN)))


@dataclass(frozen=True, slots=True)
class Plane:
    """A plane, and the points of a cloud that lie on it.

    Attributes
    ----------
    normal : (3,) float
        Of length one.
    offset : float
        Metres: points p of the plane have ``normal @ p == offset``.
    members : (m,) int
        Positions in the cloud.
    level : bool
        Nearly level, else nearly upright.
    """

    normal: Array
    offset: float
    members: Index
    level: bool


def find_planes(points: Array, within: float, least: int, seed: int = 0) -> list[Plane]:
    """Return the level and upright planes of a cloud, the one with the most points first.

    Parameters
    ----------
    points : (n, 3) float
        Metres, world frame.
    within : float
        Metres from a plane within which a point lies on it.
    least : int
        Points that make a plane.
    seed : int
        Of the random choice: the same cloud has the same planes.

    Examples
    --------
    >>> x, y = np.meshgrid(np.arange(20.0), np.arange(20.0))
    >>> floor = np.stack([x.ravel(), y.ravel(), np.full(400, 0.5)], axis=1)
    >>> [(plane.level, float(plane.offset * plane.normal[2])) for plane in find_planes(floor, 0.01, 100)]
    [(True, 0.5)]
    """
    rng = np.random.default_rng(seed)
    found: list[Plane] = []
    left = np.arange(len(points))
    while len(left) >= least and len(found) < MOST:
        some = points[left]
        plane = _best(some, within, rng)
        if plane is None:
            break
        fitted = _fitted(some, *plane, within)
        if fitted is None:
            break
        normal, offset, inside = fitted
        if np.count_nonzero(inside) < least:
            break
        found.append(Plane(normal, offset, left[inside], bool(abs(normal[2]) > _COS)))
        left = left[~_within(some, normal, offset, 2.0 * within)]
    return found


def _within(points: Array, normal: Array, offset: float, within: float) -> Mask:
    return np.asarray(np.abs(points @ normal - offset) <= within)


def _best(points: Array, within: float, rng: np.random.Generator) -> tuple[Array, float] | None:
    """Return the plane through three of the points that most of a sample lie on."""
    corner = points[rng.integers(0, len(points), (3, TRIPLES))]
    normal = np.cross(corner[1] - corner[0], corner[2] - corner[0])
    length = np.linalg.norm(normal, axis=1)
    spread = length > 1.0e-6
    normal = normal[spread] / length[spread, None]
    start = corner[0][spread]
    rise = np.abs(normal[:, 2])
    usable = np.flatnonzero((rise > _COS) | (rise < _SIN))[:TRIED]
    if len(usable) == 0:
        return None
    normal, start = normal[usable], start[usable]
    offset = (normal * start).sum(axis=1)
    sample = points[rng.integers(0, len(points), SAMPLE)] if len(points) > SAMPLE else points
    # Not by a matrix product, whose threads wait for each other longer than this takes.
    x, y, z = sample.T.astype(np.float32)
    a, b, c, d = np.column_stack([normal, offset]).T.astype(np.float32)[:, :, None]
    votes = np.count_nonzero(np.abs(a * x + b * y + c * z - d) <= within, axis=1)
    best = int(votes.argmax())
    return normal[best], float(offset[best])


def _fitted(points: Array, normal: Array, offset: float, within: float) -> tuple[Array, float, Mask] | None:
    """Return a plane fitted to the points near it, time and again, and which those are; None if it tips."""
    inside = _within(points, normal, offset, 1.5 * within)
    for _ in range(4):
        near = points[inside]
        if len(near) < 3:
            return None
        middle = near.mean(axis=0)
        spread = near - middle
        values, vectors = np.linalg.eigh(spread.T @ spread)
        if values[1] <= 0.0:
            return None
        normal = vectors[:, 0]
        rise = abs(float(normal[2]))
        if _SIN <= rise <= _COS:
            return None
        offset = float(normal @ middle)
        inside = _within(points, normal, offset, within)
    return normal, offset, inside
