"""What can be asked of a semantic map, whichever database keeps it."""

from __future__ import annotations

import difflib
import math
import time
from abc import ABC, abstractmethod
from collections.abc import Collection, Iterable, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, Self

from deixis.errors import MapError
from deixis.scene import Scene
from deixis.semantic_map.records import (
    COLUMNS,
    Row,
    map_row,
    read_as,
    same_thresholds,
    scene_of,
    thing_rows,
    view_rows,
)
from deixis.strict_json import quoted

_MIGRATIONS: Final = Path(__file__).resolve().parent / "migrations"

_KINDS: Final = ("duckdb", "postgresql", "postgis")

_TOLD: Final = """
WITH before AS (SELECT seq, stamp, whole FROM frame WHERE stamp <= $1),
     base AS (SELECT stamp, seq FROM before WHERE whole ORDER BY stamp DESC, seq DESC LIMIT 1),
     counted AS (SELECT before.stamp, before.seq FROM before LEFT JOIN base ON true
                 WHERE base.seq IS NULL OR (before.stamp, before.seq) >= (base.stamp, base.seq)),
     told AS (SELECT DISTINCT ON (thing.id) thing.*, counted.stamp, counted.seq
              FROM thing JOIN counted ON thing.frame = counted.seq
              ORDER BY thing.id, counted.stamp DESC, counted.seq DESC)
"""
"""What was told last of each thing until a time; what a whole frame does not name was gone by then."""

THINGS: Final = _TOLD + (
    "SELECT id, kind, labels, region FROM told WHERE NOT gone ORDER BY stamp, seq, position"
)

_SEEN: Final = _TOLD + "SELECT id, stamp FROM told WHERE NOT gone ORDER BY stamp, seq, position"

VIEWS: Final = """
WITH latest AS (SELECT frame FROM viewpoint JOIN frame ON frame.seq = viewpoint.frame
                WHERE frame.stamp <= $1 ORDER BY frame.stamp DESC, frame.seq DESC LIMIT 1)
SELECT id, label, x, y, z, heading, stamp FROM viewpoint WHERE frame = (SELECT frame FROM latest)
ORDER BY position
"""

_FRAMES: Final = """
SELECT seq, stamp, source, whole,
       (SELECT count(*) FROM thing WHERE thing.frame = seq AND NOT gone),
       (SELECT count(*) FROM thing WHERE thing.frame = seq AND gone)
FROM frame ORDER BY stamp, seq
"""

_SIGHTINGS: Final = """
SELECT frame.stamp, frame.seq, gone, label, x, y, z FROM thing JOIN frame ON frame.seq = thing.frame
WHERE thing.id = $1 ORDER BY frame.stamp, frame.seq
"""


@dataclass(frozen=True, slots=True)
class Frame:
    """What a map was told at once.

    Attributes
    ----------
    seq : int
        Number in the order of arrival, which need not be that of the stamps.
    stamp : float
        Seconds since the epoch: when it was so.
    source : str
        Id of the scene that was added.
    whole : bool
        Whether it shows all there was: what it does not name was gone.
    things, gone : int
        How many things it shows, and of how many it tells that they are gone.
    """

    seq: int
    stamp: float
    source: str
    whole: bool
    things: int
    gone: int


@dataclass(frozen=True, slots=True)
class Sighting:
    """One thing in one frame: when, where its box's middle was (metres), or that it was gone."""

    stamp: float
    frame: int
    gone: bool
    label: str
    center: tuple[float, float, float] | None


