"""Relations of many scenes as columns, put together scene by scene without a Python object for any row."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, Final

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from deixis.batch.schema import RELATIONS
from deixis.relations import place_in_order, rounded
from deixis.ruleset import Indicator
from deixis.ruleset.tables import Table

_NONE: Final = -1
"""No view."""


class Columns:
    """Rows of the schema :data:`~deixis.batch.schema.RELATIONS`.

    Texts are collected once a scene; rows are whole numbers that stand for them until :meth:`batch`.

    Parameters
    ----------
    places : dict
        The predicates that may come, each with where it is stated.
    """

    def __init__(self, places: Mapping[Indicator, str]) -> None:
        ranked = sorted(places, key=lambda one: (place_in_order(one[0]), one))
        self._names = [name for name, _ in ranked]
        self._places = [places[one] for one in ranked]
        self._number = {one: at for at, one in enumerate(ranked)}
        # Predicates of one name, a view more or less, are sorted together.
        self._rank = np.array([self._names.index(name) for name in self._names], dtype=np.int64)
        self._scenes: list[tuple[str, str]] = []
        self._texts: list[str] = []
        self._labels: list[str | None] = []
        self._parts: list[_Part] = []

    def add(
        self,
        source: str,
        scene: str,
        tables: Mapping[Indicator, Table],
        labels: Mapping[str, str | None],
        noise: float,
        view: str | None,
    ) -> None:
        """Append what holds in a scene, in the order of :func:`deixis.relations.in_order`.

        Parameters
        ----------
        source, scene : str
        tables : dict
            By predicate; of arity 3 the last argument is the view.
        labels : dict
            By id of the thing.
        noise : float
            Metres: a margin below it is uncertain.
        view : str or None
            If given, only its rows of what depends on a view.
        """
        found = {one: table for one, table in tables.items() if len(table)}
        if not found:
            return
        symbols = next(iter(found.values())).symbols
        sizes = [len(table) for table in found.values()]
        number = np.repeat([self._number[one] for one in found], sizes)
        figure, reference = (np.concatenate([table.columns[at] for table in found.values()]) for at in (0, 1))
        seen = np.concatenate(
            [table.columns[2] if arity == 3 else _no_view(table) for (_, arity), table in found.items()]
        )
        viewed = np.repeat([arity == 3 for _, arity in found], sizes)
        margin = np.concatenate([_margins(table) for table in found.values()])

        codes = np.unique(np.concatenate([figure, reference, seen[viewed]]))
        names = symbols.texts(codes)
        by_name = sorted(range(len(names)), key=names.__getitem__)
        rank = np.empty(len(names), dtype=np.int64)
        rank[by_name] = np.arange(len(names))
        figure, reference = (rank[np.searchsorted(codes, column)] for column in (figure, reference))
        seen = np.where(viewed, rank[np.searchsorted(codes, np.where(viewed, seen, codes[0]))], _NONE)

        order = np.lexsort((seen, reference, figure, self._rank[number]))
        if view is not None:
            kept = np.array([names[at] == view for at in by_name])
            order = order[~viewed[order] | kept[seen[order]]]
        first = len(self._texts)
        self._texts += [names[at] for at in by_name]
        self._labels += [labels.get(names[at]) for at in by_name]
        self._scenes.append((source, scene))
        self._parts.append(
            (
                np.full(len(order), len(self._scenes) - 1),
                number[order],
                figure[order] + first,
                reference[order] + first,
                np.where(seen[order] == _NONE, _NONE, seen[order] + first),
                margin[order],
                margin[order] < noise,
            )
        )

    def batch(self) -> pa.RecordBatch:
        """Return all rows."""
        if not self._parts:
            nothing = [pa.array([], field.type) for field in RELATIONS]
            return pa.RecordBatch.from_arrays(nothing, schema=RELATIONS)
        scene, number, figure, reference, view, margin, uncertain = map(
            np.concatenate, zip(*self._parts, strict=True)
        )
        texts, labels = pa.array(self._texts, pa.string()), pa.array(self._labels, pa.string())
        sources, scenes = (pa.array(column, pa.string()) for column in zip(*self._scenes, strict=True))
        names, places = pa.array(self._names, pa.string()), pa.array(self._places, pa.string())
        return pa.RecordBatch.from_arrays(
            [
                sources.take(scene),
                scenes.take(scene),
                names.take(number).dictionary_encode(),
                texts.take(figure),
                texts.take(reference),
                texts.take(pa.array(view, mask=view == _NONE)),
                labels.take(figure),
                labels.take(reference),
                pa.array(margin, mask=np.isinf(margin)),
                pa.array(uncertain),
                places.take(number).dictionary_encode(),
            ],
            schema=RELATIONS,
        )


_Part = tuple[NDArray[Any], ...]


def _no_view(table: Table) -> NDArray[np.int64]:
    return np.zeros(len(table), dtype=np.int64)


def _margins(table: Table) -> NDArray[np.float64]:
    """Return the margins as :func:`deixis.relations.rounded` gives them, infinite where no length decides."""
    margins = np.full(len(table), math.inf) if table.margins is None else table.margins
    return np.array([one if math.isinf(one) else rounded(one) for one in margins.tolist()], dtype=np.float64)
