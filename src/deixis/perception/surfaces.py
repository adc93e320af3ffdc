"""Surfaces: the planes of what no thing covers, told apart as floors, ceilings and walls, with their extents.

A level plane seen from above is a floor, one seen from below a ceiling, an upright one a wall (section 4.1
of the paper). A floor or ceiling is a polygon on its plane around all that was seen of it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, Literal

import numpy as np

from deixis.frames import Array
from deixis.perception.planes import Plane, find_planes
from deixis.pieces import pieces

Name = Literal["floor", "ceiling", "wall"]

SMALLEST: Final = 0.5
"""Square metres: what is smaller is furniture."""

LOWEST_WALL: Final = 0.6
"""Metres: what is not this tall is no wall."""

STEP: Final = 0.3
"""Metres: a level plane this much above the lowest is no floor but a table top nobody has named."""

GAP: Final = 2.0
"""Metres: patches of one plane this far apart are two surfaces."""

WITHIN: Final = 3.0
"""Standard deviations of noise from a plane within which a point lies on it."""

CLOSEST: Final = 0.015
"""Metres: and never less than this."""

LEAST: Final = 150
"""Points that make a plane."""

_CELL: Final = 0.1
_CROWD: Final = 2
_CHORD: Final = 0.01


@dataclass(frozen=True, slots=True)
class Surface:
    """A surface with its extent.

    Attributes
    ----------
    name : "floor", "ceiling" or "wall"
    polygon : (m, 3) float
        Convex, metres, world frame.
    normal : (3,) float
        Of length one, towards where it was seen from.
    members : (k,) int
        Points it was found with, by their positions in the cloud.
    """

    name: Name
    polygon: Array
    normal: Array
    members: np.ndarray[tuple[int], np.dtype[np.int64]]


def find_surfaces(points: Array, eyes: Array, noise: float) -> tuple[list[Surface], list[str]]:
    """Return the floors, ceilings and walls of a cloud, and sentences on the planes that are none of them.

    Parameters
    ----------
    points : (n, 3) float
        Metres, world frame.
    eyes : (n, 3) float
        Where each point was seen from.
    noise : float
        Standard deviation of depths, metres.
    """
    within = max(WITHIN * noise, CLOSEST)
    found: list[Surface] = []
    for plane in find_planes(points, within, LEAST):
        for members in _patches(points, plane):
            surface = _surface(points, eyes, plane, members)
            if surface is not None:
                found.append(surface)
    return _sorted_out(found)


def _patches(points: Array, plane: Plane) -> list[np.ndarray[tuple[int], np.dtype[np.int64]]]:
    """Return the members of a plane patch by patch, lone ones left out."""
    one, other = _axes(plane)
    flat = points[plane.members] @ np.stack([one, other], axis=1)
    low = flat.min(axis=0)
    cell = ((flat - low) / _CELL).astype(np.int64)
    key = cell[:, 0] * (int(cell[:, 1].max()) + 1) + cell[:, 1]
    known, place, count = np.unique(key, return_inverse=True, return_counts=True)
    crowded = count >= _CROWD
    if not crowded.any():
        return []
    width = int(cell[:, 1].max()) + 1
    middles = np.stack([known // width, known % width, np.zeros_like(known)], axis=1)[crowded] * _CELL
    label = np.full(len(known), -1)
    label[crowded] = pieces(np.ascontiguousarray(middles), GAP)[0]
    mine = label[place]
    return [plane.members[mine == number] for number in range(int(label.max()) + 1)]


def _axes(plane: Plane) -> tuple[Array, Array]:
    """Return two directions along a plane; of an upright one the first is level."""
    first = np.array([1.0, 0.0, 0.0]) if plane.level else np.cross([0.0, 0.0, 1.0], plane.normal)
    first = first - (first @ plane.normal) * plane.normal
    first /= np.linalg.norm(first)
    return first, np.cross(plane.normal, first)


def _surface(
    points: Array, eyes: Array, plane: Plane, members: np.ndarray[tuple[int], np.dtype[np.int64]]
) -> Surface | None:
    import shapely

    one, other = _axes(plane)
    flat = points[members] @ np.stack([one, other], axis=1)
    outline = shapely.convex_hull(shapely.linestrings(flat)).simplify(_CHORD)
    if outline.geom_type != "Polygon" or outline.area < SMALLEST:
        return None
    ring = shapely.get_coordinates(outline)[:-1]
    polygon = ring[:, :1] * one + ring[:, 1:] * other + plane.offset * plane.normal
    side = float(np.median((eyes[members] @ plane.normal) - plane.offset))
    normal = plane.normal if side >= 0.0 else -plane.normal
    if plane.level:
        name: Name = "floor" if normal[2] > 0.0 else "ceiling"
    elif np.ptp(polygon[:, 2]) < LOWEST_WALL:
        return None
    else:
        name = "wall"
    return Surface(name, polygon, normal, members)


def _sorted_out(found: list[Surface]) -> tuple[list[Surface], list[str]]:
    """Return the surfaces without shelves taken for floors or ceilings, and sentences on those."""
    heights = {id(one): float(one.polygon[:, 2].mean()) for one in found}
    floors = [heights[id(one)] for one in found if one.name == "floor"]
    ceilings = [heights[id(one)] for one in found if one.name == "ceiling"]
    kept, notes = [], []
    for one in found:
        height = heights[id(one)]
        shelf = one.name == "floor" and height > min(floors) + STEP
        shelf |= one.name == "ceiling" and height < max(ceilings) - STEP
        if shelf:
            notes.append(f"a level plane at {height:.2f} m is no {one.name}: left out")
        else:
            kept.append(one)
    return kept, notes
