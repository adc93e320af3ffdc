"""In whose neighbourhood a conclusion can be drawn: that of one of the things it names, its owner.

A map is cut into tiles, and each conclusion is drawn in the tile of its owner, from the facts of that tile
and so many links around it. Links lead from one thing to another that is near, but a surface is near
everything: a way that goes on from one has no bound in metres (decision 0055). So the links counted here,
unlike those of :mod:`deixis.ruleset.extent`, lead from thing to thing, and to a surface only at the end.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import chain, combinations, permutations, product
from typing import Final

from deixis.ruleset.base import BASE_FACTS
from deixis.ruleset.checking import Ruleset
from deixis.ruleset.extent import FAR, ORDERED, THINGS, Ways, called, named_in, outermost
from deixis.ruleset.model import Atom, Indicator, Negation, Rule, atoms

_MOST_THINGS: Final = 6
"""With more things in a conclusion nobody is sought to own it: the cases are two to the power of that."""

Case = frozenset[int]
"""Which of the things that a conclusion names are surfaces, counted from 0."""


_LooksIn = Callable[[Case], Iterable[Ways]]
"""What is looked at in a case."""


@dataclass(frozen=True, slots=True)
class Ownership:
    """Who owns the conclusions of a predicate.

    Attributes
    ----------
    things : tuple of int
        The arguments that are things.
    owners : mapping
        In each case the owner, counted from 0 among ``things``. A case that is not here does not occur.
    links : int
        So many links away from its owner lies at most what a conclusion rests on, surfaces apart.
    """

    things: tuple[int, ...]
    owners: Mapping[Case, int]
    links: int


@dataclass(frozen=True, slots=True)
class _Near:
    """How far conclusions of a predicate look, as :class:`deixis.ruleset.extent.Extent`, by such links.

    ``apart`` has the links between any two of the things; ``there`` says that all it names are things there.
    """

    things: tuple[int, ...] = ()
    looks: frozenset[Ways] = frozenset()
    figures: frozenset[int] = frozenset()
    apart: Mapping[tuple[int, int], int] | None = None
    bounded: bool = True
    there: bool = True


def ownerships(ruleset: Ruleset) -> dict[Indicator, Ownership]:
    """Return who owns conclusions, for those predicates whose conclusions all have an owner.

    Of the others conclusions rest on what may be anywhere: by recursion, by a common label, by what is
    written in a file, or by way of a surface that both touch.

    Examples
    --------
    >>> from deixis._files import datalog_files
    >>> from deixis.ruleset.checking import load
    >>> found = ownerships(load(datalog_files()))
    >>> found["affixed_on", 2].links, dict(found["affixed_on", 2].owners)[frozenset()]
    (1, 0)
    """
    near: dict[Indicator, _Near] = {one: _base(one) for one in BASE_FACTS}
    found: dict[Indicator, Ownership] = {}
    for one in BASE_FACTS:
        owned = _owned(near[one], partial(_base_looks, near[one]))
        if owned is not None:
            found[one] = owned
    recursive = ruleset.graph.recursive
    for component in ruleset.graph.components:
        for predicate in sorted(component - BASE_FACTS.keys()):
            rules = ruleset.by_head.get(predicate, ())
            if predicate in recursive:
                below = {one for member in component for one in _below(ruleset, member)} - component
                rests = any(near[one].looks or not near[one].bounded for one in below)
                near[predicate] = _Near(bounded=not rests)
                continue
            ways = [_Ways(rule, near) for rule in rules if rule.body]
            near[predicate] = summary = _joined(ways, len(ways) < len(rules))
            if summary.bounded and summary.things and summary.there:
                owned = _owned(summary, partial(_looks, ways, summary.things))
                if owned is not None:
                    found[predicate] = owned
    return found


def _base(predicate: Indicator) -> _Near:
    things = THINGS.get(predicate, ())
    count = range(len(things))
    looks = frozenset(tuple(int(at != other) for other in count) for at in count)
    return _Near(
        things,
        looks if things else frozenset(),
        frozenset({0} if predicate in ORDERED else ()),
        {(one, two): int(one != two) for one in count for two in count},
    )


def _base_looks(near: _Near, case: Case) -> Iterator[Ways]:
    if not case & near.figures:
        yield from near.looks


def _below(ruleset: Ruleset, predicate: Indicator) -> Iterator[Indicator]:
    for rule in ruleset.by_head.get(predicate, ()):
        yield from (atom.predicate for atom, _ in atoms(rule.body))


def _joined(ways: Sequence[_Ways], written: bool) -> _Near:
    """Return the widest of some rules with one head; ``written`` says that facts in a file have it too."""
    things = tuple(sorted({place for one in ways for place in one.places}))
    if not all(one.bounded for one in ways) or (written and len(things) > 1):
        return _Near(things, bounded=False)
    if ways and not things and any(one.measured for one in ways):
        return _Near(bounded=False)  # it looks at things and names none
    figures = [one.figures(things) for one in ways]
    apart: dict[tuple[int, int], int] = {}
    for one in ways:
        for pair, links in one.apart(things).items():
            apart[pair] = max(apart.get(pair, 0), links)
    return _Near(
        things,
        frozenset(outermost(_looks(ways, things, None))),
        frozenset.intersection(*figures) if figures else frozenset(),
        apart,
        there=not (written and things) and all(one.there(things) for one in ways),
    )


def _looks(ways: Sequence[_Ways], things: Sequence[int], case: Case | None) -> set[Ways]:
    return {look for one in ways for look in one.looks(things, case)}


def _owned(near: _Near, looks_in: _LooksIn) -> Ownership | None:
    """Return who owns the conclusions, in each case the thing that what they rest on is nearest to."""
    count = len(near.things)
    if not 0 < count <= _MOST_THINGS:
        return None
    owners: dict[Case, int] = {}
    links = 0
    for some in chain.from_iterable(combinations(range(count), size) for size in range(count + 1)):
        case = frozenset(some)
        if case & near.figures:
            continue
        # A surface itself is at hand everywhere.
        looks = [look for look in looks_in(case) if not any(look[at] == 0 for at in case)]
        others = [at for at in range(count) if at not in case]
        if not others:
            if looks:
                return None
            owners[case] = 0
            continue
        far, owner = min((max((look[at] for look in looks), default=0), at) for at in others)
        if far >= FAR:
            return None
        owners[case] = owner
        links = max(links, far)
    return Ownership(near.things, owners, links)


class _Ways:
    """The things of one rule, and the ways between them."""

    def __init__(self, rule: Rule, near: Mapping[Indicator, _Near]) -> None:
        self._head = rule.head
        self._stated = [(goal, near[goal.predicate]) for goal in rule.body if isinstance(goal, Atom)]
        denials = [goal for goal in rule.body if isinstance(goal, Negation)]
        self._denied = [
            [(atom, near[atom.predicate]) for atom in goal.goals if isinstance(atom, Atom)]
            for goal in denials
        ]
        every = list(chain(self._stated, *self._denied))
        self.bounded = all(one.bounded for _, one in every)
        self.measured = any(one.looks for _, one in every)
        named = {name for atom, one in self._stated for name in named_in(atom, one.things)}
        self.places = [place for place, value in enumerate(rule.head.args) if called(value) in named]
        # What is said to be no surface is none.
        self._solid = _figures(self._stated) | {
            called(goal.goals[0].args[0])
            for goal in denials
            if len(goal.goals) == 1 and isinstance(goal.goals[0], Atom)
            if goal.goals[0].predicate == ("surface", 1)
        }

    def there(self, things: Sequence[int]) -> bool:
        """Return whether what it names are things that are there, whatever files say."""
        sure = {name for atom, one in self._stated if one.there for name in named_in(atom, one.things)}
        return all(called(self._head.args[place]) in sure for place in things)

    def figures(self, things: Sequence[int]) -> frozenset[int]:
        """Return which of the things that the head names are never surfaces."""
        heads = self._heads(things)
        return frozenset(at for at, name in enumerate(heads) if name in self._solid)

    def apart(self, things: Sequence[int]) -> dict[tuple[int, int], int]:
        """Return how many links are between the things that the head names."""
        links = _links(self._stated, self._solid)
        heads = self._heads(things)
        count = range(len(heads))
        return {(a, b): 0 if a == b else links.get((heads[a], heads[b]), FAR) for a in count for b in count}

    def looks(self, things: Sequence[int], case: Case | None) -> Iterator[Ways]:
        """Yield what the rule looks at, from the things its head names.

        Parameters
        ----------
        things : sequence of int
        case : frozenset of int or None
            Which of them are surfaces, where that is known.
        """
        heads = self._heads(things)
        surfaces = {heads[at] for at in case or ()}
        solid = set(self._solid)
        if case is not None:
            solid |= {name for at, name in enumerate(heads) if at not in case}
        if surfaces & self._solid:
            return  # a surface is no figure: it does not hold
        for part in ([], *self._denied):
            if surfaces & _figures(part):
                continue
            # What is denied matters only where it is there, and then what it names is linked by it too.
            goes_on = solid | _figures(part)
            links = _links([*self._stated, *part], goes_on)
            for atom, one in part or self._stated:
                named = list(named_in(atom, one.things))
                for ways in one.looks:
                    yield tuple(_nearest(head, named, ways, links, goes_on) for head in heads)

    def _heads(self, things: Sequence[int]) -> list[str]:
        return [called(self._head.args[place]) for place in things]


def _figures(used: Iterable[tuple[Atom, _Near]]) -> set[str]:
    return {called(atom.args[one.things[at]]) for atom, one in used for at in one.figures}


def _nearest(
    head: str, named: Sequence[str], ways: Ways, links: Mapping[tuple[str, str], int], goes_on: set[str]
) -> int:
    """Return how many links it takes from what the head names to what an atom looks at."""
    found = FAR
    for name, way in zip(named, ways, strict=True):
        step = links.get((head, name), FAR)
        if step == 0 or way == 0 or name in goes_on:
            found = min(found, step + way)
    return found


def _links(used: Sequence[tuple[Atom, _Near]], goes_on: set[str]) -> dict[tuple[str, str], int]:
    """Return how many links there are between what atoms name, by way of what ``goes_on``."""
    names = sorted({name for atom, one in used for name in named_in(atom, one.things)})
    found = {(one, two): 0 if one == two else FAR for one in names for two in names}
    for atom, one in used:
        named = list(enumerate(named_in(atom, one.things)))
        for (a, left), (b, right) in permutations(named, 2):
            if left != right and one.apart is not None:
                found[left, right] = min(found[left, right], one.apart.get((a, b), FAR))
    for by, left, right in product(names, repeat=3):
        if by in goes_on:
            found[left, right] = min(found[left, right], found[left, by] + found[by, right])
    return found
