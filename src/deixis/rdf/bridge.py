"""A scene as an rdflib Dataset, for those who work with rdflib."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from deixis.errors import MissingDependency
from deixis.rdf.export import quads
from deixis.rdf.knowledge import Knowledge
from deixis.rdf.namespaces import XSD
from deixis.rdf.oxigraph import ox
from deixis.rdf.relations import names_of

if TYPE_CHECKING:
    from rdflib import Dataset, Graph

_STRING: Final = ox.NamedNode(XSD + "string")


def dataset(kb: Knowledge, *, proofs: bool = True) -> Dataset:
    """Return a scene with all that follows from it as an rdflib Dataset: the quads of ``deixis export``.

    Parameters
    ----------
    kb : KnowledgeBase
    proofs : bool
        Whether derivations say by which steps.

    Raises
    ------
    MissingDependency
        rdflib is not installed.

    Examples
    --------
    >>> from deixis._files import kb_dir
    >>> from deixis.knowledge import KnowledgeBase
    >>> with KnowledgeBase.from_scene(kb_dir() / "scenes" / "hans.json") as kb:
    ...     found = dataset(kb, proofs=False)
    >>> [str(row.of) for row in found.query("SELECT ?of { GRAPH view:v0 { ?what :leftOf ?of } }")]
    ['urn:deixis:scene:hans:thing:radiator']
    """
    try:
        from rdflib import Dataset, Literal, URIRef
    except ModuleNotFoundError as error:
        if error.name != "rdflib":
            raise
        raise MissingDependency("a Dataset needs rdflib: pip install 'deixis[rdf]'") from None

    known: dict[str, URIRef] = {}

    def node(given: object) -> URIRef:
        assert isinstance(given, ox.NamedNode)  # noqa: S101 - an export has no nodes without a name
        found = known.get(given.value)
        if found is None:
            found = known[given.value] = URIRef(given.value)
        return found

    def value(given: object) -> URIRef | Literal:
        if not isinstance(given, ox.Literal):
            return node(given)
        # As it was written: rdflib would write some numbers anew.
        kind = None if given.datatype == _STRING else node(given.datatype)
        return Literal(given.value, datatype=kind, normalize=False)

    result = Dataset()
    graphs: dict[URIRef, Graph] = {}
    for one in quads(kb, proofs=proofs):
        name = node(one.graph_name)
        graph = graphs.get(name)
        if graph is None:
            graph = graphs[name] = result.graph(name)
        graph.add((node(one.subject), node(one.predicate), value(one.object)))
    for prefix, iri in names_of(kb).prefixes().items():
        result.bind(prefix, iri, replace=True)
    return result
