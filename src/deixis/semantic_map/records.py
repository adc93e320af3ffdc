"""Rows of a map's tables: made of scenes, and scenes made of them."""

from __future__ import annotations

import json
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any, Final

import numpy as np

from deixis.errors import MapError
from deixis.polyhedra import boxes, hulls
from deixis.scene import Scene
from deixis.scene_format import parse_scene
from deixis.strict_json import quoted
from deixis.thresholds import Thresholds

Row = tuple[Any, ...]

COLUMNS: Final[Mapping[str, tuple[str, ...]]] = {
    "map": ("id", "thresholds", "strays"),
    "frame": ("seq", "stamp", "source", "whole"),
    "thing": (
        "frame", "position", "id", "gone", "kind", "label", "labels",
        "x", "y", "z", "hx", "hy", "hz", "yaw", "region",
    ),
    "viewpoint": ("frame", "position", "id", "label", "x", "y", "z", "heading", "stamp"),
    "shape": ("frame", "position", "hull", "box"),
    "derivation": ("rules", "turn"),
    "accounted": ("frame",),
    "held": ("relation", "figure", "reference", "view", "since", "until"),
    "holding": ("relation", "figure", "reference", "view", "since"),
}  # fmt: skip
"""The tables, each with its columns; shapes are kept where there is PostGIS."""

_LABELS: Final = ("label", "labels")


def map_row(scene: Scene) -> Row:
    """Return the row of a map that reads regions as a scene does: id, thresholds, treatment of strays."""
    told = scene.to_dict()
    return scene.id, _json(told.get("thresholds", {})), scene.strays


def thing_rows(seq: int, scene: Scene, gone: Sequence[str]) -> list[Row]:
    """Return the rows of a frame's things, and of those that it tells are gone.

    Raises
    ------
    MapError
        Something is said to be gone that the frame shows.
    SceneError
        The scene was made in Python with names that no scene file may have.
    """
    told = scene.to_dict()
    parse_scene(told)
    shown = {thing.id for thing in scene.objects}
    both = next((name for name in gone if name in shown), None)
    if both is not None:
        raise MapError(f"{quoted(both)} is in the frame and said to be gone: leave out one of the two")
    boxes = scene.boxes
    rows: list[Row] = []
    for at, (thing, values) in enumerate(zip(scene.objects, told["objects"], strict=True)):
        labels = [{"name": one.name, "score": one.score} for one in thing.labels]
        region = {key: value for key, value in values.items() if key not in ("id", "kind", *_LABELS)}
        box = (*boxes.center[at].tolist(), *boxes.half[at].tolist(), float(boxes.yaw[at]))
        rows.append((seq, at, thing.id, False, thing.kind, thing.label, _json(labels), *box, _json(region)))
    nothing = (None,) * (len(COLUMNS["thing"]) - 4)
    return rows + [(seq, len(rows) + at, name, True, *nothing) for at, name in enumerate(dict.fromkeys(gone))]


def view_rows(seq: int, scene: Scene) -> list[Row]:
    """Return the rows of a frame's views."""
    return [
        (seq, at, view.id, view.label, *view.position.tolist(), view.heading, view.stamp)
        for at, view in enumerate(scene.views)
    ]


def shape_rows(seq: int, scene: Scene) -> list[Row]:
    """Return the rows of a frame's shapes: hulls and boxes as PostGIS stores them."""
    origin = np.zeros(3)
    shapes = zip(hulls(scene, origin), boxes(scene, origin), strict=True)
    return [(seq, at, hull, box) for at, (hull, box) in enumerate(shapes)]


def scene_of(told: Row, things: Iterable[Row], views: Iterable[Row]) -> Scene:
    """Return the scene that rows tell of.

    Parameters
    ----------
    told : row
        Of the map.
    things : iterable of row
        Id, kind, labels, region.
    views : iterable of row
        Id, label, x, y, z, heading, stamp.
    """
    name, thresholds, strays = told
    seen = [
        {"id": view, "position": [x, y, z], "heading": heading}
        | ({"label": label} if label else {})
        | ({} if stamp is None else {"stamp": stamp})
        for view, label, x, y, z, heading, stamp in views
    ]
    known = {view["id"] for view in seen}
    objects = [
        {"id": thing, "kind": kind, **_labelled(json.loads(labels)), **_seen_from(json.loads(region), known)}
        for thing, kind, labels, region in things
    ]
    return Scene.from_dict(
        {
            "deixis": 1,
            "id": name,
            "strays": strays,
            "objects": objects,
            "views": seen,
            "thresholds": json.loads(thresholds),
        }
    )


def same_thresholds(told: Row, scene: Scene) -> bool:
    """Return whether a scene is read with a map's thresholds, or has none of its own to insist on."""
    return scene.thresholds == Thresholds() or map_row(scene)[1:] == told[1:]


def read_as(told: Row, scene: Scene) -> Scene:
    """Return a scene with the thresholds and the treatment of strays of the map that takes it in."""
    limits = Thresholds.of(json.loads(told[1]))
    if (scene.thresholds, scene.strays) == (limits, told[2]):
        return scene
    return replace(scene, thresholds=limits, strays=told[2])


def _seen_from(values: dict[str, Any], known: Collection[str]) -> dict[str, Any]:
    """Leave out the views that are not those of the scene: of earlier frames, which have them still."""
    views = [view for view in values.pop("seen_in", ()) if view in known]
    return {**values, "seen_in": views} if views else values


def _labelled(labels: list[dict[str, Any]]) -> dict[str, Any]:
    return {"labels": labels} if labels else {}


def _json(value: Any) -> str:
    return json.dumps(value, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
