"""Pieces of a point cloud (axioms 3, 6-8): which of its points hang together, step by step.

A cloud is a sample of a region. Points no further apart than a gap are linked, and a piece is all that a
chain of links reaches. The answer is exact; time and memory grow with the points and not with their pairs,
since points in the same or in adjoining small cells are linked unseen, and distances are computed only
where two pieces come near each other.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

from deixis.errors import GeometryError
from deixis.frames import Array, Index, Mask
from deixis.thresholds import SNAP

Strays = Literal["drop", "refuse"]
"""What becomes of the stray pieces of a point cloud: they are left out, or the scene is refused."""

Label = NDArray[np.int32]

CHUNK: Final = 1 << 20
"""Points looked at together: what they need besides themselves is some 100 bytes each."""

_FIELD: Final = 21
"""Bits of a cell's key for each of its three whole coordinates, one to spare."""

_FIRST: Final = 8
"""The least coordinate: a neighbour's key never borrows from the next field."""

_LAST: Final = (1 << _FIELD - 1) - _FIRST

_X, _Y, _Z = 1 << 2 * _FIELD, 1 << _FIELD, 1

_SURE: Final = (_X, _Y, _Z, _X + _Y, _X - _Y, _X + _Z, _X - _Z, _Y + _Z, _Y - _Z)
"""Half of the 18 cells that share a side or an edge with a cell: none of their points are too far apart."""

_NEAR: Final = (0, *_SURE, _X + _Y + _Z, _X + _Y - _Z, _X - _Y + _Z, _X - _Y - _Z)
"""A block itself and half of the 26 around it: no point beyond them is near enough."""

_DENSE: Final = 1 << 18
"""Cells in all, empty ones too, up to which they are looked at as an image."""

_BLOCK_BITS: Final = 2
"""A block is four cells wide, more than the gap, so that of a gap's length it holds all but the ends."""

_BLOCK_MASK: Final = sum((1 << _FIELD - _BLOCK_BITS) - 1 << axis * _FIELD for axis in range(3))

_PAIRS: Final = 1 << 20
"""Distances computed at once."""

_CROWD: Final = 1024
"""With more pairs of points than this between two groups, a tree is faster than all their distances."""


def one_piece(points: Array, gap: float, strays: Strays = "drop") -> tuple[Mask | None, str]:
    """Return which points of a cloud are the thing, and a sentence on the others where there are some.

    A piece with more than half of the points is the thing, and the others are strays. Where no piece has,
    nothing tells strays from the thing (corners, a thing seen in parts), and all points are kept.

    Parameters
    ----------
    points : (m, 3) float
        Metres, m >= 1, all finite.
    gap : float
        Metres, above zero: the longest step within a piece.
    strays : "drop" or "refuse"

    Returns
    -------
    keep : (m,) bool or None
        None where all are kept.
    note : str
        Empty where the cloud is of one piece.

    Raises
    ------
    GeometryError
        The cloud is in pieces and ``strays`` is ``"refuse"``, or it is too wide for its gap.

    Examples
    --------
    >>> keep, note = one_piece(np.array([[0, 0, 0], [0.1, 0, 0], [0.2, 0, 0], [7, 0, 0]]), 0.1)
    >>> keep.tolist(), note
    ([True, True, True, False], '1 of its 4 points is a stray, more than 0.1 m from the rest: left out')
    """
    label, size = pieces(points, gap)
    count, total, main = len(size), len(points), int(size[0])
    if count == 1:
        return None, ""
    apart = f"in {count:,} pieces more than {gap:g} m apart"
    if strays == "refuse":
        remedy = 'clean it, raise the threshold piece_gap, or let "strays" be "drop"'
        raise GeometryError(f"its {total:,} points are {apart}, {main:,} in the largest: {remedy}")
    if 2 * main <= total:
        return None, f"its {total:,} points are {apart}, {main:,} in the largest, not most: all are kept"
    some = "is a stray" if total - main == 1 else "are strays"
    where = f"in {count - 1:,} pieces " if count > 2 else ""
    note = f"{total - main:,} of its {total:,} points {some}, {where}more than {gap:g} m from the rest"
    return label == 0, f"{note}: left out"


