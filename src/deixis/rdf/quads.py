"""Quads of one graph, written one by one, and their order."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final

from deixis.rdf.namespaces import RDF, XSD
from deixis.rdf.oxigraph import ox

_TYPE: Final = RDF + "type"
_DOUBLE: Final = ox.NamedNode(XSD + "double")
_INTEGER: Final = ox.NamedNode(XSD + "integer")


class GraphWriter:
    """Collects the quads of one graph; subjects, predicates and targets are given as IRIs.

    Parameters
    ----------
    graph : str
        Its IRI.

    Examples
    --------
    >>> writer = GraphWriter("urn:a:graph")
    >>> writer.number("urn:a:cup", "urn:a:height", 0.1)
    >>> print(writer.quads[0])
    <urn:a:cup> <urn:a:height> "0.1"^^<http://www.w3.org/2001/XMLSchema#double> <urn:a:graph>
    """

    def __init__(self, graph: str) -> None:
        self.graph = graph
        self._graph = ox.NamedNode(graph)
        self._nodes: dict[str, ox.NamedNode] = {}
        self._quads: dict[tuple[str, str, str], ox.Quad] = {}

    @property
    def quads(self) -> list[ox.Quad]:
        """Return the quads by subject, predicate and object, each once."""
        return [self._quads[key] for key in sorted(self._quads)]

    def link(self, subject: str, predicate: str, target: str) -> None:
        """Say that a predicate leads from a subject to a target."""
        self._add(subject, predicate, target, self._node(target))

    def typed(self, subject: str, *classes: str) -> None:
        """Say what classes a subject is of."""
        for one in classes:
            self._add(subject, _TYPE, one, self._node(one))

    def text(self, subject: str, predicate: str, value: str) -> None:
        """Give a subject a text."""
        self._add(subject, predicate, value, ox.Literal(value))

    def number(self, subject: str, predicate: str, value: float) -> None:
        """Give a subject a number, to the last bit: in metres, radians, seconds or without a unit."""
        text = repr(float(value))
        self._add(subject, predicate, text, ox.Literal(text, datatype=_DOUBLE))

    def whole(self, subject: str, predicate: str, value: int) -> None:
        """Give a subject a whole number."""
        self._add(subject, predicate, str(value), ox.Literal(str(value), datatype=_INTEGER))

    def literal(self, subject: str, predicate: str, value: str, datatype: str) -> None:
        """Give a subject a value of another type."""
        self._add(subject, predicate, value, ox.Literal(value, datatype=self._node(datatype)))

    def _node(self, iri: str) -> ox.NamedNode:
        found = self._nodes.get(iri)
        if found is None:
            found = self._nodes[iri] = ox.NamedNode(iri)
        return found

    def _add(self, subject: str, predicate: str, text: str, value: ox.NamedNode | ox.Literal) -> None:
        # No predicate has two values that differ in their type only.
        key = (subject, predicate, text)
        if key not in self._quads:
            self._quads[key] = ox.Quad(self._node(subject), self._node(predicate), value, self._graph)


def in_order(quads: Iterable[ox.Quad]) -> list[ox.Quad]:
    """Return quads sorted by graph, subject, predicate and object, each once."""
    keyed = {
        (str(one.graph_name), str(one.subject), str(one.predicate), str(one.object)): one for one in quads
    }
    return [keyed[key] for key in sorted(keyed)]
