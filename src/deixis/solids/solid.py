"""Solids: what a thing is measured as when its box is not enough (decision 0017).

A solid lies in the frame of its thing's minimum box: origin at the box's centre, axes along its sides. So a
millimetre survives at any distance from the world's origin, and all that is prepared here turns with the
thing. What takes time is prepared on first use and kept as long as its scene.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, Final, TypeVar
from weakref import WeakKeyDictionary, WeakValueDictionary

import numpy as np

from deixis.boxes import NO_NORMAL, Boxes
from deixis.facts import RegionModel, SolidModel
from deixis.frames import Array, Index, Mask
from deixis.regions import BoxRegion, MeshRegion, PointRegion, Region, SurfaceRegion
from deixis.scene import Scene
from deixis.solids.hulls import Hull, box_hull, convex_hull
from deixis.solids.sampling import Samples, Single, face_normals, sample, unique_rows

Points = TypeVar("Points", Single, Array)

MAX_SAMPLES: Final = 120_000
"""About the most samples of one thing: on more than some 7 square metres they lie further apart than 1 cm."""

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
    def scouts(self) -> Samples:
        """Return few points on the surface, that may answer a question before all others are asked."""
        return self.probes.thinned(8.0 * self.samples.spacing)

    @cached_property
    def hull_probes(self) -> Samples:
        """Return points on the surface of the hull."""
        if self.convex:
            return self.probes
        found = sample(self.hull.points, self.hull.faces, 0.5 * self.granularity, MAX_SAMPLES)
        return found.thinned(found.spacing)

    @cached_property
    def tree(self) -> Any:
        """Return a tree that finds the nearest sample."""
        from scipy.spatial import cKDTree

        return cKDTree(self.samples.points)

    @cached_property
    def covered(self) -> Array:
        """Return those planes of the hull whose facet is wholly surface of the solid, (q, 4)."""
        return self.hull.facets if self.convex else _covered(self.hull, self.vertices, self.faces)


@dataclass(frozen=True, slots=True)
class Pose:
    """Where one solid lies in the frame of another: turned about Z, then shifted by (3,) metres."""

    cos: float
    sin: float
    shift: Array

    def place(self, points: Points) -> Points:
        """Return points of the one in the frame of the other, (q, 3)."""
        result = np.empty_like(points)
        x, y = points[:, 0], points[:, 1]
        # Plain numbers, so that single precision stays what it is.
        cos, sin, (shift_x, shift_y, shift_z) = float(self.cos), float(self.sin), self.shift.tolist()
        result[:, 0] = cos * x - sin * y + shift_x
        result[:, 1] = sin * x + cos * y + shift_y
        result[:, 2] = points[:, 2] + shift_z
        return result

    def turn(self, vectors: Array) -> Array:
        """Return directions of the one in the frame of the other, (q, 3)."""
        return Pose(self.cos, self.sin, np.zeros(3)).place(vectors)

    @property
    def back(self) -> Pose:
        """Return where the other lies in the frame of the one."""
        x, y, z = self.shift
        cos, sin = self.cos, self.sin
        return Pose(cos, -sin, np.array([-(cos * x + sin * y), sin * x - cos * y, -z]))

    def around(self, hull: Hull, band: float) -> tuple[Array, Array]:
        """Return the box of a hull of the one in the frame of the other, widened by a band: two corners."""
        corners = self.place(hull.corners)
        return corners.min(axis=0) - band, corners.max(axis=0) + band

    @property
    def matrix(self) -> Array:
        """Return the turn as a matrix, (3, 3)."""
        return np.array([[self.cos, -self.sin, 0.0], [self.sin, self.cos, 0.0], [0.0, 0.0, 1.0]])


_SOLIDS: WeakValueDictionary[tuple[int, str, float, RegionModel], Solid] = WeakValueDictionary()
_SCENES: WeakKeyDictionary[Scene, dict[RegionModel, Solids]] = WeakKeyDictionary()


class Solids:
    """The solids of a scene's things, each made when it is first asked for, and kept.

    With the region model ``hull`` things that have a mesh or points are their convex hull; with ``mesh``
    those with a mesh are that mesh. A thing that has only a box is that box, and a flat polygon that is no
    rectangle an outline.
    """

    def __init__(self, scene: Scene, region: RegionModel) -> None:
        # The scene itself would never be let go: it is the key that this is kept under.
        self._boxes, self._objects, self._limits = scene.boxes, scene.objects, scene.thresholds
        self._region = region
        self._made: dict[int, Solid] = {}

    @classmethod
    def of(cls, scene: Scene, region: RegionModel) -> Solids:
        """Return the solids of a scene, the same ones when asked again."""
        kept = _SCENES.setdefault(scene, {})
        return kept.setdefault(region, cls(scene, region))

    @cached_property
    def models(self) -> tuple[SolidModel, ...]:
        """Return what each thing is measured as."""
        return tuple(self._model(position) for position in range(len(self._objects)))

    @cached_property
    def more(self) -> Mask:
        """Return which things are measured as more than their box, (n,)."""
        return np.array([model != "box" for model in self.models], dtype=np.bool_)

    def _model(self, position: int) -> SolidModel:
        shape = self._objects[position].region
        if isinstance(shape, BoxRegion) or self._region == "box":
            return "box"
        if isinstance(shape, SurfaceRegion):
            return self[position].model
        return "hull" if isinstance(shape, PointRegion) else self._region

    def __getitem__(self, position: int) -> Solid:
        found = self._made.get(position)
        if found is None:
            thing = self._objects[position]
            # Scenes may share a region. Its id stays taken while the solid, which holds it, lives.
            key = (id(thing.region), thing.kind, self._limits.granularity, self._region)
            found = _SOLIDS.get(key)
            if found is None:
                found = _SOLIDS[key] = _made(
                    thing.region, self._boxes, position, self._limits.granularity, self._region
                )
            self._made[position] = found
        return found


def _made(shape: Region, boxes: Boxes, position: int, granularity: float, region: RegionModel) -> Solid:
    half, normal = boxes.half[position], int(boxes.normal[position])

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
            faces = _with_back(vertices, faces)
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
    first, place = unique_rows(np.round(vertices[used] / _SAME).astype(np.int64))
    faces = place[faces]
    a, b, c = faces.T
    sound = faces[(a != b) & (b != c) & (c != a)]
    # A mesh without any area is still matter: a wire, or dust.
    faces = sound if len(sound) else faces
    # Of faces that are there twice, seen from either side, one is enough.
    once, _ = unique_rows(np.sort(faces, axis=1))
    return vertices[used][first], faces[np.sort(once)]


def _with_back(vertices: Array, faces: Index) -> Index:
    """Return the faces, with the one that was left out where no more is missing: a back that no one sees.

    That is a hole with three or four corners, in a mesh that is closed but for it.
    """
    count = len(vertices)
    sides = np.sort(np.stack([faces, np.roll(faces, -1, axis=1)], axis=2).reshape(-1, 2), axis=1)
    keys, often = np.unique(sides[:, 0] * count + sides[:, 1], return_counts=True)
    rim = np.stack(np.divmod(keys[often == 1], count), axis=1)
    corners = np.unique(rim)
    if (
        not 3 <= len(rim) <= 4
        or len(corners) != len(rim)
        or (np.bincount(rim.reshape(-1))[corners] != 2).any()
    ):
        return faces
    # Along the rim: the first corner, its two neighbours, and what is left.
    first = corners[0]
    beside = [int(side[0] + side[1] - first) for side in rim if first in side]
    rest = [int(corner) for corner in corners if corner != first and corner not in beside]
    back = [[first, *beside], *([[rest[0], *beside]] if rest else [])]
    return np.concatenate([faces, back])


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
    return bool((hull.depth(vertices.astype(np.float32)) <= _BUMP).all())


def _covered(hull: Hull, vertices: Array, faces: Index) -> Array:
    """Return the planes of a hull whose whole facet is covered by faces that look outwards."""
    from scipy.spatial import cKDTree

    tree = cKDTree(hull.facets)

    def on_planes(points: Array, corners: Index) -> Array:
        triangles = points[corners]
        normal, area = face_normals(triangles)
        offset = -np.einsum("ij,ij->i", normal, triangles.mean(axis=1))
        gap, plane = tree.query(np.column_stack([normal, offset]), distance_upper_bound=_SAME)
        found = np.isfinite(gap)
        return np.bincount(plane[found], weights=area[found], minlength=len(hull.facets)).astype(np.float64)

    whole = on_planes(hull.points, hull.faces)
    return hull.facets[(whole > 0.0) & (on_planes(vertices, faces) >= _FULL * whole)]


def _outline(
    polygon: Array, half: Array, normal: int, region: RegionModel
) -> tuple[Array, Index, Any, bool] | None:
    """Return a flat polygon's sides as a mesh, its border, and whether it is convex; None for a rectangle.

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
