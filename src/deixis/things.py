"""Things and views: what a scene is made of, and how each is written in a scene file."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from deixis.errors import SceneError
from deixis.frames import Array
from deixis.regions import (
    BoxRegion,
    Kind,
    MeshRegion,
    PointRegion,
    Region,
    SurfaceRegion,
    region_values,
)
from deixis.strict_json import quoted

if TYPE_CHECKING:
    from deixis.scene_format import ObjectPart, ViewPart


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
    """

    id: str
    labels: tuple[Label, ...]
    kind: Kind
    region: Region

    def __post_init__(self) -> None:
        ranked = tuple(sorted(self.labels, key=lambda label: -label.score))
        object.__setattr__(self, "labels", ranked)

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


def object_of(part: ObjectPart, base: Path | None) -> SpatialObject:
    """Return the object that a part of a scene file describes; files that it names lie in the folder base."""
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
    return SpatialObject(part.id, labels, part.kind, region)


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


def view_of(part: ViewPart) -> View:
    """Return the view that a part of a scene file describes."""
    given = part.model_fields_set
    label = part.label if "label" in given else ""
    stamp = float(part.stamp) if "stamp" in given else None
    return View(part.id, label, np.array(part.position), part.heading, stamp)


def object_values(thing: SpatialObject) -> dict[str, Any]:
    """Return an object as JSON values of scene format v1, with all geometry written out."""
    values: dict[str, Any] = {"id": thing.id}
    if thing.kind != "object":
        values["kind"] = thing.kind
    if len(thing.labels) == 1 and thing.labels[0].score == 1.0:
        values["label"] = thing.label
    elif thing.labels:
        values["labels"] = [{"name": label.name, "score": label.score} for label in thing.labels]
    return values | region_values(thing.region)


def view_values(view: View) -> dict[str, Any]:
    """Return a view as JSON values of scene format v1."""
    values: dict[str, Any] = {"id": view.id}
    if view.label:
        values["label"] = view.label
    values["position"] = view.position.tolist()
    values["heading"] = view.heading
    return values if view.stamp is None else {**values, "stamp": view.stamp}
