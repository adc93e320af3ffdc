"""What has to be derived for some predicates, and in which order, for engines that work set at a time."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from typing import Literal

from deixis.ruleset.base import BASE_FACTS
from deixis.ruleset.checking import Ruleset
from deixis.ruleset.model import (
    Atom,
    Comparison,
    Constant,
    Expression,
    Goal,
    Indicator,
    Negation,
    Rule,
    atoms,
)
from deixis.ruleset.unfold import unfolded

Mode = Literal["truth", "near"]
"""In ``truth`` a row is what holds, with its margin; in ``near`` it is every derivation, whether its
comparisons of lengths hold or not, with the margin it has or lacks. A denial is as wide as what it denies
comes near (decision 0012), so only what is denied needs the second reading."""

Node = tuple[Indicator, Mode]
"""A table to derive: a predicate in one of the two readings."""


@dataclass(frozen=True, slots=True)
class Step:
    """Tables that are computed together.

    Attributes
    ----------
    nodes : tuple of Node
    recursive : bool
        Whether they rest on each other.
    """

    nodes: tuple[Node, ...]
    recursive: bool


class Plan:
    """The tables that some predicates rest on.

    Parameters
    ----------
    ruleset : Ruleset
    wanted : sequence of Indicator
        What is to be derived.
    margins : bool
        Whether each row has its margin beside it.
    near : sequence of Indicator
        What is to be derived in the other reading.
    stated : collection of Indicator
        Predicates whose rows are known, in both readings, and not derived from their rules.

    Attributes
    ----------
    rules, given : dict
        The rules of each derived predicate, written out; those without a body apart.
    once : frozenset of Indicator
        The predicates whose one rule finds each conclusion once.
    needed : set of Node
    steps : tuple of Step
        The tables that have rules, each after those it rests on: first how near, then what holds.
    constants : tuple of str
        Names and strings that the rules speak of, sorted.
    """

    def __init__(
        self,
        ruleset: Ruleset,
        wanted: Sequence[Indicator],
        *,
        margins: bool,
        near: Sequence[Indicator] = (),
        stated: Collection[Indicator] = (),
    ) -> None:
        self.ruleset, self.wanted, self.margins = ruleset, tuple(wanted), margins
        self.near, self.stated = tuple(near), frozenset(stated)
        written = unfolded(ruleset, self.stated)
        every = {one: rules for one, rules in written.rules.items() if one not in self.stated}
        # Declared in a rule file, and stated or used nowhere.
        every |= {one: () for one in (*wanted, *near) if one not in every and one not in BASE_FACTS}
        self.once = written.once
        self.rules = {one: tuple(rule for rule in rules if rule.body) for one, rules in every.items()}
        self.given = {one: tuple(rule for rule in rules if not rule.body) for one, rules in every.items()}
        self.needed = self._needed()
        self.steps = tuple(self._ordered())
        self.constants = tuple(sorted(set(self._constants())))

    @classmethod
    def of(
        cls,
        ruleset: Ruleset,
        wanted: Sequence[Indicator],
        *,
        margins: bool,
        near: Sequence[Indicator] = (),
    ) -> Plan:
        """Return the plan, made once for a ruleset."""
        key = tuple(wanted), margins, tuple(near)
        known: Plan | None = ruleset.plans.get(key)
        if known is None:
            known = ruleset.plans[key] = cls(ruleset, wanted, margins=margins, near=near)
        return known

    def _needed(self) -> set[Node]:
        """Return the tables that the wanted ones rest on."""
        found: set[Node] = set()
        todo: list[Node] = [*((one, "truth") for one in self.wanted), *((one, "near") for one in self.near)]
        while todo:
            node = todo.pop()
            if node in found:
                continue
            found.add(node)
            for rule in self.rules.get(node[0], ()):
                todo += self._uses(rule, node[1])
        return found

    def rests_on(self, one: Indicator) -> set[Indicator]:
        """Return all predicates that one rests on, itself among them."""
        found: set[Indicator] = set()
        todo = [one]
        while todo:
            predicate = todo.pop()
            if predicate not in found:
                found.add(predicate)
                todo += [
                    atom.predicate for rule in self.rules.get(predicate, ()) for atom, _ in atoms(rule.body)
                ]
        return found

    def _uses(self, rule: Rule, mode: Mode) -> Iterator[Node]:
        for goal in rule.body:
            if isinstance(goal, Atom):
                yield goal.predicate, mode
            elif isinstance(goal, Negation):
                inner = [one.predicate for one in goal.goals if isinstance(one, Atom)]
                if mode == "truth":
                    yield from ((one, "truth") for one in inner)
                if self.margins:
                    yield from ((one, "near") for one in inner)

    def _ordered(self) -> Iterator[Step]:
        recursive = self.ruleset.graph.recursive
        modes: tuple[Mode, ...] = ("near", "truth")
        for mode in modes:
            for component in self.ruleset.graph.components:
                nodes = [(one, mode) for one in sorted(component) if (one, mode) in self.needed]
                nodes = [node for node in nodes if self.rules.get(node[0])]
                if nodes:
                    yield Step(tuple(nodes), any(one in recursive for one, _ in nodes))

    def _constants(self) -> Iterator[str]:
        for predicate, _ in self.needed:
            for rule in self.rules.get(predicate, ()):
                for goal in (rule.head, *rule.body):
                    yield from _texts(goal)


def _texts(goal: Goal | Expression) -> Iterator[str]:
    match goal:
        case Constant():
            if goal.kind != "number":
                yield str(goal.value)
        case Atom():
            for value in goal.args:
                yield from _texts(value)
        case Comparison():
            yield from _texts(goal.left)
            yield from _texts(goal.right)
        case Negation():
            for inner in goal.goals:
                yield from _texts(inner)
