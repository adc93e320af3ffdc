"""Maps made and opened, by their addresses."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Final

from deixis.scene import Scene
from deixis.semantic_map.history import SemanticMap

_SHARED: Final = ("postgresql://", "postgres://")

_MAGIC: Final = slice(8, 12)
"""Where a DuckDB file says what it is."""


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


def is_map(address: str | os.PathLike[str]) -> bool:
    """Return whether something is a database by its address or its first bytes; it need hold no map."""
    text = os.fspath(address)
    if text.startswith(_SHARED):
        return True
    if not Path(text).is_file():
        return False
    try:
        with Path(text).open("rb") as file:
            return file.read(_MAGIC.stop)[_MAGIC] == b"DUCK"
    except OSError:
        return False  # whoever reads it as a scene will say what is wrong


def _opened(address: str | os.PathLike[str], *, create: bool) -> SemanticMap:
    text = os.fspath(address)
    if text.startswith(_SHARED):
        from deixis.semantic_map.shared import PostgresMap

        return PostgresMap(text)
    from deixis.semantic_map.embedded import DuckdbMap

    return DuckdbMap(Path(text), create=create)
