"""Derivations as quads: of every relation, by which axiom it was concluded, and with what to spare."""

from __future__ import annotations

from collections.abc import Iterable

from deixis.rdf.knowledge import Holds
from deixis.rdf.layout import TERM
from deixis.rdf.names import SceneNames
from deixis.rdf.quads import GraphWriter
from deixis.rdf.relations import arguments, graph_of, relation_iri
from deixis.vocabulary import BY_NAME


def write_derivations(to: GraphWriter, found: Iterable[Holds], names: SceneNames) -> None:
    """Write what each relation is, in which graph it stands, its axiom and its margin."""
    for one in found:
        relation = relation_iri(one)
        iri = names.derivation(relation.removeprefix(TERM), *arguments(one))
        to.typed(iri, TERM + "Derivation")
        to.link(iri, TERM + "relation", relation)
        to.link(iri, TERM + "figure", names.named(one.figure))
        to.link(iri, TERM + "reference", names.named(one.reference))
        to.link(iri, TERM + "inGraph", graph_of(one, names))
        if one.margin is not None:
            to.number(iri, TERM + "margin", one.margin)
        known = BY_NAME.get(one.relation)
        if known is not None:
            to.whole(iri, TERM + "axiom", known.axiom)
