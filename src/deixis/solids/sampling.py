"""Sampling: points all over a triangulated surface, each standing for a share of its area."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from deixis.frames import Array, Index

Single = NDArray[np.float32]

_AREA: Final = 0.6
"""A sample of a surface covered at a spacing of s stands for at least this times s squared of its area."""

_DENSE: Final = 40
"""A table of cells may have so many of them for each point."""


@dataclass(frozen=True, eq=False, slots=True)
class Samples:
    """Points on a surface.

    Attributes
    ----------
    points : (q, 3) float32
        Metres.
    area : (q,) float32
        Square metres of the surface that each stands for; they sum up to its area.
    normal : (q, 3) float32
        Unit normal of a face that each lies on.
    spacing : float
        Metres: no point of the surface is further than this from a sample.
    """

    points: Single
    area: Single
    normal: Single
    spacing: float

    def __len__(self) -> int:
        return len(self.points)

    def within(self, low: Array, high: Array) -> Samples:
        """Return the samples in the box between two corners, metres."""
        low, high = low.astype(np.float32), high.astype(np.float32)
        x, y, z = self.points.T
        inside = (z >= low[2]) & (z <= high[2])
        inside &= (x >= low[0]) & (x <= high[0])
        inside &= (y >= low[1]) & (y <= high[1])
        return Samples(self.points[inside], self.area[inside], self.normal[inside], self.spacing)

    def thinned(self, cell: float) -> Samples:
        """Return one of the samples in each cell of the given width, with the area of all in it."""
        keep, area = _thinned(self.points, self.area, cell)
        return Samples(
            self.points[keep],
            area.astype(np.float32),
            self.normal[keep],
            self.spacing + float(np.sqrt(3.0)) * cell,
        )


def sample(vertices: Array, faces: Index, spacing: float, most: int) -> Samples:
    """Return points all over a surface: no point of it is further than the spacing from one of them.

    Triangles no longer than that are met by their corners alone; larger ones are covered with rows of points
    along their longest side. Of several samples in a cell half a spacing wide one is kept, with the area of
    all.

    Parameters
    ----------
    vertices : (m, 3) float
        Metres.
    faces : (k, 3) int
    spacing : float
        Metres; made larger where ``most`` asks for it.
    most : int
        About how many samples there may be.

    Examples
    --------
    >>> square = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0.0]])
    >>> found = sample(square, np.array([[0, 1, 2], [0, 2, 3]]), 0.1, 10_000)
    >>> round(float(found.area.sum()), 6), found.normal[0].tolist()
    (1.0, [0.0, 0.0, 1.0])
    """
    triangles = vertices[faces]
    normal, share = face_normals(triangles)
    spacing = max(spacing, float(np.sqrt(share.sum() / (_AREA * most))))
    sides = triangles[:, (1, 2, 0)] - triangles
    length = np.sqrt((sides * sides).sum(axis=2))
    large = length.max(axis=1) > spacing
    corners = faces.reshape(-1)
    owner = np.zeros(len(vertices), dtype=np.int64)
    owner[corners] = np.repeat(np.arange(len(faces)), 3)
    used = np.zeros(len(vertices), dtype=np.bool_)
    used[corners] = True
    area = np.bincount(corners, weights=np.repeat(np.where(large, 0.0, share / 3.0), 3), minlength=len(used))
    points, stands_for, owner = vertices[used], area[used].astype(np.float64), owner[used]
    if large.any():
        more, part, place = _rows(triangles[large], share[large], length[large], spacing)
        points, stands_for = np.concatenate([points, more]), np.concatenate([stands_for, part])
        owner = np.concatenate([owner, np.flatnonzero(large)[place]])
    keep, stands_for = _thinned(points, stands_for, 0.5 * spacing)
    return Samples(
        points[keep].astype(np.float32),
        stands_for.astype(np.float32),
        normal[owner[keep]].astype(np.float32),
        spacing,
    )


def _rows(triangles: Array, share: Array, length: Array, spacing: float) -> tuple[Array, Array, Index]:
    """Return points in rows along the longest sides of triangles, the area and the triangle of each.

    A row lies at most 0.8 spacings above the next, which is longer, and has a point every spacing.
    """
    row, first = np.arange(len(triangles)), length.argmax(axis=1)
    a, b, c = (triangles[row, (first + turn) % 3] for turn in range(3))
    base = length[row, first]
    count = np.maximum(np.ceil(2.0 * share / (0.8 * spacing * base)), 1.0).astype(np.int64)
    triangle, level = _ranges(count + 1)
    height = level / count[triangle]
    number = np.ceil((1.0 - height) * base[triangle] / spacing).astype(np.int64) + 1
    row, step = _ranges(number)
    along, up = step / np.maximum(number[row] - 1, 1), height[row]
    place = triangle[row]
    points = a[place] + up[:, None] * (c - a)[place] + (along * (1.0 - up))[:, None] * (b - a)[place]
    part = (1.0 - up) / number[row]
    return points, part * (share / np.bincount(place, weights=part))[place], place


def _ranges(count: Index) -> tuple[Index, Index]:
    """Return 0 to count - 1 for each count, one after another: which count it is of, and the number."""
    owner = np.repeat(np.arange(len(count), dtype=np.int64), count)
    return owner, np.arange(len(owner), dtype=np.int64) - (np.cumsum(count) - count)[owner]


def face_normals(triangles: Array) -> tuple[Array, Array]:
    """Return unit normals and areas of triangles, (k, 3) and (k,); the normal is zero where the area is."""
    across = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    length = np.linalg.norm(across, axis=1)
    return across / np.where(length > 0.0, length, 1.0)[:, None], 0.5 * length


def _thinned(points: Array | Single, area: Array | Single, cell: float) -> tuple[Index, Array]:
    """Return the first of the points in each cell, and the area of all in it."""
    at = np.floor((points - points.min(axis=0)) / cell).astype(np.int64)
    size = at.max(axis=0) + 1
    keys = (at[:, 0] * size[1] + at[:, 1]) * size[2] + at[:, 2]
    count = int(np.prod(size))
    if count > _DENSE * len(keys):
        _, first, place = np.unique(keys, return_index=True, return_inverse=True)
        return first, np.bincount(place, weights=area, minlength=len(first)).astype(np.float64)
    # A table of all cells needs no sorting. Of equal keys the one written last stays: the first point.
    table = np.full(count, -1, dtype=np.int64)
    table[keys[::-1]] = np.arange(len(keys) - 1, -1, -1)
    taken = np.flatnonzero(table >= 0)
    return table[taken], np.bincount(keys, weights=area, minlength=count)[taken].astype(np.float64)


def unique_rows(rows: Index) -> tuple[Index, Index]:
    """Return the first row of each kind among rows of whole numbers, (q, w), and for each row its kind.

    Kinds are numbered in ascending order.

    >>> [found.tolist() for found in unique_rows(np.array([[2, 1], [1, 5], [2, 1]]))]
    [[1, 0], [1, 0, 1]]
    """
    order = np.lexsort(rows.T[::-1])
    ordered = rows[order]
    new = np.ones(len(rows), dtype=np.bool_)
    new[1:] = (ordered[1:] != ordered[:-1]).any(axis=1)
    place = np.empty(len(rows), dtype=np.int64)
    place[order] = np.cumsum(new) - 1
    return order[new], place
