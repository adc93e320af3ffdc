"""What is done in one tile: a function of the tile alone, that whatever schedules tiles may call anywhere."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from pathlib import Path
from typing import Any, Final

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
import shapely

from deixis._files import datalog_files
from deixis.boxes import Boxes, corners_xy
from deixis.engines import AutoExecutor, predicates
from deixis.errors import EngineError, GeometryError
from deixis.frames import Index, Mask
from deixis.relations import rounded_all
from deixis.ruleset import Indicator, Ruleset, load
from deixis.ruleset.columns import Symbols, base_columns
from deixis.ruleset.owning import Ownership
from deixis.ruleset.plan import Node
from deixis.ruleset.tables import Table
from deixis.scene import Scene
from deixis.tiles.cut import Cut, share_out
from deixis.tiles.measure import Labels, box_facts
from deixis.tiles.schema import RELATIONS, THINGS
from deixis.tiles.store import Loaded, Store, Tile, name_of
from deixis.vocabulary import RELATIONS as VOCABULARY

_NOBODY: Final = -1


@dataclass(frozen=True)
class Job:
    """What is to be found of a map; can be pickled.

    Parameters
    ----------
    folder : str
        Of the sorted things, see :mod:`deixis.tiles.store`.
    size : float
        Of a tile, metres.
    head : str
        The map's id, views and thresholds: a scene without objects, in JSON.
    source : str
        Where the map comes from.
    relations : tuple of str
        Which; by default all that people speak in.
    rules : tuple of str
        Paths of rule files.
    """

    folder: str
    size: float
    head: str
    source: str
    relations: tuple[str, ...] = ()
    rules: tuple[str, ...] = ()


@dataclass(frozen=True)
class Found:
    """What was found in a tile: its own relations and things, and what is needed after it, by table."""

    relations: pa.Table
    things: pa.Table
    between: Mapping[str, pa.Table]


class Worker:
    """Does tiles of a job, one after the other; keeps no state but what is compiled and open."""

    def __init__(self, job: Job) -> None:
        self._job = job
        self.head = Scene.from_dict(json.loads(job.head))
        self._views = [(view.id, view.label) for view in self.head.views]

    @classmethod
    def of(cls, job: Job) -> Worker:
        """Return the one for a job, made once in a process."""
        return _worker(job)

    @cached_property
    def ruleset(self) -> Ruleset:
        """Return the rules."""
        return load(datalog_files(), [Path(one) for one in self._job.rules])

    @cached_property
    def cut(self) -> Cut:
        """Return what is derived here, and what after."""
        names = self._job.relations or tuple(term.name for term in VOCABULARY)
        own = self.ruleset if self._job.rules else None
        wanted = [one for name in dict.fromkeys(names) for one in predicates(name, own)]
        return share_out(self.ruleset, wanted)

    @cached_property
    def places(self) -> dict[Indicator, str]:
        """Return where each wanted predicate is stated: file and line."""
        rules = self.ruleset.by_head
        wanted = (*self.cut.here, *self.cut.after)
        first = {one: rules[one][0].place for one in wanted if rules.get(one)}
        return {one: f"{place.file.name}:{place.line}" for one, place in first.items()}

    @cached_property
    def _store(self) -> Store:
        return Store(Path(self._job.folder), self._job.size)

    @cached_property
    def _executor(self) -> AutoExecutor:
        return AutoExecutor(self.ruleset)

    @cached_property
    def _nodes(self) -> dict[str, Node]:
        program = self.cut.program
        return {} if program is None else {program.names.tables[node]: node for node in self.cut.nodes}

    @cached_property
    def _labelled(self) -> bool:
        return self.cut.labels

    def __call__(self, tile: Tile) -> Found:
        """Return what is found in a tile.

        Raises
        ------
        GeometryError, EngineError
            There is too much in it and around it; the message says which tile.
        """
        loaded = self._store.load(tile, self.cut.links)
        names = loaded.table.column("id").to_pylist()
        try:
            facts = box_facts(self.head, names, self._labels(loaded), loaded.boxes())
            truth, near = self.cut.derived()
            if near:
                tables = self._executor.arrays.both(facts, truth, near, view_labels=self._views)
            else:
                found = self._executor.run(facts, truth, view_labels=self._views)
                tables = {(one, "truth"): table for one, table in found.items()}
        except (GeometryError, EngineError) as cause:
            raise type(cause)(f"tile {name_of(tile)}: {cause}; or choose smaller tiles") from cause
        rows = _Rows(facts.ids, facts.surface, loaded.own, self.cut.owners)
        between = {}
        for name, predicate in self.cut.tables.items():
            node = self._nodes.get(name)
            if node is not None:
                between[name] = rows.plain(predicate, tables[node])
                continue
            symbols = Symbols(facts.ids, ())
            columns = base_columns(predicate, facts, self._views, symbols)
            between[name] = rows.measured(predicate, columns, symbols)
        relations = self._relations(rows, {one: tables[one, "truth"] for one in self.cut.here}, loaded)
        return Found(relations, _things(loaded), between)

    def _labels(self, loaded: Loaded) -> Labels:
        if not self._labelled:
            return ()
        ranked = loaded.table.column("labels").to_pylist()
        best = loaded.table.column("label").to_pylist()
        return tuple(
            tuple((each["name"], each["score"]) for each in several)
            if several
            else (((one, 1.0),) if one is not None else ())
            for one, several in zip(best, ranked, strict=True)
        )

    def _relations(self, rows: _Rows, tables: Mapping[Indicator, Table], loaded: Loaded) -> pa.Table:
        """Return the relations that the tile owns, in the order of those wanted, then of their things."""
        label = pc.dictionary_encode(loaded.table.column("label").combine_chunks())
        parts = []
        for predicate, table in tables.items():
            keep = rows.owned(predicate, table.columns, table.symbols)
            texts, raised = table.symbols.every()
            every = pa.array(texts, pa.string())
            codes = [column[keep] for column in table.columns]
            order = np.lexsort(codes[::-1])
            keep, codes = keep[order], [column[order] for column in codes]
            named = [every.take(pa.array(column + raised)) for column in codes[:2]]
            labels = [label.take(pa.array(_missing(rows.positions(column, table.symbols)), from_pandas=True))
                      for column in codes[:2]]  # fmt: skip
            view = None
            if len(codes) == 3:
                view = pa.DictionaryArray.from_arrays(pa.array((codes[2] + raised).astype(np.int32)), every)
            margins = np.full(len(keep), np.inf) if table.margins is None else table.margins[keep]
            parts.append(self.record(predicate, named, view, labels, margins))
        return pa.concat_tables(parts).unify_dictionaries() if parts else RELATIONS.empty_table()

    def record(
        self,
        predicate: Indicator,
        named: Sequence[Any],
        view: Any,
        labels: Sequence[Any],
        margins: Any,
    ) -> pa.Table:
        """Return relations as they are written.

        Parameters
        ----------
        predicate : Indicator
        named : sequence
            Figures and references.
        view : array or None
        labels : sequence
            Of figures and references.
        margins : (n,) float
            Not yet rounded.
        """
        count = len(margins)
        margin = rounded_all(margins)
        finite = np.isfinite(margin)
        columns: dict[str, Any] = {
            "source": _same(self._job.source, count),
            "scene": _same(self.head.id, count),
            "relation": _same(predicate[0], count),
            "figure": named[0],
            "reference": named[1],
            "view": pa.nulls(count, RELATIONS.field("view").type) if view is None else view,
            "figure_label": labels[0],
            "reference_label": labels[1],
            "margin": pa.array(margin, mask=~finite),
            "uncertain": pa.array(finite & (margin < self.head.thresholds.pose_noise)),
            "rule": _same(self.places.get(predicate, ""), count),
        }
        return pa.table([columns[name] for name in RELATIONS.names], schema=RELATIONS)


@lru_cache(maxsize=1)
def _worker(job: Job) -> Worker:
    return Worker(job)


class _Rows:
    """Tells which rows a tile owns, and gives them with the names they stand for."""

    def __init__(
        self, ids: Sequence[str], surface: Mask, own: Mask, owners: Mapping[Indicator, Ownership]
    ) -> None:
        self._ids, self._surface, self._own, self._owners = ids, surface, own, owners

    def positions(self, codes: Any, symbols: Symbols) -> Index:
        """Return where in the tile the things of some numbers are, -1 for what is no thing."""
        found = np.where((codes >= 0) & (codes < len(self._ids)), codes, _NOBODY)
        if (codes < 0).any():
            # A thing that is called like something in the rules.
            places = {symbols.code(name): at for at, name in enumerate(self._ids) if symbols.code(name) < 0}
            for code, at in places.items():
                found[codes == code] = at
        return np.asarray(found, dtype=np.int64)

    def owned(self, predicate: Indicator, columns: Sequence[Any], symbols: Symbols) -> Index:
        """Return which rows of a predicate are the tile's own."""
        ownership = self._owners[predicate]
        at = [self.positions(columns[place], symbols) for place in ownership.things]
        case = np.zeros(len(columns[0]), dtype=np.int64)
        for bit, position in enumerate(at):
            case |= self._surface[position].astype(np.int64) << bit
        owner = np.full(1 << len(at), _NOBODY)
        for surfaces, which in ownership.owners.items():
            owner[sum(1 << bit for bit in surfaces)] = which
        chosen = owner[case]
        mine = np.zeros(len(case), dtype=np.bool_)
        for bit, position in enumerate(at):
            mine |= (chosen == bit) & self._own[position]
        return np.flatnonzero(mine & np.all([position >= 0 for position in at], axis=0))

    def plain(self, predicate: Indicator, table: Table) -> pa.Table:
        """Return the tile's own rows of a derived predicate: a0, a1 ..., and the margin m."""
        margins = np.full(len(table), np.inf) if table.margins is None else table.margins
        keep = self.owned(predicate, table.columns, table.symbols)
        # What is infinitely far from holding counts for nothing.
        keep = keep[margins[keep] > -np.inf]
        columns = {f"a{at}": column[keep] for at, column in enumerate(table.columns)}
        return _texts({**columns, "m": margins[keep]}, table.symbols)

    def measured(self, predicate: Indicator, columns: Mapping[str, Any], symbols: Symbols) -> pa.Table:
        """Return the tile's own rows of measured facts, with the columns beside them."""
        every = [columns[f"a{at}"] for at in range(predicate[1])]
        keep = self.owned(predicate, every, symbols)
        return _texts({name: column[keep] for name, column in columns.items()}, symbols)


