"""Counterfactuals: what would hold if things stood elsewhere, and how little changes an answer.

Things are moved, not turned. What is found by trying many places at once is verified by grounding the scene
again.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import ArrayLike

from deixis.errors import GeometryError, QueryError, SceneError
from deixis.facts import Facts
from deixis.frames import Array, Mask, bearing
from deixis.hints import hint
from deixis.placements import placements
from deixis.regions import shifted
from deixis.scene import Scene
from deixis.strict_json import quoted
from deixis.things import SpatialObject
from deixis.trials import Asked, Row, Tried

if TYPE_CHECKING:
    from deixis.ruleset import Indicator, Ruleset
    from deixis.ruleset.tables import Executor

Bracket = tuple[Array, float, float]
"""A unit vector, a distance along it at which the answer is as it was, and one at which it is another."""

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

_ALONG: Final = 100
"""Places looked at on the way to where moves along several axes lead."""

_ASIDE: Final = np.append(0.32 * 0.5 ** np.arange(11), _FINEST)
"""Metres around such a place at which one that is nearer is looked for."""

_WAYS: Final = 120
"""Random directions in which it is."""

_WORTH: Final = 0.999
"""Times the length of a move that a shorter one has at most."""

_CLEARLY: Final = 0.98
"""Times the length of a move along one line that another is, at most, where it is preferred."""

_ROUNDS: Final = 40
"""Times that a nearer one is looked for, at most."""


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
    collides : tuple of str
        Ids of the things that it would share space with, and does not now.
    """

    thing: str
    offset: tuple[float, float, float]
    distance: float
    holds: bool
    collides: tuple[str, ...] = ()

    def to_dict(self) -> dict[str, object]:
        """Return the change as a dict, ready for JSON."""
        return {
            "move": self.thing, "offset": list(self.offset), "distance": self.distance, "holds": self.holds,
            "collides": list(self.collides),
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
        except (TypeError, ValueError, OverflowError):
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


def names_in_rules(ruleset: Ruleset, predicate: Indicator) -> frozenset[str]:
    """Return the names in those rules of one's own that a predicate rests on."""
    from deixis.ruleset.model import Comparison, Constant, atoms

    found: set[str] = set()
    for one in ruleset.graph.needed([predicate]) & ruleset.user:
        for rule in ruleset.by_head.get(one, ()):
            goals = [inner for goal in rule.body for inner in getattr(goal, "goals", (goal,))]
            compared = [
                side for goal in goals if isinstance(goal, Comparison) for side in (goal.left, goal.right)
            ]
            named = [rule.head, *(atom for atom, _ in atoms(rule.body))]
            values = [*compared, *(value for atom in named for value in atom.args)]
            found |= {str(value.value) for value in values if isinstance(value, Constant)}
    return frozenset(found)


def smallest_change(
    scene: Scene, facts: Facts, executor: Executor, goal: Row, named: Collection[str] = ()
) -> Change | None:
    """Return the smallest translation found of a goal's figure that makes it true or, if it is, false.

    Tried are the directions of the world, of the boxes and views concerned, and of the contacts of the
    figure; and, to make it true, the moves that place the figure on, under, beside, within or near what else
    is asked about, made as short as can be. So a smaller translation askew to all of them may exist. A move
    after which the figure shares space with what it does not now is the last resort, and says so (decision
    0058). What is found is verified: after the move the answer is another, and at nine tenths of the way it
    is not yet.

    Parameters
    ----------
    scene : Scene
    facts : Facts
        Of the scene.
    executor : Executor
        Of the rules.
    goal : tuple of str
        A predicate's name, then its arguments: names all of them.
    named : collection of str
        What the rules name: what they say of a thing by its name they do not say of its copies.

    Returns
    -------
    Change or None
        None where nothing within :data:`FURTHEST` changes the answer.

    Raises
    ------
    GeometryError
        The facts are not of boxes: too many places have to be tried.
    QueryError
        The goal's figure is a surface, none of its arguments is a thing, or nothing is found and rules name
        the figure.
    """
    if facts.region != "box":
        raise GeometryError("the smallest change is looked for with boxes only: use the region model box")
    figure = _figure(scene, goal)
    asked = Asked(scene, facts, executor, goal, figure)
    lines = _Lines.of(_ways(scene, facts, goal, figure), _STEPS)
    tried = asked.many(lines.offsets)
    moves, composed = np.empty((0, 3)), Tried.nothing()
    if not asked.now:
        others = [scene.index(name) for name in goal[1:] if name in facts.ids and name != figure]
        moves = placements(
            scene.boxes, scene.index(figure), np.array(others, int), scene.thresholds, FURTHEST
        )
        composed = asked.many(moves)
    for free in (True, False):
        straight = _found(scene, asked, lines.brackets(tried.good(free=free)), free=free)
        start = np.flatnonzero(composed.good(free=free))
        askew = None
        if len(start):
            askew = _found(scene, asked, _shortened(asked, moves[start[0]], free=free), free=free)
        # One along an axis is easier to follow than one that is hardly shorter.
        if askew is not None and (straight is None or askew.distance < _CLEARLY * straight.distance):
            return askew
        if straight is not None:
            return straight
    if figure in named:
        raise QueryError(
            f"nothing was found, but rules name {quoted(figure)}, and what they say of it by its name was "
            "not tried elsewhere: try places with what-if"
        )
    return None


def _shortened(asked: Asked, offset: Array, *, free: bool) -> list[Bracket]:
    """Return where, on the way to a shorter move that changes the answer too, it first does."""
    rng = np.random.default_rng(0)
    for _ in range(_ROUNDS):
        ways = rng.normal(size=(_WAYS, 3))
        ways = np.concatenate([np.eye(3), -np.eye(3), ways / np.linalg.norm(ways, axis=1, keepdims=True)])
        near = (offset + _ASIDE[:, None, None] * ways).reshape(-1, 3)
        length = np.linalg.norm(near, axis=1)
        near = near[np.argsort(length, kind="stable")]
        near = near[: np.count_nonzero(length < _WORTH * np.linalg.norm(offset) - _FINEST)]
        good = np.flatnonzero(asked.many(near).good(free=free))
        if not len(good):
            break
        offset = near[good[0]]
    distance = float(np.linalg.norm(offset))
    lines = _Lines.of(offset[None] / distance, np.linspace(0.0, distance, _ALONG + 1)[1:])
    return lines.brackets(asked.many(lines.offsets).good(free=free))


def _found(scene: Scene, asked: Asked, brackets: list[Bracket], *, free: bool) -> Change | None:
    """Return the nearest change within some brackets that grounding the scene again confirms."""
    while brackets and max(high - low for _, low, high in brackets) > _FINEST:
        nearest = sorted(brackets, key=lambda one: one[2])[:_KEPT]
        finer = [np.linspace(low, high, _FINER + 1)[1:] for _, low, high in nearest]
        lines = _Lines(np.array([way for way, _, _ in nearest]), np.array(finer))
        brackets = lines.brackets(asked.many(lines.offsets).good(free=free))
    for way, _, high in sorted(brackets, key=lambda one: one[2]):
        for distance in (high, high + _FINEST):
            offset = np.round(way * distance, 6)
            holds, collides = asked.after(moved(scene, {asked.figure: offset}))
            if holds == asked.now or (free and collides):
                continue
            if asked.after(moved(scene, {asked.figure: 0.9 * offset}))[0] == asked.now:
                x, y, z = (float(one) + 0.0 for one in offset)
                return Change(asked.figure, (x, y, z), float(np.linalg.norm(offset)), holds, collides)
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


@dataclass(frozen=True, slots=True)
class _Lines:
    """Places along d lines, (d, m) metres from where a thing stands, and the unit vectors of these lines."""

    ways: Array
    steps: Array

    @classmethod
    def of(cls, ways: Array, steps: Array) -> _Lines:
        """Return lines with the same steps along each."""
        return cls(ways, np.broadcast_to(steps, (len(ways), len(steps))))

    @property
    def offsets(self) -> Array:
        """Return all the places, (d * m, 3)."""
        return (self.ways[:, None] * self.steps[:, :, None]).reshape(-1, 3)

    def brackets(self, good: Mask) -> list[Bracket]:
        """Return the lines with a good place: each with the last distance before it, and its own."""
        found = good.reshape(self.steps.shape)
        result = []
        for way, steps, line in zip(self.ways, self.steps, found, strict=True):
            if line.any():
                at = int(line.argmax())
                before = float(steps[at - 1]) if at else max(float(2.0 * steps[0] - steps[1]), 0.0)
                result.append((way, before, float(steps[at])))
        return result
