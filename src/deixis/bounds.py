"""Bounds: the plane that decides whether a figure meets a halfspace, and the figure's point that decides.

A halfspace has several bounds: the face it starts at, its end, its sides, its height. The margin of a fact
is how far the figure's decisive point lies on the right side of the bound it comes closest to breaking.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, Literal, get_args

import numpy as np

from deixis import measures
from deixis.boxes import Boxes
from deixis.frames import AXES, Array, Index
from deixis.halfspaces import strip_range
from deixis.thresholds import Thresholds

Bound = Literal["face", "middle", "end", "side", "height"]
"""Which bound decides: that at the reference's face, through its middle (a thin thing flush on a wall), at
the end of the halfspace, at its sides, or at its top and bottom."""

BOUNDS: Final[tuple[Bound, ...]] = get_args(Bound)

_STRAIGHT: Final = 1.0e-9
"""A side with a lesser part of its direction along another is square to it."""


@dataclass(frozen=True)
class Planes:
    """The decisive bound of k halfspace facts.

    Attributes
    ----------
    point : (k, 3) float
        On the plane, straight below or beside the figure's point; metres, world frame.
    normal : (k, 3) float
        Unit vectors, from the plane to where the fact holds.
    witness : (k, 3) float
        The figure's point that decides; the margin is ``normal @ (witness - point)``.
    margin : (k,) float
        Metres, not negative where the fact holds.
    bound : tuple of str
        Which bound it is.
    """

    point: Array
    normal: Array
    witness: Array
    margin: Array
    bound: tuple[Bound, ...]


class _Candidates:
    """Bounds to choose from, in the references' frames."""

    def __init__(self) -> None:
        self.margins: list[Array] = []
        self.normals: list[Array] = []
        self.points: list[Array] = []
        self.kinds: list[Index] = []

    def add(self, kind: Bound | Index, margin: Array, normal: Array, point: Array) -> None:
        self.margins.append(margin)
        self.normals.append(normal)
        self.points.append(point)
        self.kinds.append(np.full(len(margin), BOUNDS.index(kind)) if isinstance(kind, str) else kind)

    def decisive(self, reference: Boxes) -> Planes:
        """Return the one each fact comes closest to breaking, in the world."""
        k = len(reference)
        best = np.array(self.margins).argmin(axis=0)
        margin, normal, point = (
            np.array(columns)[best, np.arange(k)] for columns in (self.margins, self.normals, self.points)
        )
        normal, point = _turned(normal, reference), _turned(point, reference) + reference.center
        kinds = np.array(self.kinds)[best, np.arange(k)]
        return Planes(
            point - margin[:, None] * normal, normal, point, margin, tuple(BOUNDS[kind] for kind in kinds)
        )


