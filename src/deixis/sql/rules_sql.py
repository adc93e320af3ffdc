"""One rule as one SELECT.

Both readings of a predicate are compiled (:data:`deixis.ruleset.plan.Mode`).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Final

from deixis.ruleset.flags import flag, stands_beside
from deixis.ruleset.kinds import rule_lengths
from deixis.ruleset.model import (
    ORDER,
    Arithmetic,
    Atom,
    Comparison,
    Constant,
    Expression,
    Goal,
    Indicator,
    Kind,
    Negation,
    Rule,
    Variable,
    variables,
)
from deixis.ruleset.plan import Mode, Node
from deixis.thresholds import Thresholds

INFINITE: Final = "'inf'::DOUBLE"
"""The margin of what no length decides. The only text in any statement."""

THRESHOLDS: Final = frozenset(name for name, _ in Thresholds().items())

_OPERATORS: Final = {"=<": "<=", "=:=": "=", "=\\=": "<>", "==": "=", "\\==": "<>", "\\=": "<>"}


@dataclass
class Names:
    """How predicates and constants are called in SQL, and what a rule needs to know of predicates.

    Attributes
    ----------
    tables : mapping
        The table of each node.
    has_margin : set
        The nodes whose tables have a column m.
    codes : mapping
        Number of each constant of the rules.
    lengths : mapping
        For each argument of each predicate whether it is a length.
    margins : bool
        Whether margins are wanted.
    """

    tables: Mapping[Node, str]
    has_margin: frozenset[Node]
    codes: Mapping[str, int]
    lengths: Mapping[Indicator, Sequence[bool]]
    margins: bool


@dataclass
class _Scope:
    """What the goals of one conjunction contribute to a SELECT."""

    sources: list[str] = field(default_factory=list)
    conditions: list[str] = field(default_factory=list)
    margins: list[str] = field(default_factory=list)
    known: dict[str, str] = field(default_factory=dict)


class RuleSql:
    """Compiles one rule.

    Parameters
    ----------
    names : Names
    rule : Rule
    mode : {"truth", "near"}
    tables : mapping, optional
        Other tables for some goals of the body, by position.
    """

    def __init__(self, names: Names, rule: Rule, mode: Mode, tables: Mapping[int, str] | None = None) -> None:
        self._names, self._rule, self._mode = names, rule, mode
        self._instead = tables or {}
        self._aliases = 0
        self.thresholds: set[str] = set()
        self.tables: set[str] = set()

    def select(self) -> str:
        """Return the SELECT of the rule's conclusions: a0, a1 ..., and m where margins are wanted."""
        scope = _Scope()
        body = self._rule.body
        self._join(scope, body, self._mode, self._instead)
        lengths = rule_lengths([goal for goal in body if isinstance(goal, Atom)], self._names.lengths)
        for goal in body:
            if isinstance(goal, Comparison):
                self._compare(scope, goal, lengths, self._mode)
            elif isinstance(goal, Negation):
                self._deny(scope, goal, lengths)
        columns = [
            f"{self._value(value, scope.known)} AS a{at}" for at, value in enumerate(self._rule.head.args)
        ]
        if self._names.margins:
            columns.append(f"{_least(scope.margins)} AS m")
        return _select(", ".join(columns), scope)

    def _join(self, scope: _Scope, goals: Sequence[Goal], mode: Mode, tables: Mapping[int, str]) -> None:
        """Add the atoms: a table each, and what their arguments must equal."""
        read: list[tuple[Atom, str]] = []
        flagged: list[tuple[Atom, Indicator, tuple[int, ...], str]] = []
        for at, goal in enumerate(goals):
            if not isinstance(goal, Atom) or self._threshold(goal, scope.known):
                continue
            shown = flag(goal, goals)
            if shown is not None:
                flagged.append((goal, *shown))
                continue
            node = (goal.predicate, mode)
            alias = f"t{self._aliases}"
            self._aliases += 1
            table = tables.get(at, self._names.tables[node])
            self.tables.add(table)
            scope.sources.append(f"{table} {alias}")
            if node in self._names.has_margin:
                scope.margins.append(f"{alias}.m")
            read.append((goal, alias))
            for position, value in enumerate(goal.args):
                self._match(scope, value, f"{alias}.a{position}")
        for goal, predicate, places, column in flagged:
            alias = next(alias for one, alias in read if stands_beside(goal, one, predicate, places))
            scope.conditions.append(f"{alias}.{column}")

    def _match(self, scope: _Scope, value: Variable | Constant, column: str) -> None:
        if isinstance(value, Constant):
            scope.conditions.append(f"{column} = {self._value(value, {})}")
        elif value.name in scope.known:
            scope.conditions.append(f"{column} = {scope.known[value.name]}")
        else:
            scope.known[value.name] = column

    def _threshold(self, goal: Atom, known: dict[str, str]) -> bool:
        """Take a threshold by its name for a parameter of the statement."""
        if goal.predicate != ("threshold", 2):
            return False
        name, value = goal.args
        if not isinstance(name, Constant) or name.value not in THRESHOLDS or not isinstance(value, Variable):
            return False
        self.thresholds.add(str(name.value))
        known[value.name] = f"${name.value}"
        return True

    def _compare(self, scope: _Scope, goal: Comparison, lengths: Mapping[str, bool], mode: Mode) -> None:
        left, right = (self._value(one, scope.known) for one in (goal.left, goal.right))
        soft = goal.operator in ORDER and all(lengths.get(one.name, True) for one in variables(goal))
        if not (soft and mode == "near"):
            scope.conditions.append(f"{left} {_OPERATORS.get(goal.operator, goal.operator)} {right}")
        if soft:
            scope.margins.append(_spare(goal.operator, left, right))

    def _deny(self, scope: _Scope, goal: Negation, lengths: Mapping[str, bool]) -> None:
        if self._mode == "truth":
            inner = self._inner(scope, goal, lengths, "truth")
            held = _select("1", inner) if inner.sources else ""
            conditions = " AND ".join(inner.conditions) or "TRUE"
            scope.conditions.append(f"NOT EXISTS ({held})" if held else f"NOT ({conditions})")
        if self._names.margins:
            inner = self._inner(scope, goal, lengths, "near")
            if inner.margins or self._mode == "near":
                scope.margins.append(_denied_margin(inner))

    def _inner(self, scope: _Scope, goal: Negation, lengths: Mapping[str, bool], mode: Mode) -> _Scope:
        inner = _Scope(known=dict(scope.known))
        self._join(inner, goal.goals, mode, {})
        known = {**rule_lengths(goal.goals, self._names.lengths), **lengths}
        for one in goal.goals:
            if isinstance(one, Comparison):
                self._compare(inner, one, known, mode)
        return inner

    def _value(self, value: Expression, known: Mapping[str, str]) -> str:
        match value:
            case Variable():
                return known[value.name]
            case Constant():
                return (
                    number(value.value)
                    if value.kind == "number"
                    else str(self._names.codes[str(value.value)])
                )
            case Arithmetic(operator, (only,)):
                return f"({operator} {self._value(only, known)})"
            case Arithmetic(operator, (left, right)):
                return f"({self._value(left, known)} {operator} {self._value(right, known)})"
        raise AssertionError(value)


