"""Scene: what was seen, from where, before any geometry is computed and any rule is known.

A scene comes in through one door (:meth:`Scene.load`, :meth:`Scene.from_dict`), which refuses what is not
well formed; from then on it does not change. Lengths are metres and angles radians in the world frame:
right-handed, Z up, angles counter-clockwise seen from above.
"""

from __future__ import annotations

import difflib
import json
import os
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from deixis._files import write_whole
from deixis.boxes import Boxes
from deixis.errors import DeixisError, SceneError, ThresholdError
from deixis.frames import WORLD, Array
from deixis.pieces import Strays
from deixis.regions import (
    BoxRegion,
    Kind,
    MeshRegion,
    PointRegion,
    Region,
    RegionBox,
    SurfaceRegion,
    part_of,
    region_box,
    region_values,
    turned_oddly,
)
from deixis.strict_json import parse, quoted, read_bytes
from deixis.thresholds import Thresholds

if TYPE_CHECKING:
    from deixis.scene_format import ObjectPart, ViewPart

__all__ = [
    "BoxRegion",
    "Label",
    "MeshRegion",
    "PointRegion",
    "Region",
    "Scene",
    "SpatialObject",
    "SurfaceRegion",
    "View",
    "scene_schema",
]

HUGE: Final = 1.0e4
"""Metres: a thing longer than this is more likely in millimetres."""

TINY: Final = 1.0e-3
"""Metres: where no thing is longer than this the unit is more likely kilometres."""


@dataclass(frozen=True, slots=True)
class Label:
    """What a thing may be called, and how sure that is: ``score`` is from 0 to 1."""

    name: str
    score: float = 1.0


@dataclass(frozen=True, slots=True)
class SpatialObject:
    """A thing or a surface with its region (sReg, axioms 1-3).

    Attributes
    ----------
    id : str
        Unique in its scene.
    labels : tuple of Label
        Best first; may be empty.
    kind : "object" or "surface"
        A surface is a wall, floor or ceiling: always a reference, never a figure.
    region : Region
    seen_in : tuple of str
        Ids of the views it was seen in, each once; empty where that is not known.
    """

    id: str
    labels: tuple[Label, ...]
    kind: Kind
    region: Region
    seen_in: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        ranked = tuple(sorted(self.labels, key=lambda label: -label.score))
        object.__setattr__(self, "labels", ranked)
        object.__setattr__(self, "seen_in", tuple(dict.fromkeys(self.seen_in)))

    @property
    def label(self) -> str:
        """Return the best label's name, or the empty string where there is none."""
        return self.labels[0].name if self.labels else ""


@dataclass(frozen=True, eq=False, slots=True)
class View:
    """A pose the scene is seen from (F_r): the robot's or anyone's.

    Attributes
    ----------
    id : str
        Unique in its scene, and not ``world``.
    label : str
        Who looks, such as ``robot`` or ``you``; may be empty.
    position : (3,) float
        Metres, world frame.
    heading : float
        Radians from the world's X axis. No relation depends on it: F_r' faces the reference instead.
    stamp : float or None
        Seconds since the epoch of the recording.
    """

    id: str
    label: str
    position: Array
    heading: float = 0.0
    stamp: float | None = None

    def __post_init__(self) -> None:
        position = np.array(self.position, dtype=np.float64)
        if position.shape != (3,) or not np.isfinite([*position, self.heading]).all():
            raise SceneError(f"view {quoted(self.id)}: its pose is not finite: give x, y, z and a heading")
        position.setflags(write=False)
        object.__setattr__(self, "position", position)
        object.__setattr__(self, "heading", float(self.heading))


