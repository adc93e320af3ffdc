"""What can only be derived from all tiles together: by recursion, by common labels, by way of a surface.

It is derived by the same rules in SQL, in a database on disk with a limit to its memory, from what the tiles
have derived already and from what was measured, as far as those rules look at it.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any, Final

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from deixis.facts import Facts
from deixis.ruleset.base import BASE_FACTS
from deixis.ruleset.columns import Symbols, base_columns
from deixis.ruleset.extent import THINGS
from deixis.ruleset.model import Constant
from deixis.ruleset.plan import Node
from deixis.ruleset.tables import listed
from deixis.sql import SqlExecutor
from deixis.sql.program import Program
from deixis.tiles.database import database
from deixis.tiles.measure import box_facts
from deixis.tiles.store import FILES, Tile
from deixis.tiles.work import Worker

_BATCH: Final = 65_536
"""Rows read back at once."""

Part = tuple[Tile | None, pa.Table]


def after(worker: Worker, folder: Path, between: Path, memory: int) -> Iterator[Part]:
    """Yield the relations that are derived from all tiles, tile by tile; of None those that name no thing.

    Parameters
    ----------
    worker : Worker
    folder : Path
        Of the sorted things; a database is made in it.
    between : Path
        Where each table that the tiles have derived for this is a folder of Parquet files.
    memory : int
        Bytes that DuckDB may take.

    Raises
    ------
    EngineError
        DuckDB failed, for want of space on the disk for instance.
    """
    program = worker.cut.program
    if program is None:
        return
    with database(folder, memory, "the tiles cannot be put together", folder / "after.duckdb") as base:
        numbers = _numbers(worker, program)
        _load(base, worker, program, between, numbers)
        limits = {name: value for name, value in worker.head.thresholds.items() if name in program.thresholds}
        SqlExecutor(worker.ruleset, connection=base).derive(program, limits)
        base.read_parquet([str(folder / f"{name}.parquet") for name in FILES]).create_view("thing")
        rows = folder / "after.parquet"
        _sorted(base, worker, program).write_parquet(str(rows))
    yield from _tiles(rows, worker)


def _nothing(worker: Worker) -> Facts:
    """Return the facts of the map without its things: thresholds and views."""
    from deixis.scene import Scene

    return box_facts(worker.head, (), (), Scene("nothing").boxes)


def _numbers(worker: Worker, program: Program) -> Symbols:
    """Return numbers, below 0, for names that rules, views and thresholds have."""
    texts = dict.fromkeys(program.constants)
    for rules in program.given.values():
        for rule in rules:
            texts |= dict.fromkeys(
                str(one.value) for one in rule.head.args if isinstance(one, Constant) and one.kind != "number"
            )
    for view in worker.head.views:
        texts |= dict.fromkeys((view.id, view.label))
    texts |= dict.fromkeys(name for name, _ in worker.head.thresholds.items())
    return Symbols((), tuple(texts))


def _load(base: Any, worker: Worker, program: Program, between: Path, numbers: Symbols) -> None:
    """Make the tables that the program rests on, with numbers for names."""
    kinds = worker.ruleset.kinds
    told = worker.cut.tables
    for table in told:
        parts = [str(one) for one in sorted((between / table).glob("*.parquet"))]
        base.read_parquet(parts).create_view(f"{table}_told")
    texts, raised = numbers.every()
    known = pa.table({"text": pa.array(texts, pa.string()), "code": pa.array(np.arange(len(texts)) - raised)})
    base.register("known", known)
    names = {
        table: [at for at, kind in enumerate(kinds[one]) if kind != "number"] for table, one in told.items()
    }
    every = " UNION ALL ".join(
        f"SELECT a{at} AS text FROM {table}_told" for table, some in names.items() for at in some
    )
    base.execute("CREATE TABLE named AS SELECT text, code FROM known")
    if every:
        base.execute(
            "INSERT INTO named SELECT text, row_number() OVER () - 1 FROM "
            f"(SELECT DISTINCT text FROM ({every}) WHERE text NOT IN (SELECT text FROM known))"
        )
    for table, some in names.items():
        codes = "".join(f", n{at}.code AS a{at}" for at in some)
        # Names stand where they stood: what is not a name comes as it is.
        kept = f"t.* EXCLUDE ({', '.join(f'a{at}' for at in some)})" if some else "t.*"
        joins = "".join(f" JOIN named n{at} ON t.a{at} = n{at}.text" for at in some)
        base.execute(f"CREATE TABLE {table} AS SELECT {kept}{codes} FROM {table}_told t{joins}")
    views = [(view.id, view.label) for view in worker.head.views]
    for one, table in program.given_tables.items():
        if one in THINGS:
            continue
        columns = (
            base_columns(one, _nothing(worker), views, numbers)
            if one in BASE_FACTS
            else listed(program.given[one], kinds[one], numbers)
        )
        base.register(f"{table}_told", pa.table({name: pa.array(column) for name, column in columns.items()}))
        base.execute(f"CREATE TABLE {table} AS FROM {table}_told")


def _sorted(base: Any, worker: Worker, program: Program) -> Any:
    """Return the rows of all wanted predicates, with names and labels, those of one tile together."""
    selects = []
    for at, predicate in enumerate(worker.cut.after):
        node: Node = (predicate, "truth")
        view = "a2" if predicate[1] == 3 else "NULL::BIGINT"
        margin = "m" if node in program.names.has_margin else "'inf'::DOUBLE"
        table = program.names.tables[node]
        selects.append(f"SELECT {at} AS r, a0, a1, {view} AS a2, {margin} AS m FROM {table}")
    return base.sql(
        "SELECT CASE WHEN f.id IS NULL THEN g.tx ELSE f.tx END AS tx, "
        "CASE WHEN f.id IS NULL THEN g.ty ELSE f.ty END AS ty, r, n0.text AS figure, n1.text AS reference, "
        "n2.text AS seen, f.label AS figure_label, g.label AS reference_label, m "
        f"FROM ({' UNION ALL '.join(selects)}) "
        "JOIN named n0 ON a0 = n0.code JOIN named n1 ON a1 = n1.code LEFT JOIN named n2 ON a2 = n2.code "
        "LEFT JOIN thing f ON n0.text = f.id LEFT JOIN thing g ON n1.text = g.id "
        "ORDER BY ty NULLS FIRST, tx, r, figure, reference, seen"
    )


def _tiles(place: Path, worker: Worker) -> Iterator[Part]:
    """Yield the rows of a file, tile by tile."""
    waiting: list[pa.RecordBatch] = []
    now: Any = None
    for batch in pq.ParquetFile(place).iter_batches(_BATCH):
        tx, ty = (np.array(batch.column(name).to_pylist(), dtype=object) for name in ("tx", "ty"))
        edges = [0, *(np.flatnonzero((tx[1:] != tx[:-1]) | (ty[1:] != ty[:-1])) + 1).tolist(), len(batch)]
        for start, stop in pairwise(edges):
            if start == stop:
                continue
            tile = None if ty[start] is None else (int(tx[start]), int(ty[start]))
            if waiting and tile != now:
                yield now, _relations(worker, waiting)
                waiting = []
            now = tile
            waiting.append(batch.slice(start, stop - start))
    if waiting:
        yield now, _relations(worker, waiting)


def _relations(worker: Worker, some: Sequence[pa.RecordBatch]) -> pa.Table:
    """Return the rows of one tile as relations."""
    table = pa.Table.from_batches(some).combine_chunks()
    which = table.column("r").to_numpy()
    parts = []
    for at, predicate in enumerate(worker.cut.after):
        rows = table.take(pa.array(np.flatnonzero(which == at)))
        if not len(rows):
            continue
        view = rows.column("seen").dictionary_encode() if predicate[1] == 3 else None
        labels = [rows.column(name).dictionary_encode() for name in ("figure_label", "reference_label")]
        named = [rows.column(name) for name in ("figure", "reference")]
        parts.append(worker.record(predicate, named, view, labels, rows.column("m").to_numpy()))
    return pa.concat_tables(parts).unify_dictionaries()