def number(value: float | str) -> str:
    """Return a number as SQL; without the cast it would be a DECIMAL.

    Examples
    --------
    >>> number(0.05)
    '0.05::DOUBLE'
    """
    return f"{float(value)!r}::DOUBLE" if float(value) >= 0.0 else f"({float(value)!r})::DOUBLE"


def _select(columns: str, scope: _Scope) -> str:
    text = f"SELECT {columns}"
    if scope.sources:
        text += f" FROM {', '.join(scope.sources)}"
    if scope.conditions:
        text += f" WHERE {' AND '.join(scope.conditions)}"
    return text


def _least(margins: Sequence[str]) -> str:
    if len(margins) < 2:
        return margins[0] if margins else INFINITE
    return f"least({', '.join(margins)})"


def _denied_margin(inner: _Scope) -> str:
    """Return the margin of a denial: that of the nearest derivation with its sign turned, or none."""
    least = _least(inner.margins)
    if inner.sources:
        # Named first: the greatest of what only the outer query knows would be taken there.
        near = _select(f"{least} AS near", inner)
        return f"coalesce(-(SELECT max(near) FROM ({near})), {INFINITE})"
    if inner.conditions:
        return f"CASE WHEN {' AND '.join(inner.conditions)} THEN -{least} ELSE {INFINITE} END"
    return f"-{least}"


# In brackets: turned round, two minus signs would begin a comment.
_SPARE: Final[Mapping[str, Callable[[str, str], str]]] = {
    "=<": lambda x, y: f"({y} - {x})",
    "<": lambda x, y: f"({y} - {x})",
    ">=": lambda x, y: f"({x} - {y})",
    ">": lambda x, y: f"({x} - {y})",
    "=:=": lambda x, y: f"(-abs({x} - {y}))",
    "=\\=": lambda x, y: f"abs({x} - {y})",
}


def _spare(operator: str, left: str, right: str) -> str:
    return _SPARE[operator](left, right)


def columns_of(kinds: Sequence[Kind]) -> list[str]:
    """Return the columns of a predicate, with their types."""
    return [f"a{at} {'DOUBLE' if kind == 'number' else 'BIGINT'}" for at, kind in enumerate(kinds)]
