"""SqlExecutor: all that follows from a scene's facts, derived set at a time by DuckDB."""

from __future__ import annotations

import math
import os
import threading
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any, Final

import duckdb
import numpy as np

from deixis.errors import EngineError, QueryTimeout
from deixis.facts import Facts
from deixis.ruleset import Indicator, Ruleset
from deixis.ruleset.base import BASE_FACTS
from deixis.ruleset.columns import Columns, Symbols, base_columns
from deixis.ruleset.plan import Node, Step
from deixis.ruleset.tables import Table, listed
from deixis.sql.program import Program

_SETTINGS: Final = {
    "autoinstall_known_extensions": "false",
    "autoload_known_extensions": "false",
    "enable_external_access": "false",
}


_AGAIN: Final = 0.01
"""Seconds between two attempts to stop what takes too long."""


class SqlExecutor:
    """A database in memory that derives what a ruleset says of any scene.

    It reads and writes no file and loads no extension. Statements are compiled once for the predicates
    asked for, and hold no text: names are numbers, thresholds are parameters.

    Parameters
    ----------
    ruleset : Ruleset
    threads : int, optional
        By default as many as there are processors.
    beside : SqlExecutor, optional
        Another executor, whose database serves for this one too: starting one takes longer than most rules.
    connection : DuckDBPyConnection, optional
        A database to work in, which stays open.

    Examples
    --------
    >>> from deixis._files import kb_dir, rules_dir
    >>> from deixis.grounding import ground
    >>> from deixis.ruleset import load
    >>> from deixis.scene import Scene
    >>> names = ("facts", "topology", "direction", "commonsense")
    >>> facts = ground(Scene.load(kb_dir() / "scenes" / "hans.json"))
    >>> with SqlExecutor(load([rules_dir() / f"{name}.pl" for name in names])) as sql:
    ...     found = sql.run(facts, [("leans_on", 2)])
    >>> found["leans_on", 2].rows()
    [('extinguisher2', 'wall')]
    """

    def __init__(
        self,
        ruleset: Ruleset,
        *,
        threads: int | None = None,
        beside: SqlExecutor | None = None,
        connection: duckdb.DuckDBPyConnection | None = None,
    ) -> None:
        self.ruleset = ruleset
        self._programs: dict[tuple[tuple[Indicator, ...], bool], tuple[Program, str]] = {}
        if connection is None:
            connection = _database(threads) if beside is None else beside._connection
        self._connection: duckdb.DuckDBPyConnection = connection
        self._deadline = math.inf
        self._lock: threading.Lock = threading.Lock() if beside is None else beside._lock

    def __enter__(self) -> SqlExecutor:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Give up the database."""
        self._connection.close()

    def run(
        self,
        facts: Facts,
        wanted: Sequence[Indicator],
        *,
        view_labels: Sequence[tuple[str, str]] = (),
        margins: bool = True,
        timeout: float | None = None,
    ) -> dict[Indicator, Table]:
        """Return all rows of some predicates.

        Parameters
        ----------
        facts : Facts
        wanted : sequence of (str, int)
            Names and numbers of arguments.
        view_labels : sequence of (str, str)
            Id and label of each view.
        margins : bool
            Whether to find the margin of each row too.
        timeout : float, optional
            Seconds.

        Raises
        ------
        QueryTimeout
            It took longer.
        EngineError
            DuckDB failed, for want of memory for instance.
        GeometryError
            A measured number is not finite.
        """
        with self._lock:
            program, statement = self._program(tuple(dict.fromkeys(wanted)), margins)
            symbols = Symbols(facts.ids, program.constants)
            tables = {
                name: base_columns(one, facts, view_labels, symbols)
                if one in BASE_FACTS
                else listed(program.given[one], self.ruleset.kinds[one], symbols)
                for one, name in program.given_tables.items()
            }
            limits = {name: value for name, value in facts.thresholds.items() if name in program.thresholds}
            with self._answering(timeout), self._registered(tables):
                for step in program.steps if program.stepwise else ():
                    self._derive(program, step, limits)
                found = self._execute(statement, limits).fetchnumpy()
        return _tables(program, found, symbols)

    def derive(self, program: Program, limits: Mapping[str, float]) -> None:
        """Make the tables of all steps of a program, where those it rests on are in the database already.

        Raises
        ------
        EngineError
            DuckDB failed, for want of space for instance.
        """
        with self._lock, self._answering(None):
            for step in program.steps:
                self._derive(program, step, limits)

    def _program(self, wanted: tuple[Indicator, ...], margins: bool) -> tuple[Program, str]:
        known = self._programs.get((wanted, margins))
        if known is None:
            program = Program(self.ruleset, wanted, margins=margins)
            known = program, program.statement()
            self._programs[wanted, margins] = known
        return known

    def _execute(self, statement: str, limits: Mapping[str, float]) -> duckdb.DuckDBPyConnection:
        self._in_time()
        used = {name: value for name, value in limits.items() if f"${name}" in statement}
        return self._connection.execute(statement, used or None)

    def _in_time(self) -> None:
        # An interruption between two statements is lost.
        if time.monotonic() > self._deadline:
            raise TimeoutError

    def _derive(self, program: Program, step: Step, limits: Mapping[str, float]) -> None:
        """Make the tables of one step; of a recursive one by adding what follows from what is new."""
        for node in step.nodes:
            table = program.table(node, _first(program, node, step))
            name = program.names.tables[node]
            self._execute(f"CREATE OR REPLACE TEMP TABLE {name} AS {table}", limits)
            if step.recursive:
                self._execute(f"CREATE OR REPLACE TEMP TABLE {name}_new AS FROM {name}", limits)
        if not step.recursive:
            return
        while True:
            added = 0
            for node in step.nodes:
                added += self._grow(program, node, step, limits)
            for node in step.nodes:
                name = program.names.tables[node]
                self._execute(f"CREATE OR REPLACE TEMP TABLE {name}_new AS FROM {name}_next", limits)
                self._execute(f"INSERT INTO {name} FROM {name}_new", limits)
            if not added:
                break
        if program.margins:
            for node in step.nodes:
                name = program.names.tables[node]
                table = program.table(node, [f"FROM {name}"])
                self._execute(f"CREATE OR REPLACE TEMP TABLE {name} AS {table}", limits)

    def _grow(self, program: Program, node: Node, step: Step, limits: Mapping[str, float]) -> int:
        """Find the rows that follow from the newest ones and are not known, or have a wider margin."""
        name = program.names.tables[node]
        selects = list(program.selects(node, step.nodes))
        if not selects:
            self._execute(f"CREATE OR REPLACE TEMP TABLE {name}_next AS FROM {name} LIMIT 0", limits)
            return 0
        same = [f"known.a{at} = found.a{at}" for at in range(node[0][1])]
        if program.margins:
            same.append("known.m >= found.m")
        found = program.table(node, selects)
        self._execute(
            f"CREATE OR REPLACE TEMP TABLE {name}_next AS SELECT found.* FROM ({found}) found "
            f"WHERE NOT EXISTS (SELECT 1 FROM {name} known WHERE {' AND '.join(same)})",
            limits,
        )
        row: Any = self._execute(f"SELECT count(*) FROM {name}_next", limits).fetchone()
        return int(row[0])

    @contextmanager
    def _registered(self, tables: Mapping[str, Columns]) -> Iterator[None]:
        """Make the columns readable as tables, without a copy."""
        try:
            for name, columns in tables.items():
                self._connection.register(name, columns)
            yield
        finally:
            for name in tables:
                self._connection.unregister(name)

    @contextmanager
    def _answering(self, timeout: float | None) -> Iterator[None]:
        """Stop what takes too long, and turn DuckDB's errors into ours."""
        self._deadline = math.inf if timeout is None else time.monotonic() + timeout
        done, late = threading.Event(), threading.Event()

        def watch() -> None:
            if done.wait(timeout):
                return
            late.set()
            # What comes between two statements interrupts neither of them.
            while not done.wait(_AGAIN):
                self._connection.interrupt()

        watcher = None if timeout is None else threading.Thread(target=watch, daemon=True)
        if watcher is not None:
            watcher.start()
        try:
            yield
            self._in_time()
        except (duckdb.InterruptException, TimeoutError):
            late.set()
        except duckdb.Error as error:
            raise EngineError(f"the rules cannot be run in SQL: {error}") from error
        finally:
            done.set()
            if watcher is not None:
                watcher.join()
        if late.is_set():
            raise QueryTimeout(f"no answer within {timeout:g} s: ask something narrower, or allow more time")


