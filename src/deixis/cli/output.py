"""How results are written: tables for people, JSON, CSV and Prolog for programs."""

from __future__ import annotations

import csv
import json
import sys
from collections.abc import Iterable, Mapping, Sequence
from enum import StrEnum
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rich.progress import Progress, ProgressColumn


class Format(StrEnum):
    """Output formats of relations and facts."""

    TABLE = "table"
    JSON = "json"
    CSV = "csv"
    PL = "pl"


class RelationFormat(StrEnum):
    """Output formats of relations: those of facts, and RDF."""

    TABLE = "table"
    JSON = "json"
    CSV = "csv"
    PL = "pl"
    TTL = "ttl"
    TRIG = "trig"
    NQ = "nq"
    JSONLD = "jsonld"


def write_json(value: Any) -> None:
    """Write a value as one JSON document."""
    json.dump(value, sys.stdout, ensure_ascii=False, indent=2, allow_nan=False)
    sys.stdout.write("\n")


def write_csv(columns: Sequence[str], rows: Iterable[Sequence[object]]) -> None:
    """Write rows as CSV with a header; cells that a spreadsheet would run as a formula are quoted with '."""
    writer = csv.writer(sys.stdout, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows([_cell(value) for value in row] for row in rows)


def _cell(value: object) -> object:
    if value is None:
        return ""
    if isinstance(value, str) and value[:1] in ("=", "+", "-", "@", "\t", "\r"):
        return "'" + value
    return value


def write_table(columns: Sequence[str], rows: Iterable[Sequence[object]]) -> None:
    """Write rows as an aligned table; control characters in ids are shown escaped."""
    cells = [list(columns), *([printable(value) for value in row] for row in rows)]
    widths = [max(len(row[index]) for row in cells) for index in range(len(columns))]
    for row in cells:
        line = "  ".join(value.ljust(width) for value, width in zip(row, widths, strict=True))
        print(line.rstrip())


def printable(value: object) -> str:
    """Return a cell's text with nothing in it that a terminal would obey."""
    if value is None:
        return ""
    if isinstance(value, float):
        return f"{value:.3f}"
    return "".join(
        one if one.isprintable() else one.encode("unicode_escape").decode("ascii") for one in str(value)
    )


def printable_lines(value: object) -> str:
    """Return a text of several lines with nothing in it that a terminal would obey but their ends."""
    return "\n".join(map(printable, str(value).split("\n")))


def records(columns: Sequence[str], rows: Iterable[Mapping[str, Any]]) -> list[list[Any]]:
    """Return the named columns of mappings as rows."""
    return [[row[column] for column in columns] for row in rows]


def counted(count: int, noun: str) -> str:
    """Return how many there are of something.

    Examples
    --------
    >>> counted(1, "thing"), counted(0, "thing")
    ('1 thing', '0 things')
    """
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"


def warn(messages: Iterable[object]) -> None:
    """Say on stderr what should be known beside the answer."""
    for message in messages:
        print(f"deixis: {printable(message)}", file=sys.stderr)


def progress_bar(*more: ProgressColumn) -> Progress:
    """Return a bar that shows on stderr how far the work is, with more columns than the usual ones.

    Nothing but a terminal gets it, and it is gone when the work is done.
    """
    from rich.console import Console
    from rich.progress import Progress

    columns = (*Progress.get_default_columns(), *more)
    return Progress(*columns, console=Console(stderr=True), transient=True, disable=not sys.stderr.isatty())
