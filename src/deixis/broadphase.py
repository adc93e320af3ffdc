"""The broad phase: which ordered pairs of things may be within reach of each other.

Small scenes are compared all with all; larger ones are sorted into strips of the plan, so that the work grows
with the number of near pairs and not with the square of the things.
"""

from __future__ import annotations

from itertools import pairwise
from typing import Final

import numpy as np

from deixis.boxes import Boxes
from deixis.errors import GeometryError
from deixis.frames import Array, Index
from deixis.locality import runs
from deixis.parallel import share
from deixis.thresholds import Thresholds

MAX_PAIRS: Final = 60_000_000
"""Ordered pairs that one scene may have within reach: some 10 GiB of facts."""

_SMALL: Final = 256
"""Up to so many things, comparing all with all is faster than building an index."""

_HITS: Final = 65_536
"""Pairs compared at once: their intermediate arrays stay in the cache."""

_RANGES: Final = 16_384
"""Runs of things sought at once."""

_STRIPS: Final = 2
"""Strips in half a window."""

_KEYS: Final = 1.0e13
"""Where strips and metres are one number, the largest."""

_BITS: Final = 32
"""Bits of a pair's number that name its second thing."""

_SLACK: Final = 1.0e-6
"""Metres added to every reach, so that what stands just at it is not lost to rounding."""


def reach(boxes: Boxes, limits: Thresholds) -> Array:
    """Return how far from each thing, as a reference, a figure may be and still be spoken of, metres, (n,).

    At least T; and far enough for the halfspaces of its contextualised box, which leaves the minimum box
    by at most half its diagonal. A surface's halfspaces have no end, so neither has its reach.
    """
    half = boxes.effective_half(limits.granularity)
    sweep = 2.0 * limits.halfspace_scale
    plan = sweep * half[:, :2].max(axis=1) + np.hypot(half[:, 0], half[:, 1])
    furthest = np.maximum(np.maximum(plan, sweep * half[:, 2]), limits.closeness)
    return np.where(boxes.surface, np.inf, furthest + _SLACK)


def plan_bounds(boxes: Boxes, limits: Thresholds) -> tuple[Array, Array]:
    """Return the corners of axis-aligned rectangles around boxes in plan, metres: lower and upper, (n, 2).

    Of two things within reach of each other these are at most the larger of their two reaches apart.

    Examples
    --------
    >>> import numpy as np
    >>> one = Boxes(np.zeros((1, 3)), np.ones((1, 3)), np.zeros(1), np.array([-1]), np.zeros(1, bool))
    >>> [corner.tolist() for corner in plan_bounds(one, Thresholds())]
    [[[-1.0, -1.0]], [[1.0, 1.0]]]
    """
    around = _around(boxes, limits)[:, :2]
    center = boxes.center[:, :2]
    return center - around, center + around


def candidate_rows(boxes: Boxes, limits: Thresholds, max_pairs: int = MAX_PAIRS) -> tuple[Index, Index]:
    """Return the ordered pairs (figure, reference) that may be within reach, in lexicographic order.

    Parameters
    ----------
    boxes : Boxes
        n things.
    limits : Thresholds
    max_pairs : int
        The most ordered pairs allowed.

    Returns
    -------
    figure, reference : (p,) int
        Both orders of each unordered pair whose axis-aligned boxes are at most one reach apart.

    Raises
    ------
    GeometryError
        There are more than ``max_pairs``.

    Examples
    --------
    >>> import numpy as np
    >>> from deixis.boxes import Boxes
    >>> three = Boxes(np.array([[0, 0, 0], [1, 0, 0], [99, 0, 0.0]]), np.full((3, 3), 0.1), np.zeros(3),
    ...               np.full(3, -1), np.zeros(3, bool))
    >>> [found.tolist() for found in candidate_rows(three, Thresholds())]
    [[0, 1], [1, 0]]
    """
    n = len(boxes)
    around = _around(boxes, limits)
    limit = reach(boxes, limits)
    if n <= _SMALL:
        i, j = np.triu_indices(n, 1)
        near = _gap_squared(boxes.center, around, i, j) <= np.maximum(limit[i], limit[j]) ** 2
        keys = _keys(i[near], j[near])
    else:
        keys = _indexed(boxes.center, around, limit, limits.halfspace_scale, max_pairs)
    if len(keys) > max_pairs:
        raise GeometryError(
            f"more than {max_pairs} ordered pairs are within reach of each other: "
            "lower the closeness threshold, or ground the scene in parts"
        )
    return _sorted_pairs(keys)


