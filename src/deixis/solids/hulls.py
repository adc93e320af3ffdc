"""Convex hulls: corners, faces and planes, also of what is flat."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np

from deixis.frames import Array, Index
from deixis.solids.sampling import Single, unique_rows

DIRECTIONS: Final = 400
"""A hull with more planes, or corners, than this is looked at along so many directions only, evenly spread.

What is left out sticks out by less than 1 % of the hull's size: of a ball's 5,000 faces most say the same.
"""

_FLAT: Final = 1.0e-6
"""Metres: what is thinner than this is given this thickness, to have a hull."""

_CORNERS: Final = np.array([[x, y, z] for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)])

_BOX_FACES: Final = np.array(
    [
        [0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1],
        [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3],
    ],
    dtype=np.int64,
)  # fmt: skip


@dataclass(frozen=True, eq=False)
class Hull:
    """A convex hull.

    Attributes
    ----------
    points : (m, 3) float
        Its corners, metres.
    faces : (k, 3) int
        Positions in ``points``, counter-clockwise seen from outside.
    facets : (f, 4) float
        Outward unit normals n and offsets d of its planes, each once: x is within iff n x + d <= 0 for all.
    volume : float
        Cubic metres.
    """

    points: Array
    faces: Index
    facets: Array
    volume: float

    @cached_property
    def planes(self) -> Array:
        """Return the planes of the hull or, where there are too many, those nearest to even directions."""
        if len(self.facets) <= DIRECTIONS:
            return self.facets
        nearest = (directions(DIRECTIONS) @ self.facets[:, :3].T).argmax(axis=1)
        return np.asarray(self.facets[np.unique(nearest)])

    @cached_property
    def corners(self) -> Array:
        """Return the corners of the hull or, where there are too many, the farthest along even directions."""
        if len(self.points) <= DIRECTIONS:
            return self.points
        ways = np.concatenate([np.eye(3), -np.eye(3), directions(DIRECTIONS)])
        return np.asarray(self.points[np.unique((ways @ self.points.T).argmax(axis=1))])

    @cached_property
    def low(self) -> Array:
        """Return the least coordinates, (3,)."""
        return np.asarray(self.points.min(axis=0))

    @cached_property
    def high(self) -> Array:
        """Return the greatest coordinates, (3,)."""
        return np.asarray(self.points.max(axis=0))

    @cached_property
    def _single(self) -> tuple[Single, Single]:
        """Return the planes in single precision: normals (3, p), and offsets."""
        return np.ascontiguousarray(self.planes[:, :3].T, dtype=np.float32), self.planes[:, 3].astype(
            np.float32
        )

    def depth(self, points: Single) -> Single:
        """Return how far points lie within the hull, metres, (q,); negative outside it, where it is a bound.

        >>> box_hull(np.array([1.0, 1.0, 0.5])).depth(np.float32([[0, 0, 0.25], [3, 0, 0]])).tolist()
        [0.25, -2.0]
        """
        normals, offsets = self._single
        heights = points @ normals
        heights += offsets
        return np.asarray(-heights.max(axis=1, initial=-np.inf))


def directions(count: int) -> Array:
    """Return evenly spread unit vectors, (count, 3): a spiral over the sphere."""
    turn = np.pi * (1.0 + np.sqrt(5.0)) * np.arange(count)
    z = 1.0 - (2.0 * np.arange(count) + 1.0) / count
    level = np.sqrt(1.0 - z * z)
    return np.stack([level * np.cos(turn), level * np.sin(turn), z], axis=1)


def box_hull(half: Array) -> Hull:
    """Return the hull of the box with the given half extents, metres, about the origin."""
    normals = np.concatenate([np.eye(3), -np.eye(3)])
    facets = np.column_stack([normals, -np.tile(half, 2)])
    return Hull(_CORNERS * half, _BOX_FACES, facets, float(8.0 * np.prod(half)))


def convex_hull(points: Array) -> Hull:
    """Return the convex hull of points; one that would be flat is a micrometre thick.

    Parameters
    ----------
    points : (m, 3) float
        Metres, at least one.

    Examples
    --------
    >>> tent = convex_hull(np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]]))
    >>> len(tent.points), len(tent.planes), round(tent.volume, 3)
    (4, 4, 0.167)
    >>> len(convex_hull(np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0.0]])).points)
    6
    """
    from scipy.spatial import ConvexHull

    points = _thick(points)
    found = ConvexHull(points)
    place = np.full(len(points), -1)
    place[found.vertices] = np.arange(len(found.vertices))
    corners, faces = points[found.vertices], place[found.simplices]
    a, b, c = (corners[faces[:, corner]] for corner in range(3))
    inwards = np.einsum("ij,ij->i", np.cross(b - a, c - a), found.equations[:, :3]) < 0.0
    faces[inwards] = faces[inwards][:, ::-1]
    once, _ = unique_rows(np.round(found.equations * 1.0e9).astype(np.int64))
    return Hull(corners, faces.astype(np.int64), found.equations[np.sort(once)], float(found.volume))


def _thick(points: Array) -> Array:
    """Return the points, doubled along every direction in which they have no extent."""
    points = np.unique(points, axis=0)
    spread = points - points.mean(axis=0)
    for axis in np.linalg.eigh(spread.T @ spread)[1].T:
        if np.ptp(points @ axis) < _FLAT:
            points = np.concatenate([points - 0.5 * _FLAT * axis, points + 0.5 * _FLAT * axis])
    return points
