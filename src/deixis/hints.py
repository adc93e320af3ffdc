"""Hints: what may have been meant by a name that is not known."""

from __future__ import annotations

import difflib
from collections.abc import Sequence
from typing import Final

_LISTED: Final = 40
"""Names that are listed where none is close: all relations, and not all things of a map."""


def either(names: Sequence[str]) -> str:
    """Return some names as what may have been meant.

    Examples
    --------
    >>> either(["cup"]), either(["cup", "cap"]), either(["cup", "cap", "cop"])
    ('cup', 'cup or cap', 'cup, cap or cop')
    """
    *first, last = names
    return f"{', '.join(first)} or {last}" if first else last


def hint(name: str, known: Sequence[str]) -> str:
    """Say what may have been meant; where nothing is alike, what is known, and not more than can be read.

    Examples
    --------
    >>> hint("conter", ["counter", "mug"]), hint("xyz", ["counter", "mug"])
    (": did you mean 'counter'?", ': known are counter, mug')
    """
    if not known:
        return ": there are none"
    close = difflib.get_close_matches(name, known, n=1)
    if close:
        return f": did you mean {close[0]!r}?"
    more = f" and {len(known) - _LISTED} more" if len(known) > _LISTED else ""
    return f": known are {', '.join(known[:_LISTED])}{more}"
