"""Drawing: things and relations as what Foxglove draws: cubes, triangles, outlines, labels, arrows.

Imported only when something is drawn, since it needs foxglove-sdk.
"""

from __future__ import annotations

import colorsys
import math
import zlib
from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import Any, Final

import numpy as np
from foxglove.messages import (
    ArrowPrimitive,
    Color,
    CubePrimitive,
    KeyValuePair,
    LinePrimitive,
    LinePrimitiveLineType,
    Point3,
    Pose,
    PoseInFrame,
    Quaternion,
    SceneEntity,
    SceneEntityDeletion,
    SceneUpdate,
    TextPrimitive,
    Timestamp,
    TriangleListPrimitive,
    Vector3,
)
from scipy.spatial.transform import Rotation

from deixis.boxes import min_bound_box
from deixis.frames import Array
from deixis.regions import BoxRegion, MeshRegion, PointRegion, SurfaceRegion
from deixis.relations import Relation
from deixis.scene import Scene, SpatialObject, View

_SHAFT: Final = 0.01
_HEAD: Final = 0.04
_SHORT: Final = 0.02
"""Metres: a shorter way between two things is drawn between their middles."""

_ABOVE: Final = 0.05
"""Metres above a thing where its label is."""


@lru_cache(maxsize=1024)
def colour(name: str, alpha: float) -> Color:
    """Return a colour that is always the same for a name."""
    red, green, blue = colorsys.hsv_to_rgb(zlib.crc32(name.encode()) % 360 / 360.0, 0.6, 0.9)
    return Color(r=red, g=green, b=blue, a=alpha)


class Drawer:
    """Draws what is so at one moment.

    Parameters
    ----------
    scene : Scene
    frame : str
        Name of the fixed frame.
    stamp : int
        Nanoseconds.
    """

    def __init__(self, scene: Scene, frame: str, stamp: int) -> None:
        self._scene, self._frame = scene, frame
        self._time = Timestamp(stamp // 10**9, stamp % 10**9)

    def things(self) -> dict[str, SceneEntity]:
        """Return an entity for each thing, by its id."""
        return {thing.id: self._thing(thing) for thing in self._scene.objects}

    def relations(
        self, relations: Sequence[Relation], say: Callable[[Relation], str]
    ) -> dict[str, dict[str, SceneEntity]]:
        """Return an entity for each relation of two things, by its predicate and its name."""
        there = {thing.id for thing in self._scene.objects}
        found = [one for one in relations if one.figure in there and one.reference in there]
        result: dict[str, dict[str, SceneEntity]] = {}
        for one, arrow in zip(found, _arrows(self._scene, found), strict=True):
            ends = (one.figure, one.reference, *([] if one.view is None else [one.view]))
            told = {"sentence": say(one), "relation": one.relation, "figure": ends[0], "reference": ends[1]}
            if one.view is not None:
                told["view"] = one.view
            if one.margin is not None:
                told["margin_m"] = repr(one.margin)
            name = "|".join((one.relation, *ends))
            result.setdefault(one.relation, {})[name] = SceneEntity(
                timestamp=self._time, frame_id=self._frame, id=name, metadata=_pairs(told), arrows=[arrow]
            )
        return result

    def update(self, entities: dict[str, SceneEntity], gone: Sequence[str]) -> SceneUpdate:
        """Return a message that shows some entities, and has others be deleted."""
        deletions = [SceneEntityDeletion(timestamp=self._time, id=name) for name in gone]
        return SceneUpdate(deletions=deletions, entities=list(entities.values()))

    def pose(self, view: View) -> PoseInFrame:
        """Return the pose of a view, level, with X ahead."""
        pose = _pose(view.position.tolist(), view.heading)
        return PoseInFrame(timestamp=self._time, frame_id=self._frame, pose=pose)

    def _thing(self, thing: SpatialObject) -> SceneEntity:
        told = {"id": thing.id, "kind": thing.kind}
        for number, label in enumerate(thing.labels, 1):
            told[f"label {number}"] = f"{label.name} ({label.score:g})"
        return SceneEntity(
            timestamp=self._time, frame_id=self._frame, id=thing.id, metadata=_pairs(told), **_shape(thing)
        )


def _shape(thing: SpatialObject) -> dict[str, Any]:
    """Return the parts of a thing's entity: its region as it was told, and its label above."""
    region = thing.region
    name = thing.label or thing.id
    told = colour(name, 0.35 if thing.kind == "surface" else 0.7)
    parts: dict[str, Any]
    if isinstance(region, MeshRegion):
        mesh = TriangleListPrimitive(
            pose=_pose((0.0, 0.0, 0.0)),
            points=_points(region.vertices),
            color=told,
            indices=region.faces.ravel().tolist(),
        )
        parts, corners = {"triangles": [mesh]}, region.vertices
    elif isinstance(region, SurfaceRegion):
        outline = LinePrimitive(
            type=LinePrimitiveLineType.LineLoop,
            pose=_pose((0.0, 0.0, 0.0)),
            thickness=2.0 * _SHAFT,
            points=_points(region.polygon),
            color=told,
        )
        parts, corners = {"lines": [outline]}, region.polygon
    else:
        center, half, yaw = _box(region)
        cube = CubePrimitive(
            pose=_pose(center.tolist(), yaw), size=_vector((2.0 * half).tolist()), color=told
        )
        parts, corners = {"cubes": [cube]}, np.stack([center - half, center + half])
    low, high = corners.min(axis=0).tolist(), corners.max(axis=0).tolist()
    text = TextPrimitive(
        pose=_pose((0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1]), high[2] + _ABOVE)),
        billboard=True,
        font_size=12.0,
        scale_invariant=True,
        color=colour(name, 1.0),
        text=name,
    )
    return {**parts, "texts": [text]}


def _arrows(scene: Scene, relations: Sequence[Relation]) -> list[ArrowPrimitive]:
    """Return an arrow for each relation, from the middle of its figure to the nearest of its reference's box.

    Where that is no way at all, since one is in the other, it goes to the middle of the reference.
    """
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
    turn = Quaternion(x=0.0, y=0.0, z=math.sin(0.5 * yaw), w=math.cos(0.5 * yaw))
    return Pose(position=_vector(place), orientation=turn)


def _vector(values: Sequence[float]) -> Vector3:
    x, y, z = values
    return Vector3(x=x, y=y, z=z)


def _points(rows: Array) -> list[Point3]:
    return [Point3(x=x, y=y, z=z) for x, y, z in rows.tolist()]


def _pairs(told: dict[str, str]) -> list[KeyValuePair]:
    return [KeyValuePair(key=key, value=value) for key, value in told.items()]
