"""What the readers share: fields taken out of JSON records with a message when they are not there."""

from __future__ import annotations

import re
from collections import Counter
from typing import Any, Final

import numpy as np

from deixis.errors import ReaderError
from deixis.frames import Array
from deixis.strict_json import quoted

_WORDS: Final = re.compile(r"(?<=[a-z0-9])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])|[\s_|]+")


def mapping(value: Any, where: str) -> dict[str, Any]:
    """Return a JSON object, or raise :class:`ReaderError`."""
    if not isinstance(value, dict):
        raise ReaderError(f"{where} is not a JSON object: is the file of this format?")
    return value


def listing(record: dict[str, Any], key: str, where: str) -> list[Any]:
    """Return a record's list, or raise :class:`ReaderError`."""
    value = record.get(key)
    if not isinstance(value, list):
        raise ReaderError(f"{where} has no list {key!r}: is the file of this format?")
    return value


def text(record: dict[str, Any], key: str, where: str) -> str:
    """Return a record's string, not empty, or raise :class:`ReaderError`."""
    value = record.get(key)
    if not isinstance(value, str) or not value:
        raise ReaderError(f"{where} has no text {key!r}: add it")
    return value


def triple(value: Any, where: str) -> Array:
    """Return three finite numbers as an array of shape (3,), or raise :class:`ReaderError`."""
    numbers = isinstance(value, list) and len(value) == 3
    if not numbers or any(isinstance(v, bool) or not isinstance(v, (int, float)) for v in value):
        raise ReaderError(f"{where} is not a list of three numbers: {quoted(value)}")
    array = np.array(value, dtype=np.float64)
    if not np.isfinite(array).all():
        raise ReaderError(f"{where} holds a number that is not finite: {quoted(value)}")
    return array


def words(name: str) -> str:
    """Return a name from code as lower-case words.

    >>> words("DiningTable"), words("TVStand"), words("CD")
    ('dining table', 'tv stand', 'cd')
    """
    return " ".join(part.lower() for part in _WORDS.split(name) if part)


def readable(named: dict[str, str]) -> dict[str, str]:
    """Return a short id for each original one: the label and a number, counted in the originals' order.

    Parameters
    ----------
    named : dict
        Label (words) by original id.

    Examples
    --------
    >>> readable({"Egg|2": "egg", "Egg|1": "egg", "DiningTable|0": "dining table"})
    {'DiningTable|0': 'dining_table1', 'Egg|1': 'egg1', 'Egg|2': 'egg2'}
    """
    count: Counter[str] = Counter()
    result = {}
    for original in sorted(named):
        stem = numbered_stem(named[original])
        count[stem] += 1
        result[original] = f"{stem}{count[stem]}"
    return result


def numbered_stem(label: str) -> str:
    """Return a label as the stem of an id that a number is put behind, never ending in a digit.

    >>> numbered_stem("dining table"), numbered_stem("mp3")
    ('dining_table', 'mp3_')
    """
    stem = re.sub(r"\W+", "_", label.lower()).strip("_") or "thing"
    return f"{stem}_" if stem[-1].isdigit() else stem
