"""Intervals: from when to when each relation held."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from deixis.relations import Relation
from deixis.updates import Changes

_Key = tuple[str, str, str, str | None]


@dataclass(frozen=True, slots=True)
class Interval:
    """That a relation held for a while.

    Attributes
    ----------
    relation : Relation
        With the margin with which it began.
    since : int
        Stamp of the first moment in which it held, nanoseconds.
    until : int or None
        Stamp of the first moment in which it held no more; None where it holds to the end.
    """

    relation: Relation
    since: int
    until: int | None

    def to_dict(self) -> dict[str, Any]:
        """Return the interval as JSON values; ``since`` and ``until`` are nanoseconds."""
        return {**self.relation.to_dict(), "since": self.since, "until": self.until}


class Intervals:
    """Puts together when relations began and ceased.

    Examples
    --------
    >>> on = Relation("on_top_of", "cup", "table", None, 0.02)
    >>> kept = Intervals()
    >>> kept.take(1, Changes(None, (on,), ()))
    []
    >>> [(one.since, one.until) for one in kept.take(5, Changes(None, (), (on,)))]
    [(1, 5)]
    """

    def __init__(self) -> None:
        self._open: dict[_Key, tuple[Relation, int]] = {}

    def take(self, stamp: int, changes: Changes) -> list[Interval]:
        """Take in the changes of a moment; return the intervals that end with it."""
        ended = [
            Interval(*self._open.pop(key), stamp) for key in map(_key, changes.lost) if key in self._open
        ]
        for one in changes.gained:
            self._open[_key(one)] = one, stamp
        return ended

    def rest(self) -> Iterable[Interval]:
        """Return the intervals of what still holds."""
        return [Interval(one, since, None) for one, since in self._open.values()]


def _key(one: Relation) -> _Key:
    return one.relation, one.figure, one.reference, one.view
