"""A scene with all that follows from it as quads: RDF 1.1, the same bytes for the same scene.

=========================  ======================================================================
graph                      holds
=========================  ======================================================================
``urn:deixis:scene:S``     things, labels, regions, boxes; the relations that no view changes
its ``:view:V``, for each  the five horizontal relations as seen from V
its ``:metadata``          scene and views (SOSA), run, rules and thresholds (PROV-O)
its ``:derivations``       of every relation: its axiom, its margin and the steps of its proof
=========================  ======================================================================
"""

from __future__ import annotations

from deixis.rdf.derivations import write_derivations
from deixis.rdf.knowledge import Knowledge
from deixis.rdf.metadata import write_metadata
from deixis.rdf.oxigraph import ox
from deixis.rdf.quads import GraphWriter, in_order
from deixis.rdf.relations import names_of, relation_names, write_relations
from deixis.rdf.scene import write_things


def graph_names(kb: Knowledge) -> dict[str, str]:
    """Return the IRIs of a scene's graphs: ``scene``, ``metadata``, ``derivations``, each view's ``view:ID``.

    Examples
    --------
    >>> from deixis._files import kb_dir
    >>> from deixis.knowledge import KnowledgeBase
    >>> with KnowledgeBase.from_scene(kb_dir() / "scenes" / "hans.json") as kb:
    ...     graph_names(kb)["view:v0"]
    'urn:deixis:scene:hans:view:v0'
    """
    names = names_of(kb)
    fixed = {"scene": names.scene, "metadata": names.metadata, "derivations": names.derivations}
    return fixed | {f"view:{view.id}": names.view(view.id) for view in kb.scene.views}


def quads(kb: Knowledge) -> list[ox.Quad]:
    """Return all quads of a scene, in order."""
    names = names_of(kb)
    found = kb.relations(relation=relation_names(kb))
    scene, metadata, derivations = (
        GraphWriter(graph) for graph in (names.scene, names.metadata, names.derivations)
    )
    write_things(scene, kb.scene, names, kb.measured_as)
    write_metadata(metadata, kb, names)
    write_derivations(derivations, found, names)
    graphs = [scene, metadata, derivations, *write_relations(found, names)]
    return in_order(quad for graph in graphs for quad in graph.quads)


def nquads(kb: Knowledge) -> bytes:
    """Return everything of one scene as RDF 1.1 N-Quads, UTF-8.

    Examples
    --------
    >>> from deixis._files import kb_dir
    >>> from deixis.knowledge import KnowledgeBase
    >>> with KnowledgeBase.from_scene(kb_dir() / "scenes" / "hans.json") as kb:
    ...     lines = nquads(kb).decode().splitlines()
    >>> for line in lines:
    ...     if "sweater> <urn:deixis:term:onTopOf>" in line:
    ...         print(line.replace("urn:deixis:", ""))
    <scene:hans:thing:sweater> <term:onTopOf> <scene:hans:thing:heater> <scene:hans> .
    """
    return serialised(quads(kb), ox.RdfFormat.N_QUADS)


def serialised(found: list[ox.Quad], form: ox.RdfFormat) -> bytes:
    """Return quads in a format, UTF-8."""
    text = ox.serialize(found, format=form)
    assert text is not None  # noqa: S101 - None is for output to a file
    return text
