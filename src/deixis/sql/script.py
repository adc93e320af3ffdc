"""The rules as a script of SQL that people can read and run."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence

from deixis.ruleset import Indicator, Ruleset, shown
from deixis.sql.program import Program, arguments


def script(ruleset: Ruleset, wanted: Sequence[Indicator]) -> str:
    """Return the statements that derive some predicates, without margins.

    Examples
    --------
    >>> from deixis._files import rules_dir
    >>> from deixis.ruleset import load
    >>> rules = load([rules_dir() / "facts.pl", rules_dir() / "topology.pl"])
    >>> print(script(rules, [("is_close", 2)]).splitlines()[-1])
    CREATE TABLE is_close_2_truth AS SELECT t0.a0 AS a0, t0.a1 AS a1
    FROM pair_9_given t0 WHERE t0.a2 <= $closeness;
    """
    return "\n".join(_lines(Program(ruleset, wanted, margins=False)))


def _lines(program: Program) -> Iterator[str]:
    yield "-- The facts are tables NAME_ARITY_given with columns a0, a1 ...; names are whole numbers in them."
    yield "-- $granularity and its like are the thresholds of the scene."
    for text, code in sorted(program.names.codes.items(), key=lambda one: -one[1]):
        yield f"-- {code} is {json.dumps(text)}"
    for step in program.steps:
        tables = [program.names.tables[node] for node in step.nodes]
        for node, table in zip(step.nodes, tables, strict=True):
            selects = program.seeds(node, step.nodes) if step.recursive else program.selects(node)
            yield f"-- {json.dumps(shown(node[0]))}"
            yield f"CREATE TABLE {table} AS {program.table(node, list(selects))};"
        if not step.recursive:
            continue
        yield "-- Repeat until no row is added; the tables _new are at first copies of the tables."
        for node, table in zip(step.nodes, tables, strict=True):
            found = program.table(node, list(program.selects(node, step.nodes)))
            columns = arguments(node[0])
            yield f"CREATE TABLE {table}_next AS SELECT {columns} FROM ({found}) EXCEPT FROM {table};"
        for table in tables:
            yield f"DROP TABLE {table}_new; ALTER TABLE {table}_next RENAME TO {table}_new;"
            yield f"INSERT INTO {table} FROM {table}_new;"