def silence(connection: duckdb.DuckDBPyConnection) -> None:
    """Have a database draw no progress bar: it would be on stdout, among the answers."""
    # In a notebook there is none, and to say so is an error where ipywidgets is missing.
    if connection.execute("SELECT current_setting('enable_progress_bar')").fetchall() == [(True,)]:
        connection.execute("SET enable_progress_bar = false")


def _database(threads: int | None) -> duckdb.DuckDBPyConnection:
    settings: dict[str, str | bool | int | float | list[str]] = dict(_SETTINGS)
    settings["threads"] = threads or os.cpu_count() or 1
    connection = duckdb.connect(":memory:", config=settings)
    silence(connection)
    connection.execute("SET lock_configuration = true")
    return connection


def _first(program: Program, node: Node, step: Step) -> list[str]:
    """Return the SELECTs of a node, which in a recursive step find nothing in tables not made yet."""
    return list(program.selects(node)) if not step.recursive else list(program.seeds(node, step.nodes))


def _tables(program: Program, found: Mapping[str, Any], symbols: Symbols) -> dict[Indicator, Table]:
    tables = {}
    for at, predicate in enumerate(program.wanted):
        rows = np.flatnonzero(found["r"] == at)
        kinds = program.ruleset.kinds[predicate]
        columns = tuple(
            found[f"{'d' if kind == 'number' else 'c'}{place}"][rows] for place, kind in enumerate(kinds)
        )
        margins = found["m"][rows] if program.margins else None
        tables[predicate] = Table(kinds, columns, margins, symbols)
    return tables
