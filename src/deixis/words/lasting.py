"""How long something held, in a sentence."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from typing import TYPE_CHECKING, Final

from deixis.moments import duration, spoken
from deixis.words.phrases import is_plural, perspective, sentence, short

if TYPE_CHECKING:
    from deixis.semantic_map import Interval

PHRASES: Final = {
    "above": "above",
    "below": "below",
    "right_of": "right of",
    "left_of": "left of",
    "in_front_of": "in front of",
    "behind": "behind",
    "beside": "beside",
    "on_top_of": "on",
    "leans_on": "leaning on",
    "affixed_on": "affixed to",
    "part_in": "partly in",
    "inside": "inside",
    "near": "near",
}
"""What stands between figure and reference, after a form of "to be"."""


class Lasting:
    """Says how long relations held.

    Things are called by their labels, and by their ids too where two share a label: what else tells them
    apart, such as where they stand, need not have been so at that time.

    Parameters
    ----------
    labels, views : mapping
        What things and views are called, by their ids.

    Examples
    --------
    >>> from deixis.semantic_map import Interval
    >>> lasting = Lasting({"c": "cup", "t": "table"}, {})
    >>> lasting.was(Interval("on_top_of", "c", "t", None, 1795344125.0, 1795345205.0))
    'The cup was on the table from 2026-11-22 10:42:05 UTC to 2026-11-22 11:00:05 UTC (18 minutes).'
    """

    def __init__(self, labels: Mapping[str, str], views: Mapping[str, str]) -> None:
        self._labels, self._views = labels, views
        self._counts = Counter(labels.values())

    def called(self, thing: str) -> str:
        """Return what a thing is called."""
        label = self._labels.get(thing, "")
        if not label:
            return short(thing)
        return f"the {short(label)}" + ("" if self._counts[label] == 1 else f" ({short(thing)})")

    def holds(self, one: Interval, by: float) -> str:
        """Return that something holds, since when, and how long that was at a time."""
        length = f" ({duration(by - one.since)})" if by > one.since else ""
        return sentence(f"{self._said(one, ('has been', 'have been'))} since {spoken(one.since)}{length}")

    def held(self, one: Interval, at: float) -> str:
        """Return that something held at a time that is past, since when, and until when if it ended."""
        rest = "" if one.until is None else f", until {spoken(one.until)}"
        return sentence(
            f"at {spoken(at)} {self._said(one, ('was', 'were'))}, since {spoken(one.since)}{rest}"
        )

    def was(self, one: Interval) -> str:
        """Return from when to when something held; of what still holds, since when."""
        if one.until is None:
            return sentence(f"{self._said(one, ('has been', 'have been'))} since {spoken(one.since)}")
        length, said = duration(one.until - one.since), self._said(one, ("was", "were"))
        return sentence(f"{said} from {spoken(one.since)} to {spoken(one.until)} ({length})")

    def not_so(self, one: Interval, at: float | None, last: Interval | None) -> str:
        """Return that something does not hold, or did not at a time, and when it did last before.

        Parameters
        ----------
        one : Interval
            What is denied; its times are not looked at.
        at : float or None
            None for now.
        last : Interval or None
        """
        if at is None:
            denied = self._said(one, ("is not", "are not"))
        else:
            denied = f"at {spoken(at)} {self._said(one, ('was not', 'were not'))}"
        several = one.relation in PHRASES and is_plural(self._labels.get(one.figure, ""))
        if last is None or last.until is None:
            return sentence(f"{denied}, and {'were' if several else 'was'} not before")
        it = "they last were" if several else "it last was"
        return sentence(f"{denied}; {it} from {spoken(last.since)} to {spoken(last.until)}")

    def _said(self, one: Interval, verbs: tuple[str, str]) -> str:
        """Return figure, verb and where; of a relation without a phrase the relation itself."""
        phrase = PHRASES.get(one.relation)
        if phrase is None:
            of = [one.figure, one.reference] + ([] if one.view is None else [one.view])
            return f"it {verbs[0]} so that {one.relation}({', '.join(map(short, of))})"
        verb = verbs[is_plural(self._labels.get(one.figure, ""))]
        view = "" if one.view is None else f" {perspective(self._views.get(one.view) or one.view)}"
        return f"{self.called(one.figure)} {verb} {phrase} {self.called(one.reference)}{view}"
