"""Tracks: which detections of one moment after another are of one thing, and when a thing is gone.

Where a tracker gives ids they count. Other detections are of the thing that they overlap with under a like
name, as sightings of a map are (:mod:`deixis.perception.association`); of those left over, of the thing of
the same name that is nearest, if it can have come so far.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, field
from typing import Final, Literal, NamedTuple

import numpy as np

from deixis.boxes import Boxes
from deixis.regions import Region, RegionBox
from deixis.scene import Label
from deixis.thresholds import Thresholds

Tracking = Literal["auto", "overlap"]
"""Whether the ids of a tracker count, or only what detections have in common."""

SPEED: Final = 1.0
"""Metres a second: what moves faster and has no id is lost, and found as another thing."""

REACH: Final = (0.1, 0.5)
"""Metres: the least and the most that something may have moved between two sightings without overlap."""

_SURE: Final = 1.0e6


class Sighting(NamedTuple):
    """One thing as one moment shows it, in the fixed frame."""

    track: str
    labels: tuple[Label, ...]
    region: Region
    box: RegionBox

    @property
    def label(self) -> str:
        """Return the best label's name."""
        return max(self.labels, key=lambda one: one.score).name if self.labels else ""

    @property
    def score(self) -> float:
        """Return the best label's score, 0 without any."""
        return max((one.score for one in self.labels), default=0.0)


@dataclass(slots=True)
class _Thing:
    """A thing as it was seen last, and all the names it was given."""

    id: str
    last: Sighting
    stamp: int
    named: bool
    scores: dict[str, float] = field(default_factory=dict)
    times: int = 0

    def see(self, sighting: Sighting, stamp: int) -> None:
        self.last, self.stamp = sighting, stamp
        self.times += 1
        for label in sighting.labels:
            self.scores[label.name] = self.scores.get(label.name, 0.0) + label.score

    @property
    def labels(self) -> tuple[Label, ...]:
        """Return the names by the mean of their scores over all sightings, the best first."""
        ranked = sorted(self.scores.items(), key=lambda one: (-one[1], one[0]))
        return tuple(Label(name, round(score / self.times, 6)) for name, score in ranked[:_NAMES])


_NAMES: Final = 5


class Seen(NamedTuple):
    """What a moment shows: things by their ids, each with its region and labels; and what is gone."""

    things: dict[str, tuple[Region, tuple[Label, ...]]]
    gone: tuple[str, ...]


class Tracks:
    """The things of a log.

    Parameters
    ----------
    forget : float
        Nanoseconds: what no moment has shown for longer is gone.
    tracking : {"auto", "overlap"}
    limits : Thresholds
    taken : collection of str
        Ids that no thing may have.
    """

    def __init__(
        self, forget: float, tracking: Tracking, limits: Thresholds, taken: Collection[str] = ()
    ) -> None:
        self._forget, self._tracking, self._limits = forget, tracking, limits
        self._taken = set(taken)
        self._things: dict[str, _Thing] = {}
        self._counts: dict[str, int] = {}

    def see(self, stamp: int, sightings: Sequence[Sighting]) -> Seen:
        """Take in what a moment shows, of which no two with the same id."""
        shown: dict[str, tuple[Region, tuple[Label, ...]]] = {}
        gone = [one.id for one in self._things.values() if stamp - one.stamp > self._forget]
        for name in gone:
            del self._things[name]
        rest = []
        for sighting in sightings:
            if sighting.track and self._tracking == "auto":
                thing = self._things.get(sighting.track)
                # An id that we made may turn out to be a tracker's too: from then on it is the tracker's.
                self._note(thing if thing and thing.named else None, sighting, stamp, shown)
            else:
                rest.append(sighting)
        known = [one for one in self._things.values() if not one.named]
        match = self._matched(known, rest, stamp)
        for at, sighting in enumerate(rest):
            self._note(known[match[at]] if at in match else None, sighting, stamp, shown)
        return Seen(shown, tuple(name for name in gone if name not in shown))

    def _note(
        self,
        thing: _Thing | None,
        sighting: Sighting,
        stamp: int,
        shown: dict[str, tuple[Region, tuple[Label, ...]]],
    ) -> None:
        if thing is None:
            named = bool(sighting.track) and self._tracking == "auto"
            name = sighting.track if named else self._new(sighting.label)
            thing = self._things[name] = _Thing(name, sighting, stamp, named)
        thing.see(sighting, stamp)
        shown[thing.id] = sighting.region, thing.labels

    def _new(self, label: str) -> str:
        """Return an id that no thing has or had: the label and a number."""
        stem = label or "thing"
        while True:
            self._counts[stem] = self._counts.get(stem, 0) + 1
            name = f"{stem[:200]}_{self._counts[stem]}"
            if name not in self._things and name not in self._taken:
                return name

    def _matched(self, known: Sequence[_Thing], seen: Sequence[Sighting], stamp: int) -> dict[int, int]:
        """Return for sightings without an id which known thing each is of."""
        if not known or not seen:
            return {}
        from deixis.perception.association import associate

        match = associate(
            _boxes([one.last.box for one in known]),
            [one.labels for one in known],
            _boxes([one.box for one in seen]),
            [one.labels for one in seen],
            self._limits.granularity,
        )
        free = [at for at in range(len(known)) if at not in match.values()]
        left = [at for at in range(len(seen)) if at not in match]
        return match | self._nearest(known, free, seen, left, stamp)

    def _nearest(
        self,
        known: Sequence[_Thing],
        free: Sequence[int],
        seen: Sequence[Sighting],
        left: Sequence[int],
        stamp: int,
    ) -> dict[int, int]:
        """Return for what overlaps with nothing the thing of its name that can have come there."""
        if not free or not left:
            return {}
        from scipy.optimize import linear_sum_assignment

        cost = np.full((len(left), len(free)), _SURE)
        for row, one in enumerate(left):
            for column, other in enumerate(free):
                thing, sighting = known[other], seen[one]
                if thing.last.label != sighting.label:
                    continue
                passed = max(stamp - thing.stamp, 0) / 1.0e9
                away = float(np.linalg.norm(thing.last.box.center - sighting.box.center))
                if away <= min(max(SPEED * passed, REACH[0]), REACH[1]):
                    cost[row, column] = away
        rows, columns = linear_sum_assignment(cost)
        return {
            left[row]: free[column]
            for row, column in zip(rows.tolist(), columns.tolist(), strict=True)
            if cost[row, column] < _SURE
        }


def _boxes(rows: Sequence[RegionBox]) -> Boxes:
    return Boxes(
        np.array([row.center for row in rows], dtype=np.float64).reshape(-1, 3),
        np.array([row.half for row in rows], dtype=np.float64).reshape(-1, 3),
        np.array([row.yaw for row in rows], dtype=np.float64),
        np.array([row.normal for row in rows], dtype=np.int64),
        np.array([row.ambiguous for row in rows], dtype=np.bool_),
    )
