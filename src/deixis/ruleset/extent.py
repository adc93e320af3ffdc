"""How far from a thing a conclusion about it looks: what may change when that thing does.

Measured pairs link things that are near each other. A conclusion rests on facts about the things it names and
about others that are linked with them, one to the next; the number of links is a property of the rules. So
when a thing moves, only conclusions about things so many links away from it can change, and to draw them anew
only facts so many links further need be looked at (decision 0051).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import permutations, product
from operator import le
from typing import Final

from deixis.ruleset.base import BASE_FACTS
from deixis.ruleset.checking import Ruleset
from deixis.ruleset.model import Atom, Constant, Indicator, Negation, Rule, atoms

THINGS: Final[Mapping[Indicator, tuple[int, ...]]] = {
    ("spatial_obj", 1): (0,),
    ("surface", 1): (0,),
    ("label", 3): (0,),
    ("measured_as", 2): (0,),
    ("figure_reference", 2): (0, 1),
    ("pair", 9): (0, 1),
    ("aspect", 7): (1, 2),
    ("strict", 5): (0, 1),
    ("withheld", 3): (0,),
}
"""Arguments of base facts that are things; where there are two the things are linked."""

ORDERED: Final = frozenset({("figure_reference", 2), ("aspect", 7)})
"""Base facts that stand for pairs in figure-reference order only."""

VIEWS: Final = frozenset({("viewpoint", 1), ("view_label", 2), ("aspect", 7), ("strict", 5), ("withheld", 3)})
"""Base facts that a new pose of a view changes."""

FAR: Final = 1 << 20
"""More links than there are."""

Ways = tuple[int, ...]
"""How far something that a conclusion rests on is from each thing that the conclusion names, in links."""


@dataclass(frozen=True, slots=True)
class Extent:
    """How far a conclusion looks.

    Attributes
    ----------
    things : tuple of int
        The arguments that are things.
    looks : frozenset of Ways
        Of all it rests on, what is furthest away.
    figures : frozenset of int
        Which of ``things``, counted from 0, are figures and so never surfaces, which are near everything.
    span : int
        The things it names are at most so many links from each other.
    bounded : bool
        Whether it looks no further than some number of links.
    """

    things: tuple[int, ...] = ()
    looks: frozenset[Ways] = frozenset()
    figures: frozenset[int] = frozenset()
    span: int = 0
    bounded: bool = True


def extents(ruleset: Ruleset) -> dict[Indicator, Extent]:
    """Return how far conclusions of each predicate look.

    Examples
    --------
    >>> from deixis._files import datalog_files
    >>> from deixis.ruleset.checking import load
    >>> found = extents(load(datalog_files()))
    >>> sorted(found["on_top_of", 2].looks), sorted(found["affixed_on", 2].looks)
    ([(0, 1), (1, 0)], [(1, 2)])
    """
    found = {one: _base(one) for one in BASE_FACTS}
    recursive = ruleset.graph.recursive
    for component in ruleset.graph.components:
        for predicate in sorted(component - BASE_FACTS.keys()):
            rules = ruleset.by_head.get(predicate, ())
            if predicate not in recursive:
                found[predicate] = _joined(rules, found)
                continue
            below = [found[one] for one in _below(ruleset, component) if one not in component]
            # Recursion over what is written in files looks at nothing that was measured.
            rests = any(one.looks or not one.bounded for one in below)
            found[predicate] = Extent(bounded=not rests)
    return found


def _base(predicate: Indicator) -> Extent:
    things = THINGS.get(predicate, ())
    looks = frozenset(tuple(int(at != other) for other in range(len(things))) for at in range(len(things)))
    figures = frozenset({0} if predicate in ORDERED else ())
    return Extent(things, looks if things else frozenset(), figures, int(len(things) > 1))


def _below(ruleset: Ruleset, component: Iterable[Indicator]) -> Iterator[Indicator]:
    for predicate in component:
        for rule in ruleset.by_head.get(predicate, ()):
            yield from (atom.predicate for atom, _ in atoms(rule.body))


def _joined(rules: Sequence[Rule], found: Mapping[Indicator, Extent]) -> Extent:
    """Return the widest extent of some rules with one head, which is in none of their bodies."""
    every = [_Reach(rule, found) for rule in rules if rule.body]
    things = tuple(sorted({place for one in every for place in one.places}))
    looks: set[Ways] = set()
    bounded, span = True, 0
    for one in every:
        measured = one.looks(things)
        if measured is None:
            bounded = False
        else:
            looks |= measured
            span = max(span, one.span(things))
    if len(things) > 1 and len(every) < len(rules):
        bounded = False  # what is written in a file links any two
    if not bounded:
        return Extent(things, bounded=False)
    figures = frozenset.intersection(*(one.figures(things) for one in every)) if every else frozenset()
    return Extent(things, frozenset(outermost(looks)), figures, span)


def outermost(looks: Iterable[Ways]) -> Iterator[Ways]:
    """Yield those that are not everywhere as near as another."""
    every = set(looks)
    for one in every:
        if not any(one != other and all(map(le, one, other)) for other in every):
            yield one


class _Reach:
    """The things of one rule, and how many links are between them."""

    def __init__(self, rule: Rule, found: Mapping[Indicator, Extent]) -> None:
        self._head = rule.head
        self._stated = [(goal, found[goal.predicate]) for goal in rule.body if isinstance(goal, Atom)]
        denials = [goal for goal in rule.body if isinstance(goal, Negation)]
        self._denied = [
            [(atom, found[atom.predicate]) for atom in goal.goals if isinstance(atom, Atom)]
            for goal in denials
        ]
        every = [*self._stated, *(used for denied in self._denied for used in denied)]
        self._no_surfaces = {
            called(only.args[0])
            for goal in denials
            for only in goal.goals
            if len(goal.goals) == 1 and isinstance(only, Atom) and only.predicate == ("surface", 1)
        }
        self._bounded = all(extent.bounded for _, extent in every)
        self._links = _links(self._stated)
        named = {name for atom, extent in self._stated for name in named_in(atom, extent.things)}
        self.places = [place for place, value in enumerate(rule.head.args) if called(value) in named]

    def looks(self, things: Sequence[int]) -> set[Ways] | None:
        """Return what the rule looks at, from the things its head names; None where that has no bound."""
        if not self._bounded:
            return None
        heads = [called(self._head.args[place]) for place in things]
        found: set[Ways] = set()
        # What is denied matters only where it is there, and then what it names is linked by it too.
        for part in ([], *self._denied):
            links = _links([*self._stated, *part])
            for atom, extent in part or self._stated:
                named = list(named_in(atom, extent.things))
                for ways in extent.looks:
                    steps = [
                        min(links.get((head, name), FAR) + way for name, way in zip(named, ways, strict=True))
                        for head in heads
                    ]
                    if not heads or max(steps) >= FAR:
                        return None  # linked with none of what the head names
                    found.add(tuple(steps))
        return found

    def figures(self, things: Sequence[int]) -> frozenset[int]:
        """Return which of the things that the head names are figures."""
        known = {
            called(atom.args[extent.things[at]]) for atom, extent in self._stated for at in extent.figures
        } | self._no_surfaces
        return frozenset(at for at, place in enumerate(things) if called(self._head.args[place]) in known)

    def span(self, things: Sequence[int]) -> int:
        """Return how far the things that the head names are from each other."""
        heads = [called(self._head.args[place]) for place in things]
        return max((self._links.get((one, two), FAR) for one in heads for two in heads), default=0)


def _links(used: Sequence[tuple[Atom, Extent]]) -> dict[tuple[str, str], int]:
    """Return how many links are at most between the things that some atoms name, where they all hold."""
    names = sorted({name for atom, extent in used for name in named_in(atom, extent.things)})
    found = {(one, two): 0 if one == two else FAR for one in names for two in names}
    for atom, extent in used:
        for one, two in permutations(named_in(atom, extent.things), 2):
            if one != two:
                found[one, two] = min(found[one, two], extent.span)
    for by, one, two in product(names, repeat=3):
        found[one, two] = min(found[one, two], found[one, by] + found[by, two])
    return found


def named_in(atom: Atom, places: Iterable[int]) -> Iterator[str]:
    """Yield what stands at some places of an atom."""
    return (called(atom.args[place]) for place in places)


def called(value: object) -> str:
    """Return what a thing is called within a rule: a constant is not a variable of the same name."""
    return f"'{value.value}'" if isinstance(value, Constant) else str(getattr(value, "name", ""))
