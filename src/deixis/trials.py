"""Trials: whether a relation would hold if one of its things stood elsewhere, for many places at once.

What is said of a moved thing is found by the same geometry and rules as ever: by asking of as many copies of
the thing as there are places, none of which knows of the others.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from deixis.boxes import NO_NORMAL, Boxes, align_with_world
from deixis.facts import Facts, ViewFacts
from deixis.frames import WORLD, Array, Index, Mask
from deixis.grounding import frame, measure_pairs, meets_halfspaces, view_facts
from deixis.regrounding import reground
from deixis.scene import Scene

if TYPE_CHECKING:
    from deixis.ruleset import Indicator
    from deixis.ruleset.tables import Executor

Row = tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Tried:
    """What was found of m places.

    Attributes
    ----------
    changed : (m,) bool
        The answer is another there.
    collides : (m,) bool
        The thing shares space there with something that it does not now.
    """

    changed: Mask
    collides: Mask

    @classmethod
    def nothing(cls) -> Tried:
        """Return what was found of no places."""
        return cls(np.zeros(0, dtype=np.bool_), np.zeros(0, dtype=np.bool_))

    def good(self, *, free: bool) -> Mask:
        """Return the places where the answer is another, of those without collisions or of all."""
        return self.changed & ~self.collides if free else self.changed


class Asked:
    """A question about one thing, to be asked for many places of it.

    Parameters
    ----------
    scene : Scene
    facts : Facts
        Of the scene, of boxes.
    executor : Executor
        Of the rules.
    goal : tuple of str
        A predicate's name, then its arguments: names all of them.
    figure : str
        Which of them is moved.
    """

    def __init__(self, scene: Scene, facts: Facts, executor: Executor, goal: Row, figure: str) -> None:
        self._scene, self._facts, self._executor = scene, facts, executor
        self._goal, self.figure = goal, figure
        self._predicate: Indicator = (goal[0], len(goal) - 1)
        self._labels = [(view.id, view.label) for view in scene.views]
        self._met = self._partners(facts)
        self.now = goal[1:] in self._rows(facts)

    def after(self, scene: Scene) -> tuple[bool, tuple[str, ...]]:
        """Return the answer in the scene with the thing moved, and what it shares new space with there."""
        facts = reground(self._scene, self._facts, scene)
        new = sorted(self._partners(facts) - self._met)
        return self._goal[1:] in self._rows(facts), tuple(facts.ids[index] for index in new)

    def many(self, offsets: Array) -> Tried:
        """Return the answers after moves of (m, 3) metres, all at once."""
        if not len(offsets):
            return Tried.nothing()
        facts, names = _with_copies(self._scene, self._facts, self.figure, offsets)
        rows = self._rows(facts)
        asked = (tuple(name if one == self.figure else one for one in self._goal[1:]) for name in names)
        holds = np.array([row in rows for row in asked], dtype=np.bool_)
        first = len(facts.ids) - len(names)
        copy, other = self._meets(facts, first, len(facts.ids))
        collides = np.zeros(len(names), dtype=np.bool_)
        collides[copy[~np.isin(other, list(self._met))] - first] = True
        return Tried(holds != self.now, collides)

    def _partners(self, facts: Facts) -> set[int]:
        position = self._scene.index(self.figure)
        return set(self._meets(facts, position, position + 1)[1].tolist())

    @staticmethod
    def _meets(facts: Facts, low: int, high: int) -> tuple[Index, Index]:
        """Return some things, and beside each what it shares space with (axiom 17)."""
        rows = np.flatnonzero(facts.separation < -facts.thresholds.penetration)
        rows = rows[(facts.figure[rows] >= low) & (facts.figure[rows] < high)]
        return facts.figure[rows], facts.reference[rows]

    def _rows(self, facts: Facts) -> set[Row]:
        tables = self._executor.run(facts, [self._predicate], view_labels=self._labels, margins=False)
        return {tuple(map(str, row)) for row in tables[self._predicate].rows()}


def _with_copies(scene: Scene, facts: Facts, figure: str, offsets: Array) -> tuple[Facts, list[str]]:
    """Return facts in which a thing is replaced by copies, each moved by one of (m, 3) metres, and their ids.

    A copy has facts with all other things but with no other copy.
    """
    boxes, limits, position = scene.boxes, facts.thresholds, scene.index(figure)
    n, m = len(boxes), len(offsets)
    every = np.concatenate([np.arange(n), np.full(m, position)])
    center = boxes.center[every]
    center[n:] += offsets
    crowd = Boxes(center, boxes.half[every], boxes.yaw[every], boxes.normal[every], boxes.ambiguous[every])
    others = np.delete(np.arange(n), position)
    copy, other = np.repeat(np.arange(n, n + m), len(others)), np.tile(others, m)
    kept = (facts.figure != position) & (facts.reference != position)
    keys = [facts.figure[kept].astype(np.int64) * (n + m) + facts.reference[kept]]
    keys += [copy * (n + m) + other, other * (n + m) + copy]
    rows = np.sort(np.concatenate(keys))
    mark = "~"
    while any(name.startswith(figure + mark) for name in facts.ids):
        mark += "~"
    names = [f"{figure}{mark}{number}" for number in range(m)]
    found = replace(
        facts,
        ids=(*facts.ids, *names),
        labels=(*facts.labels, *([facts.labels[position]] * m)),
        surface=crowd.normal != NO_NORMAL,
        volume=facts.volume[every],
        pairs=measure_pairs(crowd, rows // (n + m), rows % (n + m), limits),
        views=(),
        models=(*facts.models, *([facts.models[position]] * m)),
    )
    framed, tie = align_with_world(crowd)
    seen = [_seen(crowd, found, WORLD, framed, np.ones(n + m, dtype=np.bool_), tie)]
    seen += [_seen(crowd, found, view.id, *frame(crowd, view)) for view in scene.views]
    return replace(found, views=tuple(seen)), names


def _seen(crowd: Boxes, facts: Facts, name: str, framed: Boxes, seen: Mask, tie: Mask) -> ViewFacts:
    rows: Index = np.flatnonzero(facts.ordered & seen[facts.reference])
    return view_facts(name, crowd, rows, *meets_halfspaces(crowd, framed, facts, rows), seen, tie)
