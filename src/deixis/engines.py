"""Several engines, one question: all rows of some predicates with their margins."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any, Final, Literal, Self

from deixis.errors import QueryError
from deixis.hints import hint
from deixis.vocabulary import BASE, RELATIONS

if TYPE_CHECKING:
    from deixis.arrays import ArrayExecutor
    from deixis.facts import Facts
    from deixis.prolog import PrologEngine
    from deixis.ruleset import Indicator, Ruleset
    from deixis.ruleset.tables import Executor, Table
    from deixis.sql import SqlExecutor

Engine = Literal["auto", "arrays", "duckdb", "prolog", "sparql"]
"""What can derive all relations of a scene; each gives the same. ``auto`` is arrays or DuckDB."""

FEW: Final = 50_000
"""Measured pairs up to which arrays are faster than DuckDB: some 4,000 things."""

Row = tuple[str, ...]
Found = tuple["Indicator", Row, float | None]
"""A predicate, its arguments, and the margin: None where no length decides."""


class AutoExecutor:
    """Derives by arrays what is small, by DuckDB what is large; DuckDB is started when first needed.

    Parameters
    ----------
    ruleset : Ruleset
    """

    def __init__(self, ruleset: Ruleset) -> None:
        self.ruleset = ruleset

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Give up the database, if there is one."""
        sql: SqlExecutor | None = self.__dict__.pop("sql", None)
        if sql is not None:
            sql.close()

    @cached_property
    def sql(self) -> SqlExecutor:
        """Return the one that uses DuckDB."""
        from deixis.sql import SqlExecutor

        return SqlExecutor(self.ruleset)

    @cached_property
    def arrays(self) -> ArrayExecutor:
        """Return the one that uses arrays."""
        from deixis.arrays import ArrayExecutor

        return ArrayExecutor(self.ruleset)

    def run(
        self,
        facts: Facts,
        wanted: Sequence[Indicator],
        *,
        view_labels: Sequence[tuple[str, str]] = (),
        margins: bool = True,
        timeout: float | None = None,
    ) -> dict[Indicator, Table]:
        """Return all rows of some predicates; as :meth:`deixis.sql.SqlExecutor.run`."""
        from deixis.arrays import TooMany

        if len(facts) <= FEW:
            try:
                return self.arrays.run(
                    facts, wanted, view_labels=view_labels, margins=margins, timeout=timeout
                )
            except TooMany:
                pass  # DuckDB joins piece by piece, and spills to disk
        return self.sql.run(facts, wanted, view_labels=view_labels, margins=margins, timeout=timeout)


def by_tables(
    executor: Executor,
    facts: Facts,
    labels: Sequence[tuple[str, str]],
    wanted: Sequence[Indicator],
    timeout: float | None,
) -> Iterator[Found]:
    """Yield what an executor derives."""
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
    executor: AutoExecutor,
    facts: Facts,
    labels: Sequence[tuple[str, str]],
    wanted: Sequence[Indicator],
    timeout: float | None,
) -> Iterator[Found]:
    """Yield what a triple store derives, with the margins that another executor finds.

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
        for predicate, row, margin in by_tables(executor, facts, labels, wanted, timeout)
    }
    found = [(predicate, tuple(map(str, row))) for predicate, rows in holds.items() for row in rows]
    if set(found) != margins.keys():
        raise EngineError("the SPARQL executor and another disagree: report the scene and the rules")
    for predicate, row in found:
        yield predicate, row, margins[predicate, row]


def predicates(name: str, ruleset: Ruleset | None) -> list[Indicator]:
    """Return the predicates that a relation's name stands for, those of one's own rules among them.

    Raises
    ------
    QueryError
        There is none, or one of its arguments is no name.
    """
    known = {term.name: term.arity for term in (*BASE, *RELATIONS)}
    if name in known:
        return [(name, known[name])]
    own = {} if ruleset is None else {one: ruleset.kinds[one] for one in ruleset.user}
    listed = {one: kinds for one, kinds in own.items() if one[1] in (2, 3)}
    found = [one for one in sorted(listed) if one[0] == name]
    if not found:
        raise QueryError(f"no relation {name!r}{hint(name, [*known, *sorted(n for n, _ in listed)])}")
    for predicate in found:
        if set(listed[predicate]) != {"name"}:
            raise QueryError(
                f"{name}/{predicate[1]} is no relation of things: one of its arguments is no name; "
                f"ask for it as a goal"
            )
    return found
