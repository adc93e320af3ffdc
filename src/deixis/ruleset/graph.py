"""Which predicate rests on which: components that are derived together, in an order that derives them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

from deixis.ruleset.model import Indicator, Place, Rule, atoms


@dataclass(frozen=True, slots=True)
class Edge:
    """``head`` rests on ``on``, or on its absence."""

    head: Indicator
    on: Indicator
    denied: bool
    place: Place


@dataclass(frozen=True, slots=True)
class Graph:
    """The edges of a set of rules, and their components.

    Attributes
    ----------
    edges : tuple of Edge
    components : tuple of frozenset
        Of predicates that rest on each other, each after all it rests on. Most have one predicate.
    """

    edges: tuple[Edge, ...]
    components: tuple[frozenset[Indicator], ...]

    @classmethod
    def of(cls, rules: Iterable[Rule]) -> Graph:
        r"""Return the graph of some rules.

        Examples
        --------
        >>> from pathlib import Path
        >>> from deixis.ruleset.reading import read_text
        >>> file, _ = read_text("p(X) :- e(X). q(X) :- e(X), \\+ p(X).", Path("x.pl"))
        >>> [sorted(one) for one in Graph.of(file.rules).components]
        [[('e', 1)], [('p', 1)], [('q', 1)]]
        """
        edges = tuple(
            Edge(rule.head.predicate, atom.predicate, denied, atom.place)
            for rule in rules
            for atom, denied in atoms(rule.body)
        )
        after: dict[Indicator, list[Indicator]] = {rule.head.predicate: [] for rule in rules}
        for edge in edges:
            after[edge.head].append(edge.on)
            after.setdefault(edge.on, [])
        return cls(edges, tuple(map(frozenset, _components(after))))

    @property
    def recursive(self) -> frozenset[Indicator]:
        """Return the predicates that rest on themselves."""
        itself = {edge.head for edge in self.edges if edge.on == edge.head}
        return frozenset(itself.union(*(one for one in self.components if len(one) > 1)))

    def strata(self) -> dict[Indicator, int]:
        """Return for each predicate how many denials, one on the other, it takes at most to derive it."""
        level: dict[Indicator, int] = {}
        below: dict[Indicator, list[Edge]] = {}
        for edge in self.edges:
            below.setdefault(edge.head, []).append(edge)
        for component in self.components:
            edges = [edge for one in component for edge in below.get(one, ())]
            least = max(
                (level[edge.on] + edge.denied for edge in edges if edge.on not in component), default=0
            )
            level.update(dict.fromkeys(component, least))
        return level

    def denied_cycles(self) -> Iterator[tuple[Edge, list[Indicator]]]:
        """Yield for each component with a denial in it one such edge, and the way from its target back."""
        place = {one: at for at, component in enumerate(self.components) for one in component}
        below: dict[Indicator, list[Indicator]] = {}
        for edge in self.edges:
            if place[edge.head] == place[edge.on]:
                below.setdefault(edge.head, []).append(edge.on)
        told: set[int] = set()
        for edge in self.edges:
            at = place[edge.head]
            if edge.denied and at == place[edge.on] and at not in told:
                told.add(at)
                yield edge, _way(below, edge.on, edge.head)

    def needed(self, wanted: Iterable[Indicator]) -> frozenset[Indicator]:
        """Return the predicates that some rest on, themselves included."""
        on: dict[Indicator, list[Indicator]] = {}
        for edge in self.edges:
            on.setdefault(edge.head, []).append(edge.on)
        found: set[Indicator] = set()
        todo = list(wanted)
        while todo:
            one = todo.pop()
            if one not in found:
                found.add(one)
                todo += on.get(one, ())
        return frozenset(found)


def _way(below: Mapping[Indicator, Sequence[Indicator]], start: Indicator, end: Indicator) -> list[Indicator]:
    """Return the shortest way between two predicates of one component."""
    came: dict[Indicator, Indicator] = {}
    todo = [start]
    for at in todo:
        if at == end:
            break
        for other in below.get(at, ()):
            if other not in came and other != start:
                came[other] = at
                todo.append(other)
    way = [end]
    while way[-1] != start:
        way.append(came[way[-1]])
    return way[::-1]


def _components(after: Mapping[Indicator, Sequence[Indicator]]) -> list[list[Indicator]]:
    """Return the strongly connected components, each after those it leads to (Tarjan, without recursion)."""
    number: dict[Indicator, int] = {}
    low: dict[Indicator, int] = {}
    stack: list[Indicator] = []
    on_stack: set[Indicator] = set()
    found: list[list[Indicator]] = []
    for root in after:
        if root in number:
            continue
        work = [(root, iter(after[root]))]
        while work:
            node, rest = work[-1]
            if node not in number:
                number[node] = low[node] = len(number)
                stack.append(node)
                on_stack.add(node)
            for other in rest:
                if other not in number:
                    work.append((other, iter(after[other])))
                    break
                if other in on_stack:
                    low[node] = min(low[node], number[other])
            else:
                work.pop()
                if work:
                    low[work[-1][0]] = min(low[work[-1][0]], low[node])
                if low[node] == number[node]:
                    component: list[Indicator] = []
                    while not component or component[-1] != node:
                        component.append(stack.pop())
                        on_stack.discard(component[-1])
                    found.append(component)
    return found
