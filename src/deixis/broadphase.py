"""The broad phase: which ordered pairs of things may be within reach of each other.

Small scenes are compared all with all; larger ones through a spatial index (shapely's STRtree over plan
views), so that the work grows with the number of near pairs and not with the square of the things.
"""

from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor
from itertools import pairwise
from typing import Final

import numpy as np

from deixis.boxes import Boxes
from deixis.errors import GeometryError
from deixis.frames import Array, Index
from deixis.thresholds import Thresholds

MAX_PAIRS: Final = 60_000_000
"""Ordered pairs that one scene may have within reach: some 10 GiB of facts."""

_SMALL: Final = 256
"""Up to so many things, comparing all with all is faster than building an index."""

_HITS: Final = 4_000_000
"""Pairs that one query of the index may return."""

_SLACK: Final = 1.0e-6
"""Metres added to every reach, so that what stands just at it is not lost to rounding."""

WORKERS: Final = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
"""Threads that share the work: numpy and the index let go of the interpreter while they compute."""


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
        i, j = i[near], j[near]
    else:
        i, j = _indexed(boxes.center, around, limit, max_pairs)
    if 2 * len(i) > max_pairs:
        raise GeometryError(
            f"more than {max_pairs} ordered pairs are within reach of each other: "
            "lower the closeness threshold, or ground the scene in parts"
        )
    keys = np.sort(np.concatenate([i * n + j, j * n + i]))
    return keys // n, keys % n


def candidates_of(boxes: Boxes, limits: Thresholds, some: Index) -> tuple[Index, Index]:
    """Return those of :func:`candidate_rows` in which at least one of some things takes part."""
    n = len(boxes)
    around = _around(boxes, limits)
    limit = reach(boxes, limits)
    i = np.repeat(some, n)
    j = np.tile(np.arange(n), len(some))
    near = (i != j) & (_gap_squared(boxes.center, around, i, j) <= np.maximum(limit[i], limit[j]) ** 2)
    i, j = i[near], j[near]
    keys = np.unique(np.concatenate([i * n + j, j * n + i]))
    return keys // n, keys % n


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


def _indexed(center: Array, around: Array, limit: Array, max_pairs: int) -> tuple[Index, Index]:
    """Return the unordered pairs within reach by the index; the farther-reaching of two things finds both."""
    import shapely

    # The middle of the scene is the index's origin, so that no detail is lost far from the world's.
    middle = 0.5 * (center.min(axis=0) + center.max(axis=0))
    low, high = (center - middle - around)[:, :2], (center - middle + around)[:, :2]
    tree = shapely.STRtree(shapely.box(low[:, 0], low[:, 1], high[:, 0], high[:, 1]))
    span = 2.0 * float(np.abs(np.concatenate([low, high])).max()) + 1.0
    wide = np.minimum(limit, span)[:, None]

    def search(start: int, stop: int) -> tuple[Index, Index]:
        part = slice(start, stop)
        asked, found = tree.query(shapely.box(*(low[part] - wide[part]).T, *(high[part] + wide[part]).T))
        asked = asked + start
        mine = (limit[asked] > limit[found]) | ((limit[asked] == limit[found]) & (asked < found))
        asked, found = asked[mine], found[mine]
        near = _gap_squared(center, around, asked, found) <= limit[asked] ** 2
        return asked[near], found[near]

    parts = _parts(_expected_hits(low, high, wide))
    found: list[tuple[Index, Index]] = []
    count = 0
    with ThreadPoolExecutor(WORKERS) as pool:
        for batch in range(0, len(parts), 4 * WORKERS):
            for pairs in pool.map(lambda part: search(*part), parts[batch : batch + 4 * WORKERS]):
                found.append(pairs)
                count += len(pairs[0])
            if 2 * count > max_pairs:
                # The caller refuses; to go on would only cost memory.
                break
    return np.concatenate([one for one, _ in found]), np.concatenate([other for _, other in found])


def _expected_hits(low: Array, high: Array, wide: Array) -> Array:
    """Return for each thing how many plan views its window may meet, at most, up to a coarse grid's cells."""
    half = 0.5 * (high - low).max(axis=1)
    usual = float(np.quantile(half, 0.99)) + 1.0e-9
    large = half > usual
    origin, extent = low.min(axis=0), float((high - low.min(axis=0)).max()) + 1.0e-9
    cells = int(np.clip(extent / max(usual, float(np.median(wide))), 1, 2048))
    size = extent / cells
    at = np.minimum(((0.5 * (low + high) - origin) / size).astype(np.int64), cells - 1)
    counts = np.bincount(at[~large, 0] * cells + at[~large, 1], minlength=cells * cells)
    total = np.zeros((cells + 1, cells + 1))
    total[1:, 1:] = counts.reshape(cells, cells).cumsum(axis=0).cumsum(axis=1)
    first = np.clip(((low - wide - usual - origin) / size).astype(np.int64) - 1, 0, cells)
    last = np.clip(((high + wide + usual - origin) / size).astype(np.int64) + 1, 0, cells)
    within = (
        total[last[:, 0], last[:, 1]]
        - total[first[:, 0], last[:, 1]]
        - total[last[:, 0], first[:, 1]]
        + total[first[:, 0], first[:, 1]]
    )
    return np.asarray(within + large.sum())


def _parts(hits: Array) -> list[tuple[int, int]]:
    """Return slices of the things, each with few enough expected hits to be held in memory at once."""
    number = (np.cumsum(hits) // _HITS).astype(np.int64)
    edges = np.flatnonzero(np.diff(number)) + 1
    bounds = [0, *edges.tolist(), len(hits)]
    return list(pairwise(bounds))