def pieces(points: Array, gap: float) -> tuple[Label, Index]:
    """Return which piece each point of a cloud is in (axiom 8), 0 the largest, and how large the pieces are.

    Two points are in one piece iff there is a chain of points between them whose every step is at most
    ``gap`` long, closed to a nanometre (decision 0011). Of equally large pieces the one with the first
    point given comes first.

    Parameters
    ----------
    points : (m, 3) float
        Metres, m >= 1, all finite.
    gap : float
        Metres, above zero.

    Returns
    -------
    label : (m,) int
    size : (k,) int
        Points in each piece, in falling order.

    Raises
    ------
    GeometryError
        The cloud is too wide for its gap: not even its occupied cells of gap / 3 can be numbered.

    Examples
    --------
    >>> label, size = pieces(np.array([[9, 0, 0], [0, 0, 0], [0, 1, 0], [1, 1, 0.0]]), 1.0)
    >>> label.tolist(), size.tolist()
    ([1, 0, 0, 0], [3, 1])
    """
    low, high = points.min(axis=0), points.max(axis=0)
    whole = np.zeros(len(points), dtype=np.int32), np.array([len(points)])
    if float(np.linalg.norm(high - low)) <= gap:
        return whole
    grid = _Grid.over(points, low, high, gap)
    cells = _unique(grid.keys(part) for _, part in chunks(points))
    label = _sure_links(cells)
    if label.any():
        label = _near_links(points, grid, cells, label, gap + 0.5 * SNAP)
    return _ranked(points, grid, cells, label) if label.any() else whole


@dataclass(frozen=True, slots=True)
class _Grid:
    """Cells of a third of the gap, numbered from the cloud's least corner.

    ``taken`` holds for an axis along which the cloud is too wide the occupied coordinates and what they
    are called instead: the same, save that an empty stretch is never longer than counts.
    """

    low: Array
    cell: float
    taken: tuple[tuple[Index, Index] | None, ...]

    @classmethod
    def over(cls, points: Array, low: Array, high: Array, gap: float) -> _Grid:
        """Return the grid of a cloud."""
        # A trifle less than a third: rounding must not make a sure link of a step too long.
        plain = cls(low, gap / 3.0 * (1.0 - 1.0e-9), (None, None, None))
        taken: list[tuple[Index, Index] | None] = []
        for axis in range(3):
            if (high[axis] - low[axis]) / plain.cell < _LAST - _FIRST:
                taken.append(None)
                continue
            known = _unique(plain._along(part, axis) for _, part in chunks(points))
            called = _FIRST + np.cumsum(np.minimum(np.diff(known, prepend=known[:1]), 3 << _BLOCK_BITS))
            if called[-1] > _LAST:
                raise GeometryError(
                    f"its points spread over {high[axis] - low[axis]:,.0f} m, too far to look for gaps of "
                    f"{gap:g} m: drop what is far, or raise the threshold piece_gap"
                )
            taken.append((known, called))
        return cls(low, plain.cell, tuple(taken))

    def _along(self, points: Array, axis: int) -> Index:
        along: Index = ((points[:, axis] - self.low[axis]) / self.cell).astype(np.int64)
        return along + _FIRST

    def keys(self, points: Array) -> Index:
        """Return the key of the cell that each point is in."""
        result = np.zeros(len(points), dtype=np.int64)
        for axis, taken in enumerate(self.taken):
            along = self._along(points, axis)
            if taken is not None:
                along = taken[1][np.searchsorted(taken[0], along)]
            result = (result << _FIELD) | along
        return result


def _blocks(keys: Index) -> Index:
    """Return the keys of the blocks that cells are in."""
    return (keys >> _BLOCK_BITS) & _BLOCK_MASK


def chunks(points: Array) -> Iterator[tuple[int, Array]]:
    """Yield the points in chunks, each with the position of its first."""
    for start in range(0, len(points), CHUNK):
        yield start, points[start : start + CHUNK]


def _unique(parts: Iterable[Index]) -> Index:
    """Return the different numbers in some arrays, in order, a few arrays at a time."""
    result = np.empty(0, dtype=np.int64)
    waiting: list[Index] = []
    for part in parts:
        waiting.append(_sorted_set(part))
        if sum(map(len, waiting)) > max(CHUNK, len(result)):
            result, waiting = _sorted_set(np.concatenate([result, *waiting])), []
    return _sorted_set(np.concatenate([result, *waiting]))


