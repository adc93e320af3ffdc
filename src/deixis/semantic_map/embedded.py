"""A semantic map in one DuckDB file, for one writer at a time; others wait for their turn."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Final

import duckdb
import numpy as np

from deixis.errors import MapError
from deixis.semantic_map.history import SemanticMap
from deixis.semantic_map.records import Row
from deixis.semantic_map.store import by_column, columns_of, migrations
from deixis.sql import silence
from deixis.strict_json import quoted

_SETTINGS: Final[dict[str, str | bool | int | float | list[str]]] = {
    "autoinstall_known_extensions": "false",
    "autoload_known_extensions": "false",
    "enable_external_access": "false",
}

_PATIENCE: Final = 10.0
"""Seconds that a map waits for another process that has the file open."""

_AGAIN: Final = 0.05
"""Seconds between two attempts."""

_OPENING: Final = threading.Lock()
"""Connections of one process to a file share its settings, and the first makes them."""


class DuckdbMap(SemanticMap):
    """A map in a DuckDB file; see :class:`~deixis.semantic_map.SemanticMap`.

    Parameters
    ----------
    path : Path
    create : bool
        Whether the file is to be made; otherwise it must be there.
    patience : float
        Seconds to wait for another process that has the file open.

    Raises
    ------
    MapError
        The file is not there or is there, is no map, or is in use.
    """

    def __init__(self, path: Path, *, create: bool, patience: float = _PATIENCE) -> None:
        super().__init__(quoted(str(path), 200))
        if create and path.exists() and not path.is_file():
            raise MapError(f"{self.address} is no file: choose another place")
        if not create and not path.is_file():
            raise MapError(f"{self.address} is no file: make a map with `deixis map init`")
        self._connection = self._connect(path, time.monotonic() + patience)
        try:
            self._migrate()
        except BaseException:
            self._connection.close()
            raise

    def close(self) -> None:
        """Let go of the file."""
        self._forget()
        self._connection.close()

    def _connect(self, path: Path, deadline: float) -> duckdb.DuckDBPyConnection:
        while True:
            try:
                with _OPENING:
                    return _locked(duckdb.connect(str(path), config=_SETTINGS))
            except duckdb.IOException as error:
                if "lock" not in str(error):
                    raise MapError(f"{self.address} cannot be opened: {error}") from error
                if time.monotonic() > deadline:
                    raise MapError(f"{self.address} is in use by another process: try again later") from error
                time.sleep(_AGAIN)
            except duckdb.Error as error:
                raise MapError(f"{self.address} is no map: {error}") from error

    def _migrate(self) -> None:
        with self._transaction():
            tables = {name for (name,) in self._rows("SELECT table_name FROM duckdb_tables()")}
            if tables and "migration" not in tables:
                raise MapError(f"{self.address} holds other tables: choose another file")
            self._connection.execute("CREATE TABLE IF NOT EXISTS migration (number integer PRIMARY KEY)")
            done = [number for (number,) in self._rows("SELECT number FROM migration")]
            for number, text in migrations(done, "duckdb"):
                self._connection.execute(text)
                self._connection.execute("INSERT INTO migration VALUES ($1)", [number])

    @contextmanager
    def _transaction(self) -> Iterator[None]:
        try:
            self._connection.begin()
            try:
                yield
            except BaseException:
                self._connection.rollback()
                raise
            self._connection.commit()
        except duckdb.Error as error:
            raise MapError(f"{self.address} cannot be read or written: {error}") from error

    def _rows(self, statement: str, values: Sequence[Any] = ()) -> list[Row]:
        return self._connection.execute(statement, list(values)).fetchall()

    def _run(self, statement: str, values: Sequence[Any] = ()) -> None:
        self._connection.execute(statement, list(values))

    @contextmanager
    def _deriving(self) -> Iterator[None]:
        # One process has the file, and each map is used by one thread.
        with self._transaction():
            yield

    def _insert(self, table: str, rows: Sequence[Row]) -> None:
        if not rows:
            return
        columns = by_column(columns_of(table), rows)
        self._connection.register(
            "told", {name: np.array(some, dtype=object) for name, some in columns.items()}
        )
        try:
            self._connection.execute(f"INSERT INTO {table} ({', '.join(columns)}) SELECT * FROM told")
        finally:
            self._connection.unregister("told")


def _locked(connection: duckdb.DuckDBPyConnection) -> duckdb.DuckDBPyConnection:
    """Return a connection whose settings stay as they are."""
    if connection.execute("SELECT current_setting('lock_configuration')").fetchall() == [(False,)]:
        silence(connection)
        connection.execute("SET lock_configuration = true")
    return connection
