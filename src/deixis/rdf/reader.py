"""Scenes exported as RDF, read back: TriG, N-Quads, JSON-LD, Turtle or N-Triples, by the file's ending.

Only what a scene file says is read: things, regions, labels, views, thresholds. What followed from them
follows again. In which graph a statement stands does not matter.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from deixis.errors import ReaderError
from deixis.rdf.layout import TERM
from deixis.rdf.names import SCENE
from deixis.rdf.namespaces import RDF
from deixis.rdf.terms import BOX_NUMBERS, IDENTIFIER, LABEL, POSITION_NUMBERS, THRESHOLDS
from deixis.scene import Scene
from deixis.strict_json import quoted, read_bytes

if TYPE_CHECKING:
    from deixis.rdf.oxigraph import ox

MAX_BYTES: Final = 512 * 1024 * 1024
"""Longest file that is read."""


def read(path: str | os.PathLike[str]) -> Iterator[Scene]:
    """Read the scenes of an RDF file in the layout of ``deixis export``; FILE#SCENE picks one of several.

    Raises
    ------
    ReaderError
        The file is not RDF 1.1, or what it says of a scene is incomplete.
    """
    from deixis.rdf.formats import ending, parsed

    place, wanted = Path(path), None
    if not place.exists() and "#" in place.name:
        name, _, wanted = place.name.rpartition("#")
        place = place.with_name(name)
    form, what = ending(place), quoted(place.name, 200)
    statements = _Statements(parsed(read_bytes(place, ReaderError, MAX_BYTES), form, what), what)
    scenes = {statements.text(node, IDENTIFIER): node for node in statements.of_class("Scene")}
    if wanted is not None and wanted not in scenes:
        raise ReaderError(f"{what} has no scene {quoted(wanted)}: it has {', '.join(scenes)}")
    return (_scene(statements, node) for name, node in scenes.items() if wanted in (None, name))


def sniff(head: bytes) -> bool:
    """Return whether a file begins like an export.

    >>> sniff(b'<urn:deixis:scene:hans:thing:sign> a <urn:deixis:term:SpatialObject> .')
    True
    """
    return SCENE.encode() in head and head.lstrip()[:1] in (b"<", b"@", b"P", b"{", b"[")


class _Statements:
    """What an RDF file says, by subject and predicate."""

    def __init__(self, quads: list[ox.Quad], what: str) -> None:
        self._what = what
        self._values: dict[tuple[str, str], dict[str, None]] = {}
        for quad in quads:
            value = getattr(quad.object, "value", None)
            subject = getattr(quad.subject, "value", None)
            if value is not None and subject is not None:
                self._values.setdefault((subject, quad.predicate.value), {})[value] = None
        self._members: dict[tuple[str, str], list[str]] = {}
        for (subject, predicate), values in self._values.items():
            if predicate in (RDF + "type", TERM + "ofScene"):
                for value in values:
                    self._members.setdefault((predicate, value), []).append(subject)

    def of_class(self, name: str) -> list[str]:
        """Return the nodes of one of our classes, sorted."""
        return sorted(self._members.get((RDF + "type", TERM + name), ()))

    def of_scene(self, scene: str, name: str) -> list[str]:
        """Return a scene's nodes of one of our classes, in their order."""
        mine = set(self._members.get((TERM + "ofScene", scene), ()))
        return self.ordered([node for node in self.of_class(name) if node in mine])

    def ordered(self, nodes: list[str]) -> list[str]:
        """Return nodes by their ordinals, then by name; those without one last."""
        ordinal = TERM + "ordinal"
        keyed = [(self.maybe_number(node, ordinal), node) for node in nodes]
        return [node for _, node in sorted(keyed, key=lambda one: (one[0] is None, one[0] or 0.0, one[1]))]

    def all(self, node: str, predicate: str) -> list[str]:
        """Return all values."""
        return list(self._values.get((node, predicate), ()))

    def maybe(self, node: str, predicate: str) -> str | None:
        """Return the only value, or None where there is none."""
        values = self.all(node, predicate)
        if len(values) > 1:
            raise ReaderError(f"{self._what}: {node} has {len(values)} values of {predicate}: keep one")
        return values[0] if values else None

    def text(self, node: str, predicate: str) -> str:
        """Return the only value."""
        value = self.maybe(node, predicate)
        if value is None:
            raise ReaderError(f"{self._what}: {node} has no {predicate}: add it")
        return value

    def maybe_number(self, node: str, predicate: str) -> float | None:
        """Return the only value as a number, or None where there is none."""
        value = self.maybe(node, predicate)
        return None if value is None else self._as_number(value, node, predicate)

    def number(self, node: str, predicate: str) -> float:
        """Return the only value as a number."""
        return self._as_number(self.text(node, predicate), node, predicate)

    def rows(self, node: str, name: str, kind: type[float] | type[int] = float) -> list[list[float]]:
        """Return rows of numbers: a comma between rows, a space between numbers."""
        text = self.text(node, TERM + name)
        try:
            return [[kind(one) for one in row.split()] for row in text.split(",")]
        except ValueError as cause:
            raise ReaderError(f"{self._what}: {node} has {name} that are no rows of numbers") from cause

    def _as_number(self, value: str, node: str, predicate: str) -> float:
        try:
            return float(value)
        except ValueError as cause:
            wrong = f"{node} has {quoted(value)} for {predicate}: give a number"
            raise ReaderError(f"{self._what}: {wrong}") from cause