def _sorted_set(numbers: Index) -> Index:
    # numpy's own unique hashes whole numbers first, which takes ten times as long.
    numbers = np.sort(numbers)
    return np.asarray(numbers[np.r_[True, numbers[1:] != numbers[:-1]][: len(numbers)]])


def _components(size: int, one: Index | Label, other: Index | Label) -> Label:
    """Return for labels 0..size-1, some of them linked, new ones, numbered in the order of the old."""
    if len(one) == 0:
        return np.arange(size, dtype=np.int32)
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    links = coo_array((np.ones(len(one), dtype=np.bool_), (one, other)), shape=(size, size))
    return np.asarray(connected_components(links, directed=False)[1], dtype=np.int32)


def _found(keys: Index, wanted: Index) -> tuple[Index, Index]:
    """Return which of the wanted keys there are, and where in the sorted keys."""
    place = np.searchsorted(keys, wanted)
    place[place == len(keys)] = 0
    here = np.flatnonzero(keys[place] == wanted)
    return here, place[here]


def _spread(count: Index) -> Iterator[tuple[Index, Index]]:
    """Yield (row, rank) with every rank from 0 to below the row's count, some million at a time."""
    number = (np.cumsum(count) - 1) // _PAIRS
    bounds = [0, *(np.flatnonzero(np.diff(number)) + 1).tolist(), len(count)]
    for first, last in pairwise(bounds):
        part = count[first:last]
        begin = np.repeat(np.cumsum(part) - part, part)
        yield np.repeat(np.arange(first, last), part), np.arange(len(begin)) - begin


def _sure_links(cells: Index) -> Label:
    """Return a label for each cell, the same for those that adjoin each other."""
    place = np.stack([cells >> shift & (1 << _FIELD) - 1 for shift in (2 * _FIELD, _FIELD, 0)])
    place -= place.min(axis=1, keepdims=True)
    shape = place.max(axis=1) + 1
    if shape.prod() <= _DENSE:
        from scipy.ndimage import generate_binary_structure, label

        image = np.zeros(shape, dtype=np.bool_)
        image[*place] = True
        return np.asarray(label(image, generate_binary_structure(3, 2))[0][*place] - 1, dtype=np.int32)
    links = [_found(cells, cells + offset) for offset in _SURE]
    one, other = (np.concatenate(ends).astype(np.int32) for ends in zip(*links, strict=True))
    return _components(len(cells), one, other)


def _near_links(points: Array, grid: _Grid, cells: Index, label: Label, gap: float) -> Label:
    """Return the cells' labels with those linked that have points near enough, however the cells lie."""
    contested = _contested(_blocks(cells), label)
    owner, near = [], []
    for _, part in chunks(points):
        place = np.searchsorted(cells, grid.keys(part))
        inside = contested[place]
        owner.append(place[inside])
        near.append(part[inside])
    cell, points = np.concatenate(owner), np.concatenate(near)
    block = _blocks(cells[cell])
    for offset in _NEAR if len(cell) else ():
        if not label.any():
            break
        order = np.lexsort((label[cell], block))
        cell, block, points = cell[order], block[order], points[order]
        label = _Groups.of(points, block, label[cell]).linked(int(label.max()) + 1, offset, gap)[label]
    return label


def _contested(block: Index, label: Label) -> Mask:
    """Return which cells are in, or next to, a block with cells of another label."""
    order = np.lexsort((label, block))
    label = label[order]
    known, starts, counts = np.unique(block[order], return_index=True, return_counts=True)
    least, most = label[starts], label[starts + counts - 1]
    mixed = least != most
    for offset in _NEAR[1:]:
        here, there = _found(known, known + offset)
        other = (least[here] != least[there]) | (most[here] != most[there])
        mixed[here[other]] = True
        mixed[there[other]] = True
    result = np.empty(len(block), dtype=np.bool_)
    result[order] = np.repeat(mixed, counts)
    return result


