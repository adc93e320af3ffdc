"""AI2-THOR rooms, one JSON object a line, already converted to a right-handed frame with Z up.

An object comes as an axis-aligned box and sometimes as the corners of an oriented one. Neither encloses
the other, since both are made from different meshes; the one with the smaller base is kept.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np

from deixis.boxes import min_bound_box
from deixis.errors import ReaderError
from deixis.readers._values import listing, mapping, readable, text, triple, words
from deixis.scene import Scene
from deixis.strict_json import parse, quoted, read_bytes

FRAME: Final = "right-handed z-up metres"
"""How the frame's description must begin, where a room gives one."""

DECIMALS: Final = 4
"""Of lengths in the files, and so of what is read from them."""

CONTACT_OFFSET: Final = 0.01
"""Metres: the gap at which Unity's physics lets two things rest on each other, so the granularity D here."""

TIGHTER: Final = 0.98
"""An oriented box is kept where its base is smaller than this share of the axis-aligned one's."""


@dataclass(frozen=True, slots=True)
class Parents:
    """What the simulator says of one object: the receptacles it is in or on, all by their short ids."""

    id: str
    label: str
    receptacles: tuple[str, ...]
    pickupable: bool
    receptacle: bool


def read(path: str | os.PathLike[str], *, scene: str | None = None) -> Iterator[Scene]:
    """Read AI2-THOR rooms; ``file#FloorPlan1`` or ``scene`` chooses one.

    Objects get short ids (``egg1``), see :func:`original_ids`. A floor becomes a surface at the top of
    its box, which in these rooms is where the agent stands. The robot faces the room's middle, because
    the files do not say where it looks. A simulator's boxes are exact: D is its physics' contact offset.

    Raises
    ------
    ReaderError
        The file is not of this format, or has no such room.
    """
    return (_scene(room) for room in _rooms(path, scene))


def sniff(head: bytes) -> bool:
    """Return whether a file begins like a line of this format.

    >>> sniff(b'{"scene": "FloorPlan1", "objects": [{"id": "Egg|0", "aabb_min": [0, 0, 0]')
    True
    """
    return head.startswith(b'{"scene"') and b'"aabb_min"' in head


def original_ids(path: str | os.PathLike[str], scene: str) -> dict[str, str]:
    """Return the simulator's id for each short id of a room."""
    return {short: original for original, short in _short_ids(next(_rooms(path, scene))).items()}


def parents(path: str | os.PathLike[str], scene: str) -> tuple[Parents, ...]:
    """Return what the simulator labels a room's objects with, in the scene's order.

    The labels are trigger contacts: trust them for ``pickupable`` objects only.
    """
    room = next(_rooms(path, scene))
    short = _short_ids(room)
    return tuple(
        Parents(
            short[record["id"]],
            words(record["label"]),
            tuple(short[name] for name in record.get("parents", []) if name in short),
            record.get("pickupable") is True,
            record.get("receptacle") is True,
        )
        for record in room["objects"]
    )


def _rooms(path: str | os.PathLike[str], scene: str | None) -> Iterator[dict[str, Any]]:
    """Yield the rooms, each a checked record with the key ``scene`` and a list of checked ``objects``."""
    place = Path(path)
    if scene is None and not place.exists() and "#" in place.name:
        name, _, scene = place.name.rpartition("#")
        place = place.with_name(name)
    rooms = []
    for number, line in enumerate(read_bytes(place, ReaderError).splitlines(), start=1):
        if line.strip():
            where = f"{quoted(place.name, 200)} line {number}"
            rooms.append(_room(mapping(parse(line, ReaderError, where), where), where))
    names = [room["scene"] for room in rooms]
    if scene is not None and scene not in names:
        raise ReaderError(f"{quoted(place.name, 200)} has no room {quoted(scene)}: it has {', '.join(names)}")
    return (room for room in rooms if scene in (None, room["scene"]))


