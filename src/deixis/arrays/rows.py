"""Rows of a predicate as columns, found by the values of some of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from deixis.errors import EngineError
from deixis.frames import Array, Index, Mask

Column = NDArray[Any]


class Rows:
    """The rows of one predicate.

    Parameters
    ----------
    columns : sequence of (n,) array
        Names as whole numbers, numbers as floats.
    margin : (n,) float, optional
        Of each row, metres; None where no length decides any.
    flags : mapping
        Columns beside the arguments, see :mod:`deixis.ruleset.flags`.
    """

    def __init__(
        self, columns: Sequence[Column], margin: Array | None = None, flags: Mapping[str, Mask] | None = None
    ) -> None:
        self.columns = tuple(columns)
        self.margin = margin
        self.flags = flags or {}
        self._sorted: dict[tuple[int, ...], tuple[list[int], NDArray[np.int64], Index] | None] = {}

    def __len__(self) -> int:
        return len(self.columns[0])

    def at(self, rows: Index | Mask) -> Rows:
        """Return some of the rows."""
        margin = None if self.margin is None else self.margin[rows]
        flags = {name: flag[rows] for name, flag in self.flags.items()}
        return Rows([column[rows] for column in self.columns], margin, flags)

    def matches(self, places: Sequence[int], wanted: Sequence[Column], most: int) -> tuple[Index, Index]:
        """Return which of n wanted combinations of values meets which row: positions in both.

        Parameters
        ----------
        places : sequence of int
            The columns to look in.
        wanted : sequence of (n,) array
            A column of values for each.
        most : int
            More meetings than these are refused.

        Raises
        ------
        TooMany
            There are more.
        """
        ready = self._index(tuple(places))
        if ready is None:
            return _meet_unsorted([self.columns[place] for place in places], wanted, most)
        strides, keys, order = ready
        probe = _packed(wanted, strides)
        first = np.searchsorted(keys, probe, side="left")
        count = np.searchsorted(keys, probe, side="right") - first
        return _spread(first, count, order, most)

    def _index(self, places: tuple[int, ...]) -> tuple[list[int], NDArray[np.int64], Index] | None:
        """Return how to make one whole number of these columns, the rows' numbers sorted, and their order."""
        if places not in self._sorted:
            columns = [self.columns[place] for place in places]
            strides = _strides(columns)
            if strides is None:
                self._sorted[places] = None
            else:
                keys = _packed(columns, strides)
                order = np.argsort(keys, kind="stable")
                self._sorted[places] = strides, keys[order], order
        return self._sorted[places]


class TooMany(EngineError):
    """A rule has to look at more rows at once than fit in memory."""


def refuse_more(rows: int, most: int) -> None:
    """Raise :class:`TooMany` where there are more rows than may be."""
    if rows > most:
        raise TooMany(
            f"a rule looks at {rows:,} rows at once: join its goals by things they share, or use DuckDB"
        )


def grouped(columns: Sequence[Column]) -> tuple[Index, Index]:
    """Return one row of each distinct combination of values, and of each row which combination it has."""
    count = len(columns[0])
    if count == 0:
        none = np.zeros(0, dtype=np.int64)
        return none, none
    strides = _strides(columns)
    if strides is not None:
        key = _packed(columns, strides)
    else:
        key = _codes(columns[0])
        for column in columns[1:]:
            more = _codes(column)
            key = key * (int(more.max()) + 1) + more
            _, key = np.unique(key, return_inverse=True)
    _, first, group = np.unique(key, return_index=True, return_inverse=True)
    return first, group


def _codes(column: Column) -> NDArray[np.int64]:
    """Return whole numbers from 0 that are equal where the values are: so many as there are values."""
    # Adding zero makes one of the two zeros.
    values = column + 0.0 if column.dtype == np.float64 else column
    return np.unique(values, return_inverse=True)[1].astype(np.int64)


_WIDEST = 1 << 62


def _strides(columns: Sequence[Column]) -> list[int] | None:
    """Return of columns of names the least value and how many there may be; None if that is too much."""
    found, total = [], 1
    for column in columns:
        if column.dtype == np.float64:
            return None
        low, high = (int(column.min()), int(column.max())) if len(column) else (0, 0)
        # One more for what is below, and one for what is above: a value that no row has.
        found += [low - 1, high - low + 3]
        total *= high - low + 3
    return found if total < _WIDEST else None


def _packed(columns: Sequence[Column], strides: Sequence[int]) -> NDArray[np.int64]:
    key = np.zeros(len(columns[0]), dtype=np.int64)
    for column, low, width in zip(columns, strides[::2], strides[1::2], strict=True):
        key *= width
        key += np.minimum(np.maximum(column - low, 0), width - 1)
    return key


def _meet_unsorted(columns: Sequence[Column], wanted: Sequence[Column], most: int) -> tuple[Index, Index]:
    """Return :meth:`Rows.matches` for columns among which are numbers."""
    rows = len(columns[0])
    key = np.zeros(rows + len(wanted[0]), dtype=np.int64)
    for column, values in zip(columns, wanted, strict=True):
        more = _codes(np.concatenate([column, values]))
        key = key * (int(more.max(initial=0)) + 1) + more
        _, key = np.unique(key, return_inverse=True)
    order = np.argsort(key[:rows], kind="stable")
    keys = key[:rows][order]
    first = np.searchsorted(keys, key[rows:], side="left")
    count = np.searchsorted(keys, key[rows:], side="right") - first
    return _spread(first, count, order, most)


def _spread(first: Index, count: Index, order: Index, most: int) -> tuple[Index, Index]:
    """Return left and right positions, given where each left one's partners begin and how many they are."""
    total = int(count.sum())
    refuse_more(total, most)
    if int(count.max(initial=0)) <= 1:
        left = np.flatnonzero(count)
        return left, order[first[left]]
    left = np.repeat(np.arange(len(count)), count)
    step = np.arange(total) - np.repeat(np.cumsum(count) - count, count)
    return left, order[np.repeat(first, count) + step]
