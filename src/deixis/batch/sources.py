"""Where scenes come from: files and folders cut into shards, which are read wherever they are worked on."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO, Final, Literal, NamedTuple

import pyarrow as pa
import pyarrow.parquet as pq

from deixis import readers
from deixis.batch.schema import RELATIONS, SCENES
from deixis.errors import ReaderError
from deixis.strict_json import MAX_FILE_BYTES, quoted

ENDINGS: Final = (".json", ".jsonl", ".parquet", ".ttl", ".nt", ".trig", ".nq", ".jsonld")
"""Of the files that are taken from folders."""

_STREAM: Final = 1 << 20
"""Bytes of a Parquet column read at once: a group of rows may be larger than memory."""


_TEXTS: Final = (
    pa.string(), pa.large_string(), pa.string_view(), pa.binary(), pa.large_binary(), pa.binary_view()
)  # fmt: skip


class Row(NamedTuple):
    """A row of :data:`~deixis.batch.schema.SCENES`."""

    source: str
    scene: bytes | None
    file: str


class Refused(NamedTuple):
    """What could not be read, as a row of :data:`~deixis.batch.schema.ERRORS`."""

    source: str
    kind: str
    reason: str


@dataclass(frozen=True, slots=True)
class Part:
    """Some scenes of one file.

    Attributes
    ----------
    source : str
        What the file is called in the tables.
    file : str
        Where it is.
    kind : "whole", "lines" or "rows"
        The whole file, lines of JSON, or rows of a group of rows of a Parquet file.
    count : int
        How many scenes, lines or rows.
    start : int
        The byte at which the first line begins, or the first row's number in its group.
    first : int
        Number of the first line or row in the file, from 1.
    group : int
        The group of rows.
    """

    source: str
    file: str
    kind: Literal["whole", "lines", "rows"]
    count: int = 1
    start: int = 0
    first: int = 1
    group: int = 0

    def read(self) -> Iterator[Row | Refused]:
        """Yield the scenes, or what could not be read."""
        if self.kind == "whole":
            yield Row(self.source, None, self.file)
            return
        done = 0
        try:
            for row in self._lines() if self.kind == "lines" else self._rows():
                yield row
                done += 1
        except (OSError, pa.ArrowException) as error:
            where = f"{self.source}:{self.first + done}-{self.first + self.count - 1}"
            yield Refused(where, ReaderError.__name__, f"cannot be read: {error}")

    def _lines(self) -> Iterator[Row]:
        with Path(self.file).open("rb") as file:
            file.seek(self.start)
            for number in range(self.first, self.first + self.count):
                line, _ = _line(file)
                if line.strip() or len(line) > MAX_FILE_BYTES:
                    yield Row(f"{self.source}:{number}", line, self.file)

    def _rows(self) -> Iterator[Row]:
        with pq.ParquetFile(self.file, buffer_size=_STREAM) as file:
            columns = [name for name in ("source", "scene") if name in file.schema_arrow.names]
            at, end = 0, self.start + self.count
            for batch in file.iter_batches(self.count, row_groups=[self.group], columns=columns):
                low, high = max(self.start - at, 0), min(end - at, len(batch))
                if low < high:
                    yield from self._named(batch.slice(low, high - low), self.first + at + low - self.start)
                at += len(batch)
                if at >= end:
                    return

    def _named(self, batch: pa.RecordBatch, first: int) -> Iterator[Row]:
        texts: list[Any] = batch.column("scene").cast(pa.large_binary()).to_pylist()
        names: list[Any] = [None] * len(texts)
        if "source" in batch.schema.names:
            column = batch.column("source")
            names = (column.cast(pa.large_binary()) if column.type in _TEXTS else column).to_pylist()
        for number, (name, text) in enumerate(zip(names, texts, strict=True), first):
            yield Row(f"{self.source}:{number}" if name is None else _plain(name), text or b"", self.file)


@dataclass(frozen=True, slots=True)
class Shard:
    """Scenes that are worked on together, and written to one file.

    Attributes
    ----------
    number : int
        In the order of the scenes, from 0.
    parts : tuple of Part
    """

    number: int
    parts: tuple[Part, ...]

    def __len__(self) -> int:
        return sum(part.count for part in self.parts)

    def read(self) -> tuple[pa.RecordBatch, list[Refused]]:
        """Return the scenes as a batch with the schema SCENES, and what could not be read."""
        rows: list[Row] = []
        refused: list[Refused] = []
        for part in self.parts:
            for one in part.read():
                if isinstance(one, Row):
                    rows.append(one)
                else:
                    refused.append(one)
        columns = list(zip(*rows, strict=True)) or [()] * len(SCENES)
        arrays = [pa.array(column, field.type) for column, field in zip(columns, SCENES, strict=True)]
        return pa.RecordBatch.from_arrays(arrays, schema=SCENES), refused


def files(places: Sequence[Path], target: Path | None = None) -> dict[Path, str]:
    """Return the files to read, each with what it is called: those given, and by name those in folders given.

    Parameters
    ----------
    places : sequence of Path
    target : Path, optional
        A folder that is passed by: what is written there is not read again.

    Raises
    ------
    ReaderError
        A place is not there, or a folder holds no scenes.
    """
    found: dict[Path, str] = {}
    for place in places:
        if place.is_dir():
            named = (one for one in place.rglob("*") if one.suffix in ENDINGS and one.is_file())
            inside = sorted(one for one in named if target not in one.resolve().parents)
            if not inside:
                raise ReaderError(
                    f"{quoted(str(place), 200)} holds no scenes: give files that end in {', '.join(ENDINGS)}"
                )
        elif place.is_file():
            inside = [place]
        else:
            raise ReaderError(f"{quoted(str(place), 200)} does not exist: give files or folders of scenes")
        for one in inside:
            found.setdefault(one.resolve(), os.fsencode(one).decode("utf-8", "replace"))
    return found


def shards(given: dict[Path, str], size: int) -> Iterator[Shard]:
    """Cut files into shards of at most so many scenes, in their order.

    Raises
    ------
    ReaderError
        A file cannot be read, or a Parquet file has no scenes in it.
    """
    parts: list[Part] = []
    number = count = 0
    for part in _parts(given, size):
        if count + part.count > size and parts:
            yield Shard(number, tuple(parts))
            number, parts, count = number + 1, [], 0
        parts.append(part)
        count += part.count
    if parts:
        yield Shard(number, tuple(parts))


def _parts(given: dict[Path, str], size: int) -> Iterator[Part]:
    for file, source in given.items():
        if file.suffix == ".parquet":
            yield from _row_parts(source, file, size)
        elif file.suffix == ".jsonl" and readers.sniff(file) in (None, "deixis"):
            yield from _line_parts(source, file, size)
        else:
            yield Part(source, str(file), "whole")


def _line_parts(source: str, place: Path, size: int) -> Iterator[Part]:
    try:
        with place.open("rb") as file:
            start, first, count, at = 0, 1, 0, 0
            while True:
                line, length = _line(file)
                if count == size or (not line and count):
                    yield Part(source, str(place), "lines", count, start, first)
                    start, first, count = at, first + count, 0
                if not line:
                    return
                at += length
                count += 1
    except OSError as error:
        raise ReaderError(f"{quoted(source, 200)} cannot be read: {error.strerror}") from error


def _line(file: BinaryIO) -> tuple[bytes, int]:
    """Return a line, cut off beyond what is parsed, and how long it is."""
    line: bytes = file.readline(MAX_FILE_BYTES + 1)
    length = len(line)
    more = line
    while more and not more.endswith(b"\n"):
        more = file.readline(MAX_FILE_BYTES)
        length += len(more)
    return line, length


def _row_parts(source: str, place: Path, size: int) -> Iterator[Part]:
    try:
        with pq.ParquetFile(place) as file:
            _check_columns(source, file.schema_arrow)
            first = 1
            for group in range(file.num_row_groups):
                rows = file.metadata.row_group(group).num_rows
                for start in range(0, rows, size):
                    count = min(size, rows - start)
                    yield Part(source, str(place), "rows", count, start, first + start, group)
                first += rows
    except (pa.ArrowException, OSError) as error:
        raise ReaderError(f"{quoted(source, 200)} is no Parquet file: {error}") from error


def _plain(name: object) -> str:
    """Return what a row is called, as text; in another encoding some characters are replaced."""
    return name.decode("utf-8", "replace") if isinstance(name, bytes) else str(name)


def _check_columns(source: str, schema: pa.Schema) -> None:
    """Raise :class:`ReaderError` unless a Parquet file has scenes as text."""
    if set(RELATIONS.names) <= set(schema.names):
        raise ReaderError(f"{quoted(source, 200)} holds relations, not scenes: leave it out")
    if schema.names.count("scene") != 1:
        has = ", ".join(map(quoted, schema.names[:9]))
        raise ReaderError(f"{quoted(source, 200)} has no column scene: scenes are JSON in it; it has {has}")
    kind = schema.field("scene").type
    if kind not in _TEXTS:
        raise ReaderError(f"{quoted(source, 200)}: the column scene is {kind}: give scenes as JSON text")


def total(some: Iterable[Shard]) -> int:
    """Return how many scenes there are, lines and rows without any among them."""
    return sum(map(len, some))
