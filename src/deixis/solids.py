"""Solids: what a thing is measured as when its box is not enough (decision 0015).

A solid lies in the frame of its thing's minimum box: origin at the box's centre, axes along its sides. So a
millimetre survives at any distance from the world's origin, and all that is prepared here turns with the
thing. What takes time is prepared on first use and kept as long as its scene.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, Final, Literal, get_args
from weakref import WeakKeyDictionary, WeakValueDictionary

import numpy as np

from deixis.boxes import NO_NORMAL
from deixis.frames import Array, Index
from deixis.hulls import Hull, box_hull, convex_hull
from deixis.regions import MeshRegion, PointRegion, Region, SurfaceRegion
from deixis.sampling import Samples, face_normals, sample
from deixis.scene import Scene

RegionModel = Literal["box", "hull", "mesh"]
"""What regions are measured as: boxes, convex hulls, or meshes where there are any."""

REGION_MODELS: Final[tuple[RegionModel, ...]] = get_args(RegionModel)

SolidModel = Literal["box", "outline", "hull", "mesh"]
"""What one thing is measured as; an outline is a flat surface with its polygon's own border."""

MAX_SAMPLES: Final = 60_000
"""About the most samples of one thing: on more than some 1.5 square metres they lie further apart than D/2."""

_BUMP: Final = 1.0e-3
"""Metres: where each vertex of a closed mesh is nearer than this to its hull, it fills the hull."""

_FULL: Final = 0.999
"""A part larger than this is the whole."""

_SAME: Final = 1.0e-6
"""Metres: vertices and planes nearer than this are the same."""


@dataclass(eq=False)
class Solid:
    """One thing as a solid, in the frame of its minimum box.

    Attributes
    ----------
    model : SolidModel
        What it is measured as.
    region : Region
        What it was made of.
    half : (3,) float
        Half extents of the box, metres.
    normal : int
        Of a surface the axis it has no thickness along, as in :class:`deixis.boxes.Boxes`.
    vertices : (m, 3) float
        Metres, each of them used by a face.
    faces : (k, 3) int
    hull : Hull
    convex : bool
        Whether the solid is all of its hull.
    granularity : float
        D, metres.
    outline : shapely.Polygon or None
        Of an outline its border, in the two axes beside the normal, in their order.
    """

    model: SolidModel
    region: Region
    half: Array
    normal: int
    vertices: Array
    faces: Index
    hull: Hull
    convex: bool
    granularity: float
    outline: Any = None

    @cached_property
    def samples(self) -> Samples:
        """Return points all over the surface, at most D/2 apart where that does not take too many."""
        return sample(self.vertices, self.faces, 0.5 * self.granularity, MAX_SAMPLES)

    @cached_property
    def probes(self) -> Samples:
        """Return fewer points on the surface, to be looked up in what was made of another's samples."""
        return self.samples.thinned(self.samples.spacing)

    @cached_property
    def tree(self) -> Any:
        """Return a tree that finds the nearest sample."""
        from scipy.spatial import cKDTree

        return cKDTree(self.samples.points)

    @cached_property
    def covered(self) -> Array:
        """Return those planes of the hull whose facet is wholly surface of the solid, (q, 4)."""
        return self.hull.planes if self.convex else _covered(self.hull, self.vertices, self.faces)


_SOLIDS: WeakValueDictionary[tuple[int, str, float, RegionModel], Solid] = WeakValueDictionary()
_SCENES: WeakKeyDictionary[Scene, dict[RegionModel, tuple[Solid, ...]]] = WeakKeyDictionary()


def solids(scene: Scene, region: RegionModel) -> tuple[Solid, ...]:
    """Return the solids of a scene's things, in their order; the same ones when asked again.

    With ``hull`` things that have a mesh or points are their convex hull; with ``mesh`` those with a mesh
    are that mesh. A thing that has only a box is that box, and a flat polygon that is no rectangle an
    outline.

    Parameters
    ----------
    scene : Scene
    region : RegionModel
    """
    kept = _SCENES.setdefault(scene, {})
    if region not in kept:
        kept[region] = tuple(_solid(scene, position, region) for position in range(len(scene.objects)))
    return kept[region]


def _solid(scene: Scene, position: int, region: RegionModel) -> Solid:
    """Return the solid of one thing, also where another scene has the same."""
    thing, granularity = scene.objects[position], scene.thresholds.granularity
    # The id stays taken while the solid lives, since the solid holds the region.
    key = (id(thing.region), thing.kind, granularity, region)
    found = _SOLIDS.get(key)
    if found is None:
        found = _SOLIDS[key] = _made(scene, position, region)
    return found


