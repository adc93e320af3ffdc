"""Facts as Prolog text: one list term that the bridge reads in one go.

The contract of these base facts is ``rules/facts.pl``, which declares them in module ``facts``.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from deixis.errors import GeometryError
from deixis.facts import Facts, ViewFacts
from deixis.frames import WORLD, Array, Index
from deixis.prolog.quote import atom, number
from deixis.thresholds import SNAP_DECIMALS

_HORIZONTAL_AXES = ("X+", "X-", "Y+", "Y-")
_VERTICAL_AXES = ("Z+", "Z-")
_UNITS = 10.0**SNAP_DECIMALS
_MOST_UNITS = 2.0**52
"""Up to here a float64 counts nanometres exactly."""


def facts_text(facts: Facts, views: Sequence[tuple[str, str]] = (), *, readable: bool = False) -> str:
    """Return one Prolog list of all base facts of a scene.

    Ids, labels and axes are quoted atoms, measured numbers floats that read back as the same float64.

    Parameters
    ----------
    facts : Facts
        The grounded scene.
    views : sequence of (str, str)
        Id and label of each view of the scene.
    readable : bool
        Write numbers as people do, one fact on a line; otherwise as whole nanometres (``-5e-9``), which
        is three times faster to write.

    Raises
    ------
    GeometryError
        A measured number is not finite; as Prolog text it would match anything.
    QueryError
        An id or label holds half a surrogate pair.
    """
    ids = [atom(name) for name in facts.ids]
    chunks: list[str] = []
    for name, is_surface, ranked in zip(ids, facts.surface.tolist(), facts.labels, strict=True):
        chunks.append(f"spatial_obj({name})")
        if is_surface:
            chunks.append(f"surface({name})")
        chunks += [f"label({name},{atom(label)},{number(float(score))})" for label, score in ranked]
    chunks += [f"viewpoint({atom(view.view)})" for view in facts.views if view.view != WORLD]
    chunks += [f"view_label({atom(view)},{atom(label)})" for view, label in views]
    chunks += [f"threshold({atom(name)},{number(value)})" for name, value in facts.thresholds.items()]
    chunks += _pair_facts(facts, ids, readable)
    for view in facts.views:
        chunks += _view_facts(facts, view, ids, readable)
    separator = ",\n" if readable else ","
    return f"[{separator.join(chunks)}]"


def _pair_facts(facts: Facts, ids: list[str], readable: bool) -> Iterator[str]:
    """Yield figure_reference/2, pair/9 and strict/5 of the vertical axes."""
    for i, j in zip(
        facts.figure[facts.ordered].tolist(), facts.reference[facts.ordered].tolist(), strict=True
    ):
        yield f"figure_reference({ids[i]},{ids[j]})"
    measured = (facts.distance, facts.separation, facts.protrusion, facts.intersection, facts.frontier)
    columns = np.column_stack((*measured, facts.vertical))
    yield from _rows("pair", "", facts, np.arange(len(facts)), columns, ids, readable)
    every = np.arange(len(facts))
    yield from _strict(
        facts, WORLD, every, _VERTICAL_AXES, facts.vertical, facts.vertical_strict, ids, readable
    )


def _view_facts(facts: Facts, view: ViewFacts, ids: list[str], readable: bool) -> Iterator[str]:
    """Yield aspect/7, strict/5 of the horizontal axes and withheld/3 of one view."""
    name = atom(view.view)
    yield from _rows("aspect", f"{name},", facts, view.rows, view.int_hs, ids, readable)
    yield from _strict(
        facts, view.view, view.rows, _HORIZONTAL_AXES, view.int_hs, view.cont_hs, ids, readable
    )
    for reference, reason in view.withheld:
        yield f"withheld({ids[reference]},{name},{atom(reason)})"


def _rows(
    name: str, first: str, facts: Facts, rows: Index, columns: Array, ids: list[str], readable: bool
) -> Iterator[str]:
    """Yield ``name(first figure, reference, number ...)`` for each row."""
    _check_finite(name, facts, rows, columns)
    slot, values = _numerals(columns, readable)
    # The view's name is data: it joins the row as an argument, since % in it would read as a slot.
    template = f"{name}(%s%s,%s,{','.join([slot] * columns.shape[1])})"
    pairs = zip(facts.figure[rows].tolist(), facts.reference[rows].tolist(), values.tolist(), strict=True)
    return (template % (first, ids[i], ids[j], *numbers) for i, j, numbers in pairs)


def _strict(
    facts: Facts,
    view: str,
    rows: Index,
    axes: tuple[str, ...],
    relaxed: Array,
    margins: Array,
    ids: list[str],
    readable: bool,
) -> Iterator[str]:
    """Yield strict/5, the margin of "completely in", where the figure meets the halfspace at all."""
    _check_finite("strict", facts, rows, margins)
    name, quoted = atom(view), [atom(axis) for axis in axes]
    at, along = np.nonzero(relaxed >= 0.0)
    figures, references = facts.figure[rows[at]].tolist(), facts.reference[rows[at]].tolist()
    slot, values = _numerals(margins[at, along], readable)
    template = f"strict(%s,%s,%s,%s,{slot})"
    rows_of = zip(figures, references, along.tolist(), values.tolist(), strict=True)
    return (template % (ids[i], ids[j], quoted[axis], name, value) for i, j, axis, value in rows_of)


def _numerals(values: Array, readable: bool) -> tuple[str, Array | Index]:
    """Return a format slot and what goes into it: whole nanometres, unless that loses something."""
    units = np.rint(values * _UNITS)
    whole = np.all(np.abs(units) <= _MOST_UNITS) and np.array_equal(units / _UNITS, values)
    return ("%r", values) if readable or not whole else (f"%de-{SNAP_DECIMALS}", units.astype(np.int64))


def _check_finite(name: str, facts: Facts, rows: Index, columns: Array) -> None:
    wrong = ~np.isfinite(columns).all(axis=1) if columns.size else np.zeros(0, dtype=bool)
    if wrong.any():
        row = rows[np.flatnonzero(wrong)[0]]
        figure, reference = facts.ids[facts.figure[row]], facts.ids[facts.reference[row]]
        raise GeometryError(f"a measure of {figure!r} against {reference!r} ({name}) is not finite")
