"""A semantic map in PostgreSQL, which several robots write at the same time."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any, Final

from deixis.addresses import REMEDY, well_formed
from deixis.errors import MapError, MissingDependency
from deixis.scene import Scene
from deixis.semantic_map.history import SemanticMap
from deixis.semantic_map.records import Row, shape_rows
from deixis.semantic_map.store import columns_of, migrations

try:
    import psycopg
    from psycopg import sql
except ImportError as cause:
    raise MissingDependency("a map in PostgreSQL needs psycopg: pip install 'deixis[postgis]'") from cause

_SCHEMA: Final = "deixis"
"""Where our tables are in the database; other tables are neither seen nor touched."""

_SPATIAL: Final = """
SELECT to_regtype('geometry') IS NOT NULL AND EXISTS (SELECT FROM pg_extension WHERE extname = 'postgis')
"""

_TURN: Final = 0x6465_6978
"""Number of the lock that those who make or change the tables take in turn."""

_DERIVING: Final = 0x6465_6979
"""Number of the lock that those who derive what held when take in turn."""


class PostgresMap(SemanticMap):
    """A map in a PostgreSQL database; see :class:`~deixis.semantic_map.SemanticMap`.

    Its tables are in the schema ``deixis`` and are made, or brought up to date, when it is opened. Where
    there is PostGIS, hulls and boxes are kept as geometry too (decision 0049).

    Parameters
    ----------
    address : str
        ``postgresql://...``; what it leaves out PostgreSQL's own settings say (PGUSER, PGPASSFILE ...).

    Raises
    ------
    MapError
        The server cannot be reached or refuses.
    """

    def __init__(self, address: str) -> None:
        super().__init__("the PostgreSQL database")
        if not well_formed(address):
            raise MapError(f"the address of the database is not well formed: {REMEDY}")
        with self._ours():
            self._connection: psycopg.Connection[Row] = psycopg.connect(
                address, autocommit=True, cursor_factory=psycopg.RawCursor
            )
        try:
            self._migrate()
        except BaseException:
            self._connection.close()
            raise

    def close(self) -> None:
        """Let go of the database."""
        self._forget()
        self._connection.close()

    def _migrate(self) -> None:
        with self._transaction():
            run = self._connection.execute
            run("SELECT pg_advisory_xact_lock($1)", [_TURN])
            run(sql.SQL("CREATE SCHEMA IF NOT EXISTS {}").format(sql.Identifier(_SCHEMA)))
            run("CREATE TABLE IF NOT EXISTS migration (number integer PRIMARY KEY)")
            done = [number for (number,) in self._rows("SELECT number FROM migration")]
            # PostGIS may come later: then what needs it is made when the map is opened next.
            (spatial,) = self._rows(_SPATIAL)[0]
            for number, text in migrations(done, "postgresql", *(["postgis"] if spatial else [])):
                # A text of our own, of several statements, without values.
                run(text.encode())
                run("INSERT INTO migration VALUES ($1)", [number])
            (self._spatial,) = self._rows("SELECT to_regclass('shape') IS NOT NULL")[0]

    def _more(self, scene: Scene) -> Mapping[str, list[Row]]:
        return {"shape": shape_rows(0, scene)} if self._spatial else {}

    @contextmanager
    def _ours(self) -> Iterator[None]:
        try:
            yield
        except psycopg.Error as error:
            raise MapError(f"{self.address} cannot be read or written: {error}") from error

    @contextmanager
    def _transaction(self) -> Iterator[None]:
        with self._ours(), self._connection.transaction():
            self._search()
            yield

    def _search(self) -> None:
        self._connection.execute(
            sql.SQL("SET LOCAL search_path TO {}, public").format(sql.Identifier(_SCHEMA))
        )

    def _rows(self, statement: str, values: Sequence[Any] = ()) -> list[Row]:
        return self._connection.execute(statement.encode(), values).fetchall()

    def _run(self, statement: str, values: Sequence[Any] = ()) -> None:
        self._connection.execute(statement.encode(), values)

    @contextmanager
    def _deriving(self) -> Iterator[None]:
        with self._ours():
            self._connection.execute("SELECT pg_advisory_lock($1)", [_DERIVING])
            try:
                with self._connection.transaction():
                    # All statements see the frames that there are now: others go on adding.
                    self._connection.execute("SET TRANSACTION ISOLATION LEVEL REPEATABLE READ")
                    self._search()
                    yield
            finally:
                self._connection.execute("SELECT pg_advisory_unlock($1)", [_DERIVING])

    def _insert(self, table: str, rows: Sequence[Row]) -> None:
        columns = sql.SQL(", ").join(map(sql.Identifier, columns_of(table)))
        target = sql.SQL("COPY {} ({}) FROM STDIN").format(sql.Identifier(table), columns)
        with self._connection.cursor().copy(target) as copy:
            for row in rows:
                copy.write_row(row)
