"""What holds, as columns of numbers: thousands of conclusions are compared at once, and few are named."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from deixis.arrays.rows import grouped
from deixis.frames import Array, Index, Mask
from deixis.ruleset import Indicator
from deixis.ruleset.tables import Table

Known = tuple[Indicator, tuple[str, ...]]
"""A predicate and its arguments."""

NONE: Final = -1
"""Stands where a predicate has fewer arguments than others."""

_WIDEST: Final = 1 << 62


class Names:
    """Numbers for names, that stay the same while things come and go.

    Examples
    --------
    >>> names = Names()
    >>> names.of(["cup", "table", "cup"]).tolist(), names.texts
    ([0, 1, 0], ['cup', 'table'])
    """

    def __init__(self) -> None:
        self.texts: list[str] = []
        self._codes: dict[str, int] = {}

    def __len__(self) -> int:
        return len(self.texts)

    def code(self, text: str) -> int:
        """Return the number of a name, a new one where it has none yet."""
        found = self._codes.get(text)
        if found is None:
            found = self._codes[text] = len(self.texts)
            self.texts.append(text)
        return found

    def of(self, texts: Iterable[str]) -> Index:
        """Return the numbers of many names."""
        return np.array([self.code(text) for text in texts], dtype=np.int64)


@dataclass(frozen=True, slots=True)
class Kept:
    """Conclusions.

    Attributes
    ----------
    predicate : (n,) int
        Positions in a list of predicates.
    args : (k, n) int
        Numbers of names; NONE where a predicate has fewer arguments.
    margin : (n,) float
        Infinite where no length decides.
    """

    predicate: Index
    args: Index
    margin: Array

    @classmethod
    def of(cls, tables: Mapping[Indicator, Table], order: Mapping[Indicator, int], to: Index) -> Kept:
        """Return the rows of some tables.

        Parameters
        ----------
        tables : mapping
            With margins, and with the same symbols.
        order : mapping
            Position of each predicate, of these and others.
        to : (m,) int
            What :meth:`deixis.ruleset.columns.Symbols.translated` made of the tables' symbols.
        """
        k = max((arity for _, arity in order), default=0)
        counts = [len(table) for table in tables.values()]
        predicate = np.repeat(np.array([order[one] for one in tables], dtype=np.int64), counts)
        arity = np.repeat(np.array([one[1] for one in tables], dtype=np.int64), counts)
        args = np.full((k, len(predicate)), NONE, dtype=np.int64)
        for place in range(k):
            columns = [table.columns[place] for one, table in tables.items() if one[1] > place]
            if columns:
                codes = to[np.concatenate(columns).astype(np.int64, copy=False)]
                if len(codes) == len(predicate):
                    args[place] = codes
                else:
                    args[place, arity > place] = codes
        margins = [table.margins for table in tables.values() if table.margins is not None]
        return cls(predicate, args, np.concatenate([np.zeros(0), *margins]))

    @classmethod
    def empty(cls, order: Mapping[Indicator, int]) -> Kept:
        """Return no conclusions."""
        return cls.of({}, order, np.zeros(0, dtype=np.int64))

    def __len__(self) -> int:
        return len(self.predicate)

    def at(self, rows: Index | Mask) -> Kept:
        """Return some of the conclusions."""
        return Kept(self.predicate[rows], self.args[:, rows], self.margin[rows])

    def joined(self, more: Kept) -> Kept:
        """Return these conclusions and more."""
        return Kept(
            np.concatenate([self.predicate, more.predicate]),
            np.concatenate([self.args, more.args], axis=1),
            np.concatenate([self.margin, more.margin]),
        )

    def without(self, other: Kept, names: int) -> tuple[Kept, Kept]:
        """Return what of this is not in another, and what of that is not in this; none has anything twice."""
        if not len(self) or not len(other):
            return self, other
        mine, theirs = _keys(self, other, names)
        return self.at(_absent(mine, theirs)), other.at(_absent(theirs, mine))

    def named(self, predicates: Sequence[Indicator], texts: Sequence[str]) -> Iterator[tuple[Known, float]]:
        """Yield each conclusion by its names, with its margin."""
        rows = zip(self.predicate.tolist(), self.args.T.tolist(), self.margin.tolist(), strict=True)
        for predicate, codes, margin in rows:
            one = predicates[predicate]
            yield (one, tuple([texts[code] for code in codes[: one[1]]])), margin


def _keys(one: Kept, other: Kept, names: int) -> tuple[Index, Index]:
    """Return a number for each conclusion, the same for the same one."""
    width = names + 1
    last = max(one.predicate.max(initial=0), other.predicate.max(initial=0)) + 1
    if int(last) * width ** len(one.args) < _WIDEST:
        return _packed(one, width), _packed(other, width)
    both = one.joined(other)
    _, group = grouped([both.predicate, *both.args])
    return group[: len(one)], group[len(one) :]


def _absent(keys: Index, others: Index) -> Mask:
    """Return which keys are none of some others."""
    known = np.sort(others)
    at = np.minimum(np.searchsorted(known, keys), len(known) - 1)
    return np.asarray(known[at] != keys)


def _packed(kept: Kept, width: int) -> Index:
    key = kept.predicate
    for codes in kept.args:
        key = key * width + (codes - NONE)
    return key
