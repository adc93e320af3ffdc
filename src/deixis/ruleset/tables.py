"""Tables of what holds: columns of numbers, names by their numbers."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from deixis.facts import Facts
from deixis.frames import Array
from deixis.ruleset.columns import Columns, Symbols
from deixis.ruleset.model import Constant, Indicator, Kind, Rule


@dataclass(frozen=True)
class Table:
    """All rows of one predicate.

    Attributes
    ----------
    kinds : tuple of {"name", "number", "string"}
        Of the columns.
    columns : tuple of (n,) array
        Numbers as they are; names and strings by their number in ``symbols``.
    margins : (n,) float or None
        Beside each row the metres by which a length would have to change for it to cease, infinite where
        no length decides; None where no margins were asked for.
    symbols : Symbols
    """

    kinds: tuple[Kind, ...]
    columns: tuple[NDArray[np.int64] | Array, ...]
    margins: Array | None
    symbols: Symbols

    def __len__(self) -> int:
        return len(self.columns[0])

    def rows(self) -> list[tuple[str | float, ...]]:
        """Return the rows with their names, sorted."""
        return sorted(self._named())

    def named(self) -> Iterator[tuple[tuple[str | float, ...], float]]:
        """Yield each row with its names, and its margin."""
        margins = np.full(len(self), np.inf) if self.margins is None else self.margins
        return zip(self._named(), margins.tolist(), strict=True)

    def _named(self) -> Iterator[tuple[str | float, ...]]:
        values: list[Sequence[str | float]] = [
            column.tolist() if kind == "number" else self.symbols.texts(column)
            for kind, column in zip(self.kinds, self.columns, strict=True)
        ]
        return zip(*values, strict=True)


class Executor(Protocol):
    """Derives all rows of some predicates at once; see :class:`deixis.sql.SqlExecutor`."""

    def run(
        self,
        facts: Facts,
        wanted: Sequence[Indicator],
        *,
        view_labels: Sequence[tuple[str, str]] = (),
        margins: bool = True,
        timeout: float | None = None,
    ) -> dict[Indicator, Table]:
        """Return all rows of some predicates, with their margins if wanted."""


def listed(rules: Sequence[Rule], kinds: Sequence[Kind], symbols: Symbols) -> Columns:
    """Return facts that are written in rule files as columns, each once."""
    rows = dict.fromkeys(
        tuple(one.value for one in rule.head.args if isinstance(one, Constant)) for rule in rules
    )
    columns: Columns = {}
    for at, kind in enumerate(kinds):
        values = [row[at] for row in rows]
        if kind == "number":
            columns[f"a{at}"] = np.array(values, dtype=np.float64)
        else:
            columns[f"a{at}"] = symbols.codes(str(value) for value in values)
    return columns
