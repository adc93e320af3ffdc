"""Facts as columns: every name is a whole number, so that no engine has to be handed text."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from deixis.errors import GeometryError
from deixis.facts import Facts, ViewFacts
from deixis.frames import HORIZONTAL, WORLD, Array, Index, Mask
from deixis.ruleset.model import Indicator

Columns = dict[str, NDArray[np.int64] | Array | Mask]
"""Arguments of a predicate by name, a0, a1 ..., a row for each fact; beside them what FLAGS names."""

VERTICAL: Final = ("Z+", "Z-")


class Symbols:
    """Numbers for names: 0, 1 ... for the objects, below 0 for the constants of the rules, others beyond.

    So the compiled rules are the same for every scene, and the columns of the facts serve as they are; only
    where an object is called like a constant its number is changed in them.

    Parameters
    ----------
    ids : sequence of str
        Of the objects.
    constants : sequence of str
        Of the rules: the first is -1, the next -2.

    Examples
    --------
    >>> symbols = Symbols(["cup", "world"], ["world"])
    >>> symbols.code("cup"), symbols.code("world"), symbols.code("mug")
    (0, -1, 2)
    >>> symbols.texts(np.array([2, -1]))
    ['mug', 'world']
    """

    def __init__(self, ids: Sequence[str], constants: Sequence[str]) -> None:
        self._codes = {text: at for at, text in enumerate(ids)}
        self._texts = list(ids)
        self._constants = tuple(constants)
        self._recode: dict[int, int] = {}
        for at, text in enumerate(constants):
            if text in self._codes:
                self._recode[self._codes[text]] = -1 - at
            self._codes[text] = -1 - at

    def code(self, text: str) -> int:
        """Return the number of a name, a new one where it has none yet."""
        code = self._codes.get(text)
        if code is None:
            code = self._codes[text] = len(self._texts)
            self._texts.append(text)
        return code

    def codes(self, texts: Iterable[str]) -> NDArray[np.int64]:
        """Return the numbers of many names."""
        return np.array([self.code(text) for text in texts], dtype=np.int64)

    def objects(self, positions: Index) -> NDArray[np.int64]:
        """Return the numbers of objects by their positions in the scene: the same, but for namesakes."""
        if not self._recode:
            return positions
        found = positions.copy()
        for position, code in self._recode.items():
            found[positions == position] = code
        return found

    def every(self) -> tuple[list[str], int]:
        """Return all names, and what a number is to be raised by to be a position among them.

        >>> Symbols(["cup", "mug"], ["world"]).every()
        (['world', 'cup', 'mug'], 1)
        """
        return [*reversed(self._constants), *self._texts], len(self._constants)

    def texts(self, codes: NDArray[Any]) -> list[str]:
        """Return the names of many numbers."""
        texts, constants = self._texts, self._constants
        return [texts[code] if code >= 0 else constants[-1 - code] for code in codes.tolist()]

    def translated(self, objects: Index, of: Callable[[Iterable[str]], Index]) -> Index:
        """Return other numbers for these: at 0, 1 ... and, from the end, at -1, -2 ...

        Parameters
        ----------
        objects : (n,) int
            The other numbers of the objects.
        of : callable
            From names to their other numbers.

        Examples
        --------
        >>> Symbols(["cup"], ["world", "up"]).translated(np.array([7]), lambda names: [len(n) for n in names])
        array([7, 2, 5])
        """
        others = [*self._texts[len(objects) :], *reversed(self._constants)]
        return np.concatenate([objects, of(others)])


def base_columns(
    predicate: Indicator, facts: Facts, view_labels: Sequence[tuple[str, str]], symbols: Symbols
) -> Columns:
    """Return the facts of a base predicate.

    Raises
    ------
    GeometryError
        A measured number is not finite: in SQL, NaN is equal to itself and larger than all.
    """
    columns = _MAKERS[predicate](facts, view_labels, symbols)
    for column in columns:
        if column.dtype == np.float64 and not np.isfinite(column).all():
            raise GeometryError(f"a measure in {predicate[0]}/{predicate[1]} is not a finite number")
    found: Columns = {f"a{at}": column for at, column in enumerate(columns)}
    if predicate == ("pair", 9):
        found["ordered"] = facts.ordered
    elif predicate == ("aspect", 7):
        views = facts.views
        rows = np.concatenate([np.empty(0, dtype=np.int64), *(view.rows for view in views)])
        found["ordered"] = facts.ordered[rows]
        found["viewed"] = np.repeat(
            [view.view != WORLD for view in views], [len(view.rows) for view in views]
        )
    return found


_Made = Sequence[NDArray[np.int64] | Array]
_Labels = Sequence[tuple[str, str]]


def _spatial_obj(facts: Facts, _: _Labels, symbols: Symbols) -> _Made:
    return (symbols.objects(np.arange(len(facts.ids))),)


def _surface(facts: Facts, _: _Labels, symbols: Symbols) -> _Made:
    return (symbols.objects(np.flatnonzero(facts.surface)),)


def _label(facts: Facts, _: _Labels, symbols: Symbols) -> _Made:
    count = np.array([len(ranked) for ranked in facts.labels], dtype=np.int64)
    every = [one for ranked in facts.labels for one in ranked]
    return (
        symbols.objects(np.repeat(np.arange(len(count)), count)),
        symbols.codes(name for name, _ in every),
        np.array([score for _, score in every], dtype=np.float64),
    )


def _measured_as(facts: Facts, _: _Labels, symbols: Symbols) -> _Made:
    return symbols.objects(np.arange(len(facts.ids))), symbols.codes(facts.models)


def _viewpoint(facts: Facts, _: _Labels, symbols: Symbols) -> _Made:
    return (symbols.codes(view.view for view in facts.views if view.view != WORLD),)


def _view_label(_: Facts, labels: _Labels, symbols: Symbols) -> _Made:
    return symbols.codes(view for view, _ in labels), symbols.codes(label for _, label in labels)


def _threshold(facts: Facts, _: _Labels, symbols: Symbols) -> _Made:
    items = list(facts.thresholds.items())
    return symbols.codes(name for name, _ in items), np.array([value for _, value in items], dtype=np.float64)


def _figure_reference(facts: Facts, _: _Labels, symbols: Symbols) -> _Made:
    return symbols.objects(facts.figure[facts.ordered]), symbols.objects(facts.reference[facts.ordered])


def _pair(facts: Facts, _: _Labels, symbols: Symbols) -> _Made:
    measured = (facts.distance, facts.separation, facts.protrusion, facts.intersection, facts.frontier)
    return symbols.objects(facts.figure), symbols.objects(facts.reference), *measured, *facts.vertical.T


def _aspect(facts: Facts, _: _Labels, symbols: Symbols) -> _Made:
    views = facts.views
    rows = np.concatenate([np.empty(0, dtype=np.int64), *(view.rows for view in views)])
    seen = np.repeat(symbols.codes(view.view for view in views), [len(view.rows) for view in views])
    margins = np.concatenate([np.empty((0, 4)), *(view.int_hs for view in views)])
    return seen, *_both(facts, rows, symbols), *margins.T


def _strict(facts: Facts, _: _Labels, symbols: Symbols) -> _Made:
    every = np.arange(len(facts))
    parts = [_strict_of(every, VERTICAL, WORLD, facts.vertical, facts.vertical_strict, symbols)]
    parts += [_strict_view(view, symbols) for view in facts.views]
    rows, axes, views, margins = (np.concatenate(column) for column in zip(*parts, strict=True))
    return *_both(facts, rows.astype(np.int64), symbols), axes, views, margins


def _strict_view(view: ViewFacts, symbols: Symbols) -> _Made:
    return _strict_of(view.rows, HORIZONTAL, view.view, view.int_hs, view.cont_hs, symbols)


def _strict_of(
    rows: Index, axes: Sequence[str], view: str, relaxed: Array, margins: Array, symbols: Symbols
) -> _Made:
    """Return row, axis, view and margin where the figure meets the halfspace at all."""
    meets = relaxed >= 0.0
    at, axis = np.nonzero(meets)
    return rows[at], symbols.codes(axes)[axis], np.full(len(at), symbols.code(view)), margins[meets]


def _withheld(facts: Facts, _: _Labels, symbols: Symbols) -> _Made:
    every = [(view.view, index, reason) for view in facts.views for index, reason in view.withheld]
    return (
        symbols.objects(np.array([index for _, index, _ in every], dtype=np.int64)),
        symbols.codes(view for view, _, _ in every),
        symbols.codes(reason for _, _, reason in every),
    )


def _both(facts: Facts, rows: Index, symbols: Symbols) -> tuple[Index, Index]:
    return symbols.objects(facts.figure[rows]), symbols.objects(facts.reference[rows])


_MAKERS: Final[Mapping[Indicator, Callable[[Facts, _Labels, Symbols], _Made]]] = {
    ("spatial_obj", 1): _spatial_obj,
    ("surface", 1): _surface,
    ("label", 3): _label,
    ("measured_as", 2): _measured_as,
    ("viewpoint", 1): _viewpoint,
    ("view_label", 2): _view_label,
    ("threshold", 2): _threshold,
    ("figure_reference", 2): _figure_reference,
    ("pair", 9): _pair,
    ("aspect", 7): _aspect,
    ("strict", 5): _strict,
    ("withheld", 3): _withheld,
}