class FrameStore(ABC):
    """A database of frames, each a scene as it was at some time.

    The scene of a time is what was told last of each thing until then. Views are those of the last frame
    that has any. Frames may arrive late: what counts is their stamp (decision 0047). Each thread needs a map
    of its own; several may be open on one database.
    """

    def __init__(self, address: str) -> None:
        self.address = address

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    @property
    def id(self) -> str:
        """Return the map's id, which its scenes have."""
        with self._transaction():
            return str(self._map()[0])

    def add(
        self, scene: Scene, *, stamp: float | None = None, whole: bool = False, gone: Sequence[str] = ()
    ) -> Frame:
        """Keep a scene as a frame; once this returns the frame outlives a crash.

        Parameters
        ----------
        scene : Scene
            Things it names replace what was told of them before; others stay as they were.
        stamp : float, optional
            Seconds since the epoch: when it was so. By default the latest stamp of its views, else now.
        whole : bool
            Whether the scene shows all there is, so that what it does not name is gone.
        gone : sequence of str
            Ids of things that are there no more.

        Raises
        ------
        MapError
            The stamp is not finite, the scene has other thresholds than the map, a thing is both shown and
            gone, something is said to be gone that the map was never told of, or the database cannot be
            written.
        SceneError
            With the map's thresholds and treatment of strays a thing is none.
        """
        if stamp is None:
            stamp = max((view.stamp for view in scene.views if view.stamp is not None), default=time.time())
        stamp = float(stamp)
        if not math.isfinite(stamp):
            raise MapError(
                f"the stamp of scene {quoted(scene.id)} is not finite: give seconds since the epoch"
            )
        with self._transaction():
            told = self._map()
            if not same_thresholds(told, scene):
                raise MapError(
                    f"scene {quoted(scene.id)} has other thresholds or another treatment of strays than the "
                    "map: leave them out of the scene, or make a map like it"
                )
            # What the map could not read again must not get into it: nothing is ever deleted.
            read = read_as(told, scene)
            rows = {"thing": thing_rows(0, read, gone), "viewpoint": view_rows(0, read), **self._more(read)}
            if gone:
                self._check_told(gone)
            seq = int(self._rows("SELECT nextval('frame_seq')")[0][0])
            self._insert("frame", [(seq, stamp, scene.id, whole)])
            for table, some in rows.items():
                self._insert(table, [(seq, *row[1:]) for row in some])
        return Frame(seq, stamp, scene.id, whole, len(scene.objects), len(dict.fromkeys(gone)))

    def frames(self) -> tuple[Frame, ...]:
        """Return all frames, by their stamps."""
        with self._transaction():
            return tuple(Frame(*row) for row in self._rows(_FRAMES))

    def sightings(self, thing: str) -> tuple[Sighting, ...]:
        """Return what was told of a thing, by time."""
        with self._transaction():
            rows = self._rows(_SIGHTINGS, [thing])
        return tuple(
            Sighting(stamp, frame, gone, label or "", None if gone else (x, y, z))
            for stamp, frame, gone, label, x, y, z in rows
        )

    def scene(self, *, at: float | None = None) -> Scene:
        """Return the scene as it was at a time, in seconds since the epoch; by default the last known."""
        until = _until(at)
        with self._transaction():
            return scene_of(self._map(), self._rows(THINGS, until), self._rows(VIEWS, until))

    def seen(self, *, at: float | None = None) -> dict[str, float]:
        """Return when each thing that is there at a time was last told of, by its id."""
        with self._transaction():
            return dict(self._rows(_SEEN, _until(at)))

    def _more(self, scene: Scene) -> Mapping[str, list[Row]]:  # noqa: ARG002 - most databases keep no more
        """Return rows that only some databases keep, by their tables."""
        return {}

    @abstractmethod
    def close(self) -> None:
        """Let go of the database."""

    @abstractmethod
    def _transaction(self) -> AbstractContextManager[None]:
        """Make all or nothing of what is done within; errors of the database become our own."""

    @abstractmethod
    def _rows(self, statement: str, values: Sequence[Any] = ()) -> list[Row]:
        """Return what a statement finds; $1, $2 ... stand for the values."""

    @abstractmethod
    def _run(self, statement: str, values: Sequence[Any] = ()) -> None:
        """Carry out a statement that finds nothing."""

    @abstractmethod
    def _insert(self, table: str, rows: Sequence[Row]) -> None:
        """Write rows in bulk into one of our tables."""

    def _map(self) -> Row:
        rows = self._rows("SELECT id, thresholds, strays FROM map")
        if not rows:
            raise MapError(f"{self.address} has no map in it: make one with `deixis map init`")
        return rows[0]

    def _check_told(self, names: Sequence[str]) -> None:
        """Raise :class:`MapError` unless the map was told of all these things."""
        known = self._rows("SELECT DISTINCT id FROM thing WHERE id = ANY($1::varchar[])", [list(names)])
        lost = set(names).difference(name for (name,) in known)
        if lost:
            all_names = [name for (name,) in self._rows("SELECT DISTINCT id FROM thing ORDER BY id")]
            close = difflib.get_close_matches(min(lost), all_names, n=3)
            meant = (
                f"did you mean {', '.join(map(quoted, close))}?" if close else "`deixis map list` names all"
            )
            raise MapError(f"the map was never told of {quoted(min(lost))}: {meant}")

    def _begin(self, like: Scene) -> None:
        with self._transaction():
            if self._rows("SELECT id FROM map"):
                raise MapError(f"{self.address} holds a map already: add to it, or choose another place")
            self._insert("map", [map_row(like)])


def migrations(done: Collection[int], *kinds: str) -> list[tuple[int, str]]:
    """Return number and text of the migrations still to be done in a database of some kinds.

    A file's name is its number and what it does; those for one kind of database name it at the end.
    """
    found = []
    for path in sorted(_MIGRATIONS.glob("*.sql")):
        number, _, name = path.stem.partition("_")
        kind = name.rpartition("_")[2]
        if int(number) not in done and (kind not in _KINDS or kind in kinds):
            found.append((int(number), path.read_text(encoding="utf-8")))
    return found


def columns_of(table: str) -> Sequence[str]:
    """Return the columns of one of our tables."""
    return COLUMNS[table]


def by_column(columns: Iterable[str], rows: Sequence[Row]) -> Mapping[str, tuple[Any, ...]]:
    """Return rows as columns, by their names."""
    return dict(zip(columns, zip(*rows, strict=True), strict=True))


def _until(at: float | None) -> list[float]:
    until = math.inf if at is None else float(at)
    if math.isnan(until):
        raise MapError("the time is not a number: give seconds since the epoch")
    return [until]
