"""Contact: how far two solids are apart, or how deep they overlap, and along which direction.

Distances are exact: GJK between convex solids, trees of bounding volumes between meshes (the FCL library).
The overlap of convex solids is the least translation that parts them. That of others is an estimate from
below: the depth of the deepest point of either within the matter of the other.
"""

from __future__ import annotations

import threading
from dataclasses import dataclass
from typing import Any, Final
from weakref import WeakKeyDictionary

import numpy as np

from deixis.boxes import NO_NORMAL
from deixis.errors import MissingDependency
from deixis.frames import Array
from deixis.solids.cavity import matter_depth
from deixis.solids.hulls import Hull, directions
from deixis.solids.solid import Points, Pose, Solid
from deixis.thresholds import Thresholds

STEEP: Final = float(np.sqrt(0.5))
"""A direction with at least this much of its length along Z is upright; any other is level."""

_NEAR: Final = 1.0e-4
"""Metres: of what is nearer than this the direction is that of the contact, not of the nearest points."""

_TOUCHING: Final = 1.0e-3
"""Metres: hulls that overlap by less no more than touch."""

_ON: Final = 1.0e-7
"""Metres: a point nearer than this to a surface is on it."""

_PATCH: Final = 400
"""Points of either solid that the direction of a contact is found from."""

_TRIED: Final = directions(256)
"""Directions that a contact may be parted along, before the best is bettered."""


@dataclass(frozen=True, slots=True)
class Separation:
    """How two solids a and b lie to each other.

    Attributes
    ----------
    distance : float
        Metres, the distance of the two regions or minus the depth of their overlap.
    normal : (3,) float
        Unit vector from b to a, in b's frame.
    hulls : float
        Metres, the same of their convex hulls, where only the sign counts.
    """

    distance: float
    normal: Array
    hulls: float


@dataclass(frozen=True, slots=True)
class _Shape:
    """A solid as FCL sees it: once to stand still, once to be moved about; a mesh or a convex hull."""

    still: Any
    moved: Any
    mesh: bool


_HULLS: WeakKeyDictionary[Hull, _Shape] = WeakKeyDictionary()
_MESHES: WeakKeyDictionary[Solid, _Shape] = WeakKeyDictionary()

_MOVING = threading.Lock()
"""Held from placing a shape until its distance is known: scenes may share things, and threads scenes."""


def separate(a: Solid, b: Solid, pose: Pose, limits: Thresholds, far: float = np.inf) -> Separation:
    """Return the signed separation of two solids, with its direction.

    Parameters
    ----------
    a, b : Solid
    pose : Pose
        Of a in b's frame.
    limits : Thresholds
    far : float
        Metres: of solids whose hulls are further apart, the distance of the hulls will do.

    Raises
    ------
    MissingDependency
        FCL is not installed.
    """
    hulls, at_a, at_b = _distance(_hull_shape(a), _hull_shape(b), pose)
    if a.convex and b.convex:
        if hulls > _NEAR:
            return Separation(hulls, (at_a - at_b) / hulls, hulls)
        distance, normal = _parting(a, b, pose, at_a - at_b, limits)
        return Separation(max(distance, hulls) if hulls > 0.0 else distance, normal, hulls)
    if hulls > far:
        return Separation(hulls, (at_a - at_b) / hulls, hulls)
    if hulls > _NEAR and _on_surface(a, pose.back.place(at_a[None])) and _on_surface(b, at_b[None]):
        return Separation(hulls, (at_a - at_b) / hulls, hulls)
    if hulls <= _NEAR and (_pierces(a, b, pose) or _pierces(b, a, pose.back)):
        distance = 0.0
    else:
        distance, at_a, at_b = _distance(_matter_shape(a), _matter_shape(b), pose)
    depth = 0.0
    if hulls <= 0.0:
        # Surfaces that do not cross: one of the two may still be wholly within the other.
        depth = _depth(a, b, pose, crossing=distance <= 0.0)
    if depth == 0.0 and distance > limits.granularity:
        return Separation(distance, (at_a - at_b) / distance, hulls)
    distance = -depth if depth > 0.0 else max(distance, 0.0)
    offset = at_a - at_b if distance > _NEAR else np.zeros(3)
    if hulls > -_TOUCHING:
        gap, normal = _parting(a, b, pose, offset, limits)
        if gap > -_TOUCHING:
            # Hulls that no more than touch do so where their solids do.
            return Separation(distance, normal, hulls)
    return Separation(distance, _direction(a, b, pose, distance, offset, limits), hulls)