def _texts(columns: Mapping[str, Any], symbols: Symbols) -> pa.Table:
    """Return columns with texts for the numbers that stand for names."""
    texts, raised = symbols.every()
    every = pa.array(texts, pa.string())
    return pa.table(
        {
            name: pa.DictionaryArray.from_arrays(pa.array(column + raised), every)
            if column.dtype == np.int64
            else pa.array(column)
            for name, column in columns.items()
        }
    )


def _same(text: str, count: int) -> pa.Array:
    return pa.DictionaryArray.from_arrays(pa.array(np.zeros(count, dtype=np.int32)), pa.array([text]))


def _missing(positions: Index) -> Any:
    return pa.array(positions, mask=positions < 0)


def _things(loaded: Loaded) -> pa.Table:
    own = np.flatnonzero(loaded.own)
    table = loaded.table.take(pa.array(own))
    boxes = loaded.boxes().take(own)
    kind = pa.DictionaryArray.from_arrays(
        pa.array(boxes.surface.astype(np.int8)), pa.array(["object", "surface"])
    )
    columns = [
        table.column("id"), table.column("label"), kind.cast(pa.string()),
        *(pa.array(one) for one in (*boxes.center.T, *(2.0 * boxes.half).T, boxes.yaw)),
        pa.array(_footprints(boxes), pa.binary()),
    ]  # fmt: skip
    return pa.table(columns, schema=THINGS)


def _footprints(boxes: Boxes) -> Any:
    corners = corners_xy(boxes.half)
    cos, sin = boxes.cos[:, None], boxes.sin[:, None]
    x = boxes.center[:, 0, None] + cos * corners[:, :, 0] - sin * corners[:, :, 1]
    y = boxes.center[:, 1, None] + sin * corners[:, :, 0] + cos * corners[:, :, 1]
    return shapely.to_wkb(shapely.polygons(np.stack([x, y], axis=2)))
