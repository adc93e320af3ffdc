"""SparqlExecutor: all that follows from a scene's facts, derived inside a triple store."""

from __future__ import annotations

import time
from collections.abc import Iterable, Iterator, Sequence
from typing import Any

import numpy as np

from deixis.errors import MissingDependency, QueryTimeout
from deixis.facts import Facts
from deixis.rdf.layout import DOUBLE, NODE, TYPE, iri, is_node, term, text_of
from deixis.rdf.oxigraph import ox
from deixis.rdf.sparql import RuleSparql, select
from deixis.ruleset import Indicator, Kind, Rule, Ruleset
from deixis.ruleset.base import BASE_FACTS
from deixis.ruleset.columns import Symbols, base_columns
from deixis.ruleset.model import Constant

try:
    import pyoxigraph as ox
except ModuleNotFoundError:
    raise MissingDependency("SPARQL needs pyoxigraph: pip install 'deixis[rdf]'") from None

Value = str | float
_OFTEN = 1024
"""Results after which the clock is looked at."""

_TYPE = ox.NamedNode(TYPE)
_DOUBLE = ox.NamedNode(DOUBLE)


class SparqlExecutor:
    """A triple store in memory, filled with the facts that are needed and then with what follows.

    The rules run as the CONSTRUCTs that ``deixis rules compile --to sparql`` prints, component after
    component; recursive ones until they add nothing.

    Parameters
    ----------
    ruleset : Ruleset

    Examples
    --------
    >>> from deixis._files import kb_dir, rules_dir
    >>> from deixis.grounding import ground
    >>> from deixis.ruleset import load
    >>> from deixis.scene import Scene
    >>> names = ("facts", "topology", "direction", "commonsense")
    >>> facts = ground(Scene.load(kb_dir() / "scenes" / "hans.json"))
    >>> executor = SparqlExecutor(load([rules_dir() / f"{name}.pl" for name in names]))
    >>> executor.run(facts, [("leans_on", 2)])
    {('leans_on', 2): [('extinguisher2', 'wall')]}
    """

    def __init__(self, ruleset: Ruleset) -> None:
        self.ruleset = ruleset
        self._texts = [
            (component, [RuleSparql(ruleset, rule).construct() for rule in rules])
            for component, rules in self._components()
        ]

    def _components(self) -> Iterator[tuple[frozenset[Indicator], list[Rule]]]:
        for component in self.ruleset.graph.components:
            rules = [
                rule for one in sorted(component) for rule in self.ruleset.by_head.get(one, ()) if rule.body
            ]
            if rules:
                yield component, rules

    def run(
        self,
        facts: Facts,
        wanted: Sequence[Indicator],
        *,
        view_labels: Sequence[tuple[str, str]] = (),
        timeout: float | None = None,
    ) -> dict[Indicator, list[tuple[Value, ...]]]:
        """Return all rows of some predicates, sorted.

        Parameters
        ----------
        facts : Facts
        wanted : sequence of (str, int)
            Names and numbers of arguments.
        view_labels : sequence of (str, str)
            Id and label of each view.
        timeout : float, optional
            Seconds, looked at before each rule and as it yields: while a triple store searches and finds
            nothing it does not let go of a query.

        Raises
        ------
        QueryTimeout
            It took longer.
        """
        clock = _Clock(timeout)
        needed = self.ruleset.graph.needed(wanted)
        store = ox.Store()
        for predicate in sorted(needed):
            rows = self._given(predicate, facts, view_labels)
            store.bulk_extend(_quads(predicate, self.ruleset.kinds[predicate], rows))
        for component, texts in self._texts:
            if not component & needed:
                continue
            again = True
            while again:
                before = len(store)
                for text in texts:
                    clock.look()
                    found: Any = store.query(text)
                    store.extend(
                        [ox.Quad(one.subject, one.predicate, one.object) for one in clock.timed(found)]
                    )
                again = bool(component & self.ruleset.graph.recursive) and len(store) > before
        return {one: self._rows(store, one) for one in wanted}

    def _given(
        self, predicate: Indicator, facts: Facts, labels: Sequence[tuple[str, str]]
    ) -> Iterator[tuple[Value, ...]]:
        """Yield the facts of a predicate, the scene's or those in the rule files."""
        if predicate not in BASE_FACTS:
            for rule in self.ruleset.by_head.get(predicate, ()):
                if not rule.body:
                    yield tuple(one.value for one in rule.head.args if isinstance(one, Constant))
            return
        symbols = Symbols(facts.ids, ())
        columns = base_columns(predicate, facts, labels, symbols)
        values: list[Sequence[Value]] = []
        for at in range(predicate[1]):
            column = columns[f"a{at}"]
            values.append(column.tolist() if column.dtype == np.float64 else symbols.texts(column))
        yield from zip(*values, strict=True)

    def _rows(self, store: ox.Store, predicate: Indicator) -> list[tuple[Value, ...]]:
        kinds = self.ruleset.kinds[predicate]
        found = set()
        solutions: Any = store.query(select(self.ruleset, predicate))
        for solution in solutions:
            values = (solution[at].value for at in range(len(kinds)))
            found.add(
                tuple(
                    float(value) + 0.0 if kind == "number" else text_of(value)
                    for kind, value in zip(kinds, values, strict=True)
                )
            )
        return sorted(found)


def _quads(
    predicate: Indicator, kinds: tuple[Kind, ...], rows: Iterator[tuple[Value, ...]]
) -> Iterator[ox.Quad]:
    """Yield the facts of a predicate in the layout of RDF."""
    name = ox.NamedNode(term(predicate))
    places = [ox.NamedNode(f"{term(predicate)}.{at}") for at in range(1, len(kinds) + 1)]
    known: dict[tuple[Kind, Value], Any] = {}

    def value(kind: Kind, given: Value) -> Any:
        if kind == "number":
            return ox.Literal(repr(float(given)), datatype=_DOUBLE)
        found = known.get((kind, given))
        if found is None:
            found = known[kind, given] = ox.NamedNode(iri(kind, str(given)))
        return found

    for number, row in enumerate(rows):
        values = [value(kind, given) for kind, given in zip(kinds, row, strict=True)]
        if is_node(kinds):
            node = ox.NamedNode(f"{NODE}fact:{term(predicate)}:{number}")
            yield ox.Quad(node, _TYPE, name)
            yield from (ox.Quad(node, place, one) for place, one in zip(places, values, strict=True))
        elif len(values) == 1:
            yield ox.Quad(values[0], _TYPE, name)
        else:
            yield ox.Quad(values[0], name, values[1])


class _Clock:
    """Tells when the time for an answer is over.

    Parameters
    ----------
    seconds : float or None
        From now; None for as long as it takes.
    """

    def __init__(self, seconds: float | None) -> None:
        self._seconds = seconds
        self._end = None if seconds is None else time.monotonic() + seconds

    def look(self) -> None:
        """Raise QueryTimeout if it is."""
        if self._end is not None and time.monotonic() > self._end:
            raise QueryTimeout(
                f"no answer within {self._seconds:g} s: ask something narrower, or allow more time"
            )

    def timed(self, found: Iterable[Any]) -> Iterator[Any]:
        """Yield what there is, as long as there is time."""
        for number, one in enumerate(found):
            if number % _OFTEN == 0:
                self.look()
            yield one
