"""What held when, derived from the frames of a map and kept in it.

Intervals are caught up when they are asked for: adding a frame costs nothing more. What is kept rests on the
frames that are accounted for; a frame that arrives late takes back what was derived from its stamp on
(decision 0052).
"""

from __future__ import annotations

import hashlib
import math
import time
from abc import abstractmethod
from collections.abc import Iterable, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from functools import cache
from importlib.metadata import version
from itertools import groupby
from operator import itemgetter
from typing import TYPE_CHECKING, Final

from deixis._files import datalog_files
from deixis.engines import AutoExecutor
from deixis.errors import QueryTimeout
from deixis.facts import RegionModel
from deixis.moments import spoken
from deixis.semantic_map.records import Row
from deixis.semantic_map.replay import Record, Replay
from deixis.semantic_map.store import THINGS, VIEWS, FrameStore
from deixis.vocabulary import RELATIONS

if TYPE_CHECKING:
    from deixis.ruleset import Indicator, Ruleset

_BATCH: Final = 256
"""Frames that are read, derived and kept at once."""

_EACH: Final = 60.0
"""Seconds that the derivation of one frame may take."""

KEPT: Final[tuple[Indicator, ...]] = tuple((term.name, term.arity) for term in RELATIONS)
"""The relations whose intervals are kept."""

_PENDING: Final = """
SELECT seq, stamp, whole FROM frame WHERE NOT EXISTS (SELECT 1 FROM accounted WHERE frame = seq)
ORDER BY stamp, seq
"""

_LATE: Final = """
SELECT 1 FROM accounted JOIN frame ON frame.seq = accounted.frame WHERE stamp >= $1 LIMIT 1
"""

_TAKEN_BACK: Final = (
    "DELETE FROM held WHERE until >= $1",
    "DELETE FROM accounted WHERE frame IN (SELECT seq FROM frame WHERE stamp >= $1)",
)

_THEN: Final = """
SELECT relation, figure, reference, view, since FROM lasting
WHERE since < $1 AND (until IS NULL OR until >= $1)
"""

_ALL: Final = "SELECT seq, stamp, whole FROM frame ORDER BY stamp, seq"

_SHOWN: Final = """
SELECT frame, id, gone, kind, labels, region FROM thing WHERE frame = ANY($1::bigint[])
ORDER BY frame, position
"""

_SEEN_FROM: Final = """
SELECT frame, id, label, x, y, z, heading, stamp FROM viewpoint WHERE frame = ANY($1::bigint[])
ORDER BY frame, position
"""


@dataclass(frozen=True, slots=True)
class _Followed:
    """A replay that stands where the intervals of a turn end."""

    turn: int
    replay: Replay


