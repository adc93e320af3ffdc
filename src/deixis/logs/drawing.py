"""Drawing: regions and relations as what Foxglove draws: cubes, triangles, outlines, arrows."""

from __future__ import annotations

import colorsys
import zlib
from collections.abc import Sequence
from functools import lru_cache
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from deixis.boxes import min_bound_box
from deixis.frames import Array
from deixis.regions import BoxRegion, MeshRegion, PointRegion, SurfaceRegion
from deixis.relations import Relation
from deixis.scene import Scene, SpatialObject

if TYPE_CHECKING:
    from foxglove.messages import ArrowPrimitive, Color, Pose

_SHAFT: Final = 0.01
_HEAD: Final = 0.04
_SHORT: Final = 0.02
"""Metres: a shorter way between two things is drawn between their middles."""

_ABOVE: Final = 0.05
"""Metres above a thing where its label is."""


@lru_cache(maxsize=1024)
def colour(name: str, alpha: float) -> Color:
    """Return a colour that is always the same for a name."""
    from foxglove.messages import Color

    red, green, blue = colorsys.hsv_to_rgb(zlib.crc32(name.encode()) % 360 / 360.0, 0.6, 0.9)
    return Color(r=red, g=green, b=blue, a=alpha)


def shape(thing: SpatialObject) -> dict[str, Any]:
    """Return the parts of a thing's entity: its region as it was told, and its label above."""
    from foxglove.messages import CubePrimitive, LinePrimitive, Point3, TextPrimitive, TriangleListPrimitive

    region = thing.region
    name = thing.label or thing.id
    told = colour(name, 0.35 if thing.kind == "surface" else 0.7)
    parts: dict[str, Any]
    if isinstance(region, MeshRegion):
        points = [Point3(x=x, y=y, z=z) for x, y, z in region.vertices.tolist()]
        mesh = TriangleListPrimitive(
            pose=_pose([0.0, 0.0, 0.0]), points=points, color=told, indices=region.faces.ravel().tolist()
        )
        parts, corners = {"triangles": [mesh]}, region.vertices
    elif isinstance(region, SurfaceRegion):
        from foxglove.messages import LinePrimitiveLineType as LineType

        ring = [Point3(x=x, y=y, z=z) for x, y, z in region.polygon.tolist()]
        outline = LinePrimitive(
            type=LineType.LineLoop, pose=_pose([0.0, 0.0, 0.0]), thickness=_SHAFT, points=ring, color=told
        )
        parts, corners = {"lines": [outline]}, region.polygon
    else:
        center, half, yaw = _box(region)
        cube = CubePrimitive(
            pose=_pose(center.tolist(), yaw), size=_vector((2.0 * half).tolist()), color=told
        )
        parts, corners = {"cubes": [cube]}, np.stack([center - half, center + half])
    low, high = corners.min(axis=0), corners.max(axis=0)
    x, y, _ = (0.5 * (low + high)).tolist()
    text = TextPrimitive(
        pose=_pose([x, y, float(high[2]) + _ABOVE]),
        billboard=True,
        font_size=12.0,
        scale_invariant=True,
        color=colour(name, 1.0),
        text=name,
    )
    return {**parts, "texts": [text]}


def arrows(scene: Scene, relations: Sequence[Relation]) -> list[ArrowPrimitive]:
    """Return an arrow for each relation, from the middle of its figure to the nearest of its reference's box.

    Where that is no way at all, since one is in the other, it goes to the middle of the reference.
    """
    from foxglove.messages import ArrowPrimitive, Pose, Quaternion
    from scipy.spatial.transform import Rotation

    if not relations:
        return []
    boxes = scene.boxes
    figure = np.array([scene.index(one.figure) for one in relations])
    reference = np.array([scene.index(one.reference) for one in relations])
    start, middle = boxes.center[figure], boxes.center[reference]
    cos, sin, half = boxes.cos[reference], boxes.sin[reference], boxes.half[reference]
    away = start - middle
    own = np.stack(
        [cos * away[:, 0] + sin * away[:, 1], cos * away[:, 1] - sin * away[:, 0], away[:, 2]], axis=1
    )
    own = np.clip(own, -half, half)
    end = middle + np.stack(
        [cos * own[:, 0] - sin * own[:, 1], sin * own[:, 0] + cos * own[:, 1], own[:, 2]], axis=1
    )
    way = end - start
    way = np.where(np.linalg.norm(way, axis=1)[:, None] < _SHORT, middle - start, way)
    length = np.linalg.norm(way, axis=1)
    yaw = np.arctan2(way[:, 1], way[:, 0])
    pitch = -np.arctan2(way[:, 2], np.hypot(way[:, 0], way[:, 1]))
    turns = Rotation.from_euler("ZY", np.stack([yaw, pitch], axis=1)).as_quat()
    rows = zip(relations, start.tolist(), turns.tolist(), length.tolist(), strict=True)
    return [
        ArrowPrimitive(
            pose=Pose(position=_vector(place), orientation=Quaternion(x=x, y=y, z=z, w=w)),
            shaft_length=max(long - _HEAD, 0.0),
            shaft_diameter=_SHAFT,
            head_length=min(_HEAD, long),
            head_diameter=2.0 * _SHAFT,
            color=colour(one.relation, 1.0),
        )
        for one, place, (x, y, z, w), long in rows
    ]


def _box(region: BoxRegion | PointRegion) -> tuple[Array, Array, float]:
    if isinstance(region, BoxRegion):
        return region.center, 0.5 * region.size, region.yaw
    center, half, yaw, _ = min_bound_box(region.points)
    return center, half, yaw


def _pose(place: Sequence[float], yaw: float = 0.0) -> Pose:
    from foxglove.messages import Pose, Quaternion

    turn = Quaternion(x=0.0, y=0.0, z=float(np.sin(0.5 * yaw)), w=float(np.cos(0.5 * yaw)))
    return Pose(position=_vector(place), orientation=turn)


def _vector(values: Sequence[float]) -> Any:
    from foxglove.messages import Vector3

    x, y, z = values
    return Vector3(x=x, y=y, z=z)