def nearest(a: Solid, b: Solid, pose: Pose, *, hulls: bool) -> tuple[float, Array, Array]:
    """Return the distance of two solids, or of their hulls, and the nearest point of each in b's frame.

    Where they meet, the points mean nothing.
    """
    shape = _hull_shape if hulls else _matter_shape
    return _distance(shape(a), shape(b), pose)


def _pierces(a: Solid, b: Solid, pose: Pose) -> bool:
    """Return whether a corner of a lies in b, which is convex: then they meet, and no tree need be asked."""
    return b.convex and bool((b.hull.depth(pose.place(a.hull.corners).astype(np.float32)) >= -_ON).any())


def protrusion(a: Solid, b: Solid, pose: Pose) -> float:
    """Return how far a sticks out of the hull of b, metres; not positive when it is within."""
    planes = b.hull.planes
    return float(((pose.place(a.hull.corners) @ planes[:, :3].T).max(axis=0) + planes[:, 3]).max())


def _fcl() -> Any:
    try:
        import fcl
    except ImportError as cause:
        raise MissingDependency(
            "hulls and meshes are measured with python-fcl: pip install 'deixis[mesh]', or use --region box"
        ) from cause
    return fcl


def _shape(geometry: Any, *, mesh: bool) -> _Shape:
    fcl = _fcl()
    return _Shape(fcl.CollisionObject(geometry), fcl.CollisionObject(geometry), mesh)


def _hull_shape(solid: Solid) -> _Shape:
    hull = solid.hull
    found = _HULLS.get(hull)
    if found is None:
        corners = np.column_stack([np.full(len(hull.faces), 3), hull.faces])
        geometry = _fcl().Convex(np.array(hull.points), len(corners), corners.reshape(-1))
        found = _HULLS[hull] = _shape(geometry, mesh=False)
    return found


def _matter_shape(solid: Solid) -> _Shape:
    if solid.convex:
        return _hull_shape(solid)
    found = _MESHES.get(solid)
    if found is None:
        geometry = _fcl().BVHModel()
        geometry.beginModel(len(solid.vertices), len(solid.faces))
        geometry.addSubModel(solid.vertices, solid.faces)
        geometry.endModel()
        found = _MESHES[solid] = _shape(geometry, mesh=True)
    return found


def _distance(a: _Shape, b: _Shape, pose: Pose) -> tuple[float, Array, Array]:
    """Return the distance of two shapes, and the nearest point of each in b's frame."""
    fcl = _fcl()
    result = fcl.DistanceResult()
    request = fcl.DistanceRequest(enable_nearest_points=True, enable_signed_distance=True)
    with _MOVING:
        a.moved.setTransform(fcl.Transform(pose.matrix, pose.shift))
        distance = float(fcl.distance(a.moved, b.still, request, result))
    at_a, at_b = result.nearest_points
    if b.mesh and not a.mesh:
        # Asked for a convex shape and a mesh, FCL measures mesh and shape, and tells the mesh's point first.
        at_a, at_b = at_b, at_a
    return distance, at_a, at_b


def _on_surface(solid: Solid, point: Array) -> bool:
    """Return whether a point of a solid's hull, (1, 3), is certainly on its surface."""
    if solid.convex:
        return True
    if len(solid.covered) and (np.abs(point @ solid.covered[:, :3].T + solid.covered[:, 3]) < _ON).any():
        return True
    return bool((np.abs(solid.hull.points - point).max(axis=1) < _ON).any())


def _parting(a: Solid, b: Solid, pose: Pose, offset: Array, limits: Thresholds) -> tuple[float, Array]:
    """Return the widest gap between two convex solids that a plane may be put in, and its normal.

    Where they overlap it is negative: minus the least translation. Of two that overlap one that lies in
    the other does not leave it through the bottom (decision 0004).
    """
    points_a, planes_b = pose.place(a.hull.corners), b.hull.planes
    points_b, planes_a = pose.back.place(b.hull.corners), a.hull.planes
    spread_a, spread_b = points_a @ planes_b[:, :3].T, points_b @ planes_a[:, :3].T
    normals = [planes_b[:, :3], -pose.turn(planes_a[:, :3])]
    gaps = [spread_a.min(axis=0) + planes_b[:, 3], spread_b.min(axis=0) + planes_a[:, 3]]
    length = float(np.linalg.norm(offset))
    if length > _ON:
        # Between two edges the plane is neither's face. Its normal is where FCL sees it, either way.
        tried = np.stack([offset, -offset]) / length
        normals.append(tried)
        gaps.append((points_a @ tried.T).min(axis=0) - (b.hull.corners @ tried.T).max(axis=0))
    normal, gap = np.concatenate(normals), np.concatenate(gaps)
    a_within = b.normal == NO_NORMAL and (spread_a.max(axis=0) + planes_b[:, 3]).max() <= limits.granularity
    b_within = a.normal == NO_NORMAL and (spread_b.max(axis=0) + planes_a[:, 3]).max() <= limits.granularity
    if a_within != b_within:
        down = normal[:, 2] <= -STEEP if a_within else normal[:, 2] >= STEEP
        gap = np.where(down, -np.inf, gap)
    best = int(gap.argmax())
    return float(gap[best]), normal[best]


