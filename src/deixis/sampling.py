"""Sampling: points all over a triangulated surface, each standing for a share of its area."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from deixis.frames import Array, Index

_AREA: Final = 0.25
"""A triangle halved until no side is longer than s has about this times s squared for its area."""


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

    points: NDArray[np.float32]
    area: NDArray[np.float32]
    normal: NDArray[np.float32]
    spacing: float

    def __len__(self) -> int:
        return len(self.points)

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

    Triangles are halved at the middle of their longest side until no side is longer than the spacing; the
    samples are the centroids of what results, and the vertices. Of several in a cell half a spacing wide
    one is kept, with the area of all.

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
    owner = np.arange(len(faces))
    found = [(triangles.reshape(-1, 3), np.zeros(3 * len(faces)), np.repeat(owner, 3))]
    while len(triangles):
        side = np.roll(triangles, -1, axis=1) - triangles
        length = (side * side).sum(axis=2)
        large = length.max(axis=1) > spacing * spacing
        small = ~large
        found.append((triangles[small].mean(axis=1), share[small], owner[small]))
        triangles, share, owner = triangles[large], np.tile(0.5 * share[large], 2), np.tile(owner[large], 2)
        first, row = length[large].argmax(axis=1), np.arange(len(triangles))
        a, b, c = (triangles[row, (first + turn) % 3] for turn in range(3))
        middle = 0.5 * (a + b)
        triangles = np.concatenate([np.stack([a, middle, c], axis=1), np.stack([middle, b, c], axis=1)])
    points, area, owner = (np.concatenate(part) for part in zip(*found, strict=True))
    keep, area = _thinned(points, area, 0.5 * spacing)
    return Samples(
        points[keep].astype(np.float32),
        area.astype(np.float32),
        normal[owner[keep]].astype(np.float32),
        spacing,
    )


def face_normals(triangles: Array) -> tuple[Array, Array]:
    """Return the unit normals and the areas of triangles, (k, 3) and (k,); a normal is zero where the area is."""
    across = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    length = np.linalg.norm(across, axis=1)
    return across / np.where(length > 0.0, length, 1.0)[:, None], 0.5 * length


def _thinned(
    points: Array | NDArray[np.float32], area: Array | NDArray[np.float32], cell: float
) -> tuple[Index, Array]:
    """Return the first of the points in each cell, and the area of all in it."""
    at = np.floor((points - points.min(axis=0)) / cell).astype(np.int64)
    size = at.max(axis=0) + 1
    keys = (at[:, 0] * size[1] + at[:, 1]) * size[2] + at[:, 2]
    _, first, place = np.unique(keys, return_index=True, return_inverse=True)
    return first, np.bincount(place, weights=area, minlength=len(first))