def _made(scene: Scene, position: int, region: RegionModel) -> Solid:
    boxes, shape = scene.boxes, scene.objects[position].region
    half, normal = boxes.half[position], int(boxes.normal[position])
    granularity = scene.thresholds.granularity

    def local(points: Array) -> Array:
        """Return world points in the box's frame."""
        x, y, z = (points - boxes.center[position]).T
        cos, sin = np.cos(boxes.yaw[position]), np.sin(boxes.yaw[position])
        return np.stack([cos * x + sin * y, cos * y - sin * x, z], axis=1)

    if region != "box":
        if isinstance(shape, PointRegion):
            hull = convex_hull(local(shape.points))
            return Solid("hull", shape, half, normal, hull.points, hull.faces, hull, True, granularity)
        if isinstance(shape, MeshRegion):
            vertices, faces = _tidy(local(shape.vertices), shape.faces)
            hull = convex_hull(vertices)
            if region == "hull" or _fills(hull, vertices, faces):
                return Solid(region, shape, half, normal, hull.points, hull.faces, hull, True, granularity)
            return Solid("mesh", shape, half, normal, vertices, faces, hull, False, granularity)
        if isinstance(shape, SurfaceRegion):
            found = _outline(local(shape.polygon), half, normal, region)
            if found is not None:
                vertices, faces, border, convex = found
                hull = convex_hull(vertices)
                return Solid(
                    "outline", shape, half, normal, vertices, faces, hull, convex, granularity, border
                )
    hull = box_hull(half)
    return Solid("box", shape, half, normal, hull.points, hull.faces, hull, True, granularity)


def _tidy(vertices: Array, faces: Index) -> tuple[Array, Index]:
    """Return a mesh without double or unused vertices and without faces that have no area."""
    used, faces = np.unique(faces, return_inverse=True)
    faces = faces.reshape(-1, 3)
    rounded = np.round(vertices[used] / _SAME).astype(np.int64)
    _, first, place = np.unique(rounded, axis=0, return_index=True, return_inverse=True)
    faces = place.reshape(-1)[faces]
    a, b, c = faces.T
    sound = faces[(a != b) & (b != c) & (c != a)]
    # A mesh without any area is still matter: a wire, or dust.
    return vertices[used][first], sound if len(sound) else faces


def _fills(hull: Hull, vertices: Array, faces: Index) -> bool:
    """Return whether a mesh is closed and all of its hull is within it."""
    count = len(vertices)
    start, end = faces.reshape(-1), np.roll(faces, -1, axis=1).reshape(-1)
    there, back = np.sort(start * count + end), np.sort(end * count + start)
    if (np.diff(there) == 0).any() or not np.array_equal(there, back):
        return False
    a, b, c = (vertices[faces[:, corner]] for corner in range(3))
    volume = abs(float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum())) / 6.0
    if volume < _FULL * hull.volume:
        return False
    return bool((hull.depth(vertices) <= _BUMP).all())


def _covered(hull: Hull, vertices: Array, faces: Index) -> Array:
    """Return the planes of a hull whose whole facet is covered by faces that look outwards."""
    from scipy.spatial import cKDTree

    tree = cKDTree(hull.planes)

    def on_planes(points: Array, corners: Index) -> Array:
        triangles = points[corners]
        normal, area = face_normals(triangles)
        offset = -np.einsum("ij,ij->i", normal, triangles.mean(axis=1))
        gap, plane = tree.query(np.column_stack([normal, offset]), distance_upper_bound=_SAME)
        found = np.isfinite(gap)
        return np.bincount(plane[found], weights=area[found], minlength=len(hull.planes))

    whole = on_planes(hull.points, hull.faces)
    return hull.planes[(whole > 0.0) & (on_planes(vertices, faces) >= _FULL * whole)]


def _outline(
    polygon: Array, half: Array, normal: int, region: RegionModel
) -> tuple[Array, Index, Any, bool] | None:
    """Return a flat polygon's two sides as a mesh, its border, and whether that is convex; None for a rectangle.

    A polygon that is not simple, or slopes, is left to its box.
    """
    import shapely

    plan = [axis for axis in range(3) if axis != normal]
    if normal == NO_NORMAL:
        return None
    border = shapely.Polygon(polygon[:, plan])
    whole = 4.0 * float(half[plan[0]] * half[plan[1]])
    if not border.is_valid or whole <= 0.0 or border.area >= _FULL * whole:
        return None
    around = shapely.convex_hull(border)
    convex = region == "hull" or border.area >= _FULL * around.area
    border = around if convex else border
    corners = shapely.get_coordinates(shapely.constrained_delaunay_triangles(border)).reshape(-1, 4, 2)[:, :3]
    flat = corners.reshape(-1, 2)
    sides = []
    for level in {float(half[normal]), -float(half[normal])}:
        side = np.empty((len(flat), 3))
        side[:, plan], side[:, normal] = flat, level
        sides.append(side)
    points = np.concatenate(sides)
    vertices, faces = _tidy(points, np.arange(len(points)).reshape(-1, 3))
    shapely.prepare(border)
    return vertices, faces, border, convex
