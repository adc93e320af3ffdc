"""Convex hulls: corners, faces and planes, also of what is flat."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from deixis.frames import Array, Index

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


@dataclass(frozen=True, eq=False, slots=True)
class Hull:
    """A convex hull.

    Attributes
    ----------
    points : (m, 3) float
        Its corners, metres.
    faces : (k, 3) int
        Positions in ``points``, counter-clockwise seen from outside.
    planes : (p, 4) float
        Outward unit normals n and offsets d, each plane once: x is within iff n x + d <= 0 for all.
    volume : float
        Cubic metres.
    """

    points: Array
    faces: Index
    planes: Array
    volume: float

    def depth(self, points: Array) -> Array:
        """Return how far points lie within the hull, metres, (q,); negative outside it, where it is a bound.

        >>> box_hull(np.array([1.0, 1.0, 0.5])).depth(np.array([[0, 0, 0.1], [3, 0, 0]])).tolist()
        [0.4, -2.0]
        """
        result = np.full(len(points), np.inf)
        # In parts: points times planes may be many.
        step = max(1, 4_000_000 // len(self.planes))
        for start in range(0, len(points), step):
            part = points[start : start + step] @ self.planes[:, :3].T
            result[start : start + step] = -(part + self.planes[:, 3]).max(axis=1)
        return result


def box_hull(half: Array) -> Hull:
    """Return the hull of the box with the given half extents, metres, about the origin."""
    planes = np.concatenate([np.eye(3), -np.eye(3)])
    return Hull(
        _CORNERS * half,
        _BOX_FACES,
        np.column_stack([planes, -np.tile(half, 2)]),
        float(8.0 * np.prod(half)),
    )


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
    _, once = np.unique(np.round(found.equations, 9), axis=0, return_index=True)
    return Hull(corners, faces.astype(np.int64), found.equations[np.sort(once)], float(found.volume))


def _thick(points: Array) -> Array:
    """Return the points, doubled along every direction in which they have no extent."""
    points = np.unique(points, axis=0)
    spread = points - points.mean(axis=0)
    for axis in np.linalg.eigh(spread.T @ spread)[1].T:
        if np.ptp(points @ axis) < _FLAT:
            points = np.concatenate([points - 0.5 * _FLAT * axis, points + 0.5 * _FLAT * axis])
    return points
