"""A scene with all that follows from it as quads: RDF 1.1, the same bytes for the same scene.

=========================  ======================================================================
graph                      holds
=========================  ======================================================================
``urn:deixis:scene:S``     things, labels, regions, boxes; the relations that no view changes
its ``:view:V``, for each  the five horizontal relations as seen from V
its ``:metadata``          scene and views (SOSA), run, rules and thresholds (PROV-O)
its ``:derivations``       of every relation: its axiom, its margin and the steps of its proof
its ``:history``           of a map: since when and until when each relation held (OWL-Time)
=========================  ======================================================================
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path

from deixis._files import write_whole
from deixis.errors import QueryError, SceneError
from deixis.rdf.derivations import write_derivations
from deixis.rdf.formats import DATASETS, FORMATS, ending
from deixis.rdf.knowledge import Holds, Knowledge
from deixis.rdf.metadata import write_metadata
from deixis.rdf.names import SceneNames
from deixis.rdf.oxigraph import ox
from deixis.rdf.quads import GraphWriter, in_order
from deixis.rdf.relations import names_of, relation_names, write_relations
from deixis.rdf.scene import write_identity, write_named, write_things
from deixis.strict_json import quoted


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


def quads(kb: Knowledge, *, proofs: bool = True, view: str | None = None) -> list[ox.Quad]:
    """Return all quads of a scene, in order.

    Parameters
    ----------
    kb : KnowledgeBase
    proofs : bool
        Whether derivations say by which steps, and what was measured for each; their axioms and margins are
        given in any case.
    view : str, optional
        Only this view's horizontal relations.
    """
    names = names_of(kb)
    asked = relation_names(kb)
    found = kb.relations(relation=asked, view=view)
    scene, metadata, derivations = (
        GraphWriter(graph) for graph in (names.scene, names.metadata, names.derivations)
    )
    write_things(scene, kb.scene, names, kb.measured_as)
    write_metadata(metadata, kb, names)
    told = kb.proofs(relation=asked, evidence=True) if proofs else None
    write_derivations(derivations, found, names, told)
    return _joined([scene, metadata, derivations], found, names)


def relation_quads(kb: Knowledge, found: Sequence[Holds]) -> list[ox.Quad]:
    """Return some relations as quads, in order: the relations, what they hold of, and their margins.

    Where there are none, it is still said of which scene.
    """
    names = names_of(kb)
    scene, metadata, derivations = (
        GraphWriter(graph) for graph in (names.scene, names.metadata, names.derivations)
    )
    write_identity(metadata, kb.scene, names)
    write_named(scene, kb.scene, names, {name for one in found for name in (one.figure, one.reference)})
    write_derivations(derivations, found, names)
    return _joined([scene, metadata, derivations], found, names)


def nquads(kb: Knowledge, *, proofs: bool = True) -> bytes:
    """Return everything of one scene as RDF 1.1 N-Quads, UTF-8.

    Parameters
    ----------
    kb : KnowledgeBase
    proofs : bool
        Whether derivations say by which steps, for which SWI-Prolog is asked.

    Examples
    --------
    >>> from deixis._files import kb_dir
    >>> from deixis.knowledge import KnowledgeBase
    >>> with KnowledgeBase.from_scene(kb_dir() / "scenes" / "hans.json") as kb:
    ...     lines = nquads(kb, proofs=False).decode().splitlines()
    >>> for line in lines:
    ...     if "sweater> <urn:deixis:term:onTopOf>" in line:
    ...         print(line.replace("urn:deixis:", ""))
    <scene:hans:thing:sweater> <term:onTopOf> <scene:hans:thing:heater> <scene:hans> .
    """
    return serialised(quads(kb, proofs=proofs), "nq", names_of(kb))


def serialised(found: Iterable[ox.Quad], form: str, names: SceneNames) -> bytes:
    """Return a scene's quads in a format, UTF-8.

    Raises
    ------
    QueryError
        The format holds one graph, and what is seen from several views would be mixed up in it.
    """
    given = list(found)
    if form not in DATASETS:
        views = {
            str(one.graph_name) for one in given if str(one.graph_name).startswith(f"<{names.scene}:view:")
        }
        if len(views) > 1:
            raise QueryError(
                f"{form} holds one graph, in which the relations of {len(views)} views would be mixed up: "
                f"choose one view, or one of the formats {', '.join(DATASETS)}"
            )
        given = in_order(ox.Quad(one.subject, one.predicate, one.object) for one in given)
    # JSON-LD comes expanded: a reader who wants it short has kb/context.jsonld.
    prefixes = names.prefixes() if form in ("trig", "ttl") else None
    text = ox.serialize(given, format=FORMATS[form], prefixes=prefixes)
    assert text is not None  # noqa: S101 - None is for output to a file
    text = text.rstrip(b"\n") + b"\n"
    return text if prefixes is None else _tidied(text)


def _tidied(text: bytes) -> bytes:
    """Return a text with its prefixes sorted: their order is not the same from one run to the next."""
    end = text.rfind(b"\n@prefix ") + 1
    end = text.find(b"\n", end) + 1
    return b"".join(sorted(text[:end].splitlines(keepends=True))) + text[end:]


def relations_text(kb: Knowledge, found: Sequence[Holds], form: str) -> str:
    """Return some relations with their margins in a format."""
    return serialised(relation_quads(kb, found), form, names_of(kb)).decode()


def save(
    kb: Knowledge,
    path: Path,
    *,
    proofs: bool = True,
    view: str | None = None,
    more: Sequence[ox.Quad] = (),
) -> int:
    """Write a scene with all that follows from it to a file, in the format of its ending.

    Parameters
    ----------
    kb : KnowledgeBase
    path : Path
    proofs, view
        As of :func:`quads`.
    more : sequence of quad
        What else is to be written, such as its history.

    Returns
    -------
    int
        How many quads.

    Raises
    ------
    ReaderError
        The ending names no format.
    QueryError
        The format cannot hold what is seen from several views.
    SceneError
        The file cannot be written.
    """
    form = ending(path)
    found = [*quads(kb, proofs=proofs, view=view), *more]
    text = serialised(found, form, names_of(kb))
    try:
        write_whole(path, text)
    except OSError as cause:
        raise SceneError(f"{quoted(str(path), 200)} cannot be written: {cause.strerror}") from cause
    return len(found)


def _joined(some: Iterable[GraphWriter], found: Iterable[Holds], names: SceneNames) -> list[ox.Quad]:
    """Return the quads of some graphs and of some relations, graph by graph."""
    graphs = {one.graph: one for one in some}
    write_relations(graphs, found, names)
    return [quad for graph in sorted(graphs) for quad in graphs[graph].quads]