@dataclass(frozen=True, slots=True)
class _Groups:
    """Points that share a block and a label, in the order of blocks."""

    points: Array
    block: Index
    label: Label
    start: Index
    size: Index

    @classmethod
    def of(cls, points: Array, block: Index, label: Label) -> _Groups:
        """Return the groups of points, which are in the order of blocks, then labels."""
        start = np.flatnonzero(np.r_[True, (np.diff(block) != 0) | (np.diff(label) != 0)])
        return cls(points, block[start], label[start], start, np.diff(np.r_[start, len(block)]))

    def linked(self, labels: int, offset: int, gap: float) -> Label:
        """Return new labels for old: those are linked whose groups, this offset apart, come near enough."""
        low = np.searchsorted(self.block, self.block + offset, side="left")
        high = np.searchsorted(self.block, self.block + offset, side="right")
        if offset == 0:
            # Each pair within a block once.
            low = np.arange(len(self.block)) + 1
        if not (high > low).any():
            return np.arange(labels, dtype=np.int32)
        ends = [np.empty((2, 0), dtype=np.int32)]
        crowds = [np.empty((2, 0), dtype=np.int64)]
        for i, rank in _spread(high - low):
            pair = np.stack([i, low[i] + rank])
            pair = pair[:, self.label[pair[0]] != self.label[pair[1]]]
            few = self.size[pair[0]] * self.size[pair[1]] <= _CROWD
            ends.append(self._near(pair[:, few], gap))
            crowds.append(pair[:, ~few])
        found = _components(labels, *np.concatenate(ends, axis=1))
        more = self._near_crowds(found, np.concatenate(crowds, axis=1), gap)
        return _components(labels, *np.concatenate([*ends, more], axis=1)) if more.size else found

    def _near(self, pair: Index, gap: float) -> Label:
        """Return the labels of those pairs of groups that come near enough, by all distances, (2, q)."""
        first, second = self.start[pair]
        found = [np.empty(0, dtype=np.int64)]
        for row, rank in _spread(self.size[pair[0]] * self.size[pair[1]]):
            one, other = np.divmod(rank, self.size[pair[1]][row])
            step = self.points[first[row] + one] - self.points[second[row] + other]
            found.append(np.unique(row[np.einsum("ij,ij->i", step, step) <= gap * gap]))
        return self.label[pair[:, np.concatenate(found)]]

    def _near_crowds(self, found: Label, pair: Index, gap: float) -> Label:
        """Return the labels of those pairs of groups, not yet linked, that do so, by a tree, (2, q)."""
        from scipy.spatial import cKDTree

        one, other = self.label[pair]
        pair = pair[:, found[one] != found[other]]
        both, which = np.unique(np.sort(self.label[pair], axis=0), axis=1, return_inverse=True)
        near = []
        for number in range(both.shape[1]):
            group = np.unique(pair[:, which == number])
            first = self.label[group] == both[0, number]
            tree = cKDTree(self._of(group[first]))
            distance, _ = tree.query(self._of(group[~first]), distance_upper_bound=gap)
            near.append(bool(np.isfinite(distance).any()))
        return both[:, np.flatnonzero(near)]

    def _of(self, groups: Index) -> Array:
        """Return the points of some groups."""
        rows = [self.start[groups][row] + rank for row, rank in _spread(self.size[groups])]
        return self.points[np.concatenate(rows)]


def _ranked(points: Array, grid: _Grid, cells: Index, label: Label) -> tuple[Label, Index]:
    """Return the points' labels, numbered by how many there are of each, and these counts."""
    count = int(label.max()) + 1
    size, first = np.zeros(count, dtype=np.int64), np.full(count, len(points))
    result = np.empty(len(points), dtype=np.int32)
    for start, part in chunks(points):
        here = label[np.searchsorted(cells, grid.keys(part))]
        result[start : start + len(part)] = here
        known, place, number = np.unique(here, return_index=True, return_counts=True)
        size[known] += number
        first[known] = np.minimum(first[known], start + place)
    order = np.lexsort((first, -size))
    rank = np.empty(count, dtype=np.int32)
    rank[order] = np.arange(count, dtype=np.int32)
    for start, part in chunks(points):
        result[start : start + len(part)] = rank[result[start : start + len(part)]]
    return result, size[order]
