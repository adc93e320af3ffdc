"""Addresses of databases: looked over before a library complains of them word by word, password and all."""

from __future__ import annotations

import os
import re
from pathlib import Path
from typing import Final

SHARED: Final = ("postgresql://", "postgres://")
"""How addresses of databases that several share begin."""

_MAGIC: Final = slice(8, 12)
"""Where a DuckDB file says what it is."""

REMEDY: Final = "write postgresql://user:password@host/name, with %40 for an @ within a part, %3A for a colon"

_ADDRESS: Final = re.compile(
    r"postgres(?:ql)?://(?:(?:[^\s@/%]|%[0-9A-Fa-f]{2})*@)?(?:[^\s@/\[\]%]|%[0-9A-Fa-f]{2}|\[[0-9A-Fa-f:.]+\])*(?:[/?].*)?"
)


def well_formed(address: str) -> bool:
    """Return whether an address is one of PostgreSQL, as far as its parts can be told apart.

    Examples
    --------
    >>> well_formed("postgresql://robot:a%40b@localhost:5432/map"), well_formed("postgresql:///map?host=/run")
    (True, True)
    >>> well_formed("postgresql://robot:a@b@localhost/map"), well_formed("postgresql://robot:a b@[::1/map")
    (False, False)
    """
    return not address.startswith(("postgresql:", "postgres:")) or bool(_ADDRESS.fullmatch(address))


def is_map(address: str | os.PathLike[str]) -> bool:
    """Return whether something is a database by its address or its first bytes; it need hold no map."""
    text = os.fspath(address)
    if text.startswith(SHARED):
        return True
    if not Path(text).is_file():
        return False
    try:
        with Path(text).open("rb") as file:
            return file.read(_MAGIC.stop)[_MAGIC] == b"DUCK"
    except OSError:
        return False  # whoever reads it as a scene will say what is wrong
