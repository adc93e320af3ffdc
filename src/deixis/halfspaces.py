"""Halfspaces: whether a figure reaches into the space on one side of a reference (axioms 20-34).

A halfspace is the reference's box swept outwards along one of its axes. Each answer is a margin: the number
of metres by which the figure would have to move for the answer to change, not negative where it is yes.
"""

from __future__ import annotations

import numpy as np

from deixis.frames import Array, Index
from deixis.measures import Placement, extent, plan_overlaps
from deixis.thresholds import Thresholds


def strip_range(placement: Placement, half_a: Array, half_width: Array, along_x: bool) -> tuple[Array, Array]:
    """Return how far a figure reaches, along one axis of the reference, within a strip along that axis.

    Parameters
    ----------
    placement : Placement
        Of k pairs.
    half_a : (k, 3) float
        Half extents of the figures, metres.
    half_width : (k,) float
        The strip is ``|across| <= half_width`` in the reference's frame, metres.
    along_x : bool
        Whether the strip runs along X (and Y is across it), or the other way round.

    Returns
    -------
    low, high : (k,) float
        Metres along the axis, from the reference's centre; without a common part they mean nothing.
    """
    if along_x:
        cos, sin, across, along = placement.sin, placement.cos, placement.y, placement.x
    else:
        cos, sin, across, along = placement.cos, placement.sin, placement.x, placement.y
    # From its highest corner a rectangle's outline falls along one side to the left and one to the right,
    # all the way to its ends; so the highest point in the strip is the one nearest to the corner's place.
    flat, steep = np.abs(cos), np.abs(sin)
    way = np.copysign(1.0, cos) * np.copysign(1.0, sin)
    top = way * (half_a[:, 0] * flat - half_a[:, 1] * steep)
    reach = half_a[:, 0] * steep + half_a[:, 1] * flat
    slope = steep / np.maximum(flat, _TINY), flat / np.maximum(steep, _TINY)
    results = []
    for side in (1.0, -1.0):
        corner = across + side * top
        aside = np.minimum(np.maximum(corner, -half_width), half_width) - corner
        # Moving the strip by a picometre changes nothing that is measured, and keeps steep sides finite.
        falls = np.maximum(np.abs(aside) - _PICOMETRE, 0.0)
        drop = falls * np.where(aside * side * way < 0.0, slope[0], slope[1])
        results.append(along + side * (reach - np.minimum(drop, 2.0 * reach)))
    return results[1], results[0]


_TINY = 1.0e-300
_PICOMETRE = 1.0e-12


def meets_horizontal(
    placement: Placement,
    half_a: Array,
    half_b: Array,
    normal_b: Index,
    separation: Array,
    limits: Thresholds,
) -> tuple[Array, Array]:
    """Return margins of "the figure meets the halfspace" and "lies completely in it", for X+, X-, Y+, Y-.

    A halfspace is the reference's box swept outwards along one of its axes by s times its full extent
    there, without end along a surface's normal (axioms 20, 30, decision 0001). The figure meets it
    iff their cross-sections overlap by at least D/2, the figure lies beyond the face up to D or reaches
    beyond it by D, and it begins before the halfspace ends; it lies completely in it iff, besides, it
    protrudes nowhere by more than D (axiom 21). What intersects the reference has to reach beyond the face:
    a thin thing at a drawer's side, within it, is not beside it.

    Parameters
    ----------
    placement : Placement
        Of k pairs, in the frame that the halfspaces are to be aligned with.
    half_a, half_b : (k, 3) float
        Half extents of figure and reference in their frames, metres.
    normal_b : (k,) int
        For surfaces the axis of the normal.
    separation : (k,) float
        Of :func:`deixis.measures.separation`, metres.
    limits : Thresholds

    Returns
    -------
    relaxed, strict : (k, 4) float
        Metres by which the answer would have to move to flip; not negative where it holds.
    """
    granularity = limits.granularity
    deep = separation < -limits.penetration
    thick_a, thick_b = np.maximum(half_a, 0.5 * granularity), np.maximum(half_b, 0.5 * granularity)
    a_x, a_y = extent(placement, thick_a)
    slack_z = thick_a[:, 2] + thick_b[:, 2] - 0.5 * granularity - np.abs(placement.z)
    within_z = thick_b[:, 2] + granularity - thick_a[:, 2] - np.abs(placement.z)
    relaxed, strict = np.empty((len(a_x), 4)), np.empty((len(a_x), 4))
    for axis in (0, 1):
        center, reach = (placement.x, a_x) if axis == 0 else (placement.y, a_y)
        center_across, reach_across = (placement.y, a_y) if axis == 0 else (placement.x, a_x)
        width = thick_b[:, 1 - axis]
        face = half_b[:, axis]
        depth = np.where(normal_b == axis, np.inf, 2.0 * limits.halfspace_scale * thick_b[:, axis])
        low, high = strip_range(placement, thick_a, width - 0.5 * granularity, along_x=axis == 0)
        slack = np.minimum(width - 0.5 * granularity + reach_across - np.abs(center_across), slack_z)
        within = np.minimum(width + granularity - reach_across - np.abs(center_across), within_z)
        for column, (near, far, middle) in enumerate(((low, high, center), (-high, -low, -center))):
            # Flush on a wall no thicker than D, a sheet is on the side its middle is on, not on both.
            flush = np.minimum(near - (face - granularity), middle)
            out = far - (face + granularity)
            beyond = np.where(deep, out, np.maximum(flush, out))
            meets = np.minimum(np.minimum(slack, beyond), face + depth - near)
            starts = middle - reach - (face - granularity)
            ends = face + depth + granularity - (middle + reach)
            relaxed[:, 2 * axis + column] = meets
            strict[:, 2 * axis + column] = np.minimum(np.minimum(meets, within), np.minimum(starts, ends))
    return relaxed, strict


