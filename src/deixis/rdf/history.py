"""The history of a map as quads: each relation while it held is an interval of OWL-Time.

=======================  =========================================================================
``NODE a``               ``deixis:Holding``, which is a ``time:Interval``
``deixis:relation``      the property that held, between ``deixis:figure`` and ``deixis:reference``
``deixis:seenFrom``      the view, where one matters
``time:hasBeginning``    an instant; ``time:hasEnd`` another, unless it holds by what was told last
``INSTANT``              ``time:inXSDDateTimeStamp`` and, to the last bit, ``deixis:stamp``
=======================  =========================================================================

An interval has its beginning and not its end.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from deixis.moments import exact
from deixis.rdf.knowledge import Lasts
from deixis.rdf.layout import TERM, term
from deixis.rdf.names import SceneNames
from deixis.rdf.namespaces import PROV, TIME, XSD
from deixis.rdf.oxigraph import ox
from deixis.rdf.quads import GraphWriter
from deixis.rdf.terms import IDENTIFIER, LABEL
from deixis.scene import Scene


def history_quads(
    scene: Scene, found: Iterable[Lasts], labels: Mapping[str, str], views: Mapping[str, str]
) -> list[ox.Quad]:
    """Return when relations held as quads, in order.

    Parameters
    ----------
    scene : Scene
        The one beside which they will stand: it tells what its things are called.
    found : iterable of Interval
    labels, views : mapping
        What all things and views that were ever told of are called, by their ids.
    """
    names = SceneNames(scene.id, tuple(labels), tuple(views))
    to = GraphWriter(names.history)
    to.typed(names.history, TERM + "HistoryGraph", PROV + "Entity")
    to.link(names.history, TERM + "ofScene", names.scene)
    there = {one.id for one in scene.objects}, {view.id for view in scene.views}
    for called, known, told in ((labels, names.thing, there[0]), (views, names.view, there[1])):
        for name, label in called.items():
            if name in told:
                continue
            # Not of a class: in the scene there is no such thing any more.
            to.text(known(name), IDENTIFIER, name)
            if label:
                to.text(known(name), LABEL, label)
    for one in found:
        _holding(to, one, names)
    return to.quads


def history_nquads(
    scene: Scene, found: Iterable[Lasts], labels: Mapping[str, str], views: Mapping[str, str]
) -> bytes:
    """Return the same as N-Quads, UTF-8."""
    text = ox.serialize(history_quads(scene, found, labels, views), format=ox.RdfFormat.N_QUADS)
    assert text is not None  # noqa: S101 - None is for output to a file
    return bytes(text)


def _holding(to: GraphWriter, one: Lasts, names: SceneNames) -> None:
    args = (one.figure, one.reference) + (() if one.view is None else (one.view,))
    relation = term((one.relation, len(args)))
    iri = names.holding(one.since, relation.removeprefix(TERM), *args)
    to.typed(iri, TERM + "Holding")
    to.link(iri, TERM + "relation", relation)
    to.link(iri, TERM + "figure", names.named(one.figure))
    to.link(iri, TERM + "reference", names.named(one.reference))
    if one.view is not None:
        to.link(iri, TERM + "seenFrom", names.named(one.view))
    to.link(iri, TIME + "hasBeginning", _instant(to, one.since, names))
    if one.until is not None:
        to.link(iri, TIME + "hasEnd", _instant(to, one.until, names))


def _instant(to: GraphWriter, stamp: float, names: SceneNames) -> str:
    iri = names.instant(stamp)
    to.typed(iri, TIME + "Instant")
    to.number(iri, TERM + "stamp", stamp)
    when = exact(stamp)
    if when is not None:
        to.literal(iri, TIME + "inXSDDateTimeStamp", when, XSD + "dateTimeStamp")
    return iri
