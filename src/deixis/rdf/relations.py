"""Relations as quads: each in the graph of its view, or in the scene's where no view matters."""

from __future__ import annotations

from collections.abc import Iterable

from deixis.rdf.knowledge import Holds, Knowledge
from deixis.rdf.layout import TERM, term
from deixis.rdf.names import SceneNames
from deixis.rdf.quads import GraphWriter
from deixis.vocabulary import BASE, RELATIONS


def relation_names(kb: Knowledge) -> list[str]:
    """Return all that an export holds: base relations, those people speak in, and the user's own.

    Of the user's predicates those with two or three names for arguments.
    """
    own: dict[str, bool] = {}
    for name, arity in sorted(kb.ruleset.user):
        if arity in (2, 3):
            own[name] = own.get(name, True) and set(kb.ruleset.kinds[name, arity]) == {"name"}
    return [one.name for one in (*BASE, *RELATIONS)] + [name for name, plain in own.items() if plain]


def names_of(kb: Knowledge) -> SceneNames:
    """Return the IRIs of a knowledge base's scene."""
    scene = kb.scene
    return SceneNames(
        scene.id, tuple(thing.id for thing in scene.objects), tuple(view.id for view in scene.views)
    )


def arguments(one: Holds) -> tuple[str, ...]:
    """Return the names that a relation holds of: two, or three with the view."""
    return (one.figure, one.reference) if one.view is None else (one.figure, one.reference, one.view)


def graph_of(one: Holds, names: SceneNames) -> str:
    """Return the graph that a relation stands in; a third argument of a user's own may be no view."""
    return names.view(one.view) if one.view is not None and names.is_view(one.view) else names.scene


def relation_iri(one: Holds) -> str:
    """Return the property that a relation is."""
    arity = 2 if one.view is None else 3
    return term((one.relation, arity))


def write_relations(graphs: dict[str, GraphWriter], found: Iterable[Holds], names: SceneNames) -> None:
    """Write relations into their graphs, which are added where they are not there yet."""
    for one in found:
        graph = graph_of(one, names)
        to = graphs.get(graph)
        if to is None:
            to = graphs[graph] = GraphWriter(graph)
        figure, reference, relation = names.named(one.figure), names.named(one.reference), relation_iri(one)
        if one.view is None or names.is_view(one.view):
            to.link(figure, relation, reference)
            continue
        row = names.row(relation.removeprefix(TERM), *arguments(one))
        to.typed(row, relation)
        for place, value in enumerate((figure, reference, names.named(one.view)), 1):
            to.link(row, f"{relation}.{place}", value)
