"""Databases for what is larger than memory: they take so much of it, and a folder for the rest."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import duckdb

from deixis.errors import EngineError
from deixis.sql import silence


@contextmanager
def database(
    folder: Path, memory: int, failed: str, place: Path | None = None
) -> Iterator[duckdb.DuckDBPyConnection]:
    """Open a database, and close it again; a file of it is made anew and is gone afterwards.

    Parameters
    ----------
    folder : Path
        What does not fit in memory is written into a folder in it.
    memory : int
        Bytes that DuckDB may take.
    failed : str
        What to say when DuckDB fails.
    place : Path, optional
        Its file; by default it is in memory.

    Raises
    ------
    EngineError
        DuckDB failed, for want of space on the disk for instance.
    """
    settings: dict[str, Any] = {
        "memory_limit": f"{memory // 2**20}MiB",
        "temp_directory": str(folder / "spilled"),
        "autoinstall_known_extensions": "false",
        "autoload_known_extensions": "false",
        "preserve_insertion_order": "false",
    }
    if place is not None:
        place.unlink(missing_ok=True)
    try:
        with duckdb.connect(":memory:" if place is None else str(place), config=settings) as base:
            silence(base)
            yield base
    except duckdb.Error as error:
        raise EngineError(f"{failed}: {error}") from error
    finally:
        if place is not None:
            place.unlink(missing_ok=True)
