"""What the functions of SFCGAL are called, and where they are: both differ from server to server."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

from psycopg import Connection
from psycopg.sql import SQL, Composed, Identifier

from deixis.errors import MissingDependency

_WANTED: Final = {
    "extrude": "extrude",
    "makesolid": "makesolid",
    "volume": "volume",
    "intersection": "3dintersection",
}

_SCHEMAS: Final = """
SELECT extname, nspname FROM pg_extension JOIN pg_namespace ON pg_namespace.oid = extnamespace
WHERE extname IN ('postgis', 'postgis_sfcgal')
"""

_NAMES: Final = """
SELECT DISTINCT proname FROM pg_proc JOIN pg_namespace ON pg_namespace.oid = pronamespace
WHERE nspname = ANY(%(schemas)s) AND proname = ANY(%(names)s)
"""


def schemas(connection: Connection[Any]) -> list[str]:
    """Return the schemas that PostGIS and SFCGAL are in.

    Raises
    ------
    MissingDependency
        The database has not both.
    """
    found = dict(connection.execute(_SCHEMAS).fetchall())
    missing = [name for name in ("postgis", "postgis_sfcgal") if name not in found]
    if missing:
        raise MissingDependency(
            f"the database has no {' and no '.join(missing)}: CREATE EXTENSION {missing[-1]} CASCADE"
        )
    return list(dict.fromkeys(found.values()))


def names(connection: Connection[Any]) -> Mapping[str, Identifier]:
    """Return what the functions of SFCGAL are called here: CG_ from PostGIS 3.5 on, ST_ before.

    Where there are both the new ones are taken, since the old ones are to go.
    """
    both = [prefix + name for prefix in ("cg_", "st_") for name in _WANTED.values()]
    rows = connection.execute(_NAMES, {"schemas": schemas(connection), "names": both}).fetchall()
    known = {row[0] for row in rows}
    prefix = {key: "cg_" if f"cg_{name}" in known else "st_" for key, name in _WANTED.items()}
    return {key: Identifier(prefix[key] + name) for key, name in _WANTED.items()}


def search_path(connection: Connection[Any]) -> Composed:
    """Return the statement that lets a transaction see its own tables, then PostGIS, and nothing else."""
    places = SQL(", ").join(map(Identifier, ["pg_temp", "pg_catalog", *schemas(connection)]))
    return SQL("SET LOCAL search_path TO {}").format(places)
