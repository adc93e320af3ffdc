"""Three engines, one question: all rows of some predicates with their margins."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any, Literal

if TYPE_CHECKING:
    from deixis.facts import Facts
    from deixis.prolog import PrologEngine
    from deixis.ruleset import Indicator
    from deixis.sql import SqlExecutor

Engine = Literal["duckdb", "prolog", "sparql"]
"""What can derive all relations of a scene; each gives the same."""

Row = tuple[str, ...]
Found = tuple["Indicator", Row, float | None]
"""A predicate, its arguments, and the margin: None where no length decides."""


def by_sql(
    executor: SqlExecutor,
    facts: Facts,
    labels: Sequence[tuple[str, str]],
    wanted: Sequence[Indicator],
    timeout: float | None,
) -> Iterator[Found]:
    """Yield what DuckDB derives."""
    tables = executor.run(facts, wanted, view_labels=labels, timeout=timeout)
    for predicate, table in tables.items():
        for row, margin in table.named():
            yield predicate, tuple(map(str, row)), margin if math.isfinite(margin) else None


def by_prolog(engine: PrologEngine, wanted: Sequence[Indicator], timeout: float | None) -> Iterator[Found]:
    """Yield what SWI-Prolog derives."""
    from deixis.prolog import Atom

    predicates: list[Any] = [[Atom(name), arity] for name, arity in wanted]
    rows: Any = engine.call("margins", *predicates, timeout=timeout)
    for name, *row, margin in rows:
        yield (name, len(row)), tuple(row), margin


def by_sparql(
    executor: SqlExecutor,
    facts: Facts,
    labels: Sequence[tuple[str, str]],
    wanted: Sequence[Indicator],
    timeout: float | None,
) -> Iterator[Found]:
    """Yield what a triple store derives, with the margins that SQL finds.

    SPARQL says what holds. It has no greatest of the least, so the margins are measured by the other
    executor; that the two know the same rows is checked.

    Raises
    ------
    EngineError
        They do not.
    """
    from deixis.errors import EngineError
    from deixis.rdf import SparqlExecutor

    holds = SparqlExecutor(executor.ruleset).run(facts, wanted, view_labels=labels, timeout=timeout)
    margins = {
        (predicate, row): margin
        for predicate, row, margin in by_sql(executor, facts, labels, wanted, timeout)
    }
    found = [(predicate, tuple(map(str, row))) for predicate, rows in holds.items() for row in rows]
    if set(found) != margins.keys():
        raise EngineError("the SPARQL and the SQL executor disagree: report the scene and the rules")
    for predicate, row in found:
        yield predicate, row, margins[predicate, row]
