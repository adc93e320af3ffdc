"""Boxes: minimum bounding boxes (axioms 9, 10) and contextualised boxes (axiom 12), as batches.

Boxes turn about the vertical only: their base is parallel to the XY plane (section 3 of the paper).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np
from numpy.typing import NDArray

from deixis.errors import GeometryError
from deixis.frames import QUARTER, TIE, Array, Mask, bearing, quarter_turns

NO_NORMAL: Final = -1
"""Value of ``Boxes.normal`` for a thing that is not a surface."""

_STRIP: Final = 16
"""Things across a strip of neighbours, where they are spread evenly."""


@dataclass(frozen=True)
class Boxes:
    """A batch of n boxes.

    Attributes
    ----------
    center : (n, 3) float
        Metres, world frame.
    half : (n, 3) float
        Half extents along the box's own axes, metres, never negative.
    yaw : (n,) float
        Radians from the world's X axis to the box's.
    normal : (n,) int
        For a surface the own axis (0, 1, 2) it has no thickness along; ``NO_NORMAL`` for other things.
    ambiguous : (n,) bool
        True where another box fits as well, so that the yaw is a matter of choice.
    """

    center: Array
    half: Array
    yaw: Array
    normal: NDArray[np.int64]
    ambiguous: Mask

    def __len__(self) -> int:
        return len(self.yaw)

    @cached_property
    def surface(self) -> Mask:
        """Return which boxes are surfaces, shape (n,)."""
        return np.asarray(self.normal != NO_NORMAL)

    @cached_property
    def cos(self) -> Array:
        """Return the cosines of the yaws, (n,)."""
        return np.cos(self.yaw)

    @cached_property
    def sin(self) -> Array:
        """Return the sines of the yaws, (n,)."""
        return np.sin(self.yaw)

    @cached_property
    def _columns(self) -> Array:
        """Return all that is measured with, column by column, (9, n)."""
        return np.stack([*self.center.T, *self.half.T, self.cos, self.sin, self.yaw])

    @cached_property
    def along_strips(self) -> NDArray[np.int64]:
        """Return the boxes' positions along strips of the plan, so that neighbours stand together, (n,)."""
        n = len(self)
        strips = max(int(np.sqrt(n) / _STRIP), 1)
        rank = np.empty(n, dtype=np.int64)
        rank[np.argsort(self.center[:, 1], kind="stable")] = np.arange(n)
        return np.lexsort((self.center[:, 0], rank * strips // max(n, 1)))

    def take(self, index: NDArray[np.int64]) -> Boxes:
        """Return the boxes at the given positions, their coordinates column by column for arithmetic."""
        columns = self._columns.take(index, axis=1)
        some = Boxes(
            columns[:3].T, columns[3:6].T, columns[8], self.normal.take(index), self.ambiguous.take(index)
        )
        # Gathered, not computed again: cached_property looks here first.
        some.__dict__["cos"], some.__dict__["sin"], some.__dict__["_columns"] = (
            columns[6],
            columns[7],
            columns,
        )
        return some

    def joined(self, more: Boxes) -> Boxes:
        """Return these boxes followed by more."""
        columns = ((getattr(one, name) for one in (self, more)) for name in self.__dataclass_fields__)
        return Boxes(*(np.concatenate(list(both)) for both in columns))

    def differs(self, other: Boxes) -> Mask:
        """Return which of as many other boxes are not the same, (n,)."""
        flags = (self.normal != other.normal) | (self.ambiguous != other.ambiguous)
        return np.asarray((self._columns != other._columns).any(axis=0) | flags)

    def effective_half(self, granularity: float) -> Array:
        """Return half extents, none below half the granularity: no region is thinner than D. Shape (n, 3)."""
        return np.maximum(self.half, 0.5 * granularity)

    def volume(self, granularity: float) -> Array:
        """Return volumes, cubic metres, of the boxes at the given granularity. Shape (n,)."""
        half = self.effective_half(granularity)
        return np.asarray(8.0 * half[:, 0] * half[:, 1] * half[:, 2], dtype=np.float64)


def corners_xy(half: Array) -> Array:
    """Return the base corners of boxes in their own frames, counter-clockwise, shape (n, 4, 2).

    >>> corners_xy(np.array([[2.0, 1.0, 9.0]]))[0].tolist()
    [[2.0, 1.0], [-2.0, 1.0], [-2.0, -1.0], [2.0, -1.0]]
    """
    signs = np.array([[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]])
    return np.asarray(half[:, None, :2] * signs, dtype=np.float64)


def contextualise(boxes: Boxes, position: Array) -> tuple[Boxes, Array, Mask]:
    """Return each box turned into its contextualised frame F_c, as seen from a position (axiom 12, CBB).

    A thing turns by the least angle that aligns it with the line of sight; where two turns of 45 degrees
    tie, its longer side faces the viewer, and the tie is reported. A surface keeps its plane: a wall's
    frame points along its normal away from the viewer, a floor's along its own nearest axis
    (decision 0005).

    Parameters
    ----------
    boxes : Boxes
        n minimum bounding boxes.
    position : (3,) float
        Of the view, metres, world frame.

    Returns
    -------
    cbb : Boxes
        Half extents along X_c, Y_c, Z_c; ``yaw`` is the yaw of F_c; ``normal`` counts in F_c.
    clearance : (n,) float
        Metres from the view's position to the footprint in the plane; negative inside it. The relations
        of the view to a reference are withheld where it is not positive.
    tie : (n,) bool
        Where two turns were equally small.
    """
    sight = bearing(position, boxes.center)
    k, _, tie = _least_turn(boxes, sight)
    odd = (k % 2).astype(bool)
    half_x = np.where(odd, boxes.half[:, 1], boxes.half[:, 0])
    half_y = np.where(odd, boxes.half[:, 0], boxes.half[:, 1])
    yaw = sight
    normal = boxes.normal
    if boxes.surface.any():
        wall = (normal == 0) | (normal == 1)
        axis_yaw = boxes.yaw + np.where(normal == 1, QUARTER, 0.0)
        offset = boxes.center - position
        ahead = np.cos(axis_yaw) * offset[:, 0] + np.sin(axis_yaw) * offset[:, 1]
        yaw = np.where(wall, axis_yaw + np.where(ahead < 0.0, np.pi, 0.0), yaw)
        half_x = np.where(wall, np.where(normal == 1, boxes.half[:, 1], boxes.half[:, 0]), half_x)
        half_y = np.where(wall, np.where(normal == 1, boxes.half[:, 0], boxes.half[:, 1]), half_y)
        tie = tie & ~wall
        level = normal == 2
        yaw = np.where(level, boxes.yaw + k * QUARTER, yaw)
        normal = np.where(wall, 0, normal)
    offset = position[:2] - boxes.center[:, :2]
    cos, sin = np.cos(boxes.yaw), np.sin(boxes.yaw)
    out_x = np.abs(cos * offset[:, 0] + sin * offset[:, 1]) - boxes.half[:, 0]
    out_y = np.abs(cos * offset[:, 1] - sin * offset[:, 0]) - boxes.half[:, 1]
    outside = np.hypot(np.maximum(out_x, 0.0), np.maximum(out_y, 0.0))
    clearance = np.where(outside > 0.0, outside, np.maximum(out_x, out_y))
    wall = (boxes.normal == 0) | (boxes.normal == 1)
    across = np.where(boxes.normal == 1, out_y, out_x)
    clearance = np.where(wall, across, clearance)
    half = np.stack([half_x, half_y, boxes.half[:, 2]], axis=1)
    return Boxes(boxes.center, half, yaw, normal, boxes.ambiguous), clearance, tie


def align_with_world(boxes: Boxes) -> tuple[Boxes, Mask]:
    """Return each box turned by the least angle to the world's axes: F_c with F_g in the place of F_r'.

    The cardinal relations (axioms 21-25) are stated in this frame; for a box that already lies along the
    world's axes it is the paper's F_o = F_g. A surface keeps its plane and takes its nearest own axis.

    Returns
    -------
    framed : Boxes
    tie : (n,) bool
        Where two turns were equally small.
    """
    k, _, tie = _least_turn(boxes, np.zeros_like(boxes.yaw))
    odd = (k % 2).astype(bool)
    half_x = np.where(odd, boxes.half[:, 1], boxes.half[:, 0])
    half_y = np.where(odd, boxes.half[:, 0], boxes.half[:, 1])
    yaw = np.where(boxes.surface, boxes.yaw + k * QUARTER, 0.0)
    normal = np.where(odd & (boxes.normal == 0), 1, np.where(odd & (boxes.normal == 1), 0, boxes.normal))
    half = np.stack([half_x, half_y, boxes.half[:, 2]], axis=1)
    return Boxes(boxes.center, half, yaw, normal, boxes.ambiguous), tie


def _least_turn(boxes: Boxes, target: Array) -> tuple[NDArray[np.int64], Array, Mask]:
    """Return :func:`quarter_turns` with ties decided: the longer side lies across the target's X axis."""
    k, theta = quarter_turns(boxes.yaw, target)
    long_side = np.maximum(boxes.half[:, 0], boxes.half[:, 1])
    square = np.abs(boxes.half[:, 0] - boxes.half[:, 1]) <= TIE * np.maximum(long_side, 1.0e-12)
    tie = (np.abs(np.abs(theta) - QUARTER / 2.0) < TIE) & ~square
    along = np.where((k % 2).astype(bool), boxes.half[:, 1], boxes.half[:, 0])
    wrong = tie & (along >= long_side)
    step = np.where(theta > 0.0, 1, -1)
    return np.where(wrong, k + step, k), np.where(wrong, theta - step * QUARTER, theta), tie


def convex_hull_2d(points: Array) -> Array:
    """Return the hull's vertices in counter-clockwise order, (h, 2); of points on a line its two ends."""
    import shapely

    hull = shapely.convex_hull(shapely.multipoints(points))
    ring = shapely.get_coordinates(hull)
    if hull.geom_type != "Polygon":
        return np.asarray(ring, dtype=np.float64)
    ring = ring[:-1]
    following = np.roll(ring, -1, axis=0)
    clockwise = float((ring[:, 0] * following[:, 1] - ring[:, 1] * following[:, 0]).sum()) < 0.0
    return np.asarray(ring[::-1] if clockwise else ring, dtype=np.float64)


def min_bound_box(points: Array) -> tuple[Array, Array, float, bool]:
    """Return the minimum bounding box of a point set (axiom 10): least base area, base level.

    The least-area rectangle has a side on an edge of the convex hull of the points' plan view. Where
    several rectangles of different yaw are equally small (regular polygons) the choice hangs on the order
    of the points, so that it turns with the object, and the box is marked ambiguous (decision 0008).

    Parameters
    ----------
    points : (m, 3) float
        Metres, world frame; at least one point, all finite.

    Returns
    -------
    center : (3,) float
    half : (3,) float
    yaw : float
        Radians in [0, pi/2).
    ambiguous : bool

    Raises
    ------
    GeometryError
        Not an (m, 3) array of finite numbers with m >= 1.

    Examples
    --------
    >>> center, half, yaw, ambiguous = min_bound_box(np.array([[0, 0, 0], [2, 0, 0], [2, 1, 3], [0, 1, 3.0]]))
    >>> center.tolist(), sorted(half.tolist()), ambiguous
    ([1.0, 0.5, 1.5], [0.5, 1.0, 1.5], False)
    """
    points = np.asarray(points, dtype=np.float64)
    if points.ndim != 2 or points.shape[1] != 3 or len(points) == 0 or not np.isfinite(points).all():
        raise GeometryError(f"expected finite points of shape (m, 3) with m >= 1, got shape {points.shape}")
    low, high = points.min(axis=0), points.max(axis=0)
    origin = 0.5 * (low + high)
    plan = points[:, :2] - origin[:2]
    ring = convex_hull_2d(plan)
    edges = np.roll(ring, -1, axis=0) - ring
    length = np.hypot(edges[:, 0], edges[:, 1])
    size = float(np.hypot(*(high - low)[:2]))
    usable = length > max(1.0e-9 * size, 1.0e-12)
    if not usable.any():
        return origin, 0.5 * (high - low) * np.array([0.0, 0.0, 1.0]), 0.0, True
    angle = np.arctan2(edges[usable, 1], edges[usable, 0]) % QUARTER
    angle = np.where(angle > QUARTER - 1.0e-12, 0.0, angle)
    cos, sin = np.cos(angle)[:, None], np.sin(angle)[:, None]
    along = cos * ring[:, 0] + sin * ring[:, 1]
    across = cos * ring[:, 1] - sin * ring[:, 0]
    extent_x = along.max(axis=1) - along.min(axis=1)
    extent_y = across.max(axis=1) - across.min(axis=1)
    area = extent_x * extent_y
    tied = np.flatnonzero(area <= area.min() + 1.0e-7 * size * size)
    spread = (angle[tied] - angle[tied[0]] + QUARTER / 2.0) % QUARTER - QUARTER / 2.0
    ambiguous = bool((np.abs(spread) > 1.0e-6).any())
    # Among ties the edge next in turn after the first point given, seen from the middle of all: an order
    # that moves with the object, and does not depend on which points of a straight side count as corners.
    spoke = plan - plan.mean(axis=0)
    first = spoke[int((np.hypot(spoke[:, 0], spoke[:, 1]) > 1.0e-6 * size).argmax())]
    direction = np.arctan2(edges[usable][tied, 1], edges[usable][tied, 0])
    turn = (direction - np.arctan2(first[1], first[0]) + 1.0e-6) % (2.0 * np.pi)
    best = int(tied[turn.argmin()]) if ambiguous else int(area.argmin())
    yaw = float(angle[best])
    middle_x = 0.5 * (along[best].max() + along[best].min())
    middle_y = 0.5 * (across[best].max() + across[best].min())
    c, s = np.cos(yaw), np.sin(yaw)
    center = origin + np.array([c * middle_x - s * middle_y, s * middle_x + c * middle_y, 0.0])
    half = 0.5 * np.array([extent_x[best], extent_y[best], high[2] - low[2]])
    return center, half, yaw, ambiguous
