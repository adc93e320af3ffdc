"""Maps made and opened, by their addresses."""

from __future__ import annotations

import os
from pathlib import Path

from deixis.addresses import SHARED
from deixis.scene import Scene
from deixis.semantic_map.history import SemanticMap


def create_map(address: str | os.PathLike[str], like: Scene) -> SemanticMap:
    """Make an empty map and return it.

    Parameters
    ----------
    address : path or str
        A DuckDB file that is not there yet, or ``postgresql://...``.
    like : Scene
        Gives the map its id, its thresholds and what becomes of strays; its things are not added.

    Raises
    ------
    MapError
        There is a map already, or the database cannot be written.
    MissingDependency
        PostgreSQL was asked for without psycopg.
    """
    kept = _opened(address, create=True)
    try:
        kept._begin(like)
    except BaseException:
        kept.close()
        raise
    return kept


def open_map(address: str | os.PathLike[str]) -> SemanticMap:
    """Return a map that is there already; raises as :func:`create_map` does."""
    kept = _opened(address, create=False)
    try:
        _ = kept.id
    except BaseException:
        kept.close()
        raise
    return kept


def _opened(address: str | os.PathLike[str], *, create: bool) -> SemanticMap:
    text = os.fspath(address)
    if text.startswith(SHARED):
        from deixis.semantic_map.shared import PostgresMap

        return PostgresMap(text)
    from deixis.semantic_map.embedded import DuckdbMap

    return DuckdbMap(Path(text), create=create)
