"""Hulls and boxes as PostGIS stores them: polyhedral surfaces in EWKB, for COPY.

What is flat is a polygon, what is thin a line, and a point a point: there is no polyhedron without a volume.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator
from typing import Final

import numpy as np

from deixis.boxes import convex_hull_2d
from deixis.frames import Array
from deixis.regions import MeshRegion, PointRegion
from deixis.scene import Scene

_POINT, _LINE, _POLYGON, _POLYHEDRON = (0x80000000 | kind for kind in (1, 2, 3, 15))

_FACES: Final = ((0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7))
"""A box's faces, counter-clockwise seen from outside: four corners below, then four above them."""

_FLAT: Final = 1.0e-6
"""Metres: points that are thinner than this along some direction have no hull with a volume."""


def hulls(scene: Scene, origin: Array) -> Iterator[str]:
    """Yield the convex hull of each thing's region, in hexadecimal, with coordinates from the origin given.

    A surface is the rectangle of its plane (decision 0005), as thick as it is.

    Examples
    --------
    >>> from deixis.regions import BoxRegion
    >>> from deixis.scene import Label, SpatialObject
    >>> sheet = SpatialObject("sheet", (Label("paper"),), "object", BoxRegion([0, 0, 0], [1, 1, 0]))
    >>> [text[:10] for text in hulls(Scene("desk", (sheet,)), np.zeros(3))]  # a polygon
    ['0103000080']
    """
    for thing, region, box in zip(scene.objects, scene.regions, boxes(scene, origin), strict=True):
        if thing.kind == "object" and isinstance(region, PointRegion):
            yield _hull(region.points - origin).hex()
        elif thing.kind == "object" and isinstance(region, MeshRegion):
            yield _hull(region.vertices[np.unique(region.faces)] - origin).hex()
        else:
            yield box


def boxes(scene: Scene, origin: Array) -> Iterator[str]:
    """Yield the minimum bounding box of each thing, in hexadecimal, in coordinates from the origin."""
    own = scene.boxes
    for center, half, yaw in zip(own.center - origin, own.half, own.yaw.tolist(), strict=True):
        yield _box(center, half, yaw).hex()


def _box(center: Array, half: Array, yaw: float) -> bytes:
    cos, sin = np.cos(yaw), np.sin(yaw)
    along, across = half[0] * np.array([cos, sin, 0.0]), half[1] * np.array([-sin, cos, 0.0])
    up = np.array([0.0, 0.0, half[2]])
    solid = [half[0] > 0.0, half[1] > 0.0, half[2] > 0.0]
    spans = [axis for axis, there in zip((along, across, up), solid, strict=True) if there]
    if len(spans) == 3:
        ring = [-along - across, along - across, along + across, -along + across]
        corners = np.array([center + at - up for at in ring] + [center + at + up for at in ring])
        return _polyhedron([corners[list(face)] for face in _FACES])
    if len(spans) == 2:
        one, other = spans
        return _polygon(
            np.array([center - one - other, center + one - other, center + one + other, center - one + other])
        )
    if len(spans) == 1:
        return _head(_LINE, 2) + _coordinates(np.array([center - spans[0], center + spans[0]]))
    return struct.pack("<BI", 1, _POINT) + _coordinates(center)


def _hull(points: Array) -> bytes:
    from scipy.spatial import ConvexHull

    spread = points - points.mean(axis=0)
    # Directions in which the points spread, least first.
    ways = np.linalg.eigh(spread.T @ spread)[1]
    if len(points) < 4 or np.ptp(spread @ ways[:, 0]) < _FLAT:
        return _flat(points, spread @ ways[:, 1:])
    found = ConvexHull(points)
    corners = points[found.simplices]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    inwards = (normals * found.equations[:, :3]).sum(axis=1) < 0.0
    corners[inwards] = corners[inwards][:, ::-1]
    return _polyhedron(list(corners))


def _flat(points: Array, plane: Array) -> bytes:
    """Return the hull of points that lie in a plane, with their places in it, (m, 2): a polygon or less."""
    ring = convex_hull_2d(plane).reshape(-1, 2)
    corners = points[[int(np.abs(plane - corner).sum(axis=1).argmin()) for corner in ring]]
    if len(ring) > 2:
        return _polygon(corners)
    if len(ring) == 2:
        return _head(_LINE, 2) + _coordinates(corners)
    return struct.pack("<BI", 1, _POINT) + _coordinates(corners)


def _polyhedron(faces: list[Array]) -> bytes:
    return _head(_POLYHEDRON, len(faces)) + b"".join(map(_polygon, faces))


def _polygon(ring: Array) -> bytes:
    return _head(_POLYGON, 1) + struct.pack("<I", len(ring) + 1) + _coordinates(np.vstack([ring, ring[:1]]))


def _head(kind: int, count: int) -> bytes:
    return struct.pack("<BII", 1, kind, count)


def _coordinates(points: Array) -> bytes:
    return np.ascontiguousarray(points, dtype="<f8").tobytes()
