"""All rules as SQL: what has to be computed, in which order, and the statements for it."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Sequence
from functools import cached_property
from typing import Final

from deixis.ruleset import Indicator, Rule, Ruleset
from deixis.ruleset.model import Atom
from deixis.ruleset.plan import Mode, Node, Plan
from deixis.sql.rules_sql import INFINITE, Names, RuleSql, columns_of

MOST_AT_ONCE: Final = 100
"""Tables that one statement derives; DuckDB takes no more than some hundreds, one on the other."""


class Program(Plan):
    """The statements that derive some predicates from the facts.

    Parameters
    ----------
    ruleset : Ruleset
    wanted : sequence of Indicator
        What is to be derived.
    margins : bool
        Whether each row has its margin beside it.
    stated : collection of Indicator
        Predicates whose rows are in tables already, of each reading one, with their margins.
    """

    def __init__(
        self,
        ruleset: Ruleset,
        wanted: Sequence[Indicator],
        *,
        margins: bool,
        stated: Collection[Indicator] = (),
    ) -> None:
        super().__init__(ruleset, wanted, margins=margins, stated=stated)
        self.thresholds: set[str] = set()
        self._read: set[str] = set()
        self._alike: dict[str, list[Indicator]] = {}
        for one in sorted(ruleset.kinds):
            self._alike.setdefault(_plain(one), []).append(one)
        self.names = Names(
            tables=self._tables(),
            has_margin=frozenset(
                n for n in self.needed if margins and (self.rules.get(n[0]) or n[0] in self.stated)
            ),
            codes={text: -1 - at for at, text in enumerate(self.constants)},
            lengths=ruleset.lengths,
            margins=margins,
        )
        self._result = self._select_all()
        self._read |= {self.names.tables[one, "truth"] for one in self.wanted}
        names = {one: self.given_name(one) for one, _ in sorted(self.needed) if one not in self.stated}
        self.given_tables = {one: name for one, name in names.items() if name in self._read}

    @property
    def stepwise(self) -> bool:
        """Return whether it takes more than one statement: for recursion, or because there is too much."""
        return any(step.recursive for step in self.steps) or len(self.steps) > MOST_AT_ONCE

    def _tables(self) -> dict[Node, str]:
        """Return the name of each node's table: derived by rules, or given as facts."""
        return {
            (predicate, mode): self._table_name(predicate, mode)
            if self.rules.get(predicate) or predicate in self.stated
            else self.given_name(predicate)
            for predicate, mode in self.needed
        }

    def given_name(self, predicate: Indicator) -> str:
        """Return the table of a predicate's facts."""
        return self._table_name(predicate, "given")

    def _table_name(self, predicate: Indicator, what: str) -> str:
        """Return the name of a table: only small letters, digits and _, whatever the predicate is called."""
        same = self._alike[_plain(predicate)]
        number = f"_{same.index(predicate)}" if len(same) > 1 else ""
        return f"{_plain(predicate)}{number}_{what}"

    def selects(self, node: Node, delta: Sequence[Node] = ()) -> Iterator[str]:
        """Yield a SELECT for each rule of a node.

        Parameters
        ----------
        node : Node
        delta : sequence of Node
            Where given, only what follows from the new rows of these: for each of their places in a body a
            SELECT that reads the new rows there.
        """
        predicate, mode = node
        for rule in self.rules[predicate]:
            if not delta:
                yield self._select(rule, mode, {})
                continue
            for at, goal in enumerate(rule.body):
                if isinstance(goal, Atom) and (goal.predicate, mode) in delta:
                    yield self._select(rule, mode, {at: f"{self.names.tables[goal.predicate, mode]}_new"})
        if self.given[predicate] and not delta:
            yield self._facts(predicate)

    def seeds(self, node: Node, together: Sequence[Node]) -> Iterator[str]:
        """Yield what a recursive node begins with: its facts, and what follows without the others."""
        predicate, mode = node
        rules = [
            rule
            for rule in self.rules[predicate]
            if not any(isinstance(goal, Atom) and (goal.predicate, mode) in together for goal in rule.body)
        ]
        for rule in rules:
            yield self._select(rule, mode, {})
        margin = f", {INFINITE} AS m" if self.margins else ""
        if self.given[predicate]:
            yield self._facts(predicate)
        elif not rules:
            columns = (
                f"0::{one.split()[1]} AS {one.split()[0]}"
                for one in columns_of(self.ruleset.kinds[predicate])
            )
            yield f"SELECT {', '.join(columns)}{margin} WHERE FALSE"

    def _facts(self, predicate: Indicator) -> str:
        name = self.given_name(predicate)
        self._read.add(name)
        margin = f", {INFINITE} AS m" if self.margins else ""
        return f"SELECT {arguments(predicate)}{margin} FROM {name}"

    def _select(self, rule: Rule, mode: Mode, tables: dict[int, str]) -> str:
        compiler = RuleSql(self.names, rule, mode, tables)
        text = compiler.select()
        self.thresholds |= compiler.thresholds
        self._read |= compiler.tables
        return text

    def table(self, node: Node, selects: Sequence[str]) -> str:
        """Return a SELECT of all rows of a node, each once, with the widest of its margins."""
        columns = arguments(node[0])
        union = " UNION ALL ".join(selects)
        if node[0] in self.once:
            return union
        if self.margins:
            return f"SELECT {columns}, max(m) AS m FROM ({union}) GROUP BY {columns}"
        return f"SELECT DISTINCT {columns} FROM ({union})"

    def result(self) -> str:
        """Return a SELECT of all wanted rows: r, which of the wanted; c0 ..., names; d0 ..., numbers; m."""
        widest = max((arity for _, arity in self.wanted), default=0)
        parts = []
        for at, predicate in enumerate(self.wanted):
            kinds = self.ruleset.kinds[predicate]
            columns = [f"{at} AS r"]
            for place in range(widest):
                known = place < len(kinds)
                is_number = known and kinds[place] == "number"
                columns.append(
                    f"a{place} AS c{place}" if known and not is_number else f"0::BIGINT AS c{place}"
                )
                if place in self.numbers:
                    columns.append(f"a{place} AS d{place}" if is_number else f"0::DOUBLE AS d{place}")
            node: Node = (predicate, "truth")
            if self.margins:
                columns.append("m" if node in self.names.has_margin else f"{INFINITE} AS m")
            parts.append(f"SELECT {', '.join(columns)} FROM {self.names.tables[node]}")
        return " UNION ALL ".join(parts)

    @cached_property
    def numbers(self) -> frozenset[int]:
        """Return the places where a wanted predicate has a number."""
        return frozenset(
            place
            for one in self.wanted
            for place, kind in enumerate(self.ruleset.kinds[one])
            if kind == "number"
        )

    def statement(self) -> str:
        """Return the statement that gives all wanted rows.

        Where it goes step by step the tables of all steps must be there; otherwise it derives them itself.
        """
        return self._result

    def _select_all(self) -> str:
        nodes = [node for step in self.steps for node in step.nodes]
        parts = [
            f"{self.names.tables[node]} AS ({self.table(node, list(self.selects(node)))})" for node in nodes
        ]
        if self.stepwise:
            return self.result()
        return (f"WITH {', '.join(parts)} " if parts else "") + self.result()


def arguments(predicate: Indicator) -> str:
    """Return the argument columns of a predicate.

    Examples
    --------
    >>> arguments(("near", 2))
    'a0, a1'
    """
    return ", ".join(f"a{at}" for at in range(predicate[1]))


def _plain(predicate: Indicator) -> str:
    return f"{re.sub('[^a-z0-9_]', '_', predicate[0])}_{predicate[1]}"