class HistoryStore(FrameStore):
    """A database of frames, and of what follows from them.

    Parameters
    ----------
    address : str
    """

    _batch = _BATCH

    def __init__(self, address: str) -> None:
        super().__init__(address)
        self._followed: _Followed | None = None
        self._executor: AutoExecutor | None = None

    def catch_up(self, *, timeout: float = 600.0) -> None:
        """Derive what held when, as far as it is not known yet; every question about intervals does so first.

        Parameters
        ----------
        timeout : float
            Seconds. What was derived until then is kept.

        Raises
        ------
        QueryTimeout
            There is more to derive; the message says from when on.
        """
        deadline = time.monotonic() + timeout
        while True:
            followed, self._followed = self._followed, None
            with self._deriving():
                followed, rest = self._next(followed, deadline)
            # Only now is it in the database.
            self._followed = followed
            if rest is None:
                return
            if time.monotonic() > deadline:
                raise QueryTimeout(
                    f"what held from {spoken(rest)} on could not be derived within {timeout:g} s: "
                    "what was derived is kept, so ask again, or give it more time"
                )

    def _forget(self) -> None:
        """Give up what is kept in memory; it is made again when it is needed."""
        self._followed = None
        if self._executor is not None:
            self._executor.close()
            self._executor = None

    @abstractmethod
    def _deriving(self) -> AbstractContextManager[None]:
        """Make all or nothing of what is done within, of all who derive for this map one at a time."""

    def _next(self, followed: _Followed | None, deadline: float) -> tuple[_Followed | None, float | None]:
        """Derive some frames; return where that ends, and the stamp of the first that is left, or None."""
        turn = self._turn()
        pending = self._rows(_PENDING)
        if not pending:
            return (followed if followed is not None and followed.turn == turn else None), None
        start = pending[0][1]
        if self._rows(_LATE, [start]):
            since = self._rows(_THEN, [start])
            for statement in _TAKEN_BACK:
                self._run(statement, [start])
            pending, followed = self._rows(_PENDING), None
        else:
            since = self._rows("SELECT relation, figure, reference, view, since FROM holding")
        record = Record({tuple(key): stamp for *key, stamp in since})
        known = followed is not None and followed.turn == turn
        replay = followed.replay if followed is not None and known else self._replay_from(start)
        done = self._follow(replay, record, pending, deadline, known=known)
        self._run("DELETE FROM holding")
        self._insert("held", record.closed)
        self._insert("holding", [(*key, stamp) for key, stamp in record.open.items()])
        self._insert("accounted", [(seq,) for seq, _, _ in pending[:done]])
        self._run("UPDATE derivation SET turn = $1", [turn + 1])
        return _Followed(turn + 1, replay), pending[done][1] if done < len(pending) else None

    def _turn(self) -> int:
        """Return how often anything was derived; what other rules derived is given up."""
        found, rules = self._rows("SELECT rules, turn FROM derivation"), _digest()
        if found and found[0][0] == rules:
            return int(found[0][1])
        for table in ("held", "holding", "accounted", "derivation"):
            self._run(f"DELETE FROM {table}")
        turn = int(found[0][1]) + 1 if found else 0
        self._insert("derivation", [(rules, turn)])
        return turn

    def _replay_from(self, start: float) -> Replay:
        """Return a replay that stands just before a time."""
        before = [math.nextafter(start, -math.inf)]
        rules = theory()
        things, views = self._rows(THINGS, before), self._rows(VIEWS, before)
        if self._executor is None:
            self._executor = AutoExecutor(rules)
        return Replay(self._map(), things, views, rules, self._executor, KEPT, "box", _EACH)

    def _replayed(
        self, ruleset: Ruleset, wanted: Sequence[Indicator], region: RegionModel, timeout: float
    ) -> list[Row]:
        """Return the intervals of some relations over the whole of time, derived now and kept nowhere."""
        deadline = time.monotonic() + timeout
        record = Record({})
        with AutoExecutor(ruleset) as executor, self._transaction():
            replay = Replay(self._map(), (), (), ruleset, executor, wanted, region, _EACH)
            frames, known = self._rows(_ALL), False
            while frames:
                done = self._follow(replay, record, frames, deadline, known=known)
                frames, known = frames[done:], True
                if frames and time.monotonic() > deadline:
                    raise QueryTimeout(
                        f"these relations could not be derived beyond {spoken(frames[0][1])} within "
                        f"{timeout:g} s, and they are not kept: give it more time, or ask for those that are"
                    )
        return [*record.closed, *((*key, since, None) for key, since in record.open.items())]

    def _follow(
        self, replay: Replay, record: Record, frames: Sequence[Row], deadline: float, *, known: bool
    ) -> int:
        """Take in some of the frames, note what they change, and return how many they were.

        Parameters
        ----------
        replay : Replay
        record : Record
        frames : sequence of row
            Number, stamp and whether whole, by stamp and number. All of one stamp are taken in together.
        deadline : float
            No further stamp is begun after it.
        known : bool
            Whether the record has what holds where the replay stands.
        """
        size = self._batch
        while size < len(frames) and frames[size][1] == frames[size - 1][1]:
            size += 1
        frames = frames[:size]
        numbers = [[seq for seq, _, _ in frames]]
        things, views = (_by_frame(self._rows(one, numbers)) for one in (_SHOWN, _SEEN_FROM))
        done = 0
        for stamp, group in groupby(frames, itemgetter(1)):
            some = list(group)
            seen = [views[seq] for seq, _, _ in some if seq in views]
            told = [(whole, things.get(seq, ())) for seq, _, whole in some]
            gained, lost = replay.tell(told, seen[-1] if seen else None)
            if known:
                record.note(stamp, gained, lost)
            else:
                record.settle(stamp, replay.holds)
            known, done = True, done + len(some)
            if time.monotonic() > deadline:
                break
        return done


def _by_frame(rows: Iterable[Row]) -> dict[int, list[Row]]:
    found: dict[int, list[Row]] = {}
    for frame, *values in rows:
        found.setdefault(frame, []).append(tuple(values))
    return found


@cache
def theory() -> Ruleset:
    """Return the theory's rules, read once in a process."""
    from deixis.ruleset import load

    return load(datalog_files())


@cache
def _digest() -> str:
    """Return what tells the rules of now, and the program that measures, from those of other times."""
    digest = hashlib.sha256(version("deixis").encode())
    for path in datalog_files():
        digest.update(path.read_bytes())
    return digest.hexdigest()
