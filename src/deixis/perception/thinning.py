"""Thinning: a stream of labelled points becomes one point for each small cell, the mean of those in it.

What is kept grows with the surfaces that were seen and not with the points, so that a file of any length is
read in memory that has a limit.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

import numpy as np

from deixis.errors import SceneError
from deixis.frames import Array, Index
from deixis.perception.clouds import CloudFile

CELL: Final = 0.01
"""Metres: of things."""

COARSE: Final = 5
"""Cells on a side of one for what is no thing."""

MAX_CELLS: Final = 5_000_000
"""Most cells of a cloud: what is kept of each is 48 bytes."""

MAX_THINGS: Final = 4095
"""Most things of a cloud."""

LONE: Final = 4
"""Points, itself among them, that a thing's point has near it, or is left out."""

_BITS: Final = 17
_HALF: Final = 1 << _BITS - 1
_WAITING: Final = 4_000_000


def thinned(cloud: CloudFile, advance: Callable[[int], None] | None = None) -> tuple[dict[int, Array], Array]:
    """Return the points of each thing by its number, and those of no thing, each (m, 3) metres.

    Parameters
    ----------
    cloud : CloudFile
    advance : function, optional
        Told how many points were read, again and again.

    Raises
    ------
    SceneError
        The file is damaged, has more things or more surface than the limits, or a point is too far away.
    """
    known = np.empty(0, dtype=np.int64)
    cells = _Cells()
    for points, instances in cloud.parts():
        numbers = np.unique(instances)
        known = np.union1d(known, numbers[numbers > 0])
        if len(known) > MAX_THINGS:
            raise SceneError(f"the file {cloud.name} has more than {MAX_THINGS:,} instances: split it")
        cells.add(points, instances, cloud.name)
        if advance is not None:
            advance(len(points))
    numbers, means = cells.means()
    order = np.argsort(numbers, kind="stable")
    numbers, means = numbers[order], means[order]
    bounds = np.searchsorted(numbers, known)
    ends = np.searchsorted(numbers, known, side="right")
    things = {
        int(number): _crowded(means[low:high]) for number, low, high in zip(known, bounds, ends, strict=True)
    }
    return things, means[: int(np.searchsorted(numbers, 1))]


class _Cells:
    """Sums of points by instance and cell."""

    def __init__(self) -> None:
        self._numbers = np.empty(0, dtype=np.int64)
        self._keys = np.empty(0, dtype=np.int64)
        self._sums = np.empty((0, 4))
        self._waiting: list[tuple[Index, Index, Array]] = []

    def add(self, points: Array, numbers: Index, name: str) -> None:
        """Add points."""
        cell = np.where(numbers > 0, CELL, CELL * COARSE)
        place = np.floor(points / cell[:, None])
        if len(place) and np.abs(place).max() >= _HALF:
            raise SceneError(
                f"the file {name} has points more than {_HALF * CELL:.0f} m away: use a local frame"
            )
        grid = place.astype(np.int64) + _HALF
        key = (grid[:, 0] << 2 * _BITS) | (grid[:, 1] << _BITS) | grid[:, 2]
        sums = np.concatenate([points, np.ones((len(points), 1))], axis=1)
        self._waiting.append(_summed(numbers, key, sums))
        if sum(len(one[0]) for one in self._waiting) > max(_WAITING, len(self._keys)):
            self._merge()
        if len(self._keys) > MAX_CELLS:
            raise SceneError(f"the file {name} covers more than {MAX_CELLS:,} cells of {CELL} m: split it")

    def _merge(self) -> None:
        parts = [(self._numbers, self._keys, self._sums), *self._waiting]
        self._waiting = []
        self._numbers, self._keys, self._sums = _summed(
            np.concatenate([one[0] for one in parts]),
            np.concatenate([one[1] for one in parts]),
            np.concatenate([one[2] for one in parts]),
        )

    def means(self) -> tuple[Index, Array]:
        """Return the instance and the mean of each cell."""
        self._merge()
        return self._numbers, self._sums[:, :3] / self._sums[:, 3:]


def _summed(numbers: Index, keys: Index, sums: Array) -> tuple[Index, Index, Array]:
    """Return the sums of equal instances and cells."""
    if len(keys) == 0:
        return numbers, keys, sums
    order = np.lexsort((keys, numbers))
    numbers, keys, sums = numbers[order], keys[order], sums[order]
    first = np.flatnonzero(np.r_[True, (np.diff(keys) != 0) | (np.diff(numbers) != 0)])
    return numbers[first], keys[first], np.add.reduceat(sums, first, axis=0)


def _crowded(points: Array) -> Array:
    """Return the points that have others near them, or all where that is none."""
    from scipy.spatial import cKDTree

    tree = cKDTree(points)
    count = tree.query_ball_point(points, 2.5 * CELL, return_length=True)
    keep = np.asarray(count) >= LONE
    return np.asarray(points[keep]) if keep.any() else points
