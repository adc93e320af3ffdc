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
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, Final

import numpy as np

from deixis._files import write_whole
from deixis.boxes import Boxes
from deixis.errors import DeixisError, SceneError, ThresholdError
from deixis.frames import WORLD, Array
from deixis.hints import either
from deixis.pieces import Strays
from deixis.regions import (
    BoxRegion,
    MeshRegion,
    PointRegion,
    Region,
    RegionBox,
    SurfaceRegion,
    part_of,
    region_box,
    turned_oddly,
)
from deixis.strict_json import parse, quoted, read_bytes
from deixis.things import Label, SpatialObject, View, object_of, object_values, view_of, view_values
from deixis.thresholds import Thresholds

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


LARGE: Final = 10.0
"""Metres: where half of the things, surfaces apart, are longer than this the unit is more likely smaller."""

UNLIKE: Final = 1.0e3
"""Times as long as half of the others: a thing that is longer yet is more likely in another unit."""


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
            if len(set(ids)) < len(ids):
                repeated = [name for name, count in Counter(ids).items() if count > 1]
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
        objects = tuple(object_of(part, base) for part in parts.objects)
        views = tuple(view_of(part) for part in parts.views)
        known = {view.id for view in views}
        for thing in objects:
            lost = next((view for view in thing.seen_in if view not in known), None)
            if lost is not None:
                raise SceneError(
                    f"object {quoted(thing.id)}: seen in {quoted(lost)}, which is no view of the scene: "
                    "add it or leave it out"
                )
        scene = cls(parts.id, objects, views, limits, strays=parts.strays)
        object.__setattr__(scene, "diagnostics", (*diagnostics, *_oddities(scene)))
        return scene

    @cached_property
    def boxes(self) -> Boxes:
        """Return the minimum bounding boxes of the objects, in their order (axiom 10), surfaces marked."""
        return _boxes(self._rows)

    @cached_property
    def regions(self) -> tuple[Region, ...]:
        """Return the objects' regions, in their order: point clouds without their strays (axiom 3)."""
        return tuple(
            part_of(thing.region, row.keep) for thing, row in zip(self.objects, self._rows, strict=True)
        )

    @cached_property
    def _rows(self) -> tuple[RegionBox, ...]:
        return tuple(map(self._row, self.objects))

    def _row(self, thing: SpatialObject) -> RegionBox:
        try:
            return region_box(thing.region, thing.kind, self.thresholds, self.strays)
        except DeixisError as cause:
            raise SceneError(f"object {quoted(thing.id)}: {cause}") from cause

    @cached_property
    def _positions(self) -> dict[str, int]:
        return {thing.id: position for position, thing in enumerate(self.objects)}

    def changed(
        self,
        *,
        objects: Iterable[SpatialObject] = (),
        removed: Iterable[str] = (),
        views: Iterable[View] | None = None,
    ) -> Scene:
        """Return the scene with some objects replaced, added or removed, at a cost of only those.

        Parameters
        ----------
        objects : iterable of SpatialObject
            They take the place of those with their ids; others are put at the end.
        removed : iterable of str
            Ids of objects that are there no more.
        views : iterable of View, optional
            All views from now on; by default those there are.

        Raises
        ------
        SceneError
            What is to be removed is not there, an object is given twice or is both given and removed, or a
            region has no box.

        Examples
        --------
        >>> box = BoxRegion([0, 0, 0.4], [1, 1, 0.8])
        >>> scene = Scene("room", (SpatialObject("table", (), "object", box),))
        >>> cup = SpatialObject("cup", (), "object", BoxRegion([0, 0, 0.85], [0.1, 0.1, 0.1]))
        >>> [thing.id for thing in scene.changed(objects=[cup], removed=["table"]).objects]
        ['cup']
        """
        gone = {self.index(name) for name in removed}
        given = tuple(objects)
        twice = next((name for name, times in Counter(one.id for one in given).items() if times > 1), None)
        if twice is not None:
            raise SceneError(f"object {quoted(twice)} is given more than once: leave out all but one")
        rows = [self._row(thing) for thing in given]
        # Where each object given goes; those not there yet come after the others.
        things, every = list(self.objects), list(self._rows)
        source = np.arange(len(things))
        fresh = []
        for at, (thing, row) in enumerate(zip(given, rows, strict=True)):
            position = self._positions.get(thing.id)
            if position in gone:
                raise SceneError(f"object {quoted(thing.id)} is both given and removed: leave out one")
            if position is None:
                things.append(thing)
                every.append(row)
                fresh.append(len(self.objects) + at)
            else:
                things[position], every[position] = thing, row
                source[position] = len(self.objects) + at
        source = np.concatenate([source, np.array(fresh, dtype=np.int64)])
        if gone:
            stay = [at for at in range(len(things)) if at not in gone]
            things, every, source = [things[at] for at in stay], [every[at] for at in stay], source[stay]
        scene = Scene(
            self.id, tuple(things), self.views if views is None else tuple(views),
            self.thresholds, self.diagnostics, self.strays,
        )  # fmt: skip
        # Known already: cached_property looks here first.
        scene.__dict__["_rows"] = tuple(every)
        scene.__dict__["boxes"] = (
            self.boxes.joined(_boxes(rows)).take(source) if given or gone else self.boxes
        )
        if not gone and not fresh:
            scene.__dict__["_positions"] = self._positions
        return scene

    def index(self, name: str) -> int:
        """Return the position of the object with an id, or raise :class:`SceneError` with near misses."""
        position = self._positions.get(name)
        if position is None:
            near = difflib.get_close_matches(name, self._positions, n=3)
            hint = f"did you mean {either([*map(quoted, near)])}?" if near else "give the id of one it has"
            raise SceneError(f"scene {quoted(self.id)} has no object {quoted(name)}: {hint}")
        return position

    def to_dict(self) -> dict[str, Any]:
        """Return the scene as JSON values of scene format v1, with all geometry written out."""
        result: dict[str, Any] = {"deixis": 1, "id": self.id}
        if self.strays != "drop":
            result["strays"] = self.strays
        result["objects"] = [object_values(thing) for thing in self.objects]
        result["views"] = [view_values(view) for view in self.views]
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


