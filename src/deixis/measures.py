"""Measures between two boxes: closed forms over k pairs at once (axioms 13, 14, 18, 19, 39).

A pair is a figure ``a`` and a reference ``b``. Everything is computed from the difference of the two
centres, so that a millimetre survives at any distance from the world's origin. Two boxes with vertical
sides are the product of their plan views (rectangles) and their height intervals; every closed form here
follows from that.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from deixis.boxes import Boxes
from deixis.frames import Array, Index, Mask
from deixis.thresholds import SNAP

_SIGNS = np.array([[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]])


@dataclass(frozen=True, slots=True)
class Placement:
    """Where k figures lie, seen in the frames of their k references.

    Attributes
    ----------
    x, y, z : (k,) float
        The figure's centre in the reference's frame, metres.
    cos, sin : (k,) float
        Of the figure's yaw in the reference's frame.
    """

    x: Array
    y: Array
    z: Array
    cos: Array
    sin: Array

    def reversed(self) -> Placement:
        """Return the references as seen in the frames of the figures."""
        return Placement(
            -(self.cos * self.x + self.sin * self.y),
            self.sin * self.x - self.cos * self.y,
            -self.z,
            self.cos,
            -self.sin,
        )

    def take(self, index: Index) -> Placement:
        """Return the placements at the given positions."""
        return Placement(self.x[index], self.y[index], self.z[index], self.cos[index], self.sin[index])


def place(figure: Boxes, reference: Boxes) -> Placement:
    """Return the figures' centres and yaws in their references' frames."""
    x, y, z = (figure.center - reference.center).T
    cos, sin = reference.cos, reference.sin
    return Placement(
        cos * x + sin * y,
        cos * y - sin * x,
        z,
        figure.cos * cos + figure.sin * sin,
        figure.sin * cos - figure.cos * sin,
    )


def extent(placement: Placement, half: Array) -> tuple[Array, Array]:
    """Return the figures' half extents along the references' X and Y axes, each (k,), metres."""
    cos, sin = np.abs(placement.cos), np.abs(placement.sin)
    return half[:, 0] * cos + half[:, 1] * sin, half[:, 0] * sin + half[:, 1] * cos


def plan_overlaps(placement: Placement, half_a: Array, half_b: Array) -> Array:
    """Return by how much two plan views overlap along each of the four face normals, (4, k) metres.

    The order is the reference's X, Y, then the figure's X, Y. The plan views are apart iff some entry is
    negative; the least entry is the least translation that would part them (separating axes).
    """
    back = placement.reversed()
    a_x, a_y = extent(placement, half_a)
    b_x, b_y = extent(back, half_b)
    return np.stack(
        [
            half_b[:, 0] + a_x - np.abs(placement.x),
            half_b[:, 1] + a_y - np.abs(placement.y),
            half_a[:, 0] + b_x - np.abs(back.x),
            half_a[:, 1] + b_y - np.abs(back.y),
        ]
    )


def corners_in_reference(placement: Placement, half_a: Array) -> tuple[Array, Array]:
    """Return the figure's plan corners in the reference's frame, counter-clockwise, x and y (4, k) each."""
    along = _SIGNS[:, :1] * half_a[:, 0]
    across = _SIGNS[:, 1:] * half_a[:, 1]
    return (
        placement.x + along * placement.cos - across * placement.sin,
        placement.y + along * placement.sin + across * placement.cos,
    )


def vertical_escapes(
    placement: Placement,
    half_a: Array,
    half_b: Array,
    surface_a: Mask,
    surface_b: Mask,
    granularity: float,
) -> tuple[Array, Array]:
    """Return how far the figure would have to rise, and to sink, to leave the reference's height interval.

    What a thing completely contains (up to D, and its middle at all) lies on the thing's bottom, it does
    not cling to it from below: the way out through the bottom is not counted (infinite), so that a knife in
    a drawer is in it and a sheet on a table is on it. Surfaces have no inside (decision 0004).

    Parameters
    ----------
    placement : Placement
        Of k pairs.
    half_a, half_b : (k, 3) float
        Half extents of figure and reference, metres.
    surface_a, surface_b : (k,) bool
        Which are surfaces.
    granularity : float
        D, metres.

    Returns
    -------
    up, down : (k,) float
        Metres; negative when the figure is already above, or below.
    """
    tall = half_a[:, 2] + half_b[:, 2]
    # A sheet in the very plane of the bottom is not above it, whichever way its height is rounded.
    limit, level = granularity + SNAP, np.abs(placement.z) + SNAP
    # A plate no thicker than D that is flush under a shelf protrudes by no more than D, but is not in it.
    within_b = ~surface_b & (level <= half_b[:, 2]) & (protrusion(placement, half_a, half_b) <= limit)
    within_a = (
        ~surface_a & (level <= half_a[:, 2]) & (protrusion(placement.reversed(), half_b, half_a) <= limit)
    )
    # Of two things that contain each other up to D neither is the container.
    within_b, within_a = within_b & ~within_a, within_a & ~within_b
    up = np.where(within_a, np.inf, tall - placement.z)
    down = np.where(within_b, np.inf, tall + placement.z)
    return up, down


def separation(
    placement: Placement, half_a: Array, half_b: Array, up: Array, down: Array
) -> tuple[Array, Array]:
    """Return the signed separation of two boxes and the direction it is measured along.

    Apart, it is the least distance (axiom 14); overlapping, minus the least translation that parts them.

    Parameters
    ----------
    placement : Placement
        Of k pairs.
    half_a, half_b : (k, 3) float
        Half extents of figure and reference, metres.
    up, down : (k,) float
        Of :func:`vertical_escapes`.

    Returns
    -------
    separation : (k,) float
        Metres.
    normal : (k, 3) float
        Unit vectors from reference to figure, in the reference's frame.
    """
    overlaps = plan_overlaps(placement, half_a, half_b)
    depth = np.minimum(np.minimum(overlaps[0], overlaps[1]), np.minimum(overlaps[2], overlaps[3]))
    gap_x, gap_y = _plan_gap(placement, half_a, half_b)
    level = depth < 0.0
    normal = np.empty((3, len(depth)))
    normal[0] = np.where(level, gap_x, 0.0)
    normal[1] = np.where(level, gap_y, 0.0)
    gap_z = np.abs(placement.z) - half_a[:, 2] - half_b[:, 2]
    normal[2] = np.copysign(np.maximum(gap_z, 0.0), placement.z)
    result = np.sqrt((normal * normal).sum(axis=0))
    normal /= np.where(result > 0.0, result, 1.0)
    deep = np.flatnonzero(~level & (gap_z <= 0.0))
    if len(deep):
        some = placement.take(deep)
        up, down = up[deep], down[deep]
        escape = np.minimum(up, down)
        axes = _face_normals(some, overlaps[:, deep].argmin(axis=0))
        upright = escape <= depth[deep]
        axes[:, upright] = 0.0
        axes[2, upright] = np.where(up <= down, 1.0, -1.0)[upright]
        normal[:, deep] = axes
        result[deep] = -np.minimum(depth[deep], escape)
    return result, normal.T


def _plan_gap(placement: Placement, half_a: Array, half_b: Array) -> tuple[Array, Array]:
    """Return the shortest vectors from the references' plan views to the figures', x and y, (k,) each.

    It ends at a corner of one of the two. Where the plan views overlap without a corner in the other, the
    result has no meaning.
    """
    cos, sin = placement.cos, placement.sin
    squared, gap_x, gap_y = _corner_gap(placement, half_a, half_b)
    squared_back, back_x, back_y = _corner_gap(placement.reversed(), half_b, half_a)
    closer = squared_back < squared
    # From the figure to the reference's corner: turned round, and into the reference's frame.
    return (
        np.where(closer, sin * back_y - cos * back_x, gap_x),
        np.where(closer, -sin * back_x - cos * back_y, gap_y),
    )


def _corner_gap(placement: Placement, half_a: Array, half_b: Array) -> tuple[Array, Array, Array]:
    """Return the shortest vectors from the references' plan views to a corner of the figures'.

    Their squared length, and x and y, (k,) each.
    """
    along_x, along_y = half_a[:, 0] * placement.cos, half_a[:, 0] * placement.sin
    across_x, across_y = half_a[:, 1] * placement.sin, half_a[:, 1] * placement.cos
    right = placement.x + along_x, placement.y + along_y
    left = placement.x - along_x, placement.y - along_y
    best = gap_x = gap_y = np.empty(0)
    # The corners in the order of _SIGNS; of equally near ones the first is taken.
    for number, ((at_x, at_y), add) in enumerate(
        ((right, True), (left, True), (left, False), (right, False))
    ):
        x = _beyond(at_x - across_x if add else at_x + across_x, half_b[:, 0])
        y = _beyond(at_y + across_y if add else at_y - across_y, half_b[:, 1])
        squared = x * x
        squared += y * y
        if number == 0:
            best, gap_x, gap_y = squared, x, y
            continue
        closer = squared < best
        best = np.minimum(best, squared)
        gap_x, gap_y = np.where(closer, x, gap_x), np.where(closer, y, gap_y)
    return best, gap_x, gap_y


def _beyond(coordinate: Array, half: Array) -> Array:
    """Return the signed part of a coordinate that lies beyond ``[-half, half]``."""
    inside = np.maximum(coordinate, -half)
    np.minimum(inside, half, out=inside)
    return np.subtract(coordinate, inside, out=inside)


def _face_normals(placement: Placement, face: Index) -> Array:
    """Return unit vectors along some face normals of :func:`plan_overlaps`, towards the figure, (3, k)."""
    back = placement.reversed()
    zero = np.zeros_like(placement.x)
    sign_x, sign_y = np.copysign(1.0, placement.x), np.copysign(1.0, placement.y)
    own_x, own_y = np.copysign(1.0, -back.x), np.copysign(1.0, -back.y)
    return np.stack(
        [
            np.choose(face, [sign_x, zero, own_x * placement.cos, -own_y * placement.sin]),
            np.choose(face, [zero, sign_y, own_x * placement.sin, own_y * placement.cos]),
            zero,
        ]
    )


def protrusion(placement: Placement, half_a: Array, half_b: Array) -> Array:
    """Return how far the figure sticks out of the reference, metres, (k,); not positive when it is within."""
    a_x, a_y = extent(placement, half_a)
    return np.maximum(
        np.maximum(
            np.abs(placement.x) + a_x - half_b[:, 0],
            np.abs(placement.y) + a_y - half_b[:, 1],
        ),
        np.abs(placement.z) + half_a[:, 2] - half_b[:, 2],
    )


def plan_area(placement: Placement, half_a: Array, half_b: Array) -> Array:
    """Return the area that two plan views share, square metres, (k,).

    Each side of the figure contributes the area between it and the reference's lower side, clamped to the
    reference's window; the signed sum is the shared area. Nothing branches on a corner being in or out, so
    coinciding sides need no special care.
    """
    x0, y0 = corners_in_reference(placement, half_a)
    d_x, d_y = np.roll(x0, -1, axis=0) - x0, np.roll(y0, -1, axis=0) - y0
    w_x, w_y = half_b[:, 0], half_b[:, 1]
    enter, leave = slab(x0, d_x, w_x)
    leave = np.maximum(enter, leave)
    low, high = slab(y0, d_y, w_y)
    level = (np.abs(d_y) <= _PARALLEL) & (low > high)
    low, high = np.clip(low, enter, leave), np.clip(high, enter, leave)
    middle = 0.5 * (high - low) * (2.0 * y0 + (low + high) * d_y + 2.0 * w_y)
    middle = np.where(level, 0.0, middle)
    # Where the side runs above the window it counts with the window's full height.
    above = np.where(d_y > 0.0, leave - high, low - enter)
    above = np.where(level, np.where(y0 > w_y, leave - enter, 0.0), above)
    strip = d_x * (middle + above * 2.0 * w_y)
    return np.asarray(np.maximum(-strip.sum(axis=0), 0.0))


_PARALLEL = 1.0e-15


def slab(start: Array, step: Array, half_width: Array) -> tuple[Array, Array]:
    """Return the span of t within [0, 1] where ``|start + t * step| <= half_width``; none if first > last."""
    parallel = np.abs(step) <= _PARALLEL
    safe = np.where(parallel, 1.0, step)
    one, other = (-half_width - start) / safe, (half_width - start) / safe
    within = np.abs(start) <= half_width
    return (
        np.where(parallel, np.where(within, 0.0, 1.0), np.maximum(np.minimum(one, other), 0.0)),
        np.where(parallel, np.where(within, 1.0, 0.0), np.minimum(np.maximum(one, other), 1.0)),
    )


def perimeter_inside(placement: Placement, half_a: Array, half_b: Array) -> Array:
    """Return the length of the figure's plan outline that runs inside the reference's plan, metres, (k,)."""
    x0, y0 = corners_in_reference(placement, half_a)
    d_x, d_y = np.roll(x0, -1, axis=0) - x0, np.roll(y0, -1, axis=0) - y0
    x_in, x_out = slab(x0, d_x, half_b[:, 0])
    y_in, y_out = slab(y0, d_y, half_b[:, 1])
    span = np.maximum(np.minimum(x_out, y_out) - np.maximum(x_in, y_in), 0.0)
    return np.asarray((span * np.hypot(d_x, d_y)).sum(axis=0), dtype=np.float64)


def intersection_volume(placement: Placement, half_a: Array, half_b: Array) -> Array:
    """Return the volume of inter (axiom 18), cubic metres, (k,)."""
    height = half_a[:, 2] + half_b[:, 2] - np.abs(placement.z)
    height = np.minimum(height, 2.0 * np.minimum(half_a[:, 2], half_b[:, 2]))
    return plan_area(placement, half_a, half_b) * np.maximum(height, 0.0)


def surface_inside(placement: Placement, half_a: Array, half_b: Array, granularity: float) -> Array:
    """Return the area of the figure's surface that lies inside the reference, square metres, (k,).

    D times this is the measure of the reference's points adjacent to inter (axiom 39). Inside is by at
    least D/2: a reference that reaches less far beyond the figure's face has no point one D away from it.
    """
    window = np.maximum(half_b - 0.5 * granularity, 0.0)
    height = half_a[:, 2] + window[:, 2] - np.abs(placement.z)
    height = np.maximum(np.minimum(height, 2.0 * np.minimum(half_a[:, 2], window[:, 2])), 0.0)
    faces = np.zeros(len(placement.x))
    for level in (placement.z - half_a[:, 2], placement.z + half_a[:, 2]):
        faces += np.abs(level) <= window[:, 2]
    return perimeter_inside(placement, half_a, window) * height + faces * plan_area(placement, half_a, window)
