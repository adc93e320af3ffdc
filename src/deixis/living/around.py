"""What is around a change: how many links each thing is from what changed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from deixis.facts import Facts
from deixis.frames import Index, Mask
from deixis.ruleset.extent import Extent, Ways


@dataclass(frozen=True, slots=True)
class Placed:
    """Facts, and the numbers of the names of their things, (n,)."""

    facts: Facts
    codes: Index


class Around:
    """How many links each thing is from what changed.

    Links are those of before and of now; between things that did not change they are the same.

    Parameters
    ----------
    before, after : Placed
    changed : (m,) int
        Numbers of the names of what changed.
    names : int
        How many names there are.
    """

    def __init__(self, before: Placed, after: Placed, changed: Index, names: int) -> None:
        self._names, self._count = names, len(after.codes)
        # Things of now by their positions, then those that are gone.
        place = np.full(names, -1, dtype=np.int64)
        place[after.codes] = np.arange(self._count)
        gone = before.codes[place[before.codes] < 0]
        place[gone] = self._count + np.arange(len(gone))
        self._codes = np.concatenate([after.codes, gone])
        here = place[before.codes]
        told = np.zeros(names, dtype=np.bool_)
        told[changed] = True
        old = told[before.codes]
        rows = np.flatnonzero(old[before.facts.figure] | old[before.facts.reference])
        # What was a surface and is none, or the other way round, has conclusions about it as a figure.
        surface = np.zeros(len(self._codes), dtype=np.bool_)
        surface[: self._count] = after.facts.surface
        surface[self._count :] = before.facts.surface[here >= self._count]
        surface[here] &= before.facts.surface
        self._surface = surface
        self._links = (
            np.concatenate([after.facts.figure, here[before.facts.figure[rows]]]),
            np.concatenate([after.facts.reference, here[before.facts.reference[rows]]]),
        )
        self._within = [told[self._codes]]
        self._by_name: dict[int, Mask] = {}
        # A rule may name what is not there.
        self._figure_by_name = self._named(~surface)

    def within(self, steps: int) -> Mask:
        """Return what is at most so many links from what changed."""
        while len(self._within) <= steps:
            self._within.append(_wider(self._within[-1], self._links))
        return np.asarray(self._within[steps])

    def touched(self, extent: Extent, args: Index) -> Mask:
        """Return which conclusions may rest on what changed, given the names of their arguments, (k, n)."""
        things = [args[place] for place in extent.things]
        found = np.zeros(args.shape[1], dtype=np.bool_)
        for ways in extent.looks:
            near = np.ones(args.shape[1], dtype=np.bool_)
            for codes, steps in zip(things, ways, strict=True):
                near &= self._near(steps)[codes]
            found |= near
        for at in extent.figures:
            found &= self._figure_by_name[things[at]]
        return found

    def region(self, extent: Extent) -> Mask:
        """Return what all such conclusions rest on, as far as it is there now."""
        found = np.zeros(len(self._codes), dtype=np.bool_)
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

    def _near(self, steps: int) -> Mask:
        if steps not in self._by_name:
            self._by_name[steps] = self._named(self.within(steps))
        return self._by_name[steps]

    def _named(self, mask: Mask) -> Mask:
        found = np.zeros(self._names, dtype=np.bool_)
        found[self._codes] = mask
        return found


def _wider(inside: Mask, links: tuple[Index, Index]) -> Mask:
    """Return what is inside, or one link away, whichever way it points."""
    figure, reference = links
    wider = inside.copy()
    wider[reference[inside[figure]]] = True
    wider[figure[inside[reference]]] = True
    return wider