def _boxes(rows: Sequence[RegionBox]) -> Boxes:
    return Boxes(
        np.array([row.center for row in rows], dtype=np.float64).reshape(-1, 3),
        np.array([row.half for row in rows], dtype=np.float64).reshape(-1, 3),
        np.array([row.yaw for row in rows], dtype=np.float64),
        np.array([row.normal for row in rows], dtype=np.int64),
        np.array([row.ambiguous for row in rows], dtype=np.bool_),
    )


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
    notes += _odd_lengths(scene, extents)
    turns = [(f"view {quoted(view.id)}: ", turned_oddly("heading", view.heading)) for view in scene.views]
    return notes + [name + note for name, note in turns if note]


def _odd_lengths(scene: Scene, extents: Array) -> list[str]:
    """Return sentences on objects that are too long, all of them or one beside the others."""
    things = np.array([at for at, thing in enumerate(scene.objects) if thing.kind == "object"], dtype=int)
    lengths = extents[things]
    if not len(things) or lengths.max() > HUGE:
        return []
    middle = float(np.median(lengths))
    if middle > LARGE:
        what = f"half of its objects are {middle:,.0f} m long or more"
        return [f"scene {quoted(scene.id)}: {what}: is the unit centimetres or millimetres?"]
    # Whichever of the longer half is left out, the median of the others is this.
    others = float(np.median(np.sort(lengths)[:-1])) if len(things) > 1 else 0.0
    unlike = things[lengths > UNLIKE * others] if others > 0.0 else things[:0]
    return [
        f"object {quoted(scene.objects[at].id)}: {extents[at]:,.3g} m long, and half of the others at most "
        f"{others:.2g} m: is its unit another?"
        for at in map(int, unlike)
    ]
