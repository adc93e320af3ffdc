"""Small scenes in a line or two, for tests."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Any

from deixis.scene import Scene

ROBOT = {"id": "v0", "label": "robot", "position": [-5.0, 0.3, 0.4], "heading": 0.0}


def box(
    name: str, center: Sequence[float], size: Sequence[float], yaw: float = 0.0, label: str | None = None
) -> dict[str, Any]:
    """Return an object given by its box."""
    return {
        "id": name,
        "label": name if label is None else label,
        "box": {"center": list(center), "size": list(size), "yaw": yaw},
    }


def floor(name: str = "floor", half: float = 4.0, z: float = 0.0) -> dict[str, Any]:
    """Return a level square surface."""
    ring = [[-half, -half, z], [half, -half, z], [half, half, z], [-half, half, z]]
    return {"id": name, "kind": "surface", "label": "floor", "polygon": ring}


def wall(name: str = "wall", x: float = 2.0, half: float = 3.0, height: float = 2.5) -> dict[str, Any]:
    """Return an upright surface across the X axis."""
    ring = [[x, -half, 0.0], [x, half, 0.0], [x, half, height], [x, -half, height]]
    return {"id": name, "kind": "surface", "label": "wall", "polygon": ring}


def scene(
    *objects: dict[str, Any],
    views: Iterable[dict[str, Any]] = (ROBOT,),
    thresholds: dict[str, float] | None = None,
    name: str = "test",
) -> Scene:
    """Return the scene of some objects."""
    data: dict[str, Any] = {"deixis": 1, "id": name, "objects": list(objects), "views": list(views)}
    if thresholds is not None:
        data["thresholds"] = thresholds
    return Scene.from_dict(data)


def turned(data: dict[str, Any], angle: float, shift: Sequence[float] = (0.0, 0.0, 0.0)) -> dict[str, Any]:
    """Return an object or a view turned about the world's vertical and then shifted."""
    cos, sin = math.cos(angle), math.sin(angle)

    def move(point: Sequence[float]) -> list[float]:
        x, y, z = point
        return [cos * x - sin * y + shift[0], sin * x + cos * y + shift[1], z + shift[2]]

    result = dict(data)
    if "box" in data:
        result["box"] = {
            "center": move(data["box"]["center"]),
            "size": data["box"]["size"],
            "yaw": data["box"].get("yaw", 0.0) + angle,
        }
    for key in ("polygon", "points"):
        if key in data:
            result[key] = [move(point) for point in data[key]]
    if "position" in data:
        result["position"] = move(data["position"])
        result["heading"] = data["heading"] + angle
    return result
