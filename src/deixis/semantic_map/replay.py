"""A map followed frame by frame: what held, and when that changed."""

from __future__ import annotations

import json
from collections.abc import Collection, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from deixis.facts import RegionModel
from deixis.grounding import ground
from deixis.living import Known, Living
from deixis.regrounding import reground
from deixis.semantic_map.intervals import Key
from deixis.semantic_map.records import Row, scene_of

if TYPE_CHECKING:
    from deixis.ruleset import Indicator, Ruleset
    from deixis.ruleset.tables import Executor

Told = tuple[str | None, ...]
"""Kind, labels and region of a thing, as they stand in the map."""


class Record:
    """The intervals of some relations, while time goes on.

    Parameters
    ----------
    since : mapping
        What holds to begin with, each since when.
    """

    def __init__(self, since: Mapping[Key, float]) -> None:
        self.open = dict(since)
        self.closed: list[Row] = []

    def note(self, stamp: float, gained: Iterable[Key], lost: Iterable[Key]) -> None:
        """Take down what began to hold at a time and what ceased to."""
        for key in lost:
            since = self.open.pop(key, None)
            if since is not None:
                self.closed.append((*key, since, stamp))
        for key in gained:
            self.open.setdefault(key, stamp)

    def settle(self, stamp: float, holds: Collection[Key]) -> None:
        """Take down that at a time just this holds."""
        self.note(stamp, holds, [key for key in self.open if key not in holds])


class Replay:
    """What follows from a map while its frames are told again, one after the other.

    Parameters
    ----------
    told : row
        Of the map: id, thresholds, treatment of strays.
    things, views : sequence of row
        What there is to begin with; as of :func:`~deixis.semantic_map.records.scene_of`.
    ruleset : Ruleset
    executor : Executor
    wanted : sequence of Indicator
    region : "box", "hull" or "mesh"
    timeout : float
        Seconds that each derivation may take.
    """

    def __init__(
        self,
        told: Row,
        things: Sequence[Row],
        views: Sequence[Row],
        ruleset: Ruleset,
        executor: Executor,
        wanted: Sequence[Indicator],
        region: RegionModel,
        timeout: float,
    ) -> None:
        self._map = told
        self._told = {name: _plain(kind, labels, region) for name, kind, labels, region in things}
        self._views = _poses(views)
        self._scene = scene_of(told, _rows(self._told), views)
        self._facts = ground(self._scene, region=region)
        seen = [(view.id, view.label) for view in self._scene.views]
        self._living = Living(ruleset, executor, wanted, self._facts, seen, timeout=timeout)

    @property
    def holds(self) -> set[Key]:
        """Return all that holds now."""
        return set(map(_key, self._living.holds))

    def tell(
        self, frames: Sequence[tuple[bool, Sequence[Row]]], views: Sequence[Row] | None
    ) -> tuple[list[Key], list[Key]]:
        """Take in the frames of one stamp; return what they made hold, and what hold no more.

        Parameters
        ----------
        frames : sequence of (bool, sequence of row)
            In their order: whether it shows all there is, and its things: id, gone, kind, labels, region.
        views : sequence of row or None
            Of the last frame that has any; None where none has.
        """
        now = dict(self._told)
        for whole, rows in frames:
            if whole:
                now.clear()
            for name, gone, *values in rows:
                if gone:
                    now.pop(name, None)
                else:
                    now[name] = _plain(*values)
        changed = {name: value for name, value in now.items() if self._told.get(name) != value}
        removed = [name for name in self._told if name not in now]
        looked = views is not None and _poses(views) != self._views
        if not (changed or removed or looked):
            return [], []
        shown = scene_of(self._map, _rows(changed), views if looked and views is not None else ())
        after = self._scene.changed(
            objects=shown.objects, removed=removed, views=shown.views if looked else None
        )
        facts = reground(self._scene, self._facts, after)
        labels = [(view.id, view.label) for view in after.views]
        found = self._living.advance(facts, labels, [*changed, *removed], looked=looked)
        self._scene, self._facts, self._told = after, facts, now
        self._views = _poses(views) if looked and views is not None else self._views
        return list(map(_key, found.gained)), list(map(_key, found.lost))


def _plain(kind: str, labels: str, region: str) -> Told:
    """Return what a thing is, without the views that it was seen in: nothing follows from them."""
    if '"seen_in"' not in region:
        return kind, labels, region
    values: dict[str, Any] = json.loads(region)
    values.pop("seen_in", None)
    return kind, labels, json.dumps(values)


def _rows(things: Mapping[str, Told]) -> list[Row]:
    return [(name, *value) for name, value in things.items()]


def _poses(views: Sequence[Row]) -> list[Row]:
    """Return views without their stamps."""
    return [row[:-1] for row in views]


def _key(known: Known) -> Key:
    (name, arity), row = known
    return name, row[0], row[1], row[2] if arity == 3 else None