def _depth(a: Solid, b: Solid, pose: Pose, *, crossing: bool) -> float:
    """Return the depth of the deepest point of either in the matter of the other, metres.

    Of solids whose surfaces do not cross a few points are enough to know.
    """
    if a.outline is not None or b.outline is not None:
        return _depth_in_surface(a, b, pose)
    deepest = 0.0
    for one, other, there in ((a, b, pose), (b, a, pose.back)):
        points = (one.probes if crossing else one.scouts).within(*there.back.around(other.hull, 0.0)).points
        deepest = max(deepest, float(matter_depth(other, there.place(points)).max(initial=0.0)))
    return deepest


def _depth_in_surface(a: Solid, b: Solid, pose: Pose) -> float:
    """Return the least translation that brings a solid out of a flat surface: to a side, or over a border."""
    import shapely

    if b.outline is None:
        a, b, pose = b, a, pose.back
    points = pose.place(a.probes.points).astype(np.float64)
    plan = points[:, [axis for axis in range(3) if axis != b.normal]]
    over = shapely.intersects_xy(b.outline, plan)
    if not over.any():
        return 0.0
    height, thick = points[over, b.normal], float(b.half[b.normal])
    sides = max(0.0, float(height.max()) + thick), max(0.0, thick - float(height.min()))
    border = shapely.distance(b.outline.boundary, shapely.points(plan[over]))
    return min(*sides, float(border.max()))


def _direction(a: Solid, b: Solid, pose: Pose, distance: float, offset: Array, limits: Thresholds) -> Array:
    """Return the direction in which a contact is most easily parted: the normal of the plane between them.

    It is found from the points of either that are near the other, so that a book that leans on the edge of
    a box is parted from it along the book's own normal.
    """
    band = max(distance, 0.0) + limits.granularity
    near_a, near_b = _patches(a, b, pose, band)
    length = float(np.linalg.norm(offset))
    if not len(near_a) or not len(near_b):
        if length > _ON:
            return offset / length
        near_a, near_b = pose.place(a.hull.corners), b.hull.corners
    tried = _TRIED
    if length > _ON:
        tried = np.concatenate([tried, offset[None] / length])
    best = tried[_gaps(near_a, near_b, tried).argmax()]
    for width in (0.12, 0.05, 0.02):
        tried = best + width * _TRIED[::4]
        tried = np.concatenate([best[None], tried / np.linalg.norm(tried, axis=1)[:, None]])
        best = tried[_gaps(near_a, near_b, tried).argmax()]
    return np.asarray(best, dtype=np.float64)


def _gaps(a: Array, b: Array, normals: Array) -> Array:
    """Return how wide the gap is between points a and b along normals, metres; negative for an overlap."""
    return np.asarray((a @ normals.T).min(axis=0) - (b @ normals.T).max(axis=0))


def _patches(a: Solid, b: Solid, pose: Pose, band: float) -> tuple[Array, Array]:
    """Return points of either that are nearer to the other than the band, (k, 3) and (l, 3), in b's frame."""
    if a.convex and not b.convex:
        near_b, near_a = _patches(b, a, pose.back, band)
        return pose.place(near_a), pose.place(near_b)
    points = pose.place(a.samples.within(*pose.back.around(b.hull, band)).points)
    if b.convex:
        near = b.hull.depth(points) >= -band
        some = _some(points[near]).astype(np.float64)
        heights = some @ b.hull.planes[:, :3].T + b.hull.planes[:, 3]
        planes = b.hull.planes[heights.argmax(axis=1)]
        return some, some - heights.max(axis=1, initial=-np.inf)[:, None] * planes[:, :3]
    gap, place = b.tree.query(points, distance_upper_bound=band)
    near = np.isfinite(gap)
    found = b.samples.points[np.unique(place[near])]
    return _some(points[near]).astype(np.float64), _some(found).astype(np.float64)


def _some(points: Points) -> Points:
    return points[:: len(points) // _PATCH + 1]