def _scene(said: _Statements, node: str) -> Scene:
    data: dict[str, Any] = {
        "deixis": 1,
        "id": said.text(node, IDENTIFIER),
        "strays": said.maybe(node, TERM + "strays") or "drop",
        "objects": [_object(said, thing) for thing in said.of_scene(node, "SpatialObject")],
        "views": [_view(said, view) for view in said.of_scene(node, "View")],
    }
    limits = said.maybe(node, TERM + "thresholds")
    if limits is not None:
        given = {name: said.maybe_number(limits, TERM + iri) for name, iri in THRESHOLDS.items()}
        data["thresholds"] = {name: value for name, value in given.items() if value is not None}
    elif not data["objects"] and not data["views"]:
        raise ReaderError(f"{node} has a name and no things: `deixis export` writes what can be read back")
    return Scene.from_dict(data)


def _object(said: _Statements, node: str) -> dict[str, Any]:
    values: dict[str, Any] = {"id": said.text(node, IDENTIFIER)}
    if TERM + "Surface" in said.all(node, RDF + "type"):
        values["kind"] = "surface"
    labels = [
        {"name": said.text(one, TERM + "labelName"), "score": said.number(one, TERM + "score")}
        for one in said.ordered(said.all(node, TERM + "recognised"))
    ]
    if labels:
        values["labels"] = labels
    return values | _region(said, said.text(node, TERM + "region"))


def _region(said: _Statements, node: str) -> dict[str, Any]:
    kinds = [one.removeprefix(TERM) for one in said.all(node, RDF + "type") if one.startswith(TERM)]
    match kinds:
        case ["BoxRegion"]:
            numbers = [said.number(node, TERM + name) for name in BOX_NUMBERS]
            yaw = said.maybe_number(node, TERM + "yaw") or 0.0
            return {"box": {"center": numbers[:3], "size": numbers[3:], "yaw": yaw}}
        case ["PointRegion"]:
            return {"points": said.rows(node, "vertices")}
        case ["MeshRegion"]:
            return {"mesh": {"vertices": said.rows(node, "vertices"), "faces": said.rows(node, "faces", int)}}
        case ["PolygonRegion"]:
            return {"polygon": said.rows(node, "vertices")}
    raise ReaderError(f"{node} is of {len(kinds)} kinds of region: give exactly one")


def _view(said: _Statements, node: str) -> dict[str, Any]:
    values: dict[str, Any] = {
        "id": said.text(node, IDENTIFIER),
        "position": [said.number(node, TERM + name) for name in POSITION_NUMBERS],
        "heading": said.maybe_number(node, TERM + "heading") or 0.0,
    }
    label, stamp = said.maybe(node, LABEL), said.maybe_number(node, TERM + "stamp")
    if label is not None:
        values["label"] = label
    return values if stamp is None else {**values, "stamp": stamp}
