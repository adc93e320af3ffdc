"""Hints: what may have been meant by a name that is not known."""

from __future__ import annotations

import difflib
from collections.abc import Sequence


def hint(name: str, known: Sequence[str]) -> str:
    """Say what may have been meant."""
    if not known:
        return ": there are none"
    close = difflib.get_close_matches(name, known, n=1)
    return f": did you mean {close[0]!r}?" if close else f": known are {', '.join(known)}"