def planes(
    figure: Boxes, framed: Boxes, separation: Array, axis: str, limits: Thresholds, *, strict: bool = False
) -> Planes:
    """Return the bounds that decide "the figure meets the halfspace" along one axis (axioms 20-34).

    Parameters
    ----------
    figure, framed : Boxes
        k figures, and their references: as framed in a view (:func:`deixis.grounding.frame`) or by the world
        for the horizontal axes, as they are for Z+ and Z-.
    separation : (k,) float
        Metres.
    axis : {"X+", "X-", "Y+", "Y-", "Z+", "Z-"}
    limits : Thresholds
    strict : bool
        Whether it is "lies completely in the halfspace" that is asked.

    Examples
    --------
    >>> from deixis.scene import Scene
    >>> cup = {"id": "cup", "label": "cup", "box": {"center": [0, 0, 0.83], "size": [0.1, 0.1, 0.1]}}
    >>> table = {"id": "table", "label": "table", "box": {"center": [0.5, 0, 0.375], "size": [1.2, 1, 0.75]}}
    >>> boxes = Scene.from_dict({"deixis": 1, "id": "s", "objects": [cup, table], "views": []}).boxes
    >>> one, other = boxes.take(np.array([0])), boxes.take(np.array([1]))
    >>> found = planes(one, other, np.array([0.03]), "Z+", Thresholds())
    >>> found.bound, found.margin.round(3).tolist(), found.witness.round(3).tolist()
    (('face',), [0.11], [[0.0, 0.0, 0.88]])
    """
    number = AXES.index(axis)
    sign = 1.0 if number % 2 == 0 else -1.0
    if number < 4:
        return _horizontal(figure, framed, separation, number // 2, sign, limits, strict)
    return _vertical(figure, framed, separation, sign, limits, strict)


def _horizontal(
    a: Boxes, b: Boxes, separation: Array, axis: int, sign: float, limits: Thresholds, strict: bool
) -> Planes:
    d, k, across = limits.granularity, len(a), 1 - axis
    there = measures.place(a, b)
    half_a, half_b = a.effective_half(d), b.effective_half(d)
    center = np.stack([there.x, there.y, there.z], axis=1)
    reach = np.stack(measures.extent(there, half_a), axis=1)
    forward, aside, upright = (np.tile(np.eye(3)[one], (k, 1)) for one in (axis, across, 2))
    forward = sign * forward
    # Towards the reference's middle, across and up or down.
    aside *= -np.copysign(1.0, center[:, across])[:, None]
    upright *= -np.copysign(1.0, center[:, 2])[:, None]
    width, face = half_b[:, across], b.half[:, axis]
    depth = np.where(b.normal == axis, np.inf, 2.0 * limits.halfspace_scale * half_b[:, axis])
    low, high = strip_range(there, half_a, width - 0.5 * d, along_x=axis == 0)
    near, far = (low, high) if sign > 0.0 else (-high, -low)
    height = _common_height(there, half_a, half_b)

    def corner(way: Array, along: Array | None = None) -> Array:
        """Return the figure's farthest point some way; in the strip, where it is to lie so far along it."""
        point = _support(there, half_a, way)
        point[:, 2] = height
        if along is not None:
            point[:, axis] = sign * along
            point[:, across] = np.clip(point[:, across], 0.5 * d - width, width - 0.5 * d)
        return point

    first, last = corner(-forward, near), corner(forward, far)
    found = _Candidates()
    start, middle, out = near - (face - d), sign * center[:, axis], far - (face + d)
    flush = np.minimum(start, middle)
    leaves = (separation < -limits.penetration) | (out >= flush)
    centred = ~leaves & (middle < start)
    found.add(
        np.where(centred, BOUNDS.index("middle"), BOUNDS.index("face")),
        np.where(leaves, out, flush),
        forward,
        np.where(leaves[:, None], last, np.where(centred[:, None], center, first)),
    )
    found.add("end", face + depth - near, -forward, first)
    gap = np.abs(center[:, across])
    found.add("side", width - 0.5 * d + reach[:, across] - gap, aside, corner(aside))
    rise = np.abs(center[:, 2])
    level = center + half_a[:, 2:] * upright
    found.add("height", half_a[:, 2] + half_b[:, 2] - 0.5 * d - rise, upright, level)
    if strict:
        found.add("side", width + d - reach[:, across] - gap, aside, corner(-aside))
        level = center - half_a[:, 2:] * upright
        found.add("height", half_b[:, 2] + d - half_a[:, 2] - rise, upright, level)
        found.add("face", middle - reach[:, axis] - (face - d), forward, corner(-forward))
        found.add("end", face + depth + d - (middle + reach[:, axis]), -forward, corner(forward))
    return found.decisive(b)


def _vertical(a: Boxes, b: Boxes, separation: Array, sign: float, limits: Thresholds, strict: bool) -> Planes:
    d, band, k = limits.granularity, limits.penetration, len(a)
    there = measures.place(a, b)
    back = there.reversed()
    half_a, half_b = a.effective_half(d), b.effective_half(d)
    center = np.stack([there.x, there.y, there.z], axis=1)
    forward = np.tile([0.0, 0.0, sign], (k, 1))
    overlaps = measures.plan_overlaps(there, half_a, half_b)
    height = _common_height(there, half_a, half_b)
    found = _Candidates()
    zero = np.zeros(k)
    x_a, y_a = np.stack([there.cos, there.sin, zero], axis=1), np.stack([-there.sin, there.cos, zero], axis=1)
    x_b, y_b = np.tile(np.eye(3)[0], (k, 1)), np.tile(np.eye(3)[1], (k, 1))
    # Towards the reference's middle, along the sides of either.
    ways = [
        way * side[:, None]
        for way, side in (
            (x_b, -np.copysign(1.0, there.x)),
            (y_b, -np.copysign(1.0, there.y)),
            (x_a, np.copysign(1.0, back.x)),
            (y_a, np.copysign(1.0, back.y)),
        )
    ]
    for way, overlap in zip(ways, overlaps, strict=True):
        point = _support(there, half_a, way)
        point[:, 2] = height
        found.add("side", overlap - 0.5 * d, way, point)
    lateral = overlaps.min(axis=0)
    up, down = measures.vertical_escapes(there, a.half, b.half, a.surface, b.surface, d)
    escape, other = (up, down) if sign > 0.0 else (down, up)
    face = b.half[:, 2]
    depth = np.where(b.normal == 2, np.inf, 2.0 * limits.halfspace_scale * half_b[:, 2])
    near, far = sign * center[:, 2] - a.half[:, 2], sign * center[:, 2] + a.half[:, 2]
    first, last = center - a.half[:, 2:] * forward, center + a.half[:, 2:] * forward
    out, start = far - (face + d), near - (face - d)
    deep = separation < -band
    contact = ~deep & (separation <= d)
    room = np.where(np.isinf(escape), 0.0, np.minimum(np.minimum(lateral, band), other))
    margin = np.where(contact, near - face + room, np.where(deep, out, np.maximum(start, out)))
    leaves = ~contact & (deep | (out >= start))
    found.add("face", margin, forward, np.where(leaves[:, None], last, first))
    found.add("end", face + depth - near, -forward, first)
    if strict:
        for way in ways[:2]:
            point = _support(there, half_a, -way)
            point[:, 2] = height
            width = np.einsum("ij,ij->i", np.abs(way), half_b)
            found.add("side", np.einsum("ij,ij->i", way, point) + width + d, way, point)
        found.add("face", start, forward, first)
        found.add("end", face + depth + d - far, -forward, last)
    return found.decisive(b)


def _common_height(there: measures.Placement, half_a: Array, half_b: Array) -> Array:
    """Return the middle of the heights that figure and reference share, or of those between them."""
    low = np.maximum(there.z - half_a[:, 2], -half_b[:, 2])
    high = np.minimum(there.z + half_a[:, 2], half_b[:, 2])
    return np.clip(0.5 * (low + high), there.z - half_a[:, 2], there.z + half_a[:, 2])


def _support(there: measures.Placement, half_a: Array, way: Array) -> Array:
    """Return the figures' points farthest along level directions, (k, 3).

    Of a side square to the direction it is the middle.
    """
    along = way[:, 0] * there.cos + way[:, 1] * there.sin
    across = way[:, 1] * there.cos - way[:, 0] * there.sin
    x = np.where(np.abs(along) > _STRAIGHT, np.copysign(half_a[:, 0], along), 0.0)
    y = np.where(np.abs(across) > _STRAIGHT, np.copysign(half_a[:, 1], across), 0.0)
    return np.stack(
        [there.x + x * there.cos - y * there.sin, there.y + x * there.sin + y * there.cos, there.z], axis=1
    )


def _turned(vectors: Array, boxes: Boxes) -> Array:
    """Return vectors in the frames of boxes, (k, 3), as the world's."""
    x, y, z = vectors.T
    return np.stack([boxes.cos * x - boxes.sin * y, boxes.sin * x + boxes.cos * y, z], axis=1)
