"""Where the things of a map come from: Parquet, Arrow, JSON lines and scene files, batch by batch."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from itertools import islice
from pathlib import Path
from typing import Any, Final

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.ipc
import pyarrow.parquet as pq

from deixis.boxes import NO_NORMAL, Boxes
from deixis.broadphase import plan_bounds, reach
from deixis.errors import ReaderError, SceneError
from deixis.frames import Array
from deixis.scene import Scene
from deixis.strict_json import MAX_FILE_BYTES, parse, quoted
from deixis.thresholds import MAX_COORDINATE, Thresholds
from deixis.tiles.schema import BOXES, LABELS, OBJECTS

_ROWS: Final = 65_536
"""Rows of a table read at once."""

_LINES: Final = 2_048
"""Lines of JSON read at once."""

_CENTER, _SIZE = ("x", "y", "z"), ("size_x", "size_y", "size_z")

_LONGEST: Final = 256
"""Characters of an id or a label, as in scene files."""

_MOST_LABELS: Final = 5

# As deixis.scene_format has it: control characters, separators of lines, and what turns the writing round.
_UNPLAIN: Final = r"[\p{Cc}\p{Zl}\p{Zp}\x{061c}\x{200e}\x{200f}\x{202a}-\x{202e}\x{2066}-\x{2069}]"

KINDS: Final = "Parquet (.parquet), Arrow (.arrow), JSON lines (.jsonl) or scene files (.json)"


def files(places: Sequence[Path], target: Path | None = None) -> list[Path]:
    """Return the files to read: those given, and those in folders given, by name.

    Parameters
    ----------
    places : sequence of Path
    target : Path, optional
        A folder that is passed by: what is written there is not read again.

    Raises
    ------
    ReaderError
        A place is not there, or is of no known kind.
    """
    found: list[Path] = []
    for place in places:
        if place.is_dir():
            named = (one for kind in _READERS for one in place.rglob(f"*{kind}") if one.is_file())
            inside = sorted(one for one in named if target not in one.resolve().parents)
            if not inside:
                raise ReaderError(f"{quoted(str(place), 200)} holds no map: give {KINDS}")
            found += inside
        elif not place.is_file():
            raise ReaderError(f"{quoted(str(place), 200)} does not exist: give {KINDS}, or a folder of them")
        elif place.suffix not in _READERS:
            raise ReaderError(f"{quoted(str(place), 200)} is of no known kind: give {KINDS}")
        else:
            found.append(place)
    return found


def head(places: Sequence[Path]) -> Scene:
    """Return what is not in tables: the map's id, views and thresholds, as a scene without objects.

    They stand in the scene files among the places, which must agree on the thresholds; without one there
    are no views, and the thresholds are the usual ones.
    """
    scenes = [replace(Scene.load(one), objects=()) for one in places if one.suffix == ".json"]
    if not scenes:
        return Scene(places[0].stem)
    for other in scenes[1:]:
        if (other.thresholds, other.strays) != (scenes[0].thresholds, scenes[0].strays):
            raise SceneError(
                f"the scenes {quoted(scenes[0].id)} and {quoted(other.id)} have other thresholds: "
                "one map is read with one set of them"
            )
    views = tuple(view for scene in scenes for view in scene.views)
    return replace(scenes[0], views=views, diagnostics=())


def batches(places: Sequence[Path], head: Scene) -> Iterator[pa.RecordBatch]:
    """Yield all things of some files, with the schema :data:`~deixis.tiles.schema.BOXES`.

    Raises
    ------
    ReaderError
        A file is not what its ending says, or lacks a column.
    SceneError
        A thing is not well formed; the message names it.
    """
    for place in places:
        yield from _READERS[place.suffix](place, head)


def _parquet(place: Path, head: Scene) -> Iterator[pa.RecordBatch]:
    try:
        with pq.ParquetFile(place) as file:
            columns = _columns(place, file.schema_arrow)
            yield from _tables(place, file.iter_batches(_ROWS, columns=columns), head)
    except (pa.ArrowException, OSError) as error:
        raise ReaderError(f"{quoted(place.name, 200)} is no Parquet file: {_first_line(error)}") from error


def _arrow(place: Path, head: Scene) -> Iterator[pa.RecordBatch]:
    try:
        with pa.memory_map(str(place)) as source, pyarrow.ipc.open_file(source) as file:
            columns = _columns(place, file.schema)
            every = (file.get_batch(at).select(columns) for at in range(file.num_record_batches))
            yield from _tables(place, every, head)
    except (pa.ArrowException, OSError) as error:
        raise ReaderError(f"{quoted(place.name, 200)} is no Arrow file: {_first_line(error)}") from error


def _columns(place: Path, schema: pa.Schema) -> list[str]:
    """Return which of the known columns a table has."""
    missing = [name for name in ("id", *_CENTER, *_SIZE) if name not in schema.names]
    if missing:
        raise ReaderError(
            f"{quoted(place.name, 200)} has no column {', '.join(missing)}: "
            f"a row of a map has {', '.join(OBJECTS.names)}"
        )
    return [name for name in OBJECTS.names if name in schema.names]


def _tables(place: Path, every: Iterable[pa.RecordBatch], head: Scene) -> Iterator[pa.RecordBatch]:
    row = 0
    for batch in every:
        yield _checked(_Rows(quoted(place.name, 200), row, batch), head.thresholds)
        row += len(batch)


class _Rows:
    """Rows of a table, and what they are called where something is wrong with one."""

    def __init__(self, place: str, first: int, batch: pa.RecordBatch) -> None:
        self._place, self._first = place, first
        self._batch = batch
        self.ids = self.texts("id", required=True)

    def __len__(self) -> int:
        return int(self._batch.num_rows)

    def __contains__(self, name: str) -> bool:
        return name in self._batch.schema.names

    def column(self, name: str, kind: pa.DataType) -> pa.Array:
        column = self._batch.column(name)
        try:
            column.validate(full=True)
            return column.cast(kind)
        except pa.ArrowException as error:
            raise ReaderError(
                f"{self._place}: the column {name} is not what it should be, {kind}: {_first_line(error)}"
            ) from error

    def refuse_where(self, wrong: pa.Array, name: str, said: str) -> None:
        """Raise SceneError for the first row of which this is true."""
        rows = np.flatnonzero(pc.fill_null(wrong, True).to_numpy(zero_copy_only=False))
        if len(rows):
            at = int(rows[0])
            one = self._batch.column("id")[at].as_py() if name != "id" else None
            who = f"object {quoted(one)}" if one is not None else f"row {self._first + at + 1}"
            value = self._batch.column(name)[at].as_py()
            raise SceneError(f"{self._place}, {who}: {name} is {quoted(value)}: {said}")

    def texts(self, name: str, *, required: bool = False) -> pa.Array:
        column = self.column(name, pa.string())
        self._names(column, name, required)
        return column

    def _names(self, column: pa.Array, name: str, required: bool) -> None:
        size = pc.utf8_length(column)
        long = pc.or_(pc.less(size, 1), pc.greater(size, _LONGEST))
        wrong = pc.or_(long, pc.match_substring_regex(column, _UNPLAIN))
        self.refuse_where(
            wrong if required else pc.fill_null(wrong, False),
            name,
            f"give 1 to {_LONGEST} characters, no control characters among them",
        )

    def numbers(self, name: str, low: float = -MAX_COORDINATE) -> Array:
        column = self.column(name, pa.float64())
        # What is not finite is not between the two either; nor is what is missing.
        inside = pc.and_(pc.greater_equal(column, low), pc.less_equal(column, MAX_COORDINATE))
        self.refuse_where(pc.invert(inside), name, f"give a finite number from {low:g} to {MAX_COORDINATE:g}")
        return np.asarray(column.to_numpy(), dtype=np.float64)

    def surfaces(self) -> Array:
        if "kind" not in self:
            return np.zeros(len(self), dtype=np.bool_)
        column = pc.fill_null(self.column("kind", pa.string()), "object")
        known = pc.is_in(column, pa.array(["object", "surface"]))
        self.refuse_where(pc.invert(known), "kind", "give object or surface")
        return np.asarray(pc.equal(column, "surface").to_numpy(zero_copy_only=False))

    def labels(self) -> tuple[pa.Array, pa.Array]:
        """Return the best label of each, and all of those that have several or are not sure of one."""
        none = pa.nulls(len(self), LABELS)
        label = self.texts("label") if "label" in self else pa.nulls(len(self), pa.string())
        if "labels" not in self:
            return label, none
        column = self.column("labels", LABELS)
        flat = pc.list_flatten(column)
        names, scores = flat.field("name"), flat.field("score")
        size = pc.utf8_length(names)
        fine = pc.and_(pc.and_(pc.greater_equal(size, 1), pc.less_equal(size, _LONGEST)),
                       pc.invert(pc.match_substring_regex(names, _UNPLAIN)))  # fmt: skip
        fine = pc.and_(fine, pc.and_(pc.greater_equal(scores, 0.0), pc.less_equal(scores, 1.0)))
        good = np.asarray(pc.fill_null(fine, False).to_numpy(zero_copy_only=False), dtype=np.bool_)
        wrong = np.zeros(len(self), dtype=np.bool_)
        wrong[pc.list_parent_indices(column).to_numpy()[~good]] = True
        many = pc.fill_null(pc.greater(pc.list_value_length(column), _MOST_LABELS), False)
        self.refuse_where(
            pc.or_(pa.array(wrong), many), "labels",
            f"give at most {_MOST_LABELS}, each a name and a score from 0 to 1",
        )  # fmt: skip
        ranked = [
            None if not one else sorted(one, key=lambda label: -label["score"]) for one in column.to_pylist()
        ]
        both = pc.and_(pc.is_valid(label), pa.array([one is not None for one in ranked]))
        self.refuse_where(both, "label", "and there are labels too: keep one of them")
        best = pa.array([None if one is None else one[0]["name"] for one in ranked], pa.string())
        return pc.coalesce(label, best), pa.array(ranked, LABELS)


def _checked(rows: _Rows, limits: Thresholds) -> pa.RecordBatch:
    center = np.stack([rows.numbers(name) for name in _CENTER], axis=1)
    half = 0.5 * np.stack([rows.numbers(name, 0.0) for name in _SIZE], axis=1)
    yaw = rows.numbers("yaw") if "yaw" in rows else np.zeros(len(rows))
    # As of a surface given by a box: it has no thickness along its shortest side, level where that is a tie.
    thin = np.array([2, 0, 1])[np.argmin(half[:, [2, 0, 1]], axis=1)] if len(rows) else np.zeros(0, np.int64)
    normal = np.where(rows.surfaces(), thin, NO_NORMAL).astype(np.int64)
    boxes = Boxes(center, half, yaw, normal, np.zeros(len(rows), dtype=np.bool_))
    return _batch(rows.ids, *rows.labels(), boxes, limits)


def _batch(
    ids: pa.Array, label: pa.Array, labels: pa.Array, boxes: Boxes, limits: Thresholds
) -> pa.RecordBatch:
    low, high = plan_bounds(boxes, limits)
    columns: list[Any] = [
        *boxes.center.T, *boxes.half.T, boxes.yaw, boxes.normal.astype(np.int8), boxes.ambiguous,
        *low.T, *high.T, reach(boxes, limits),
    ]  # fmt: skip
    arrays = [pa.array(np.ascontiguousarray(column)) for column in columns]
    return pa.RecordBatch.from_arrays([ids, label, labels, *arrays], schema=BOXES)


def _scene(place: Path, head: Scene) -> Iterator[pa.RecordBatch]:
    yield _of_scene(Scene.load(place), head)


def _lines(place: Path, head: Scene) -> Iterator[pa.RecordBatch]:
    frame = head.to_dict()
    with place.open("rb") as file:
        numbered = enumerate(iter(lambda: file.readline(MAX_FILE_BYTES + 1), b""), 1)
        told = ((number, line) for number, line in numbered if line.strip())
        while some := list(islice(told, _LINES)):
            objects = [
                parse(line, SceneError, f"{quoted(place.name, 200)}, line {number}") for number, line in some
            ]
            try:
                scene = Scene.from_dict({**frame, "objects": objects})
            except SceneError as cause:
                raise SceneError(
                    f"{quoted(place.name, 200)}, lines {some[0][0]} to {some[-1][0]}: {cause}"
                ) from cause
            yield _of_scene(scene, head)


def _of_scene(scene: Scene, head: Scene) -> pa.RecordBatch:
    things = scene.objects
    sure = [len(one.labels) == 1 and one.labels[0].score == 1.0 for one in things]
    labels = [
        None if plain or not one.labels else [{"name": each.name, "score": each.score} for each in one.labels]
        for one, plain in zip(things, sure, strict=True)
    ]
    return _batch(
        pa.array([one.id for one in things], pa.string()),
        pa.array([one.label or None for one in things], pa.string()),
        pa.array(labels, LABELS),
        scene.boxes,
        head.thresholds,
    )


def _first_line(error: BaseException) -> str:
    return quoted(str(error).splitlines()[0] if str(error) else type(error).__name__, 200)


_READERS: Final = {".parquet": _parquet, ".arrow": _arrow, ".jsonl": _lines, ".json": _scene}
