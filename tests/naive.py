"""What follows from rules, worked out in the plainest way: over and over, until nothing is new.

Written for the tests, apart from the engines: nested loops over rows, no indexes, no rewriting of rules.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from deixis.facts import Facts
from deixis.ruleset import Indicator, Rule, Ruleset
from deixis.ruleset.base import BASE_FACTS
from deixis.ruleset.columns import Symbols, base_columns
from deixis.ruleset.model import (
    Arithmetic,
    Atom,
    Comparison,
    Constant,
    Expression,
    Negation,
    Variable,
    variables,
)

Value = str | float
Row = tuple[Value, ...]
Table = dict[Row, float]
"""Rows with their margins."""

Bound = dict[str, Value]

COMPARE = {
    "<": lambda x, y: x < y,
    "=<": lambda x, y: x <= y,
    ">": lambda x, y: x > y,
    ">=": lambda x, y: x >= y,
    "=:=": lambda x, y: x == y,
    "=\\=": lambda x, y: x != y,
    "==": lambda x, y: x == y,
    "=": lambda x, y: x == y,
    "\\==": lambda x, y: x != y,
    "\\=": lambda x, y: x != y,
}
SPARE = {
    "<": lambda x, y: y - x,
    "=<": lambda x, y: y - x,
    ">": lambda x, y: x - y,
    ">=": lambda x, y: x - y,
    "=:=": lambda x, y: -abs(x - y),
    "=\\=": lambda x, y: abs(x - y),
}


def base_rows(facts: Facts, predicate: Indicator) -> Table:
    """Return the facts of a base predicate."""
    symbols = Symbols(facts.ids, ())
    columns = base_columns(predicate, facts, (), symbols)
    values = []
    for at in range(predicate[1]):
        column = columns[f"a{at}"]
        values.append(column.tolist() if column.dtype == np.float64 else symbols.texts(column))
    return dict.fromkeys(zip(*values, strict=True), math.inf)


class Naive:
    """All that follows from facts by a ruleset: what holds, and how near everything else comes."""

    def __init__(
        self, ruleset: Ruleset, wanted: Sequence[Indicator], base: Mapping[Indicator, Table]
    ) -> None:
        self.ruleset = ruleset
        needed = ruleset.graph.needed(wanted)
        self.near: dict[Indicator, Table] = {}
        self.truth: dict[Indicator, Table] = {}
        for one in needed & BASE_FACTS.keys():
            self.near[one] = self.truth[one] = base[one]
        for tables, near in ((self.near, True), (self.truth, False)):
            for component in ruleset.graph.components:
                todo = [one for one in component & needed if one not in BASE_FACTS]
                tables.update({one: {} for one in todo})
                while sum(self._more(tables, one, near) for one in todo):
                    pass

    def _more(self, tables: dict[Indicator, Table], predicate: Indicator, near: bool) -> bool:
        """Apply all rules of a predicate once; return whether anything is new or wider."""
        found = list(self._conclusions(tables, predicate, near))
        table, changed = tables[predicate], False
        for row, margin in found:
            if row not in table or table[row] < margin:
                table[row], changed = margin, True
        return changed

    def _conclusions(
        self, tables: dict[Indicator, Table], predicate: Indicator, near: bool
    ) -> Iterator[tuple[Row, float]]:
        for rule in self.ruleset.by_head.get(predicate, ()):
            plain = self._plain(rule)
            for bound, margin in self._solve(tables, list(rule.body), {}, near, plain):
                yield tuple(_value(one, bound) for one in rule.head.args), margin

    def _plain(self, rule: Rule) -> set[str]:
        """Return the variables of a rule that are numbers, and no lengths."""
        found = set()
        for goal in rule.body:
            for atom in goal.goals if isinstance(goal, Negation) else (goal,):
                if not isinstance(atom, Atom):
                    continue
                for value, length in zip(atom.args, self.ruleset.lengths[atom.predicate], strict=True):
                    measured = atom.name != "threshold" or atom.args[0] != _SCALE
                    if isinstance(value, Variable) and not (length and measured):
                        found.add(value.name)
        return found

    def _solve(
        self, tables: dict[Indicator, Table], goals: list[object], bound: Bound, near: bool, plain: set[str]
    ) -> Iterator[tuple[Bound, float]]:
        """Yield each way to bind the variables, with the least margin on the way."""
        if not goals:
            yield bound, math.inf
            return
        goal, *rest = goals
        for extended, margin in self._step(tables, goal, bound, near, plain):
            for whole, more in self._solve(tables, rest, extended, near, plain):
                yield whole, min(margin, more)

    def _step(
        self, tables: dict[Indicator, Table], goal: object, bound: Bound, near: bool, plain: set[str]
    ) -> Iterator[tuple[Bound, float]]:
        if isinstance(goal, Atom):
            for row, margin in list(tables[goal.predicate].items()):
                extended = _matched(goal, row, bound)
                if extended is not None:
                    yield extended, margin
        elif isinstance(goal, Comparison):
            left, right = _value(goal.left, bound), _value(goal.right, bound)
            soft = goal.operator in SPARE and not any(one.name in plain for one in variables(goal))
            if (near and soft) or COMPARE[goal.operator](left, right):
                yield bound, SPARE[goal.operator](left, right) if soft else math.inf
        elif isinstance(goal, Negation):
            inner = list(goal.goals)
            if near or not any(True for _ in self._solve(self.truth, inner, bound, False, plain)):
                margins = [margin for _, margin in self._solve(self.near, inner, bound, True, plain)]
                yield bound, -max(margins) if margins else math.inf


_SCALE = Constant("name", "halfspace_scale", None)  # type: ignore[arg-type]


def _matched(atom: Atom, row: Row, bound: Bound) -> Bound | None:
    extended = dict(bound)
    for value, cell in zip(atom.args, row, strict=True):
        if isinstance(value, Constant):
            if value.value != cell:
                return None
        elif extended.setdefault(value.name, cell) != cell:
            return None
    return extended


def _value(value: Expression, bound: Bound) -> Value:
    if isinstance(value, Variable):
        return bound[value.name]
    if isinstance(value, Arithmetic):
        numbers = [float(_value(one, bound)) for one in value.operands]
        if len(numbers) == 1:
            return -numbers[0]
        return numbers[0] + numbers[1] if value.operator == "+" else numbers[0] - numbers[1]
    return value.value
