"""The service description of an endpoint (SPARQL 1.1 Service Description)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from deixis.rdf.evaluator import GRAPHS
from deixis.rdf.functions import DOCUMENTED
from deixis.rdf.layout import TYPE
from deixis.rdf.oxigraph import ox

_SD: Final = "http://www.w3.org/ns/sparql-service-description#"
_FORMATS: Final = "http://www.w3.org/ns/formats/"
_RDFS: Final = "http://www.w3.org/2000/01/rdf-schema#"
_WRITTEN: Final = (
    "SPARQL_Results_JSON",
    "SPARQL_Results_XML",
    "SPARQL_Results_CSV",
    "SPARQL_Results_TSV",
    "Turtle",
    "N-Triples",
    "RDF_XML",
    "TriG",
    "N-Quads",
    "JSON-LD",
)


def description(endpoint: str, graphs: Sequence[str], form: str, *, update: bool) -> bytes:
    """Return what an endpoint offers, as RDF.

    Parameters
    ----------
    endpoint : str
        Its IRI.
    graphs : sequence of str
        The named graphs.
    form : str
        A key of ``GRAPHS``.
    update : bool
        Whether it takes updates.

    Examples
    --------
    >>> text = description("http://localhost/sparql", ["urn:g"], "nt", update=False).decode()
    >>> "service-description#endpoint> <http://localhost/sparql>" in text
    True
    """
    service, dataset, default = (ox.BlankNode(name) for name in ("service", "dataset", "default"))
    triples = []

    def say(
        subject: ox.NamedNode | ox.BlankNode, predicate: str, value: str | ox.BlankNode | ox.Literal
    ) -> None:
        target = ox.NamedNode(value) if isinstance(value, str) else value
        triples.append(ox.Triple(subject, ox.NamedNode(predicate), target))

    say(service, TYPE, _SD + "Service")
    say(service, _SD + "endpoint", endpoint)
    say(service, _SD + "supportedLanguage", _SD + "SPARQL11Query")
    if update:
        say(service, _SD + "supportedLanguage", _SD + "SPARQL11Update")
    for feature in ("UnionDefaultGraph", "EmptyGraphs"):
        say(service, _SD + "feature", _SD + feature)
    for name in _WRITTEN:
        say(service, _SD + "resultFormat", _FORMATS + name)
    for one in DOCUMENTED:
        function = ox.NamedNode(one.iri)
        say(service, _SD + "extensionFunction", one.iri)
        say(function, TYPE, _SD + "Function")
        say(function, _RDFS + "label", ox.Literal(one.name))
        say(function, _RDFS + "comment", ox.Literal(f"{one.text} Example: {one.example}", language="en"))
    say(service, _SD + "defaultDataset", dataset)
    say(dataset, TYPE, _SD + "Dataset")
    say(dataset, _SD + "defaultGraph", default)
    say(default, TYPE, _SD + "Graph")
    for at, name in enumerate(graphs):
        graph = ox.BlankNode(f"g{at}")
        say(dataset, _SD + "namedGraph", graph)
        say(graph, TYPE, _SD + "NamedGraph")
        say(graph, _SD + "name", name)
    return ox.serialize(triples, format=GRAPHS[form]) or b""
