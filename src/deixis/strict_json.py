"""JSON read strictly: what the standard library lets through in silence is refused here."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any, Final, NoReturn

from deixis.errors import DeixisError

MAX_FILE_BYTES: Final = 64 * 1024 * 1024
"""Largest JSON text that is parsed; larger clouds and meshes belong in a file beside the scene."""

MAX_DIGITS: Final = 400
"""Longest number literal; every float64 has a shorter exact form than this in practice."""


def quoted(value: object, limit: int = 60) -> str:
    r"""Return a value as it may stand in a message: quoted, escaped where not printable, and short.

    >>> quoted("cup" + chr(10))
    "'cup\\n'"
    """
    text = repr(value)
    return text if len(text) <= limit else f"{text[: limit - 3]}..."


def read_bytes(
    path: Path, error: type[DeixisError], limit: int = MAX_FILE_BYTES, name: str | None = None
) -> bytes:
    """Return the contents of a regular file, or raise the given error where it is missing or too long.

    Parameters
    ----------
    path : Path
    error : type
        The leaf of :class:`DeixisError` to raise.
    limit : int
        Bytes.
    name : str, optional
        What the message calls the file instead of its whole path.
    """
    shown = quoted(str(path) if name is None else name, 200)
    try:
        if not path.is_file():
            reason = "is not a file" if path.exists() else "does not exist"
            raise error(f"{shown} {reason}: give the path of a file")
        size = path.stat().st_size
        if size > limit:
            raise error(f"{shown} is {size:,} bytes long: the limit is {limit:,}")
        return path.read_bytes()
    except (OSError, ValueError) as cause:
        reason = getattr(cause, "strerror", None) or str(cause)
        raise error(f"{shown} cannot be read: {reason}") from cause


def parse(text: bytes, error: type[DeixisError], what: str) -> Any:
    """Return the JSON value of a UTF-8 text, or raise the given error with the place and the reason.

    Refused beside bad syntax: invalid UTF-8, a key given twice in one object, ``NaN``, ``Infinity``, a
    number too large for float64, and nesting beyond the interpreter's depth.

    Parameters
    ----------
    text : bytes
        At most :data:`MAX_FILE_BYTES` long.
    error : type
        The leaf of :class:`DeixisError` to raise.
    what : str
        What the message calls the text: a file name, a line.

    Examples
    --------
    >>> from deixis.errors import SceneError
    >>> parse(b'{"a": 1}', SceneError, "text")
    {'a': 1}
    >>> parse(b'{"a": 1, "a": 2}', SceneError, "text")
    Traceback (most recent call last):
    deixis.errors.SceneError: text: the key 'a' is given twice in one object: keep one
    """

    def refuse(reason: str) -> NoReturn:
        raise error(f"{what}: {reason}")

    def number(literal: str) -> float:
        value = float(literal) if len(literal) <= MAX_DIGITS else math.inf
        return value if math.isfinite(value) else refuse(f"the number {quoted(literal)} is too large")

    def whole(literal: str) -> float | int:
        return int(literal) if len(literal) <= 20 else number(literal)

    def constant(literal: str) -> NoReturn:
        refuse(f"{literal} is not a number of JSON: give a finite number")

    def mapping(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
        result = dict(pairs)
        if len(result) != len(pairs):
            seen: set[str] = set()
            twice = next(key for key, _ in pairs if key in seen or seen.add(key))  # type: ignore[func-returns-value]
            refuse(f"the key {quoted(twice)} is given twice in one object: keep one")
        return result

    if len(text) > MAX_FILE_BYTES:
        refuse(f"{len(text):,} bytes of JSON: the limit is {MAX_FILE_BYTES:,}")
    try:
        # A byte order mark is no content: editors on some systems write one.
        decoded = text.decode("utf-8-sig")
    except UnicodeDecodeError as cause:
        raise error(f"{what}: not UTF-8 at byte {cause.start}: save the file as UTF-8") from cause
    try:
        return json.loads(
            decoded,
            object_pairs_hook=mapping,
            parse_float=number,
            parse_int=whole,
            parse_constant=constant,
        )
    except json.JSONDecodeError as cause:
        raise error(f"{what}: not JSON at line {cause.lineno}, column {cause.colno}: {cause.msg}") from cause
    except RecursionError as cause:
        raise error(f"{what}: nested too deeply for a scene: flatten it") from cause
