"""ArrayExecutor: all that follows from a scene's facts, derived set at a time in this process."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np

from deixis.arrays.program import Program, program
from deixis.arrays.rows import Rows, grouped
from deixis.arrays.rule import World
from deixis.errors import QueryTimeout
from deixis.facts import Facts
from deixis.ruleset import Indicator, Ruleset
from deixis.ruleset.base import BASE_FACTS
from deixis.ruleset.columns import Symbols, base_columns
from deixis.ruleset.plan import Node, Plan, Step
from deixis.ruleset.tables import Table, listed
from deixis.thresholds import Thresholds

_MOST: Final = 20_000_000
"""Rows looked at at once: some 100 bytes each."""

Programs = Mapping[Node, Sequence[Program]]
"""The rules of each table, made ready."""


class ArrayExecutor:
    """Derives what a ruleset says of any scene, without a database.

    For scenes of up to some thousand things it is several times faster than DuckDB, which plans for longer
    than it works; for maps DuckDB is faster.

    Parameters
    ----------
    ruleset : Ruleset

    Examples
    --------
    >>> from deixis._files import datalog_files, kb_dir
    >>> from deixis.grounding import ground
    >>> from deixis.ruleset import load
    >>> from deixis.scene import Scene
    >>> facts = ground(Scene.load(kb_dir() / "scenes" / "hans.json"))
    >>> found = ArrayExecutor(load(datalog_files())).run(facts, [("leans_on", 2)])
    >>> found["leans_on", 2].rows()
    [('extinguisher2', 'wall')]
    """

    def __init__(self, ruleset: Ruleset) -> None:
        self.ruleset = ruleset
        self._ready: dict[Plan, Programs] = {}

    def run(
        self,
        facts: Facts,
        wanted: Sequence[Indicator],
        *,
        view_labels: Sequence[tuple[str, str]] = (),
        margins: bool = True,
        timeout: float | None = None,
    ) -> dict[Indicator, Table]:
        """Return all rows of some predicates; as :meth:`deixis.sql.SqlExecutor.run`.

        Raises
        ------
        QueryTimeout
            It took longer than ``timeout`` seconds.
        TooMany
            A rule has to look at more rows at once than fit in memory.
        GeometryError
            A measured number is not finite.
        """
        found = self.both(facts, wanted, view_labels=view_labels, margins=margins, timeout=timeout)
        return {predicate: table for (predicate, _), table in found.items()}

    def both(
        self,
        facts: Facts,
        wanted: Sequence[Indicator],
        near: Sequence[Indicator] = (),
        *,
        view_labels: Sequence[tuple[str, str]] = (),
        margins: bool = True,
        timeout: float | None = None,
    ) -> dict[Node, Table]:
        """Return all rows of some predicates, and of some how near they come to holding: as :meth:`run`."""
        plan = Plan.of(
            self.ruleset, tuple(dict.fromkeys(wanted)), margins=margins, near=tuple(dict.fromkeys(near))
        )
        symbols = Symbols(facts.ids, plan.constants)
        deadline = math.inf if timeout is None else time.monotonic() + timeout

        def check() -> None:
            if time.monotonic() > deadline:
                raise QueryTimeout(
                    f"no answer within {timeout:g} s: ask something narrower, or allow more time"
                )

        tables: dict[Node, Rows] = {}
        given: dict[Indicator, Rows] = {}
        for predicate, mode in plan.needed:
            if predicate not in given and not (plan.rules.get(predicate) and not plan.given[predicate]):
                given[predicate] = self._given(plan, predicate, facts, view_labels, symbols)
            if not plan.rules.get(predicate):
                tables[predicate, mode] = given[predicate]
        world = World(
            tables=tables,
            codes={text: symbols.code(text) for text in plan.constants},
            limits=dict(facts.thresholds.items()),
            margins=margins,
            most=_MOST,
            check=check,
        )
        programs = self._programs(plan)
        for step in plan.steps:
            _derive(world, plan, programs, step, tables, given)
        nodes: list[Node] = [*((one, "truth") for one in plan.wanted), *((one, "near") for one in plan.near)]
        return {node: self._table(tables[node], node[0], margins, symbols) for node in nodes}

    def _programs(self, plan: Plan) -> Programs:
        """Return the rules of a plan, made ready once."""
        found = self._ready.get(plan)
        if found is None:
            limits = [name for name, _ in Thresholds().items()]
            found = self._ready[plan] = {
                (predicate, mode): tuple(
                    program(rule, mode, lengths=self.ruleset.lengths, limits=limits, margins=plan.margins)
                    for rule in plan.rules[predicate]
                )
                for step in plan.steps
                for predicate, mode in step.nodes
            }
        return found

    def _given(
        self,
        plan: Plan,
        predicate: Indicator,
        facts: Facts,
        view_labels: Sequence[tuple[str, str]],
        symbols: Symbols,
    ) -> Rows:
        columns = (
            base_columns(predicate, facts, view_labels, symbols)
            if predicate in BASE_FACTS
            else listed(plan.given[predicate], self.ruleset.kinds[predicate], symbols)
        )
        names = [f"a{at}" for at in range(predicate[1])]
        flags = {
            name: column.astype(np.bool_, copy=False) for name, column in columns.items() if name not in names
        }
        return Rows([columns[name] for name in names], flags=flags)

    def _table(self, rows: Rows, predicate: Indicator, margins: bool, symbols: Symbols) -> Table:
        margin = np.full(len(rows), np.inf) if rows.margin is None else np.ascontiguousarray(rows.margin)
        return Table(self.ruleset.kinds[predicate], rows.columns, margin if margins else None, symbols)


def _derive(
    world: World,
    plan: Plan,
    programs: Programs,
    step: Step,
    tables: dict[Node, Rows],
    given: dict[Indicator, Rows],
) -> None:
    """Fill in the tables of one step; of a recursive one until nothing is new or has a wider margin."""
    if step.recursive:
        for predicate, mode in step.nodes:
            kinds = plan.ruleset.kinds[predicate]
            columns = [np.zeros(0, np.float64 if kind == "number" else np.int64) for kind in kinds]
            tables[predicate, mode] = Rows(columns, np.zeros(0) if plan.margins else None)
    while True:
        grown = False
        for node in step.nodes:
            found = [world.conclusions(one) for one in programs[node]]
            if plan.given[node[0]]:
                found.append(given[node[0]])
            rows = found[0] if len(found) == 1 and node[0] in plan.once else _once(found)
            grown = grown or (step.recursive and _differs(rows, tables[node]))
            tables[node] = rows
        if not grown:
            return


def _once(found: Sequence[Rows]) -> Rows:
    """Return all rows, each once, with the widest of its margins."""
    columns = [np.concatenate(parts) for parts in zip(*(rows.columns for rows in found), strict=True)]
    first, group = grouped(columns)
    margin = None
    if any(rows.margin is not None for rows in found):
        every = np.concatenate(
            [np.full(len(rows), np.inf) if rows.margin is None else rows.margin for rows in found]
        )
        margin = np.full(len(first), -np.inf)
        np.maximum.at(margin, group, every)
    return Rows([column[first] for column in columns], margin)


def _differs(one: Rows, other: Rows) -> bool:
    if len(one) != len(other):
        return True
    if one.margin is None or other.margin is None:
        return False
    return not np.array_equal(one.margin, other.margin)
