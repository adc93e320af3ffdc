"""Living: what follows from a scene, kept up while it changes.

What follows is derived once; after each change only conclusions about things near what changed are drawn
anew, from the facts near those (:mod:`deixis.ruleset.extent`). Rules that look at everything, by recursion
for instance, are run in full. The result is always that of a full run.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from deixis.facts import Facts
from deixis.frames import Mask
from deixis.living.around import Around, Placed
from deixis.living.kept import NONE, Kept, Known, Names
from deixis.ruleset import Indicator, Ruleset
from deixis.ruleset.extent import VIEWS, Extent, extents
from deixis.ruleset.plan import Plan

if TYPE_CHECKING:
    from deixis.ruleset.tables import Executor

Labels = Sequence[tuple[str, str]]

_SPARE: Final = 1_024
"""Names that are not used any more, beyond as many as there are things, before they are forgotten."""

_MANY: Final = 2
"""With one in so many things changed, drawing all conclusions anew costs no more than finding which."""

_WIDE: Final = 4
"""What looks at more than one in so many things is not looked at together with what does not."""


@dataclass(frozen=True, slots=True)
class Difference:
    """What a change made hold, and what it made hold no more, each with its margin."""

    gained: dict[Known, float]
    lost: dict[Known, float]


class Living:
    """What follows from a scene that changes.

    Parameters
    ----------
    ruleset : Ruleset
    executor : Executor
        Derives; asked for few facts mostly.
    wanted : sequence of Indicator
        What to keep; names for arguments.
    facts : Facts
    labels : sequence of (str, str)
        Id and label of each view.
    timeout : float
        Seconds that each derivation may take; one that takes longer leaves all as it was.
    """

    def __init__(
        self,
        ruleset: Ruleset,
        executor: Executor,
        wanted: Sequence[Indicator],
        facts: Facts,
        labels: Labels,
        *,
        timeout: float = 60.0,
    ) -> None:
        self._executor, self._timeout = executor, timeout
        self._wanted = tuple(dict.fromkeys(wanted))
        self._order = {one: at for at, one in enumerate(self._wanted)}
        known = extents(ruleset)
        plan = Plan.of(ruleset, self._wanted, margins=True)
        self._viewed = {one for one in self._wanted if not VIEWS.isdisjoint(plan.rests_on(one))}
        # What looks as far as another is kept together with it; what looks at everything, in the last group.
        self._groups: list[Extent | None] = [
            *dict.fromkeys(known[one] for one in self._wanted if known[one].bounded),
            None,
        ]
        group = [self._groups.index(known[one] if known[one].bounded else None) for one in self._wanted]
        self._group = np.array(group, dtype=np.int64)
        # What is all written in rule files never changes.
        self._looking = np.array(
            [not known[one].bounded or bool(known[one].looks) for one in self._wanted], dtype=np.bool_
        )
        self._names = Names()
        self._now = Placed(facts, self._names.of(facts.ids))
        every = np.ones(len(self._wanted), dtype=np.bool_)
        self._kept = self._split(self._derive(self._now, labels, every))

    @property
    def wanted(self) -> tuple[Indicator, ...]:
        """Return the predicates that are kept."""
        return self._wanted

    @property
    def holds(self) -> dict[Known, float]:
        """Return all that holds, with its margins."""
        texts = self._names.texts
        return dict(one for kept in self._kept for one in kept.named(self._wanted, texts))

    def advance(self, facts: Facts, labels: Labels, things: Iterable[str], *, looked: bool) -> Difference:
        """Take over the facts of the changed scene; return what now holds and did not, and the reverse.

        Parameters
        ----------
        facts : Facts
            Of the scene as it is now.
        labels : sequence of (str, str)
            Id and label of each view.
        things : iterable of str
            Ids of all that moved, came, went, or is called otherwise.
        looked : bool
            Whether a view came, went, moved, or is called otherwise.
        """
        changed = self._names.of(things)
        same = facts.ids == self._now.facts.ids
        now = Placed(facts, self._now.codes if same else self._names.of(facts.ids))
        whole = np.array([self._anew(one, len(changed) > 0, looked) for one in self._wanted], dtype=np.bool_)
        if _MANY * len(changed) >= len(facts.ids):
            whole |= self._looking
        found = self._derive(now, labels, whole)
        dropped = [whole[kept.predicate] for kept in self._kept]
        if len(changed) and (self._looking & ~whole).any():
            nearby = Around(self._now, now, changed, len(self._names))
            found = found.joined(self._nearby(nearby, now, labels, ~whole & self._looking))
            for at, (kept, extent) in enumerate(zip(self._kept, self._groups, strict=True)):
                if extent is not None:
                    dropped[at] = dropped[at] | nearby.touched(extent, kept.args)
        return self._taken_over(now, found, dropped)

    def _anew(self, one: Indicator, changed: bool, looked: bool) -> bool:
        """Return whether all conclusions of a predicate are drawn anew."""
        far = self._groups[self._group[self._order[one]]] is None
        return (looked and one in self._viewed) or (changed and far)

    def _nearby(self, nearby: Around, now: Placed, labels: Labels, wanted: Mask) -> Kept:
        """Return the conclusions of some predicates that may rest on what changed."""
        found = Kept.empty(self._order)
        for groups, region in self._regions(nearby, wanted):
            some = wanted & np.isin(self._group, list(groups))
            drawn = self._derive(Placed(now.facts.among(region), now.codes[region]), labels, some)
            group = self._group[drawn.predicate]
            for at, extent in groups.items():
                rows = np.flatnonzero(group == at)
                touched = nearby.touched(extent, drawn.args[:, rows])
                found = found.joined(drawn.at(rows[touched]))
        return found

    def _regions(self, nearby: Around, wanted: Mask) -> list[tuple[dict[int, Extent], Mask]]:
        """Return which groups are looked at together, each with the things that their conclusions rest on.

        To run all rules over one region costs less than to run some of them over each; but not where what
        touches a floor, which is everything, has to be looked at for some.
        """
        found: dict[bool, tuple[dict[int, Extent], Mask]] = {}
        for at in np.unique(self._group[wanted]).tolist():
            extent = self._groups[at]
            if extent is not None:
                region = nearby.region(extent)
                wide = _WIDE * int(region.sum()) > len(region)
                groups, known = found.setdefault(wide, ({}, np.zeros_like(region)))
                groups[at] = extent
                known |= region
        return list(found.values())

    def _derive(self, now: Placed, labels: Labels, wanted: Mask) -> Kept:
        some = [one for one, asked in zip(self._wanted, wanted.tolist(), strict=True) if asked]
        if not some:
            return Kept.empty(self._order)
        tables = self._executor.run(now.facts, some, view_labels=labels, timeout=self._timeout)
        to = tables[some[0]].symbols.translated(now.codes, self._names.of)
        return Kept.of(tables, self._order, to)

    def _taken_over(self, now: Placed, found: Kept, dropped: Sequence[Mask]) -> Difference:
        """Put what was found in the place of what is dropped."""
        names = len(self._names)
        every: list[Kept] = []
        gained: dict[Known, float] = {}
        lost: dict[Known, float] = {}
        for kept, after, drop in zip(self._kept, self._split(found), dropped, strict=True):
            before = kept.at(np.flatnonzero(drop))
            new, old = after.without(before, names)
            gained |= new.named(self._wanted, self._names.texts)
            lost |= old.named(self._wanted, self._names.texts)
            changed = len(before) > 0 or len(after) > 0
            every.append(kept.at(np.flatnonzero(~drop)).joined(after) if changed else kept)
        self._kept, self._now = every, now
        if len(self._names) > 2 * len(now.codes) + _SPARE:
            self._forget()
        return Difference(gained, lost)

    def _split(self, found: Kept) -> list[Kept]:
        group = self._group[found.predicate]
        return [found.at(np.flatnonzero(group == at)) for at in range(len(self._groups))]

    def _forget(self) -> None:
        """Give up the names of what is not there any more."""
        used = np.unique(np.concatenate([self._now.codes, *(kept.args.ravel() for kept in self._kept)]))
        used = used[used != NONE]
        # The last place is for NONE.
        to = np.full(len(self._names) + 1, NONE, dtype=np.int64)
        to[used] = np.arange(len(used))
        texts, self._names = self._names.texts, Names()
        self._names.of(texts[code] for code in used.tolist())
        self._now = Placed(self._now.facts, to[self._now.codes])
        self._kept = [Kept(kept.predicate, to[kept.args], kept.margin) for kept in self._kept]