def meets_vertical(
    placement: Placement,
    half_a: Array,
    half_b: Array,
    normal_b: Index,
    separation: Array,
    up: Array,
    down: Array,
    limits: Thresholds,
) -> tuple[Array, Array]:
    """Return the margins of :func:`meets_horizontal` along Z+ and Z- of the minimum box (axioms 26, 27).

    Of two things in contact the figure is beyond the face that the contact is on: the way out through it is
    the shortest. So of two books side by side neither is above the other, however their boxes overlap, and
    a spoon sunk in the box of a counter is above it.

    Parameters
    ----------
    placement, half_a, half_b, normal_b
        As for :func:`meets_horizontal`, in the reference's own frame.
    separation, up, down : (k,) float
        Of :func:`separation` and :func:`vertical_escapes`, metres.
    limits : Thresholds
    """
    granularity, band = limits.granularity, limits.penetration
    thick_a, thick_b = np.maximum(half_a, 0.5 * granularity), np.maximum(half_b, 0.5 * granularity)
    lateral = plan_overlaps(placement, thick_a, thick_b).min(axis=0)
    slack = lateral - 0.5 * granularity
    a_x, a_y = extent(placement, thick_a)
    within = granularity - np.maximum(
        np.abs(placement.x) + a_x - thick_b[:, 0], np.abs(placement.y) + a_y - thick_b[:, 1]
    )
    face = half_b[:, 2]
    depth = np.where(normal_b == 2, np.inf, 2.0 * limits.halfspace_scale * thick_b[:, 2])
    deep = separation < -band
    contact = ~deep & (separation <= granularity)
    relaxed, strict = np.empty((len(a_x), 2)), np.empty((len(a_x), 2))
    for column, (center, escape, other) in enumerate(((placement.z, up, down), (-placement.z, down, up))):
        near, far = center - half_a[:, 2], center + half_a[:, 2]
        out = far - (face + granularity)
        beyond = np.where(deep, out, np.maximum(near - (face - granularity), out))
        # A way out that does not count is as far as it would be if it did.
        blocked = center - half_a[:, 2] - face
        facing = np.where(np.isinf(escape), blocked, np.minimum(np.minimum(lateral, band), other) - escape)
        beyond = np.where(contact, facing, beyond)
        meets = np.minimum(np.minimum(slack, beyond), face + depth - near)
        relaxed[:, column] = meets
        strict[:, column] = np.minimum(
            np.minimum(meets, within),
            np.minimum(near - (face - granularity), face + depth + granularity - far),
        )
    return relaxed, strict
