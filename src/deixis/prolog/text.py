"""Facts as Prolog text: one list term that the bridge reads in one go.

The contract of these base facts is ``rules/facts.pl``, which declares them in module ``facts``.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import chain, islice
from typing import Final

import numpy as np

from deixis.errors import GeometryError
from deixis.facts import Facts
from deixis.frames import WORLD, Array, Index
from deixis.prolog.quote import atom, id_atom, number
from deixis.thresholds import SNAP_DECIMALS

_HORIZONTAL_AXES: Final = ("X+", "X-", "Y+", "Y-")
_VERTICAL_AXES: Final = ("Z+", "Z-")
_LIST: Final = 10_000
"""Facts in one list, where there are several."""

_UNITS: Final = 10.0**SNAP_DECIMALS
_MOST_UNITS: Final = 2.0**52
"""Up to here a float64 counts nanometres exactly."""


def facts_text(facts: Facts, views: Sequence[tuple[str, str]] = (), *, readable: bool = False) -> str:
    """Return all base facts of a scene as one Prolog list, or as the clauses of a Prolog file.

    Ids, labels and axes are quoted atoms, measured numbers floats that read back as the same float64.

    Parameters
    ----------
    facts : Facts
        The grounded scene.
    views : sequence of (str, str)
        Id and label of each view of the scene.
    readable : bool
        Write clauses, one on a line and those of a predicate together, with numbers as people write them;
        otherwise a list with numbers as whole nanometres (``-5e-9``), which is three times faster.

    Raises
    ------
    GeometryError
        A measured number is not finite; as Prolog text it would match anything.
    QueryError
        An id or label holds half a surrogate pair.

    Examples
    --------
    >>> from deixis.grounding import ground
    >>> from deixis.scene import Scene
    >>> facts = ground(Scene.from_dict({"deixis": 1, "id": "empty", "objects": [], "views": []}))
    >>> print(facts_text(facts, [("v0", "robot")], readable=True).splitlines()[-1])
    view_label('v0','robot').
    """
    table = _Table(facts, list(map(atom if readable else id_atom, facts.ids)), readable)
    chunks = chain(_of_things(table, views), _of_pairs(table), _of_views(table))
    if readable:
        return "".join(f"{one}.\n" for one in sorted(chunks, key=lambda one: one.partition("(")[0]))
    return f"[{','.join(chunks)}]"


def facts_parts(
    facts: Facts, views: Sequence[tuple[str, str]] = (), *, thresholds: bool = True
) -> tuple[list[str], list[str]]:
    """Return all base facts of a scene as Prolog lists of at most 10,000, in two parts.

    Lists of this length take little memory to read. No predicate is in both parts, so that one may be read
    beside the other and all facts of a predicate still come in their order.

    Parameters
    ----------
    facts, views
        As for :func:`facts_text`, and with the same errors.
    thresholds : bool
        Whether the thresholds are among them.
    """
    table = _Table(facts, list(map(id_atom, facts.ids)), False)
    things = _of_things(table, views, thresholds=thresholds)
    return list(_lists(chain(things, _of_pairs(table)))), list(_lists(_of_views(table)))


def _lists(chunks: Iterator[str]) -> Iterator[str]:
    while part := list(islice(chunks, _LIST)):
        yield f"[{','.join(part)}]"


def _of_things(table: _Table, views: Sequence[tuple[str, str]], *, thresholds: bool = True) -> Iterator[str]:
    """Yield each fact of one thing, of a view or of the scene, without its full stop."""
    facts = table.facts
    volumes = np.round(facts.volume, SNAP_DECIMALS).tolist()
    for name, is_surface, ranked in zip(table.ids, facts.surface.tolist(), facts.labels, strict=True):
        yield f"spatial_obj({name})"
        if is_surface:
            yield f"surface({name})"
        yield from (f"label({name},{atom(label)},{number(float(score))})" for label, score in ranked)
    yield from (f"box_volume({name},{number(size)})" for name, size in zip(table.ids, volumes, strict=True))
    yield from (f"measured_as({name},{model})" for name, model in zip(table.ids, facts.models, strict=True))
    yield from (f"viewpoint({atom(view.view)})" for view in facts.views if view.view != WORLD)
    yield from (f"view_label({atom(view)},{atom(label)})" for view, label in views)
    if thresholds:
        yield from (f"threshold({atom(name)},{number(value)})" for name, value in facts.thresholds.items())
    for view in facts.views:
        for reference, reason in view.withheld:
            yield f"withheld({table.ids[reference]},{atom(view.view)},{atom(reason)})"


def _of_pairs(table: _Table) -> Iterator[str]:
    """Yield figure_reference/2 and pair/9."""
    facts, every = table.facts, np.arange(len(table.facts))
    measured = (facts.distance, facts.separation, facts.protrusion, facts.intersection, facts.frontier)
    yield from table.rows("figure_reference(", "", np.flatnonzero(facts.ordered), ())
    yield from table.rows("pair(", "", every, (*measured, *facts.vertical.T))


def _of_views(table: _Table) -> Iterator[str]:
    """Yield strict/5 and aspect/7."""
    facts, every = table.facts, np.arange(len(table.facts))
    yield from table.strict(atom(WORLD), every, _VERTICAL_AXES, facts.vertical, facts.vertical_strict)
    for view in facts.views:
        name = atom(view.view)
        yield from table.rows(f"aspect({name},", "", view.rows, tuple(view.int_hs.T))
        yield from table.strict(name, view.rows, _HORIZONTAL_AXES, view.int_hs, view.cont_hs)


@dataclass(frozen=True)
class _Table:
    """The facts about pairs, with the ids quoted once for all rows."""

    facts: Facts
    ids: list[str]
    readable: bool

    def strict(
        self, view: str, rows: Index, axes: Sequence[str], relaxed: Array, margins: Array
    ) -> Iterator[str]:
        """Yield strict/5, the margin of "completely in", where the figure meets the halfspace at all."""
        for axis, meets, margin in zip(axes, relaxed.T >= 0.0, margins.T, strict=True):
            yield from self.rows("strict(", f",{atom(axis)},{view}", rows[meets], (margin[meets],))

    def rows(self, before: str, after: str, rows: Index, columns: Sequence[Array]) -> Iterator[str]:
        """Return one fact for each row: before, figure, reference, after, numbers."""
        figures, references = self.facts.figure[rows], self.facts.reference[rows]
        slots, cells = "", []
        for column in columns:
            if not np.isfinite(column).all():
                worst = int(np.flatnonzero(~np.isfinite(column))[0])
                figure, reference = self.facts.ids[figures[worst]], self.facts.ids[references[worst]]
                raise GeometryError(f"a measure of {figure!r} against {reference!r} is not a finite number")
            slot, values = _numerals(column, self.readable)
            slots += f",{slot}"
            cells.append(values.tolist())
        # The view's name is data, in which % is no slot.
        template = f"{before.replace('%', '%%')}%s,%s{after.replace('%', '%%')}{slots})"
        named = self.ids.__getitem__
        columns_of_text = (map(named, figures.tolist()), map(named, references.tolist()))
        return map(template.__mod__, zip(*columns_of_text, *cells, strict=True))


def _numerals(values: Array, readable: bool) -> tuple[str, Array | Index]:
    """Return a format slot and what goes into it: whole nanometres, unless that loses something."""
    units = np.rint(values * _UNITS)
    whole = np.all(np.abs(units) <= _MOST_UNITS) and np.array_equal(units / _UNITS, values)
    return ("%r", values) if readable or not whole else (f"%de-{SNAP_DECIMALS}", units.astype(np.int64))
