"""One rule, evaluated over tables."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np

from deixis.arrays.rows import Column, Rows, refuse_more
from deixis.frames import Array, Index, Mask
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
    Negation,
    Rule,
    Variable,
    variables,
)
from deixis.ruleset.plan import Mode, Node

Scalar = float | int
Held = Column | Scalar
"""What a variable stands for: a value a row, or one for all rows."""

_COMPARE: Final[Mapping[str, Callable[[Any, Any], Any]]] = {
    "<": np.less,
    "=<": np.less_equal,
    ">": np.greater,
    ">=": np.greater_equal,
    "=:=": np.equal,
    "=\\=": np.not_equal,
    "==": np.equal,
    "=": np.equal,
    "\\==": np.not_equal,
    "\\=": np.not_equal,
}

_SPARE: Final[Mapping[str, Callable[[Any, Any], Any]]] = {
    "<": lambda x, y: y - x,
    "=<": lambda x, y: y - x,
    ">": lambda x, y: x - y,
    ">=": lambda x, y: x - y,
    "=:=": lambda x, y: -abs(x - y),
    "=\\=": lambda x, y: abs(x - y),
}


@dataclass(frozen=True)
class World:
    """What rules are evaluated over.

    Attributes
    ----------
    tables : mapping
        The rows of each node, as far as they are known yet.
    codes : mapping
        Numbers of the names and strings in the rules.
    limits : mapping
        The thresholds, by name.
    lengths : mapping
        For each argument of each predicate whether it is a length.
    margins : bool
        Whether margins are wanted.
    most : int
        Rows that may be looked at at once.
    check : callable
        Called now and then; raises when the time is up.
    """

    tables: Mapping[Node, Rows]
    codes: Mapping[str, int]
    limits: Mapping[str, float]
    lengths: Mapping[Indicator, Sequence[bool]]
    margins: bool
    most: int
    check: Callable[[], None]


@dataclass
class _Found:
    """The ways found so far in which a conjunction may hold, a row each."""

    count: int = 1
    held: dict[str, Held] = field(default_factory=dict)
    margin: Array | None = None

    def at(self, rows: Index | Mask) -> _Found:
        held = {name: one[rows] if isinstance(one, np.ndarray) else one for name, one in self.held.items()}
        count = int(rows.sum()) if rows.dtype == np.bool_ else len(rows)
        return _Found(count, held, None if self.margin is None else self.margin[rows])

    def narrow(self, margin: Any) -> None:
        """Take into account one more margin, for all rows or a row each."""
        if self.margin is None:
            self.margin = np.broadcast_to(np.asarray(margin, dtype=np.float64), (self.count,))
        else:
            self.margin = np.minimum(self.margin, margin)


class RuleArrays:
    """Evaluates one rule.

    Parameters
    ----------
    world : World
    rule : Rule
    mode : {"truth", "near"}
    """

    def __init__(self, world: World, rule: Rule, mode: Mode) -> None:
        self._world, self._rule, self._mode = world, rule, mode

    def conclusions(self) -> Rows:
        """Return the rows that the rule concludes, some perhaps several times, with their margins."""
        rule = self._rule
        lengths = rule_lengths([goal for goal in rule.body if isinstance(goal, Atom)], self._world.lengths)
        found = self._conjunction(_Found(), rule.body, lengths, self._mode)
        for goal in rule.body:
            if isinstance(goal, Negation):
                found = self._deny(found, goal, lengths)
        columns = [np.asarray(self._value(value, found.held)) for value in rule.head.args]
        whole = [np.broadcast_to(column, (found.count,)) for column in columns]
        margin = found.margin if self._world.margins else None
        return Rows(whole, margin)

    def _conjunction(
        self, found: _Found, goals: Sequence[Goal], lengths: Mapping[str, bool], mode: Mode
    ) -> _Found:
        """Return the ways in which atoms and comparisons hold too."""
        atoms = [goal for goal in goals if isinstance(goal, Atom)]
        checks = [goal for goal in goals if isinstance(goal, Comparison)]
        atoms = [goal for goal in atoms if not self._threshold(goal, found.held)]
        shown = {at: flag(goal, goals) for at, goal in enumerate(atoms)}
        read = [goal for at, goal in enumerate(atoms) if shown[at] is None]
        flagged = [(goal, *told) for at, goal in enumerate(atoms) if (told := shown[at]) is not None]
        while True:
            for one in [one for one in checks if all(name.name in found.held for name in variables(one))]:
                checks.remove(one)
                found = self._compare(found, one, lengths, mode)
            if not read:
                return found
            # What shares something with what is known comes first: fewer rows on the way.
            goal = next((one for one in read if self._linked(one, found)), read[0])
            read.remove(goal)
            columns = [
                column
                for one, predicate, places, column in flagged
                if stands_beside(one, goal, predicate, places)
            ]
            flagged = [one for one in flagged if not stands_beside(one[0], goal, one[1], one[2])]
            found = self._join(found, goal, columns, mode)

    def _linked(self, goal: Atom, found: _Found) -> bool:
        return any(
            isinstance(value, Constant) or isinstance(found.held.get(value.name), np.ndarray)
            for value in goal.args
        )

    def _threshold(self, goal: Atom, held: dict[str, Held]) -> bool:
        """Take a threshold by its name for a number."""
        if goal.predicate != ("threshold", 2):
            return False
        name, value = goal.args
        if not isinstance(name, Constant) or name.value not in self._world.limits:
            return False
        if not isinstance(value, Variable) or value.name in held:
            return False
        held[value.name] = self._world.limits[str(name.value)]
        return True

    def _join(self, found: _Found, goal: Atom, flags: Sequence[str], mode: Mode) -> _Found:
        """Return the ways found so far, each with each row of an atom's table that fits."""
        self._world.check()
        table = self._world.tables[goal.predicate, mode]
        keep: Mask | None = None
        for name in flags:
            keep = table.flags[name] if keep is None else keep & table.flags[name]
        fresh: dict[str, int] = {}
        places: list[int] = []
        wanted: list[Column] = []
        for place, value in enumerate(goal.args):
            column = table.columns[place]
            equal: Mask | None = None
            if isinstance(value, Constant):
                equal = column == self._value(value, {})
            elif value.name in fresh:
                equal = column == table.columns[fresh[value.name]]
            elif value.name in found.held:
                known = found.held[value.name]
                if isinstance(known, np.ndarray):
                    places.append(place)
                    wanted.append(known)
                else:
                    equal = column == known
            else:
                fresh[value.name] = place
            if equal is not None:
                keep = equal if keep is None else keep & equal
        if places:
            left, right = table.matches(places, wanted, self._world.most)
            if keep is not None:
                fits = keep[right]
                left, right = left[fits], right[fits]
        else:
            right = np.arange(len(table)) if keep is None else np.flatnonzero(keep)
            refuse_more(found.count * len(right), self._world.most)
            left = np.repeat(np.arange(found.count), len(right))
            right = np.tile(right, found.count) if found.count != 1 else right
        result = found.at(left)
        for name, place in fresh.items():
            result.held[name] = table.columns[place][right]
        if table.margin is not None:
            result.narrow(table.margin[right])
        return result

    def _compare(self, found: _Found, goal: Comparison, lengths: Mapping[str, bool], mode: Mode) -> _Found:
        left, right = (self._value(one, found.held) for one in (goal.left, goal.right))
        soft = goal.operator in ORDER and all(lengths.get(one.name, True) for one in variables(goal))
        if self._world.margins and soft:
            found = _Found(found.count, found.held, found.margin)
            found.narrow(_SPARE[goal.operator](left, right))
        if soft and mode == "near":
            return found
        holds = np.broadcast_to(_COMPARE[goal.operator](left, right), (found.count,))
        return found if holds.all() else found.at(holds)

    def _deny(self, found: _Found, goal: Negation, lengths: Mapping[str, bool]) -> _Found:
        """Return the ways found in which a denial holds too, with the margin it has."""
        known = {**rule_lengths(goal.goals, self._world.lengths), **lengths}
        outside = {name.name for name in variables(goal)}
        if self._mode == "truth":
            refuted = self._inner(found, goal, known, outside, "truth")
            holds = np.ones(found.count, dtype=np.bool_)
            holds[np.asarray(refuted.held[_ROW])] = False
            if not holds.all():
                found = found.at(holds)
        if self._world.margins:
            near = self._inner(found, goal, known, outside, "near")
            if near.margin is not None or self._mode == "near":
                closest = np.full(found.count, -np.inf)
                margin = np.full(near.count, np.inf) if near.margin is None else near.margin
                np.maximum.at(closest, np.asarray(near.held[_ROW]), margin)
                found = _Found(found.count, found.held, found.margin)
                found.narrow(-closest)
        return found

    def _inner(
        self, found: _Found, goal: Negation, lengths: Mapping[str, bool], names: set[str], mode: Mode
    ) -> _Found:
        held = {name: one for name, one in found.held.items() if name in names}
        return self._conjunction(
            _Found(found.count, {**held, _ROW: np.arange(found.count)}), goal.goals, lengths, mode
        )

    def _value(self, value: Expression, held: Mapping[str, Held]) -> Held:
        match value:
            case Variable():
                return held[value.name]
            case Constant():
                return float(value.value) if value.kind == "number" else self._world.codes[str(value.value)]
            case Arithmetic("-", (only,)):
                return -self._value(only, held)
            case Arithmetic("+", (only,)):
                return self._value(only, held)
            case Arithmetic("+", (left, right)):
                return self._value(left, held) + self._value(right, held)
            case Arithmetic("-", (left, right)):
                return self._value(left, held) - self._value(right, held)
        raise AssertionError(value)


_ROW: Final = ""
"""Which way of the outer conjunction a way of a denied one belongs to; no variable is called so."""
