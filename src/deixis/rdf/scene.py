"""A scene as quads: its things with labels and regions, its views, its thresholds.

All that a scene file says is here, so that a scene can be read back (:mod:`deixis.rdf.reader`).
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Final

import numpy as np

from deixis.boxes import Boxes
from deixis.facts import SolidModel
from deixis.frames import Array
from deixis.rdf.layout import TERM
from deixis.rdf.names import SceneNames
from deixis.rdf.namespaces import GEO
from deixis.rdf.quads import GraphWriter
from deixis.rdf.terms import BOX_NUMBERS, IDENTIFIER, LABEL, POSITION_NUMBERS, THRESHOLDS
from deixis.scene import BoxRegion, MeshRegion, PointRegion, Region, Scene, SpatialObject, SurfaceRegion

# The six faces of a box by its corners, which are counted in binary: x, y, z low or high; outwards.
_FACES: Final = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))


def write_things(
    to: GraphWriter, scene: Scene, names: SceneNames, measured_as: Mapping[str, SolidModel]
) -> None:
    """Write the things of a scene and what they were measured as."""
    for position, thing in enumerate(scene.objects):
        iri = names.thing(thing.id)
        _named(to, iri, thing)
        to.link(iri, TERM + "ofScene", names.scene)
        to.whole(iri, TERM + "ordinal", position)
        to.text(iri, TERM + "measuredAs", measured_as[thing.id])
        _labels(to, iri, thing)
        region = f"{iri}:region"
        to.link(iri, TERM + "region", region)
        _region(to, region, thing.region)
        box = f"{iri}:box"
        to.link(iri, TERM + "minBoundBox", box)
        _min_bound_box(to, box, scene.boxes, position, names.frame)


def write_named(to: GraphWriter, scene: Scene, names: SceneNames, some: Collection[str]) -> None:
    """Write of some things only what they are called."""
    for thing in scene.objects:
        if thing.id in some:
            _named(to, names.thing(thing.id), thing)


def write_identity(to: GraphWriter, scene: Scene, names: SceneNames) -> None:
    """Write that there is a scene, and what it is called."""
    to.typed(names.scene, TERM + "Scene")
    to.text(names.scene, IDENTIFIER, scene.id)


def write_scene(to: GraphWriter, scene: Scene, names: SceneNames) -> None:
    """Write what a scene is called, its thresholds, and from where it is seen."""
    write_identity(to, scene, names)
    to.text(names.scene, TERM + "strays", scene.strays)
    to.link(names.scene, TERM + "thresholds", names.thresholds)
    to.typed(names.thresholds, TERM + "Thresholds")
    for name, value in scene.thresholds.items():
        to.number(names.thresholds, TERM + THRESHOLDS[name], value)
    for position, view in enumerate(scene.views):
        iri = names.view(view.id)
        to.typed(iri, TERM + "View")
        to.link(iri, TERM + "ofScene", names.scene)
        to.text(iri, IDENTIFIER, view.id)
        to.whole(iri, TERM + "ordinal", position)
        if view.label:
            to.text(iri, LABEL, view.label)
        for name, value in zip(POSITION_NUMBERS, view.position.tolist(), strict=True):
            to.number(iri, TERM + name, value)
        to.number(iri, TERM + "heading", view.heading)
        if view.stamp is not None:
            to.number(iri, TERM + "stamp", view.stamp)


def _named(to: GraphWriter, iri: str, thing: SpatialObject) -> None:
    to.typed(iri, TERM + "SpatialObject")
    if thing.kind == "surface":
        to.typed(iri, TERM + "Surface")
    to.text(iri, IDENTIFIER, thing.id)
    if thing.label:
        to.text(iri, LABEL, thing.label)


def _labels(to: GraphWriter, iri: str, thing: SpatialObject) -> None:
    for rank, label in enumerate(thing.labels):
        node = f"{iri}:label:{rank}"
        to.link(iri, TERM + "recognised", node)
        to.typed(node, TERM + "Recognition")
        to.whole(node, TERM + "ordinal", rank)
        to.text(node, TERM + "labelName", label.name)
        to.number(node, TERM + "score", label.score)


def _region(to: GraphWriter, iri: str, region: Region) -> None:
    match region:
        case BoxRegion():
            to.typed(iri, TERM + "BoxRegion")
            _box_numbers(to, iri, region.center, region.size, region.yaw)
        case PointRegion():
            to.typed(iri, TERM + "PointRegion")
            to.text(iri, TERM + "vertices", _numbers(region.points))
        case MeshRegion():
            to.typed(iri, TERM + "MeshRegion")
            to.text(iri, TERM + "vertices", _numbers(region.vertices))
            to.text(iri, TERM + "faces", _numbers(region.faces))
        case SurfaceRegion():
            to.typed(iri, TERM + "PolygonRegion")
            to.text(iri, TERM + "vertices", _numbers(region.polygon))


def _min_bound_box(to: GraphWriter, iri: str, boxes: Boxes, at: int, frame: str) -> None:
    center, half, yaw = boxes.center[at], boxes.half[at], float(boxes.yaw[at])
    to.typed(iri, TERM + "MinBoundBox")
    _box_numbers(to, iri, center, 2.0 * half, yaw)
    signs = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    cos, sin = np.cos(yaw), np.sin(yaw)
    turn = np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])
    corners = np.round(center + (signs * half) @ turn.T, 9) + 0.0
    rings = ", ".join(f"(({_numbers(corners[[*face, face[0]]])}))" for face in _FACES)
    to.literal(iri, GEO + "asWKT", f"<{frame}> POLYHEDRALSURFACE Z ({rings})", GEO + "wktLiteral")


def _box_numbers(to: GraphWriter, iri: str, center: Array, size: Array, yaw: float) -> None:
    for name, value in zip(BOX_NUMBERS, [*center.tolist(), *size.tolist()], strict=True):
        to.number(iri, TERM + name, value)
    to.number(iri, TERM + "yaw", yaw)


def _numbers(rows: np.ndarray[tuple[int, ...], np.dtype[np.generic]]) -> str:
    """Return rows of numbers as text: a comma between rows, a space between numbers, to the last bit."""
    return ", ".join(" ".join(map(repr, row)) for row in rows.tolist())
