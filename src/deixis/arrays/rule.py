"""One rule, evaluated over tables."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np

from deixis.arrays.program import ROW, Check, Conjunction, Denial, Join, Program
from deixis.arrays.rows import Column, Rows, refuse_more
from deixis.frames import Array, Index, Mask
from deixis.ruleset.model import Arithmetic, Constant, Expression, Variable
from deixis.ruleset.plan import Node

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
    margins: bool
    most: int
    check: Callable[[], None]

    def conclusions(self, program: Program) -> Rows:
        """Return the rows that a rule concludes, some perhaps several times, with their margins."""
        found = self._conjunction(_Found(), program.body)
        columns = []
        for value in program.head.args:
            column = self._value(value, found.held)
            columns.append(column if isinstance(column, np.ndarray) else np.full(found.count, column))
        return Rows(columns, found.margin if self.margins else None)

    def _conjunction(self, found: _Found, conjunction: Conjunction) -> _Found:
        """Return the ways in which atoms and comparisons hold too."""
        for name, limit in conjunction.limits:
            found.held[name] = self.limits[limit]
        for step in conjunction.steps:
            if isinstance(step, Join):
                table = self.tables[step.predicate, conjunction.mode]
                found = self._join(found, step, table)
            elif isinstance(step, Denial):
                found = self._deny(found, step)
            else:
                found = self._compare(found, step, near=conjunction.mode == "near")
        return found

    def _join(self, found: _Found, step: Join, table: Rows) -> _Found:
        """Return the ways found so far, each with each row of an atom's table that fits."""
        self.check()
        keep: Mask | None = None
        for fits in self._fits(found, step, table):
            keep = fits if keep is None else keep & fits
        if step.keys:
            wanted = [np.asarray(found.held[name]) for _, name in step.keys]
            left, right = table.matches([place for place, _ in step.keys], wanted, self.most)
            if keep is not None:
                some = keep[right]
                left, right = left[some], right[some]
            result = found.at(left, step.kept)
        else:
            right = np.arange(len(table)) if keep is None else np.flatnonzero(keep)
            refuse_more(found.count * len(right), self.most)
            if found.count == 1:
                result = found.repeated(len(right), step.kept)
            else:
                result = found.at(np.repeat(np.arange(found.count), len(right)), step.kept)
                right = np.tile(right, found.count)
        for place, name in step.fresh:
            result.held[name] = table.columns[place][right]
        if table.margin is not None:
            result.narrow(table.margin[right])
        return result

    def _fits(self, found: _Found, step: Join, table: Rows) -> Sequence[Mask]:
        """Return which rows of an atom's table fit, for each thing that is asked of them alone."""
        every = [table.flags[name] for name in step.flags]
        every += [table.columns[place] == self._value(value, {}) for place, value in step.constants]
        every += [table.columns[place] == table.columns[other] for place, other in step.repeated]
        every += [table.columns[place] == found.held[name] for place, name in step.scalars]
        return every

    def _compare(self, found: _Found, step: Check, *, near: bool) -> _Found:
        goal = step.goal
        left, right = self._value(goal.left, found.held), self._value(goal.right, found.held)
        if self.margins and step.soft:
            found = _Found(found.count, found.held, found.margin)
            found.narrow(_SPARE[goal.operator](left, right))
        if near and step.soft:
            return found
        holds = _COMPARE[goal.operator](left, right)
        if holds.all():
            return found
        rows = np.flatnonzero(holds) if holds.ndim else np.zeros(0, dtype=np.int64)
        return found.at(rows, step.kept)

    def _deny(self, found: _Found, denial: Denial) -> _Found:
        """Return the ways found in which a denial holds too, with the margin it has."""
        if denial.truth is not None:
            refuted = np.asarray(self._inner(found, denial, denial.truth).held[ROW])
            if len(refuted):
                holds = np.ones(found.count, dtype=np.bool_)
                holds[refuted] = False
                found = found.at(np.flatnonzero(holds), denial.kept | denial.held)
        if denial.near is not None:
            near = self._inner(found, denial, denial.near)
            if near.margin is not None or denial.truth is None:
                closest = np.full(found.count, -np.inf)
                margin = np.full(near.count, np.inf) if near.margin is None else near.margin
                np.maximum.at(closest, np.asarray(near.held[ROW]), margin)
                found = _Found(found.count, found.held, found.margin)
                found.narrow(-closest)
        return found

    def _inner(self, found: _Found, denial: Denial, conjunction: Conjunction) -> _Found:
        held: dict[str, Held] = {name: found.held[name] for name in denial.held}
        held[ROW] = np.arange(found.count)
        return self._conjunction(_Found(found.count, held), conjunction)

    def _value(self, value: Expression, held: Mapping[str, Held]) -> Held:
        match value:
            case Variable():
                return held[value.name]
            case Constant():
                return float(value.value) if value.kind == "number" else self.codes[str(value.value)]
            case Arithmetic("-", (only,)):
                return -self._value(only, held)
            case Arithmetic("+", (only,)):
                return self._value(only, held)
            case Arithmetic("+", (left, right)):
                return self._value(left, held) + self._value(right, held)
            case Arithmetic("-", (left, right)):
                return self._value(left, held) - self._value(right, held)
        raise AssertionError(value)


@dataclass(slots=True)
class _Found:
    """The ways found so far in which a conjunction may hold, a row each."""

    count: int = 1
    held: dict[str, Held] = field(default_factory=dict)
    margin: Array | None = None

    def at(self, rows: Index, kept: Collection[str]) -> _Found:
        """Return some of the ways, and of what is known in them what is needed."""
        held = {
            name: one[rows] if isinstance(one, np.ndarray) else one
            for name, one in self.held.items()
            if name in kept
        }
        return _Found(len(rows), held, None if self.margin is None else self.margin[rows])

    def repeated(self, times: int, kept: Collection[str]) -> _Found:
        """Return the one way there is, so many times."""
        return self.at(np.zeros(times, dtype=np.int64), kept)

    def narrow(self, margin: Array | float) -> None:
        """Take into account one more margin, for all rows or a row each."""
        if self.margin is not None:
            self.margin = np.minimum(self.margin, margin)
        elif isinstance(margin, np.ndarray) and margin.ndim:
            self.margin = margin
        else:
            self.margin = np.full(self.count, margin, dtype=np.float64)
