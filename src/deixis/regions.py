"""Regions of space (axioms 1-3): boxes, point sets, meshes and flat surfaces, and the box of each.

A region is what was observed; its box is what the relations are computed with (axioms 9, 10). All lengths
are metres in the world frame: right-handed, Z up.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any, Final, Literal

import numpy as np
from numpy.typing import NDArray

from deixis.boxes import NO_NORMAL, min_bound_box
from deixis.errors import SceneError
from deixis.frames import QUARTER, Array, Mask
from deixis.pieces import Strays, chunks, one_piece
from deixis.thresholds import MAX_COORDINATE, SNAP, Thresholds

Kind = Literal["object", "surface"]

LEVEL_WITHIN: Final = 10.0
"""Degrees: a plane nearer to level, or to upright, than this is read as exactly so; the rest is noise."""

LINE_WIDTH: Final = 1.0e-6
"""Metres: points whose spread across their main direction is below this lie on one line."""

_FEW: Final = 1024
"""Points whose box is computed from all of them."""


def _fixed(values: Any, columns: int | None, name: str) -> Array:
    """Return a read-only float64 array of shape (3,) or (m, 3), refusing what is not finite or too large.

    Always in row order, so that sums come out the same however the caller's array lies in memory. A copy,
    unless nobody else can write to it: a large cloud need not be held twice.
    """
    try:
        taken = isinstance(values, np.ndarray) and values.dtype == np.float64 and values.flags.c_contiguous
        taken = taken and values.base is None and not values.flags.writeable
        array = values if taken else np.array(values, dtype=np.float64, order="C")
    except (TypeError, ValueError) as cause:
        raise SceneError(f"{name} is not an array of numbers: give metres as plain numbers") from cause
    shaped = array.shape == (3,) if columns is None else array.ndim == 2 and array.shape[1] == columns
    if not shaped:
        raise SceneError(f"{name} has the shape {array.shape}: give three numbers for each point")
    low, high = (float(array.min()), float(array.max())) if array.size else (0.0, 0.0)
    # A number that is none is also the least and the greatest.
    if not (math.isfinite(low) and math.isfinite(high)):
        raise SceneError(f"{name} holds a number that is not finite: drop such points")
    if max(-low, high) > MAX_COORDINATE:
        raise SceneError(f"{name} holds a number beyond {MAX_COORDINATE:g} m: use metres in a local frame")
    array.setflags(write=False)
    return array


@dataclass(frozen=True, eq=False, slots=True)
class BoxRegion:
    """A box with a level base.

    Attributes
    ----------
    center : (3,) float
        Metres, world frame.
    size : (3,) float
        Full extents along the box's own axes, metres; zero is allowed.
    yaw : float
        Radians, counter-clockwise, from the world's X axis to the box's.

    Raises
    ------
    SceneError
        A number is not finite, too large, or a size is negative.
    """

    center: Array
    size: Array
    yaw: float = 0.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "center", _fixed(self.center, None, "the box's center"))
        object.__setattr__(self, "size", _fixed(self.size, None, "the box's size"))
        if (self.size < 0.0).any():
            raise SceneError("the box's size is negative: give full extents, zero or more")
        if not math.isfinite(self.yaw):
            raise SceneError("the box's yaw is not finite: give radians")
        object.__setattr__(self, "yaw", float(self.yaw))


@dataclass(frozen=True, eq=False, slots=True)
class PointRegion:
    """A point set, such as a segment of a depth image: ``points`` has shape (m, 3), m >= 1, metres.

    A read-only float64 array that owns its numbers is taken as it is; any other is copied.
    """

    points: Array

    def __post_init__(self) -> None:
        object.__setattr__(self, "points", _fixed(self.points, 3, "the point set"))
        if len(self.points) == 0:
            raise SceneError("the point set is empty: give at least one point")


@dataclass(frozen=True, eq=False, slots=True)
class MeshRegion:
    """A triangle mesh.

    Attributes
    ----------
    vertices : (m, 3) float
        Metres, world frame, m >= 3.
    faces : (k, 3) int
        Positions in ``vertices``, k >= 1.
    """

    vertices: Array
    faces: NDArray[np.int64]

    def __post_init__(self) -> None:
        object.__setattr__(self, "vertices", _fixed(self.vertices, 3, "the mesh's vertices"))
        faces = np.array(self.faces)
        if faces.ndim != 2 or faces.shape[1] != 3 or len(faces) == 0 or faces.dtype.kind not in "iu":
            raise SceneError("the mesh has no triangles: give three vertex positions for each face")
        if faces.min() < 0 or faces.max() >= len(self.vertices):
            last = len(self.vertices) - 1
            raise SceneError(f"a face of the mesh names a vertex outside 0..{last}: repair it")
        faces = faces.astype(np.int64)
        faces.setflags(write=False)
        object.__setattr__(self, "faces", faces)


@dataclass(frozen=True, eq=False, slots=True)
class SurfaceRegion:
    """A flat bounded surface (wall, floor, ceiling): ``polygon`` has shape (m, 3), m >= 3, metres."""

    polygon: Array

    def __post_init__(self) -> None:
        object.__setattr__(self, "polygon", _fixed(self.polygon, 3, "the polygon"))
        if len(self.polygon) < 3:
            raise SceneError("the polygon has fewer than three points: give its corners in order")
        spread = self.polygon - self.polygon.mean(axis=0)
        if np.linalg.svd(spread, compute_uv=False)[1] <= LINE_WIDTH:
            raise SceneError("the polygon's points lie on one line: give corners that enclose an area")


Region = BoxRegion | PointRegion | MeshRegion | SurfaceRegion


def shifted(region: Region, offset: Array) -> Region:
    """Return a region moved by (3,) metres, not turned.

    Examples
    --------
    >>> shifted(BoxRegion([0.0, 0.0, 1.0], [1.0, 1.0, 1.0]), np.array([0.5, 0.0, 0.0])).center.tolist()
    [0.5, 0.0, 1.0]
    """
    match region:
        case BoxRegion():
            return replace(region, center=region.center + offset)
        case PointRegion():
            return replace(region, points=region.points + offset)
        case MeshRegion():
            return replace(region, vertices=region.vertices + offset)
        case SurfaceRegion():
            return replace(region, polygon=region.polygon + offset)


@dataclass(frozen=True, slots=True)
class RegionBox:
    """The box of one region, as a row of :class:`deixis.boxes.Boxes`, and what is odd about it.

    ``keep`` says which points of a point set are in the box; None where all are.
    """

    center: Array
    half: Array
    yaw: float
    normal: int
    ambiguous: bool
    note: str = ""
    keep: Mask | None = None


def region_box(region: Region, kind: Kind, limits: Thresholds, strays: Strays = "drop") -> RegionBox:
    """Return the minimum bounding box of a region (axiom 10), with the plane of a surface.

    A polygon is a plane: within :data:`LEVEL_WITHIN` degrees of level or of upright it is read as exactly
    that, with its scatter about the plane as its thickness (0 when it is flat). Any other polygon keeps
    its true box and counts as level. A surface given as a box or points has its thinnest axis for normal.
    A thing's point set is freed of its strays (axiom 3, decision 0015); a surface may be seen in patches.

    Parameters
    ----------
    region : Region
    kind : "object" or "surface"
    limits : Thresholds
        A surface bent by more than the granularity is worth a note; ``piece_gap`` parts strays.
    strays : "drop" or "refuse"

    Raises
    ------
    GeometryError
        A thing's point set has strays, and they are to be refused.

    Examples
    --------
    >>> floor = SurfaceRegion([[0, 0, 0], [4, 0, 0], [4, 3, 0], [0, 3, 0]])
    >>> box = region_box(floor, "surface", Thresholds())
    >>> box.normal, box.half.tolist()
    (2, [2.0, 1.5, 0.0])
    """
    if isinstance(region, SurfaceRegion):
        return _surface_box(region.polygon, limits.granularity)
    note, keep = "", None
    if isinstance(region, BoxRegion):
        center, half, yaw, ambiguous = region.center, 0.5 * region.size, region.yaw, False
        note = turned_oddly("yaw", yaw)
    elif isinstance(region, PointRegion):
        if kind == "object":
            keep, note = one_piece(region.points, max(limits.piece_gap, limits.granularity), strays)
        center, half, yaw, ambiguous = min_bound_box(_decisive(region.points, keep))
    else:
        # A vertex that no face uses is no part of the thing.
        center, half, yaw, ambiguous = min_bound_box(region.vertices[np.unique(region.faces)])
    # A slab as thick as it is wide is more likely a floor than a wall: level wins a tie.
    normal = NO_NORMAL if kind == "object" else min((2, 0, 1), key=lambda axis: float(half[axis]))
    return RegionBox(center, half, yaw, normal, ambiguous, note, keep)


def turned_oddly(name: str, angle: float) -> str:
    """Return a doubt about an angle of more than a full turn, or nothing."""
    odd = abs(angle) > 2.0 * math.pi + 1.0e-6
    return f"{name} {angle:g} is more than a full turn: is the unit degrees?" if odd else ""


def part_of(region: Region, keep: Mask | None) -> Region:
    """Return a region with only those points of a point set that are to be kept; any other as it is."""
    if keep is None or not isinstance(region, PointRegion):
        return region
    points = region.points[keep]
    points.setflags(write=False)
    return PointRegion(points)


def _decisive(points: Array, keep: Mask | None) -> Array:
    """Return the points that a minimum box hangs on, in the order given: it is that of all but for rounding.

    They are the corners of the plan's hull, one of the lowest points and one of the highest. Taken chunk by
    chunk, so that the work needs no memory to speak of.
    """
    some = [
        _corners(part if keep is None else part[keep[start : start + len(part)]])
        for start, part in chunks(points)
    ]
    return np.concatenate(some)


def _corners(points: Array) -> Array:
    if len(points) <= _FEW:
        return points
    import shapely

    ring = shapely.get_coordinates(shapely.convex_hull(shapely.linestrings(points[:, :2])))
    x, y, z = points.T
    decides = np.isin(x, ring[:, 0]) & np.isin(y, ring[:, 1])
    decides[[z.argmin(), z.argmax()]] = True
    return points[decides]


def region_values(region: Region) -> dict[str, Any]:
    """Return a region as it is written in scene format v1."""
    match region:
        case BoxRegion() as box:
            values: dict[str, Any] = {"center": box.center.tolist(), "size": box.size.tolist()}
            return {"box": {**values, "yaw": box.yaw} if box.yaw else values}
        case PointRegion() as cloud:
            return {"points": cloud.points.tolist()}
        case MeshRegion() as mesh:
            return {"mesh": {"vertices": mesh.vertices.tolist(), "faces": mesh.faces.tolist()}}
        case SurfaceRegion() as surface:
            return {"polygon": surface.polygon.tolist()}


def _surface_box(polygon: Array, granularity: float) -> RegionBox:
    middle = polygon.mean(axis=0)
    spread = polygon - middle
    plane = np.linalg.svd(spread, full_matrices=False)[2][2]
    tilt = float(np.degrees(np.arccos(min(1.0, abs(float(plane[2]))))))
    scatter = spread @ plane
    thickness = float(np.ptp(scatter))
    thickness = 0.0 if thickness <= SNAP else thickness
    centring = 0.5 * float(scatter.max() + scatter.min()) if thickness else 0.0
    if tilt <= LEVEL_WITHIN:
        center, half, yaw, ambiguous = min_bound_box(polygon)
        # The height of the plane under the rectangle's centre, not the mean of unevenly spaced corners.
        offset = float(plane[:2] @ (center[:2] - middle[:2]))
        height = float(middle[2]) - (offset - centring) / float(plane[2])
        if np.ptp(polygon[:, 2]) == 0.0:
            height = float(polygon[0, 2])
        bend = float(np.tan(np.radians(tilt)) * np.hypot(half[0], half[1]))
        center = np.array([center[0], center[1], height])
        half = np.array([half[0], half[1], 0.5 * thickness])
        note = f"tilted by {tilt:.1f} degrees, {bend:.2f} m at its edge: read as level"
        return RegionBox(center, half, yaw, 2, ambiguous, note if bend > granularity else "")
    if tilt >= 90.0 - LEVEL_WITHIN:
        facing = float(np.arctan2(plane[1], plane[0])) % np.pi
        outward = np.array([np.cos(facing), np.sin(facing)])
        along = spread[:, :2] @ np.array([-outward[1], outward[0]])
        low, high = float(polygon[:, 2].min()), float(polygon[:, 2].max())
        half_long, half_tall = 0.5 * float(np.ptp(along)), 0.5 * (high - low)
        level = 0.5 * (low + high)
        sideways = 0.5 * float(along.max() + along.min())
        # Where the plane stands at half height: a leaning wall is turned upright about its middle.
        forward = (centring - float(plane[2]) * (level - float(middle[2]))) / float(plane[:2] @ outward)
        plan = middle[:2] + forward * outward + sideways * np.array([-outward[1], outward[0]])
        bend = float(np.tan(np.radians(90.0 - tilt))) * half_tall
        note = f"leans by {90.0 - tilt:.1f} degrees, {bend:.2f} m at its top: read as upright"
        normal = 0 if facing < QUARTER else 1
        across = (0.5 * thickness, half_long) if normal == 0 else (half_long, 0.5 * thickness)
        return RegionBox(
            np.array([plan[0], plan[1], level]),
            np.array([*across, half_tall]),
            facing - normal * QUARTER,
            normal,
            False,
            note if bend > granularity else "",
        )
    center, half, yaw, ambiguous = min_bound_box(polygon)
    note = f"slopes by {tilt:.0f} degrees, neither level nor upright: its whole box counts as a level surface"
    return RegionBox(center, half, yaw, 2, ambiguous, note)
