"""Intervals: how long a relation held, and what differs between two times."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

from deixis.vocabulary import RELATIONS

Key = tuple[str, str, str, str | None]
"""Relation, figure, reference, and the view or None."""

_ORDER: Final = {term.name: position for position, term in enumerate(RELATIONS)}


@dataclass(frozen=True, slots=True)
class Interval:
    """A relation while it held, from ``since`` on and before ``until``.

    Attributes
    ----------
    relation : str
    figure, reference : str
        Ids of the two things.
    view : str or None
        Id of the view, where it matters.
    since : float
        Seconds since the epoch: the stamp of the frame that made it hold.
    until : float or None
        The stamp of the frame that ended it; None where, by what was told last, it holds.

    Examples
    --------
    >>> Interval("on_top_of", "cup", "table", None, 10.0, 20.0).holds(20.0)
    False
    """

    relation: str
    figure: str
    reference: str
    view: str | None
    since: float
    until: float | None

    @property
    def key(self) -> Key:
        """Return the relation that held."""
        return self.relation, self.figure, self.reference, self.view

    def holds(self, at: float) -> bool:
        """Return whether it held at a time."""
        return self.since <= at and (self.until is None or at < self.until)

    def to_prolog(self) -> str:
        """Return the relation as a Prolog fact without its full stop; ids are quoted."""
        from deixis.prolog.quote import atom

        ids = [self.figure, self.reference] + ([] if self.view is None else [self.view])
        return f"{self.relation}({','.join(map(atom, ids))})"

    def to_dict(self) -> dict[str, Any]:
        """Return the interval as a dict, ready for JSON."""
        return {
            "relation": self.relation,
            "figure": self.figure,
            "reference": self.reference,
            "view": self.view,
            "since": self.since,
            "until": self.until,
        }


@dataclass(frozen=True, slots=True)
class Between:
    """What differs between two times.

    Attributes
    ----------
    start, end : float
    gained : tuple of Interval
        What holds at the end and did not at the start, by ``since``.
    lost : tuple of Interval
        What held at the start and does not at the end, by ``until``.
    passing : tuple of Interval
        What held for a while between, and at neither.
    """

    start: float
    end: float
    gained: tuple[Interval, ...]
    lost: tuple[Interval, ...]
    passing: tuple[Interval, ...]

    def __bool__(self) -> bool:
        return bool(self.gained or self.lost or self.passing)

    @classmethod
    def of(cls, start: float, end: float, found: tuple[Interval, ...]) -> Between:
        """Return the differences, given all intervals that touch the span.

        Examples
        --------
        >>> before = Interval("on_top_of", "cup", "table", None, 0.0, 20.0)
        >>> after = Interval("on_top_of", "cup", "floor", None, 20.0, None)
        >>> between = Between.of(10.0, 30.0, (before, after))
        >>> between.gained == (after,), between.lost == (before,)
        (True, True)
        """
        before = {one.key for one in found if one.holds(start)}
        after = {one.key for one in found if one.holds(end)}
        return cls(
            start,
            end,
            tuple(one for one in found if one.holds(end) and one.key not in before),
            tuple(
                sorted(
                    (one for one in found if one.holds(start) and one.key not in after),
                    key=lambda one: (one.until or 0.0, rank(one)),
                )
            ),
            tuple(one for one in found if one.key not in before | after),
        )


def rank(one: Interval) -> tuple[Any, ...]:
    """Return the place of an interval's relation in the order of the vocabulary, then by ids."""
    return _ORDER.get(one.relation, len(_ORDER)), one.relation, one.figure, one.reference, one.view or ""