def _room(room: dict[str, Any], where: str) -> dict[str, Any]:
    text(room, "scene", where)
    frame = room.get("frame", FRAME)
    if not isinstance(frame, str) or not frame.startswith(FRAME):
        raise ReaderError(f"{where} is in the frame {quoted(frame)}: convert it to {FRAME}")
    seen: set[str] = set()
    for index, record in enumerate(listing(room, "objects", where)):
        name = text(mapping(record, f"{where}: object number {index + 1}"), "id", f"{where}: an object")
        if name in seen:
            raise ReaderError(f"{where}: object {quoted(name)} is given more than once: keep one")
        seen.add(name)
        text(record, "label", f"{where}: object {quoted(name)}")
        if "parents" in record:
            listing(record, "parents", f"{where}: object {quoted(name)}")
    return room


def _short_ids(room: dict[str, Any]) -> dict[str, str]:
    return readable({record["id"]: words(record["label"]) for record in room["objects"]})


def _scene(room: dict[str, Any]) -> Scene:
    short = _short_ids(room)
    objects = [_object(record, short[record["id"]]) for record in room["objects"]]
    notes = (
        []
        if any(thing.get("kind") for thing in objects)
        else [f"scene {quoted(room['scene'])}: no floor is given"]
    )
    views = []
    if room.get("agent_position_trilaterated") is not None:
        position = triple(
            room["agent_position_trilaterated"], f"room {quoted(room['scene'])}: the agent's position"
        )
        ahead = _middle(objects) - position[:2]
        heading = round(float(np.arctan2(ahead[1], ahead[0])), DECIMALS)
        # Adding zero makes a negative zero positive.
        views = [
            {"id": "robot", "label": "robot", "position": (position + 0.0).tolist(), "heading": heading + 0.0}
        ]
    data = {
        "deixis": 1,
        "id": room["scene"],
        "objects": objects,
        "views": views,
        "thresholds": {"granularity": CONTACT_OFFSET},
    }
    return Scene.from_dict(data, diagnostics=notes)


def _object(record: dict[str, Any], short: str) -> dict[str, Any]:
    where = f"object {quoted(record['id'])}"
    low = triple(record.get("aabb_min"), f"{where}: aabb_min")
    high = triple(record.get("aabb_max"), f"{where}: aabb_max")
    if (high < low).any():
        raise ReaderError(f"{where}: aabb_max is below aabb_min: swap them")
    values: dict[str, Any] = {"id": short, "label": words(record["label"])}
    if values["label"] == "floor":
        top = float(high[2])
        ring = [(low[0], low[1]), (high[0], low[1]), (high[0], high[1]), (low[0], high[1])]
        return {
            "id": short,
            "kind": "surface",
            "label": "floor",
            "polygon": [[float(x), float(y), top] for x, y in ring],
        }
    center, size, yaw = 0.5 * (low + high), high - low, 0.0
    if record.get("obb_corners") is not None:
        corners = listing(record, "obb_corners", where)
        points = np.array([triple(corner, f"{where}: obb_corners") for corner in corners]).reshape(-1, 3)
        if len(points) == 0:
            raise ReaderError(f"{where}: obb_corners is empty: leave it out")
        middle, half, turn, _ = min_bound_box(points)
        if 4.0 * half[0] * half[1] < TIGHTER * size[0] * size[1]:
            # A tilted thing's upright box is taller than the thing: its true height is the other box's.
            center = np.array([middle[0], middle[1], center[2]])
            size = np.array([2.0 * half[0], 2.0 * half[1], size[2]])
            yaw = turn
    values["box"] = {"center": (center.round(DECIMALS) + 0.0).tolist(), "size": size.round(DECIMALS).tolist()}
    if yaw:
        values["box"]["yaw"] = round(yaw, DECIMALS)
    return values


def _middle(objects: list[dict[str, Any]]) -> np.ndarray[Any, np.dtype[np.float64]]:
    """Return the plan middle of the floors, or of all things where there is no floor, shape (2,)."""
    corners = [point for thing in objects for point in thing.get("polygon", [])]
    corners = corners or [thing["box"]["center"] for thing in objects] or [[0.0, 0.0, 0.0]]
    plan = np.array(corners)[:, :2]
    return np.asarray(0.5 * (plan.min(axis=0) + plan.max(axis=0)))
