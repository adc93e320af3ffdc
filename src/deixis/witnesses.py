"""Witnesses: the points between which a separation is measured, to be shown in a picture.

Move the reference by the separation along its normal, and the two just touch. Where they touch is the
patch that everything here is taken from: its middle is the figure's point, and the reference's is where that
point comes from. So one rule serves what is apart, what touches and what overlaps.
"""

from __future__ import annotations

from itertools import product
from typing import Final

import numpy as np

from deixis import measures
from deixis.boxes import Boxes
from deixis.facts import Facts
from deixis.frames import Array, Index, Mask
from deixis.scene import Scene

_ON: Final = 1.0e-9
"""Metres: a corner nearer than this to a side is on it; rounding is far less, and nothing is seen of it."""

_PARALLEL: Final = 1.0e-9
"""Sides whose directions have a lesser cross product, radians, have no point in which they cross."""


def segments(boxes: Boxes, figure: Index, reference: Index, granularity: float) -> Array:
    """Return for each pair of boxes the two points between which their signed separation is measured.

    Apart, they are nearest points; overlapping, the points that give the depth along the contact normal: the
    figure's deepest, and that on the reference's face where it would come out. From the second to the
    first it is the separation times the normal that :func:`deixis.measures.separation` gives.

    Parameters
    ----------
    boxes : Boxes
        Of a scene, metres, world frame.
    figure, reference : (k,) int
        Positions in it.
    granularity : float
        D, metres: what counts as within the other does not leave it through the bottom (decision 0004).

    Returns
    -------
    (k, 2, 3) float
        The figure's point, then the reference's, metres, world frame.

    Examples
    --------
    >>> from deixis.scene import Scene
    >>> cup = {"id": "cup", "label": "cup", "box": {"center": [0, 0, 0.83], "size": [0.1, 0.1, 0.1]}}
    >>> table = {"id": "table", "label": "table", "box": {"center": [0.5, 0, 0.375], "size": [1.2, 1, 0.75]}}
    >>> scene = Scene.from_dict({"deixis": 1, "id": "s", "objects": [cup, table], "views": []})
    >>> segments(scene.boxes, np.array([0]), np.array([1]), 0.02).round(3)[0].tolist()
    [[0.0, 0.0, 0.78], [0.0, 0.0, 0.75]]
    """
    a, b = boxes.take(figure), boxes.take(reference)
    there = measures.place(a, b)
    up, down = measures.vertical_escapes(there, a.half, b.half, a.surface, b.surface, granularity)
    separation, normal = measures.separation(there, a.half, b.half, up, down)
    offset = separation[:, None] * normal
    local = _middle_of_contact(there, a.half, b.half, offset)
    return np.stack([_to_world(local, b), _to_world(local - offset, b)], axis=1)


def measured_segments(scene: Scene, facts: Facts, rows: Index) -> Array:
    """Return the points of :func:`segments` for rows of the facts, of what the facts were measured of.

    Of hulls and meshes the figure's point is on the figure's surface; the other lies where the separation
    says, which is on the reference where the two are apart or convex (decision 0039).
    """
    figure, reference = facts.figure[rows].astype(np.int64), facts.reference[rows].astype(np.int64)
    points = segments(scene.boxes, figure, reference, facts.thresholds.granularity)
    more = np.array([model != "box" for model in facts.models], dtype=np.bool_)
    other = np.flatnonzero(more[figure] | more[reference])
    if len(other):
        from deixis.solids import touching_points

        points[other] = touching_points(scene, facts, rows[other])
    return points


def _middle_of_contact(there: measures.Placement, half_a: Array, half_b: Array, offset: Array) -> Array:
    """Return the middle of where figures touch references that are moved by an offset, reference frame."""
    x, y, z = offset.T
    moved = measures.Placement(there.x - x, there.y - y, there.z - z, there.cos, there.sin)
    low = np.maximum(moved.z - half_a[:, 2], -half_b[:, 2])
    high = np.minimum(moved.z + half_a[:, 2], half_b[:, 2])
    plan = _middle_in_plan(moved, half_a, half_b)
    return np.column_stack([plan, 0.5 * (low + high)]) + offset


def _middle_in_plan(there: measures.Placement, half_a: Array, half_b: Array) -> Array:
    """Return the mean corner of what two plan views have in common, reference frame, (k, 2).

    Its corners are corners of either that lie in the other, and crossings of their sides.
    """
    corners_a = np.stack(measures.corners_in_reference(there, half_a))
    back = there.reversed()
    seen_b = np.stack(measures.corners_in_reference(back, half_b))
    signs = np.array([[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]])
    corners_b = signs.T[:, :, None] * half_b.T[:2, None]
    total, count = np.zeros((2, len(there.x))), np.zeros(len(there.x))

    def add(points: Array, where: Mask) -> None:
        nonlocal total, count
        total, count = total + np.where(where, points, 0.0), count + where

    for corner in range(4):
        add(corners_a[:, corner], _within(corners_a[:, corner], half_b))
        apart = (np.abs(corners_a - corners_b[:, None, corner]).max(axis=0) > _ON).all(axis=0)
        add(corners_b[:, corner], _within(seen_b[:, corner], half_a) & apart)
    for i, j in product(range(4), repeat=2):
        start, other = corners_a[:, i], corners_b[:, j]
        side, across = corners_a[:, (i + 1) % 4] - start, corners_b[:, (j + 1) % 4] - other
        add(*_crossing(start, side, other, across))
    # A corner that touches and, by rounding, is nowhere within: it cannot be farther out than that.
    lost = count == 0.0
    if lost.any():
        nearest = np.clip(corners_a, -half_b.T[:2, None], half_b.T[:2, None])
        gap = np.linalg.norm(corners_a - nearest, axis=0)
        best = np.take_along_axis(corners_a, gap.argmin(axis=0)[None, None], axis=1)[:, 0]
        total, count = np.where(lost, best, total), np.where(lost, 1.0, count)
    return np.asarray((total / count).T)


def _within(points: Array, half: Array) -> Mask:
    """Return which points, (2, k), lie in the plan view of boxes about the origin, or on its sides."""
    return np.asarray((np.abs(points) <= half.T[:2] + _ON).all(axis=0))


def _crossing(start: Array, side: Array, other: Array, across: Array) -> tuple[Array, Mask]:
    """Return where two sides cross, (2, k), and which of them do elsewhere than at a corner of either."""
    turn = side[0] * across[1] - side[1] * across[0]
    long, wide = np.hypot(*side), np.hypot(*across)
    crosses = np.abs(turn) > _PARALLEL * long * wide
    safe = np.where(crosses, turn, 1.0)
    gap = other - start
    t = (gap[0] * across[1] - gap[1] * across[0]) / safe
    u = (gap[0] * side[1] - gap[1] * side[0]) / safe
    crosses &= (np.abs(t - 0.5) * long < 0.5 * long - _ON) & (np.abs(u - 0.5) * wide < 0.5 * wide - _ON)
    return start + t * side, crosses


def _to_world(points: Array, boxes: Boxes) -> Array:
    """Return points in the frames of boxes, (k, 3), in the world's."""
    x, y, z = points.T
    turned = np.stack([boxes.cos * x - boxes.sin * y, boxes.sin * x + boxes.cos * y, z], axis=1)
    return np.asarray(boxes.center + turned)
