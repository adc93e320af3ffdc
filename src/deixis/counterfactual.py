"""Counterfactuals: what would hold if things stood elsewhere, and how little changes an answer.

Things are moved, not turned. What is said of a moved thing is found by the same geometry and rules as ever:
by grounding the scene again, or for many places at once by asking of as many copies of the thing, none of
which knows of the others.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import ArrayLike

from deixis.boxes import NO_NORMAL, Boxes, align_with_world
from deixis.errors import GeometryError, QueryError, SceneError
from deixis.facts import Facts, ViewFacts
from deixis.frames import WORLD, Array, Index, Mask, bearing
from deixis.grounding import frame, measure_pairs, meets_halfspaces, view_facts
from deixis.hints import hint
from deixis.regions import shifted
from deixis.regrounding import reground
from deixis.scene import Scene
from deixis.strict_json import quoted
from deixis.things import SpatialObject

if TYPE_CHECKING:
    from deixis.ruleset import Indicator
    from deixis.ruleset.tables import Executor

Row = tuple[str, ...]

FURTHEST: Final = 3.0
"""Metres: a change further away than this is not looked for."""

_STEPS: Final = np.concatenate([np.arange(0.005, 0.5, 0.005), np.arange(0.5, FURTHEST + 1e-9, 0.02)])
"""Distances tried along each direction first."""

_FINEST: Final = 1.0e-4
"""Metres: a change is found to within this."""

_FINER: Final = 25
"""Steps that the interval in which an answer changes is divided into."""

_KEPT: Final = 4
"""Directions that are looked at more closely: those in which an answer changes first."""


@dataclass(frozen=True, slots=True)
class Change:
    """The smallest translation found of a thing that changes the answer to a question.

    Attributes
    ----------
    thing : str
        Id of what is moved.
    offset : (float, float, float)
        Metres, world frame.
    distance : float
        Metres.
    holds : bool
        What the answer is afterwards.
    """

    thing: str
    offset: tuple[float, float, float]
    distance: float
    holds: bool

    def to_dict(self) -> dict[str, object]:
        """Return the change as a dict, ready for JSON."""
        return {
            "move": self.thing, "offset": list(self.offset), "distance": self.distance, "holds": self.holds
        }  # fmt: skip


def moved(scene: Scene, offsets: Mapping[str, ArrayLike]) -> Scene:
    """Return a scene with some things moved by x, y, z metres, not turned.

    Raises
    ------
    SceneError
        There is no such object, or an offset is not three finite numbers.

    Examples
    --------
    >>> cup = {"id": "cup", "box": {"center": [0, 0, 1], "size": [0.1, 0.1, 0.1]}}
    >>> scene = Scene.from_dict({"deixis": 1, "id": "s", "objects": [cup], "views": []})
    >>> moved(scene, {"cup": (0, 0, -0.5)}).boxes.center.tolist()
    [[0.0, 0.0, 0.5]]
    """
    things = list(scene.objects)
    for thing in moved_things(scene, offsets):
        things[scene.index(thing.id)] = thing
    return replace(scene, objects=tuple(things))


def moved_things(scene: Scene, offsets: Mapping[str, ArrayLike]) -> tuple[SpatialObject, ...]:
    """Return things of a scene moved by x, y, z metres, not turned; raises as :func:`moved` does."""
    things = []
    for name, given in offsets.items():
        thing = scene.objects[scene.index(name)]
        try:
            numeric = np.asarray(given).dtype.kind in "iuf"
            offset = np.array(given, dtype=np.float64)
        except (TypeError, ValueError):
            numeric, offset = False, np.zeros(0)
        if not numeric or offset.shape != (3,) or not np.isfinite(offset).all():
            raise SceneError(f"the move of {quoted(name)} is not x, y, z in metres: give three numbers")
        things.append(replace(thing, region=shifted(thing.region, offset)))
    return tuple(things)


def named_fact(goal: str, known: Sequence[str], predicates: Callable[[str], Sequence[Indicator]]) -> Row:
    """Return a goal's predicate and arguments, all of them known names.

    Parameters
    ----------
    goal : str
        Such as ``on_top_of(cup, table)``.
    known : sequence of str
        Ids of things and views.
    predicates : callable
        From a name to the predicates it stands for; refuses other names.

    Raises
    ------
    QueryError
        It is not one predicate of known names.
    """
    from deixis.ruleset import read_text
    from deixis.ruleset.model import Constant

    file, problems = read_text(f"{goal.strip().removesuffix('.')} .", Path("goal"))
    args = [one for rule in file.rules for one in rule.head.args]
    names = [str(one.value) for one in args if isinstance(one, Constant) and one.kind != "number"]
    if problems or len(file.rules) != 1 or file.rules[0].body or len(names) != len(args):
        raise QueryError(f"{goal!r} is not one relation of named things, such as on_top_of(cup, table)")
    head = file.rules[0].head
    if head.predicate not in predicates(head.name):
        raise QueryError(f"{head.name} does not take {len(args)} arguments")
    for name in names:
        if name not in known:
            raise QueryError(f"nothing is called {name!r}{hint(name, known)}")
    return (head.name, *names)


def smallest_change(scene: Scene, facts: Facts, executor: Executor, goal: Row) -> Change | None:
    """Return the smallest translation found of a goal's figure that makes it true or, if it is, false.

    Tried are the directions of the world, of the boxes and views concerned, and of the contacts of the
    figure, so a smaller translation askew to all of them may exist. What is found is verified: after the
    move the answer is another, and at nine tenths of the way it is not yet.

    Parameters
    ----------
    scene : Scene
    facts : Facts
        Of the scene.
    executor : Executor
        Of the rules.
    goal : tuple of str
        A predicate's name, then its arguments: names all of them.

    Returns
    -------
    Change or None
        None where nothing within :data:`FURTHEST` changes the answer.

    Raises
    ------
    GeometryError
        The facts are not of boxes: too many places have to be tried.
    QueryError
        The goal's figure is a surface, or none of its arguments is a thing.
    """
    if facts.region != "box":
        raise GeometryError("the smallest change is looked for with boxes only: use the region model box")
    figure = _figure(scene, goal)
    asked = _Asked(scene, facts, executor, goal, figure)
    now = asked.here()
    ways = _ways(scene, facts, goal, figure)
    brackets = _first_changes(asked, ways, [_STEPS] * len(ways), now)
    while brackets and max(high - low for _, low, high in brackets) > _FINEST:
        nearest = sorted(brackets, key=lambda one: one[2])[:_KEPT]
        finer = [np.linspace(low, high, _FINER + 1)[1:] for _, low, high in nearest]
        brackets = _first_changes(asked, np.array([way for way, _, _ in nearest]), finer, now)
    for way, _, high in sorted(brackets, key=lambda one: one[2]):
        for distance in (high, high + _FINEST):
            offset = np.round(way * distance, 6)
            if asked.at(offset) != now and asked.at(0.9 * offset) == now:
                x, y, z = (float(one) + 0.0 for one in offset)
                return Change(figure, (x, y, z), float(np.linalg.norm(offset)), not now)
    return None


def _figure(scene: Scene, goal: Row) -> str:
    """Return the first thing that a goal speaks of."""
    ids = {thing.id: thing.kind for thing in scene.objects}
    things = [name for name in goal[1:] if name in ids]
    if not things:
        raise QueryError(f"none of {', '.join(map(quoted, goal[1:]))} is a thing of scene {quoted(scene.id)}")
    if ids[things[0]] == "surface":
        raise QueryError(f"{quoted(things[0])} is a surface, which nobody moves: ask about a thing")
    return things[0]


def _ways(scene: Scene, facts: Facts, goal: Row, figure: str) -> Array:
    """Return unit vectors worth trying, (d, 3): among them those that margins are measured along."""
    position = scene.index(figure)
    things = [scene.index(name) for name in goal[1:] if name in facts.ids]
    angles = [*np.arange(8) * 0.25 * np.pi]
    for index in things:
        angles += [float(scene.boxes.yaw[index]) + turn * 0.5 * np.pi for turn in range(4)]
        for view in scene.views:
            if view.id in goal:
                facing = float(bearing(view.position, scene.boxes.center[[index]])[0])
                angles += [facing + turn * 0.5 * np.pi for turn in range(4)]
    level = np.stack([np.cos(angles), np.sin(angles), np.zeros(len(angles))], axis=1)
    # Straight away from, or to, what it is in contact with and what is asked about.
    near = (facts.figure == position) & (
        (facts.distance <= facts.thresholds.granularity) | np.isin(facts.reference, things)
    )
    contact = facts.normal[near].astype(np.float64)
    ways = np.concatenate([[[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]], level, contact, -contact])
    ways = ways[np.linalg.norm(ways, axis=1) > 0.5]
    _, first = np.unique(np.round(ways, 6), axis=0, return_index=True)
    return np.asarray(ways[np.sort(first)])


def _first_changes(
    asked: _Asked, ways: Array, distances: Sequence[Array], now: bool
) -> list[tuple[Array, float, float]]:
    """Return ways along which the answer changes: each with the last distance before, and the first after."""
    offsets = np.concatenate([way * steps[:, None] for way, steps in zip(ways, distances, strict=True)])
    found = asked.many(offsets) != now
    changes, start = [], 0
    for way, steps in zip(ways, distances, strict=True):
        changed = np.flatnonzero(found[start : start + len(steps)])
        start += len(steps)
        if len(changed):
            at = int(changed[0])
            before = float(steps[at - 1]) if at else max(float(2.0 * steps[0] - steps[1]), 0.0)
            changes.append((way, before, float(steps[at])))
    return changes


class _Asked:
    """A question about one thing, to be asked for many places of it."""

    def __init__(self, scene: Scene, facts: Facts, executor: Executor, goal: Row, figure: str) -> None:
        self._scene, self._facts, self._executor = scene, facts, executor
        self._goal, self._figure = goal, figure
        self._predicate: Indicator = (goal[0], len(goal) - 1)
        self._labels = [(view.id, view.label) for view in scene.views]

    def here(self) -> bool:
        """Return the answer as things are."""
        return self._goal[1:] in self._rows(self._facts)

    def at(self, offset: Array) -> bool:
        """Return the answer after a move of (3,) metres, by grounding the scene again."""
        after = moved(self._scene, {self._figure: offset})
        return self._goal[1:] in self._rows(reground(self._scene, self._facts, after))

    def many(self, offsets: Array) -> Mask:
        """Return the answers after moves of (m, 3) metres, (m,), all at once."""
        facts, names = _with_copies(self._scene, self._facts, self._figure, offsets)
        rows = self._rows(facts)
        asked = (tuple(name if one == self._figure else one for one in self._goal[1:]) for name in names)
        return np.array([row in rows for row in asked], dtype=np.bool_)

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
