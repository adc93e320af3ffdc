"""Shapes: what a thing is drawn as beside its box, cut down where there is too much, and then said so."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final

import numpy as np

from deixis.frames import Array
from deixis.regions import MeshRegion, PointRegion, Region, SurfaceRegion

POINTS: Final = 2_000
"""Points drawn of one thing."""

FACES: Final = 4_000
"""Triangles drawn of one thing; of a larger mesh some of its vertices are drawn instead."""

TOTAL: Final = 150_000
"""Points and triangles of a page: what comes after them is drawn as its box."""

_MILLIMETRES: Final = 1000.0


def shapes(regions: Sequence[Region]) -> list[dict[str, Any] | None]:
    """Return what each region is drawn as; None stands for its box.

    Coordinates are whole millimetres in one row. ``of`` tells how many points or triangles there are, where
    fewer are drawn.

    Examples
    --------
    >>> shapes([SurfaceRegion([[0, 0, 0], [1, 0, 0], [1, 1, 0]])])
    [{'ring': [0, 0, 0, 1000, 0, 0, 1000, 1000, 0]}]
    """
    found: list[dict[str, Any] | None] = []
    left = TOTAL
    for region in regions:
        shape = _shape(region)
        used = 0 if shape is None else max(len(shape.get("points", ())), len(shape.get("faces", ()))) // 3
        found.append(shape if used <= left else None)
        left -= used if used <= left else 0
    return found


def _shape(region: Region) -> dict[str, Any] | None:
    match region:
        case SurfaceRegion():
            return {"ring": _row(region.polygon)}
        case PointRegion():
            return _points(region.points, len(region.points))
        case MeshRegion() if len(region.faces) <= FACES:
            used, faces = np.unique(region.faces, return_inverse=True)
            return {"vertices": _row(region.vertices[used]), "faces": faces.reshape(-1).tolist()}
        case MeshRegion():
            return _points(region.vertices[np.unique(region.faces)], len(region.faces))
    return None


def _points(points: Array, of: int) -> dict[str, Any]:
    """Return some of the points, evenly spread over their order."""
    some = points[np.linspace(0, len(points) - 1, min(len(points), POINTS)).astype(np.int64)]
    shape: dict[str, Any] = {"points": _row(some)}
    return shape if len(some) == of else {**shape, "of": of}


def _row(points: Array) -> list[int]:
    return [int(value) for value in np.rint(points * _MILLIMETRES).reshape(-1)]
