"""VirtualHome graphs: JSON with axis-aligned boxes in Unity's frame, Y up and left-handed.

The frame is converted once, here: x = unity z, y = -unity x, z = unity y. One axis is turned over, since
exchanging axes alone would keep the frame left-handed and swap left and right.
"""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Final

import numpy as np

from deixis.errors import ReaderError
from deixis.frames import Array
from deixis.readers._values import listing, mapping, numbered_stem, text, triple, words
from deixis.scene import Scene
from deixis.strict_json import parse, quoted, read_bytes

SURFACES: Final = {"Floor": "floor", "Floors": "floor", "Ceiling": "ceiling", "Walls": "wall"}
"""Categories of the building's own parts, and what they are called."""

ROOMS: Final = "Rooms"

THIN: Final = 0.2
"""Metres: a wall thicker than this is a corner piece, whose box is mostly the room in front of it."""

DECIMALS: Final = 5


def read(path: str | os.PathLike[str], *, view: str | Sequence[float] | None = None) -> Scene:
    """Read a VirtualHome graph; ``view`` is the robot's x, y, z, heading (Z up), which the graph has not.

    Ids are the class name and the number (``plate41``). Floors, ceilings and straight walls become
    surfaces. Rooms, corner pieces of walls and nodes without a box are left out and counted in the
    diagnostics.

    Raises
    ------
    ReaderError
        The file is not of this format, or ``view`` is not four numbers.
    """
    place = Path(path)
    nodes, _ = _graph(place)
    kept = _kept(nodes)
    left_out = Counter(_reason(node) for node in nodes if node["id"] not in kept)
    name = quoted(place.stem, 200)
    notes = [f"scene {name}: {count} {reason} left out" for reason, count in sorted(left_out.items())]
    objects = [_object(node, kept[node["id"]]) for node in nodes if node["id"] in kept]
    data = {"deixis": 1, "id": place.stem, "objects": objects, "views": [] if view is None else [_view(view)]}
    return Scene.from_dict(data, diagnostics=notes)


def sniff(head: bytes) -> bool:
    """Return whether a file begins like a graph of this format.

    >>> sniff(b'{"nodes": [{"id": 1, "category": "Rooms", "class_name": "bathroom"')
    True
    """
    return b'"nodes"' in head and b'"class_name"' in head


def edges(path: str | os.PathLike[str]) -> tuple[tuple[str, str, str], ...]:
    """Return the simulator's own relations (figure, relation, reference) between things of the scene.

    The relation is one of ON, INSIDE, CLOSE, FACING, BETWEEN; relations to what :func:`read` leaves out
    are left out here.
    """
    nodes, links = _graph(Path(path))
    kept = _kept(nodes)
    result = []
    for number, link in enumerate(links):
        where = f"edge number {number + 1}"
        record = mapping(link, where)
        relation = text(record, "relation_type", where)
        figure, reference = record.get("from_id"), record.get("to_id")
        if figure in kept and reference in kept:
            result.append((kept[figure], relation, kept[reference]))
    return tuple(result)


def to_world(unity: Array) -> Array:
    """Return points of Unity's left-handed frame with Y up in the right-handed one with Z up.

    Parameters
    ----------
    unity : (..., 3) float
        Metres: right, up, forward.

    Returns
    -------
    (..., 3) float
        Metres: forward, left, up.

    Examples
    --------
    >>> to_world(np.array([1.0, 2.0, 3.0])).tolist()
    [3.0, -1.0, 2.0]
    """
    return np.stack([unity[..., 2], -unity[..., 0], unity[..., 1]], axis=-1)


def _graph(place: Path) -> tuple[list[dict[str, Any]], list[Any]]:
    name = quoted(place.name, 200)
    graph = mapping(parse(read_bytes(place, ReaderError), ReaderError, name), name)
    nodes = listing(graph, "nodes", name)
    seen: set[int] = set()
    for index, node in enumerate(nodes):
        where = f"{name}: node number {index + 1}"
        number = mapping(node, where).get("id")
        if isinstance(number, bool) or not isinstance(number, int):
            raise ReaderError(f"{where} has no whole number 'id': add it")
        if number in seen:
            raise ReaderError(f"{name}: node {number} is given more than once: keep one")
        seen.add(number)
        text(node, "class_name", f"{name}: node {number}")
    return nodes, listing(graph, "edges", name)


def _reason(node: dict[str, Any]) -> str:
    """Return why a node is no thing of the scene, or the empty string if it is one."""
    if node.get("category") == ROOMS:
        return "rooms (they hold everything)"
    if node.get("bounding_box") is None:
        return "nodes without a box"
    if node.get("category") in SURFACES and float(_extents(node)[1].min()) > THIN:
        return "corner pieces of walls (their boxes are mostly empty)"
    return ""


def _kept(nodes: list[dict[str, Any]]) -> dict[int, str]:
    return {
        node["id"]: f"{numbered_stem(node['class_name'])}{node['id']}" for node in nodes if not _reason(node)
    }


def _extents(node: dict[str, Any]) -> tuple[Array, Array]:
    """Return centre and size of a node's box in the world frame, metres."""
    where = f"node {node['id']}: bounding_box"
    box = mapping(node["bounding_box"], where)
    size = triple(box.get("size"), f"{where}.size")
    if (size < 0.0).any():
        raise ReaderError(f"{where}.size is negative: {quoted(box['size'])}")
    return to_world(triple(box.get("center"), f"{where}.center")), np.abs(to_world(size))


def _object(node: dict[str, Any], name: str) -> dict[str, Any]:
    center, size = _extents(node)
    values: dict[str, Any] = {"id": name, "label": words(node["class_name"])}
    if node.get("category") in SURFACES:
        values = {"id": name, "kind": "surface", "label": SURFACES[node["category"]]}
    # Adding zero makes a negative zero positive.
    values["box"] = {"center": (center.round(DECIMALS) + 0.0).tolist(), "size": size.round(DECIMALS).tolist()}
    return values


def _view(view: str | Sequence[float]) -> dict[str, Any]:
    try:
        x, y, z, heading = (float(part) for part in (view.split(",") if isinstance(view, str) else view))
    except (TypeError, ValueError) as cause:
        raise ReaderError(f"view is {quoted(view)}: give four numbers x,y,z,heading") from cause
    return {"id": "robot", "label": "robot", "position": [x, y, z], "heading": heading}
