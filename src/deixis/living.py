"""Living scenes: relations kept while things move, come and go, at the cost of what can have changed.

What follows from a scene is derived once; after each change only conclusions about things near what changed
are drawn anew, from the facts near those (:mod:`deixis.ruleset.extent`). Rules that look at everything, by
recursion for instance, are run in full. The result is always that of a full run.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from deixis.facts import Facts
from deixis.frames import Index, Mask
from deixis.ruleset import Indicator, Ruleset
from deixis.ruleset.extent import VIEWS, Extent, Ways, extents
from deixis.ruleset.plan import Plan

if TYPE_CHECKING:
    from deixis.ruleset.tables import Executor

Row = tuple[str, ...]
Known = tuple[Indicator, Row]
"""A predicate and its arguments."""

Labels = Sequence[tuple[str, str]]

_MANY: Final = 2
"""With one in so many things changed, drawing all conclusions anew costs no more than finding which."""


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
        self._executor, self._facts, self._timeout = executor, facts, timeout
        known = extents(ruleset)
        self._extents: dict[Indicator, Extent] = {one: known[one] for one in wanted}
        plans = {one: Plan.of(ruleset, [one], margins=True) for one in wanted}
        self._viewed = {one for one, plan in plans.items() if any(node[0] in VIEWS for node in plan.needed)}
        self._near = [one for one in wanted if self._extents[one].bounded]
        self._far = [one for one in wanted if not self._extents[one].bounded]
        self._groups: dict[Extent, list[Indicator]] = {}
        for one in self._near:
            self._groups.setdefault(self._extents[one], []).append(one)
        self.holds: dict[Known, float] = {}
        self._about: dict[str, set[Known]] = {}
        self._note(self._derive(facts, labels, wanted))

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
        changed = set(things)
        before: dict[Known, float] = {}
        after: dict[Known, float] = {}
        whole = [*(self._far if changed or looked else ())]
        if _MANY * len(changed) >= len(facts.ids):
            whole += self._near
        elif looked:
            whole += [one for one in self._near if one in self._viewed]
        if whole:
            before |= {one: margin for one, margin in self.holds.items() if one[0] in whole}
            after |= self._derive(facts, labels, whole)
        if changed:
            around = _Around(self._facts, facts, changed)
            for extent, group in self._groups.items():
                some = [one for one in group if one not in whole]
                if some:
                    region = around.region(extent)
                    keys = {
                        one
                        for name in around.nearest(extent)
                        for one in self._about.get(name, ())
                        if one[0] in some and around.touches(extent, one[1])
                    }
                    before |= {one: self.holds[one] for one in keys}
                    found = self._derive(facts.among(region), labels, some)
                    after |= {one: margin for one, margin in found.items() if around.touches(extent, one[1])}
        self._facts = facts
        gained = {one: margin for one, margin in after.items() if one not in before}
        lost = {one: margin for one, margin in before.items() if one not in after}
        for one in lost:
            del self.holds[one]
            for name in self._names(one):
                self._about[name].discard(one)
        self._note(after)
        return Difference(gained, lost)

    def _derive(self, facts: Facts, labels: Labels, wanted: Sequence[Indicator]) -> dict[Known, float]:
        tables = self._executor.run(facts, wanted, view_labels=labels, timeout=self._timeout)
        return {
            (predicate, tuple(map(str, row))): margin
            for predicate, table in tables.items()
            for row, margin in table.named()
        }

    def _names(self, known: Known) -> set[str]:
        predicate, row = known
        return {row[place] for place in self._extents[predicate].things}

    def _note(self, found: dict[Known, float]) -> None:
        self.holds |= found
        for one in found:
            for name in self._names(one):
                self._about.setdefault(name, set()).add(one)


class _Around:
    """How many links each thing is from what changed.

    Links are those of before and of now; between things that did not change they are the same.

    Parameters
    ----------
    before, after : Facts
    changed : set of str
        Ids of things.
    """

    def __init__(self, before: Facts, after: Facts, changed: set[str]) -> None:
        positions = {name: at for at, name in enumerate(after.ids)}
        gone = [at for at, name in enumerate(before.ids) if name not in positions]
        positions |= {before.ids[old]: len(after.ids) + at for at, old in enumerate(gone)}
        here = np.array([positions[name] for name in before.ids], dtype=np.int64)
        old = np.array([name in changed for name in before.ids], dtype=np.bool_)
        rows = np.flatnonzero(old[before.figure] | old[before.reference])
        self._count = len(after.ids)
        self._positions = positions
        self._names = [*after.ids, *(before.ids[at] for at in gone)]
        # What was a surface and is none, or the other way round, has conclusions about it as a figure.
        surface = np.concatenate([after.surface, before.surface[gone]])
        surface[here] &= before.surface
        self._surface = surface
        self._links = (
            np.concatenate([after.figure, here[before.figure[rows]]]),
            np.concatenate([after.reference, here[before.reference[rows]]]),
        )
        start = np.zeros(len(positions), dtype=np.bool_)
        start[[positions[name] for name in changed if name in positions]] = True
        self._within = [start]

    def within(self, steps: int) -> Mask:
        """Return what is at most so many links from what changed."""
        while len(self._within) <= steps:
            self._within.append(_wider(self._within[-1], self._links))
        return self._within[steps]

    def touches(self, extent: Extent, row: Row) -> bool:
        """Return whether a conclusion may rest on what changed."""
        names = [row[place] for place in extent.things]
        if not all(name in self._positions for name in names):
            return False  # written in a rule file, of something that is not there
        at = [self._positions[name] for name in names]
        if any(self._surface[at[figure]] for figure in extent.figures):
            return False
        return any(
            all(self.within(steps)[place] for place, steps in zip(at, ways, strict=True))
            for ways in extent.looks
        )

    def nearest(self, extent: Extent) -> set[str]:
        """Return things of which each conclusion that may rest on what changed names one."""
        found = np.zeros(len(self._names), dtype=np.bool_)
        for ways in extent.looks:
            found |= self._start(extent, ways)[0]
        return {self._names[at] for at in np.flatnonzero(found).tolist()}

    def region(self, extent: Extent) -> Mask:
        """Return what all such conclusions rest on, as far as it is there now."""
        found = np.zeros(len(self._names), dtype=np.bool_)
        for ways in extent.looks:
            some, at = self._start(extent, ways)
            for _ in range(max(extent.span, *(other[at] for other in extent.looks))):
                some = _wider(some, self._links)
            found |= some
        return found[: self._count]

    def _start(self, extent: Extent, ways: Ways) -> tuple[Mask, int]:
        """Return which things may be the one named that is nearest to what changed, and which one that is."""
        at = min(range(len(ways)), key=lambda one: (ways[one], one not in extent.figures))
        some = self.within(ways[at])
        return (some & ~self._surface if at in extent.figures else some), at


def _wider(inside: Mask, links: tuple[Index, Index]) -> Mask:
    """Return what is inside, or one link away, whichever way it points."""
    figure, reference = links
    wider = inside.copy()
    wider[reference[inside[figure]]] = True
    wider[figure[inside[reference]]] = True
    return wider