def candidates_of(boxes: Boxes, limits: Thresholds, some: Index) -> tuple[Index, Index]:
    """Return those of :func:`candidate_rows` in which at least one of some things takes part."""
    n = len(boxes)
    around = _around(boxes, limits)
    limit = reach(boxes, limits)
    i = np.repeat(some, n)
    j = np.tile(np.arange(n), len(some))
    near = (i != j) & (_gap_squared(boxes.center, around, i, j) <= np.maximum(limit[i], limit[j]) ** 2)
    i, j = i[near], j[near]
    # A pair of two of them is found by both.
    seen = np.zeros(n, dtype=np.bool_)
    seen[some] = True
    once = ~seen[j] | (i < j)
    return _sorted_pairs(_keys(i[once], j[once]))


def _keys(i: Index, j: Index) -> Index:
    """Return a number for each ordered pair, both of each unordered one."""
    return np.concatenate([i << _BITS | j, j << _BITS | i])


def _sorted_pairs(keys: Index) -> tuple[Index, Index]:
    """Return the ordered pairs of these numbers in lexicographic order, in part in the same memory."""
    keys.sort()
    figure = keys >> _BITS
    keys &= (1 << _BITS) - 1
    return figure, keys


def _around(boxes: Boxes, limits: Thresholds) -> Array:
    """Return the half extents of axis-aligned boxes around boxes, metres, (n, 3)."""
    half = boxes.effective_half(limits.granularity)
    cos, sin = np.abs(boxes.cos), np.abs(boxes.sin)
    return np.stack(
        [half[:, 0] * cos + half[:, 1] * sin, half[:, 0] * sin + half[:, 1] * cos, half[:, 2]], axis=1
    )


def _gap_squared(center: Array, around: Array, i: Index, j: Index) -> Array:
    """Return the squared distance of axis-aligned boxes, square metres."""
    result = np.zeros(len(i))
    for axis in range(3):
        gap = np.abs(center[i, axis] - center[j, axis]) - around[i, axis] - around[j, axis]
        np.maximum(gap, 0.0, out=gap)
        result += gap * gap
    return result


def _indexed(center: Array, around: Array, limit: Array, scale: float, max_pairs: int) -> Index:
    """Return the numbers of the pairs within reach; the farther-reaching of two things finds both.

    The plan is cut into strips along X. Things are sorted by strip and by X within it, so that those whose
    centre lies in a window are one run in each of its strips.
    """
    ends = np.isfinite(limit)
    # What reaches no farther than another thing is no larger than a part of that reach (see reach).
    largest = around[ends, :2].max(initial=0.0)
    other = np.minimum(np.where(ends, limit, 0.0) / (1.0 + np.sqrt(2.0) * scale), largest)
    low, extent = center.min(axis=0), np.ptp(center, axis=0) + 1.0
    window = np.minimum(around[:, :2] + (limit + other)[:, None] + _SLACK, 2.0 * extent[:2])
    # Few enough strips for a double to tell a centimetre beyond the last.
    width = max(float(np.median(window[:, 1])) / _STRIPS, extent[0] * extent[1] / _KEYS)
    strip, x = ((center[:, 1] - low[1]) / width).astype(np.int64), center[:, 0] - low[0]
    order = np.lexsort((x, strip))
    strip, x, window = strip[order], x[order], window[order]
    y = (center[:, 1] - low[1])[order]
    last = int(strip[-1])
    lowest = np.clip((y - window[:, 1]) / width, 0, last).astype(np.int64)
    highest = np.clip((y + window[:, 1]) / width, 0, last).astype(np.int64)
    key = strip * extent[0] + x
    left = np.maximum(x - window[:, 0], 0.0) - 0.02
    right = np.minimum(x + window[:, 0], extent[0] - 1.0) + 0.02
    center, around, limit = center[order], around[order], limit[order]
    squared = limit**2
    found: list[Index] = []

    def search(part: tuple[int, int]) -> None:
        asking = np.arange(*part)
        strips = highest[asking] - lowest[asking] + 1
        base = runs(lowest[asking], strips) * extent[0]
        asking = np.repeat(asking, strips)
        first = np.searchsorted(key, base + left[asking])
        size = np.searchsorted(key, base + right[asking], "right") - first
        for some in _slices(size, _HITS):
            # More than that is refused; to go on would only cost memory.
            if sum(map(len, found)) > max_pairs:
                return
            one, two = np.repeat(asking[some], size[some]), runs(first[some], size[some])
            farther = np.flatnonzero((limit[one] > limit[two]) | ((limit[one] == limit[two]) & (one < two)))
            one, two = one[farther], two[farther]
            near = np.flatnonzero(_gap_squared(center, around, one, two) <= squared[one])
            found.append(_keys(order[one[near]], order[two[near]]))

    share(search, [(part.start, part.stop) for part in _slices(highest - lowest + 1, _RANGES)])
    return np.concatenate(found)


def _slices(cost: Index, most: int) -> list[slice]:
    """Return slices of things so that the costs of each add up to little more than the most."""
    edges = np.flatnonzero(np.diff(np.cumsum(cost) // most)) + 1
    return [slice(start, stop) for start, stop in pairwise([0, *edges.tolist(), len(cost)])]