@dataclass(frozen=True, eq=False)
class Scene:
    """Things, surfaces and viewpoints of one place, with the thresholds to read them with.

    Attributes
    ----------
    id : str
    objects : tuple of SpatialObject
        Ids are unique.
    views : tuple of View
        Ids are unique; may be empty.
    thresholds : Thresholds
    diagnostics : tuple of str
        What was found odd or left out on the way in, each a sentence naming its object.
    strays : "drop" or "refuse"
        What becomes of the stray pieces of a point cloud (axiom 3, decision 0015).

    Raises
    ------
    SceneError
        An id is given twice, or a view is called ``world``.

    Examples
    --------
    >>> box = BoxRegion([0, 0, 0.4], [1, 1, 0.8])
    >>> scene = Scene("room", (SpatialObject("table", (Label("table"),), "object", box),))
    >>> scene.boxes.half.tolist()
    [[0.5, 0.5, 0.4]]
    """

    id: str
    objects: tuple[SpatialObject, ...] = ()
    views: tuple[View, ...] = ()
    thresholds: Thresholds = field(default_factory=Thresholds)
    diagnostics: tuple[str, ...] = ()
    strays: Strays = "drop"

    def __post_init__(self) -> None:
        object.__setattr__(self, "objects", tuple(self.objects))
        object.__setattr__(self, "views", tuple(self.views))
        for noun, ids in (("object", [o.id for o in self.objects]), ("view", [v.id for v in self.views])):
            repeated = [name for name, count in Counter(ids).items() if count > 1]
            if repeated:
                raise SceneError(f"{noun} {quoted(repeated[0])} is given more than once: rename all but one")
        if any(view.id == WORLD for view in self.views):
            raise SceneError(f"view {quoted(WORLD)}: the name is taken by the cardinal directions: rename it")

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Scene:
        """Return the scene in a file of scene format v1, or raise :class:`SceneError`.

        Parameters
        ----------
        path : path
            Of a JSON file. Point and mesh files it names must lie in its folder.
        """
        place = Path(path)
        data = parse(read_bytes(place, SceneError), SceneError, quoted(place.name, 200))
        try:
            return cls.from_dict(data, base=place.parent)
        except SceneError as cause:
            raise SceneError(f"{quoted(place.name, 200)}: {cause}") from cause

    @classmethod
    def from_dict(cls, data: object, base: Path | None = None, diagnostics: Iterable[str] = ()) -> Scene:
        """Return the scene described by JSON values of scene format v1.

        Parameters
        ----------
        data : dict
            As in a file; tuples and arrays may stand for lists.
        base : Path, optional
            Folder of the point and mesh files that the scene names.
        diagnostics : iterable of str
            What a reader found odd or left out; put before the scene's own.

        Raises
        ------
        SceneError
            Anything is missing, unknown, of the wrong kind or out of range; the message names it.

        Examples
        --------
        >>> Scene.from_dict({"deixis": 1, "id": "empty"}).objects
        ()
        """
        from deixis.scene_format import parse_scene

        parts = parse_scene(data)
        try:
            limits = Thresholds.of(parts.thresholds.model_dump(exclude_unset=True))
        except ThresholdError as cause:
            raise SceneError(f"scene {quoted(parts.id)}: {cause}") from cause
        objects = tuple(_object(part, base) for part in parts.objects)
        views = tuple(_view(part) for part in parts.views)
        known = {view.id for view in views}
        for thing in objects:
            if lost := [view for view in thing.seen_in if view not in known]:
                raise SceneError(f"object {quoted(thing.id)}: seen in {quoted(lost[0])}, no view: add it")
        scene = cls(parts.id, objects, views, limits, strays=parts.strays)
        object.__setattr__(scene, "diagnostics", (*diagnostics, *_oddities(scene)))
        return scene

    @cached_property
    def boxes(self) -> Boxes:
        """Return the minimum bounding boxes of the objects, in their order (axiom 10), surfaces marked."""
        rows = self._rows
        return Boxes(
            np.array([row.center for row in rows], dtype=np.float64).reshape(-1, 3),
            np.array([row.half for row in rows], dtype=np.float64).reshape(-1, 3),
            np.array([row.yaw for row in rows], dtype=np.float64),
            np.array([row.normal for row in rows], dtype=np.int64),
            np.array([row.ambiguous for row in rows], dtype=np.bool_),
        )

    @cached_property
    def regions(self) -> tuple[Region, ...]:
        """Return the objects' regions, in their order: point clouds without their strays (axiom 3)."""
        return tuple(
            part_of(thing.region, row.keep) for thing, row in zip(self.objects, self._rows, strict=True)
        )

    @cached_property
    def _rows(self) -> tuple[RegionBox, ...]:
        rows = []
        for thing in self.objects:
            try:
                rows.append(region_box(thing.region, thing.kind, self.thresholds, self.strays))
            except DeixisError as cause:
                raise SceneError(f"object {quoted(thing.id)}: {cause}") from cause
        return tuple(rows)

    @cached_property
    def _positions(self) -> dict[str, int]:
        return {thing.id: position for position, thing in enumerate(self.objects)}

    def index(self, name: str) -> int:
        """Return the position of the object with an id, or raise :class:`SceneError` with near misses."""
        position = self._positions.get(name)
        if position is None:
            near = difflib.get_close_matches(name, self._positions, n=3)
            hint = f"did you mean {', '.join(map(quoted, near))}?" if near else "give the id of one it has"
            raise SceneError(f"scene {quoted(self.id)} has no object {quoted(name)}: {hint}")
        return position

    def to_dict(self) -> dict[str, Any]:
        """Return the scene as JSON values of scene format v1, with all geometry written out."""
        result: dict[str, Any] = {"deixis": 1, "id": self.id}
        if self.strays != "drop":
            result["strays"] = self.strays
        result["objects"] = [_object_values(thing) for thing in self.objects]
        result["views"] = [_view_values(view) for view in self.views]
        defaults = dict(Thresholds().items())
        changed = {name: value for name, value in self.thresholds.items() if value != defaults[name]}
        return {**result, "thresholds": changed} if changed else result

    def to_json(self) -> str:
        """Return the scene as the text of a scene file, one object or view a line."""
        values = self.to_dict()
        lines = []
        for key, value in values.items():
            if isinstance(value, list) and value:
                rows = ",\n".join(f"  {json.dumps(item, ensure_ascii=False)}" for item in value)
                lines.append(f"{json.dumps(key)}: [\n{rows}\n ]")
            else:
                lines.append(f"{json.dumps(key)}: {json.dumps(value, ensure_ascii=False)}")
        return "{\n " + ",\n ".join(lines) + "\n}\n"

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the scene to a file, whole or not at all: an interrupted write leaves the old file."""
        place = Path(path)
        try:
            write_whole(place, self.to_json().encode())
        except OSError as cause:
            raise SceneError(f"{quoted(str(place), 200)} cannot be written: {cause.strerror}") from cause


def scene_schema() -> dict[str, Any]:
    """Return the JSON Schema of scene format v1, as exported to ``kb/scene.schema.json``."""
    from deixis import scene_format

    return scene_format.scene_schema()


def _object(part: ObjectPart, base: Path | None) -> SpatialObject:
    given = part.model_fields_set
    labels: tuple[Label, ...] = ()
    if "label" in given:
        labels = (Label(part.label),)
    elif "labels" in given:
        labels = tuple(Label(label.name, float(label.score)) for label in part.labels)
    try:
        region = _region(part, given, base)
    except SceneError as cause:
        raise SceneError(f"object {quoted(part.id)}: {cause}") from cause
    return SpatialObject(
        part.id, labels, part.kind, region, tuple(part.seen_in) if "seen_in" in given else ()
    )


def _region(part: ObjectPart, given: set[str], base: Path | None) -> Region:
    from deixis.mesh_file import locate, read_geometry

    if "box" in given:
        return BoxRegion(np.array(part.box.center), np.array(part.box.size), part.box.yaw)
    if "polygon" in given:
        return SurfaceRegion(np.array(part.polygon))
    if "points" in given:
        if isinstance(part.points, str):
            return PointRegion(read_geometry(locate(part.points, base))[0])
        return PointRegion(np.array(part.points))
    if isinstance(part.mesh, str):
        return MeshRegion(*read_geometry(locate(part.mesh, base)))
    return MeshRegion(np.array(part.mesh.vertices), np.array(part.mesh.faces))


def _view(part: ViewPart) -> View:
    given = part.model_fields_set
    label = part.label if "label" in given else ""
    stamp = float(part.stamp) if "stamp" in given else None
    return View(part.id, label, np.array(part.position), part.heading, stamp)


def _oddities(scene: Scene) -> list[str]:
    """Return sentences on what is allowed but looks like a mistake: units, angles, surfaces out of true."""
    notes = [
        f"{thing.kind} {quoted(thing.id)}: {row.note}"
        for thing, row in zip(scene.objects, scene._rows, strict=True)
        if row.note
    ]
    extents = 2.0 * scene.boxes.half.max(axis=1, initial=0.0)
    for position in np.flatnonzero(extents > HUGE):
        thing = scene.objects[int(position)]
        notes.append(f"object {quoted(thing.id)}: {extents[position]:,.0f} m long: is the unit millimetres?")
    if len(extents) and float(extents.max()) < TINY:
        notes.append(f"scene {quoted(scene.id)}: nothing is longer than 1 mm: is the unit kilometres?")
    turns = [(f"view {quoted(view.id)}: ", turned_oddly("heading", view.heading)) for view in scene.views]
    return notes + [name + note for name, note in turns if note]


def _object_values(thing: SpatialObject) -> dict[str, Any]:
    values: dict[str, Any] = {"id": thing.id}
    if thing.kind != "object":
        values["kind"] = thing.kind
    if len(thing.labels) == 1 and thing.labels[0].score == 1.0:
        values["label"] = thing.label
    elif thing.labels:
        values["labels"] = [{"name": label.name, "score": label.score} for label in thing.labels]
    values |= region_values(thing.region)
    return {**values, "seen_in": list(thing.seen_in)} if thing.seen_in else values


def _view_values(view: View) -> dict[str, Any]:
    values: dict[str, Any] = {"id": view.id}
    if view.label:
        values["label"] = view.label
    values["position"] = view.position.tolist()
    values["heading"] = view.heading
    return values if view.stamp is None else {**values, "stamp": view.stamp}
