"""The folder that a data set is written to: two files a shard, each whole or not at all."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any, Final

import pyarrow as pa
import pyarrow.parquet as pq

from deixis._files import write_whole
from deixis.batch.relate import Relate
from deixis.errors import ReaderError
from deixis.strict_json import parse, quoted, read_bytes

_MANIFEST: Final = "_manifest.json"

_ERRORS: Final = "_errors"
"""Readers of Parquet folders pass by what begins with _."""

_COUNTS: Final = b"deixis"
"""Key of the counts in an error file."""


@dataclass(frozen=True, slots=True)
class Counts:
    """What became of scenes: how many they were, the relations that hold, how many were refused."""

    scenes: int = 0
    relations: int = 0
    refused: int = 0

    def __add__(self, other: Counts) -> Counts:
        return Counts(
            self.scenes + other.scenes, self.relations + other.relations, self.refused + other.refused
        )


@dataclass(frozen=True, slots=True)
class Folder:
    """Where shards are written.

    Parameters
    ----------
    path : Path
    """

    path: Path

    def write(self, number: int, scenes: int, relations: pa.Table, errors: pa.Table) -> Counts:
        """Write a shard: the relations, then the errors, whose file says that it is done."""
        counts = Counts(scenes, relations.num_rows, errors.num_rows)
        told = {**(errors.schema.metadata or {}), _COUNTS: json.dumps(asdict(counts)).encode()}
        places = self._relations(number), self._errors(number)
        for place, table in zip(places, (relations, errors.replace_schema_metadata(told)), strict=True):
            sink = pa.BufferOutputStream()
            pq.write_table(table, sink, compression="zstd")
            try:
                write_whole(place, sink.getvalue())
            except OSError as cause:
                raise ReaderError(f"{quoted(str(place), 200)} cannot be written: {cause.strerror}") from cause
        return counts

    def done(self, number: int) -> Counts | None:
        """Return what became of a shard, or None if it is not done."""
        place = self._errors(number)
        if not (place.exists() and self._relations(number).exists()):
            return None
        try:
            return Counts(**json.loads((pq.read_schema(place).metadata or {})[_COUNTS]))
        except (pa.ArrowException, KeyError, TypeError, ValueError) as cause:
            raise ReaderError(
                f"{quoted(str(place), 200)} is not as it was written: remove it, and its shard is done again"
            ) from cause

    def begin(self, given: Mapping[Path, str], relate: Relate, limit: float, shard: int) -> None:
        """Note what is to be done here, or see that it is what was begun.

        Raises
        ------
        ReaderError
            The folder holds something else, or cannot be written to.
        """
        told = _manifest(given, relate, limit, shard)
        place = self.path / _MANIFEST
        try:
            (self.path / _ERRORS).mkdir(parents=True, exist_ok=True)
            begun = any(self.path.glob("*.parquet"))
            if begun and not place.exists():
                raise ReaderError(
                    f"{quoted(str(self.path), 200)} holds other Parquet files: give another folder with -o"
                )
            if begun:
                before = parse(read_bytes(place, ReaderError), ReaderError, quoted(str(place), 200))
                other = _differing(before, told)
                if other:
                    raise ReaderError(
                        f"{quoted(str(self.path), 200)} was begun with other {' and '.join(other)}: "
                        f"give another folder with -o, or remove this one"
                    )
            else:
                if place.exists():
                    # Of relations that were removed: it would say that they are there.
                    for stale in (self.path / _ERRORS).glob("*.parquet"):
                        stale.unlink()
                write_whole(place, (json.dumps(told, indent=1) + "\n").encode())
        except OSError as cause:
            raise ReaderError(
                f"{quoted(str(self.path), 200)} cannot be written to: {cause.strerror}: give another with -o"
            ) from cause

    def _relations(self, number: int) -> Path:
        return self.path / f"{number:08d}.parquet"

    def _errors(self, number: int) -> Path:
        return self.path / _ERRORS / f"{number:08d}.parquet"


def _manifest(given: Mapping[Path, str], relate: Relate, limit: float, shard: int) -> dict[str, Any]:
    """Return what the result rests on; what is long as a digest."""
    states = [(source, place.stat()) for place, source in given.items()]
    inputs = [[source, state.st_size, state.st_mtime_ns] for source, state in states]
    options = asdict(relate) | {"limit": limit, "shard": shard}
    # Where the rules lie is no matter, but what they say.
    options["rules"] = rules_digest(relate)
    return {
        "deixis": version("deixis"),
        "options": json.loads(json.dumps(options)),
        "files": len(inputs),
        "inputs": _digest(inputs),
    }


def rules_digest(relate: Relate) -> str:
    """Return what is another text when the rule files of one's own say something else."""
    return _digest([place.read_text(encoding="utf-8", errors="replace") for place in relate.rule_files])


def _digest(value: Sequence[Any]) -> str:
    return hashlib.sha256(json.dumps(value).encode()).hexdigest()


def _differing(before: object, told: Mapping[str, Any]) -> list[str]:
    """Return the names of what is not the same."""
    old: Any = before if isinstance(before, dict) else {}
    options: Any = old.get("options") if isinstance(old.get("options"), dict) else {}
    found = [f"{name} (option)" for name, value in told["options"].items() if options.get(name) != value]
    if old.get("inputs") != told["inputs"]:
        found.append("inputs (name, size or time of change)")
    if old.get("deixis") != told["deixis"]:
        found.append("version of Deixis")
    return found
