"""The ontology says what the vocabulary, the rules and the export say, and nothing geometry does not keep."""

from __future__ import annotations

import io
import json
import shutil
from functools import cache
from itertools import combinations
from pathlib import Path
from typing import Any

import pyoxigraph as ox
import pytest
import rdflib
from hypothesis import given

from commands import call, run
from deixis import KnowledgeBase, Scene
from deixis.errors import QueryError
from deixis.rdf import dataset
from deixis.rdf.export import quads
from deixis.rdf.history import history_quads
from deixis.rdf.layout import TERM
from deixis.rdf.namespaces import PREFIXES
from deixis.rdf.ontology import definition, ontology
from deixis.semantic_map import Interval
from deixis.vocabulary import BASE, RELATIONS, TERMS
from ontology import ASYMMETRIC, CONTEXT, EXCLUDES, IMPLIES, MORE_PREFIXES, ONTOLOGY, SYMMETRIC
from ontology import context as context_text
from ontology import ontology as ontology_text
from scenes import box, scene
from worlds import World, worlds

KB = Path(__file__).resolve().parent.parent / "kb"
OWL, RDFS, SKOS = MORE_PREFIXES["owl"], PREFIXES["rdfs"], MORE_PREFIXES["skos"]
TYPE = PREFIXES["rdf"] + "type"
SH = rdflib.Namespace("http://www.w3.org/ns/shacl#")

NAMES = [term.name for term in (*BASE, *RELATIONS)]
RDF_NAMES = {term.name: term.rdf for term in (*BASE, *RELATIONS)}


@cache
def store() -> ox.Store:
    result = ox.Store()
    result.load(path=ONTOLOGY, format=ox.RdfFormat.TURTLE)
    return result


def rows(query: str) -> list[tuple[str, ...]]:
    found = store().query(query, prefixes=PREFIXES | MORE_PREFIXES)
    return sorted(tuple(one.value for one in row) for row in found)


# One source


def test_it_is_what_the_rules_and_the_vocabulary_say() -> None:
    assert ONTOLOGY.read_text(encoding="utf-8") == ontology_text(), "write it anew: python tests/ontology.py"
    assert CONTEXT.read_text(encoding="utf-8") == context_text(), "write it anew: python tests/ontology.py"


def test_every_term_has_its_axiom_its_predicate_and_a_definition() -> None:
    found = rows("SELECT ?t ?axiom ?name { ?t :axiom ?axiom ; skos:notation ?name ; skos:definition ?text }")
    assert found == sorted((TERM + term.rdf, str(term.axiom), f"{term.name}/{term.arity}") for term in TERMS)


def test_every_word_of_an_export_is_declared() -> None:
    rich = scene(
        {"id": "cloud", "points": [[0, 0, 0], [0.05, 0, 0], [0, 0.05, 0.05]], "seen_in": ["v"]},
        {"id": "mesh", "mesh": {"vertices": [[0, 0, 0], [1, 0, 0], [0, 1, 0]], "faces": [[0, 1, 2]]}},
        views=[{"id": "v", "position": [1, 1, 1], "stamp": 1.0}],
    )
    used = set()
    for given_scene in (
        rich,
        Scene.load(KB / "scenes" / "hans.json"),
        Scene.load(KB / "scenes" / "study.json"),
    ):
        with KnowledgeBase(given_scene) as kb:
            for quad in quads(kb):
                used |= {
                    one.value
                    for one in (quad.predicate, quad.object)
                    if isinstance(one, ox.NamedNode) and one.value.startswith(TERM)
                }
    past = [Interval("left_of", "a", "b", "v", 1.0, 2.0)]
    for quad in history_quads(rich, past, {"a": "cup", "b": ""}, {"v": "robot"}):
        used |= {
            one.value
            for one in (quad.predicate, quad.object)
            if isinstance(one, ox.NamedNode) and one.value.startswith(TERM)
        }
    declared = {name for (name,) in rows("SELECT ?t { ?t a ?kind FILTER(ISIRI(?t)) }")}
    assert used - declared == set()
    # Nor is anything declared that is never said, but for what needs a rarer scene or is a step of no export.
    measures = {TERM + term.rdf for term in TERMS if term.kind == "measure"}
    relations = {TERM + term.rdf for term in (*BASE, *RELATIONS)}
    kinds = {TERM + name for name in ("Region", "Step", "Conjunction", "axiom")}
    assert {name for name in declared if name.startswith(TERM)} - used - measures - relations - kinds == set()


def test_links_are_no_equivalences() -> None:
    text = ONTOLOGY.read_text(encoding="utf-8")
    assert "equivalent" not in text
    assert "sameAs" not in text
    assert "TransitiveProperty" not in text
    assert "owl:imports" not in text
    outside = rows("SELECT ?b { ?a skos:closeMatch|skos:relatedMatch ?b }")
    assert {iri.rpartition("#")[0] for (iri,) in outside} == {
        "http://knowrob.org/kb/knowrob.owl",
        "http://robots.kmi.ac.uk/ont/1.0/spatial-onto",
        "http://www.ease-crc.org/ont/SOMA.owl",
        "http://www.ontologydesignpatterns.org/ont/dul/DUL.owl",
        "http://www.opengis.net/ont/geosparql",
        "https://w3id.org/bot",
    }


def test_it_stays_in_owl_2_rl() -> None:
    allowed = {
        OWL + name
        for name in (
            "Ontology",
            "Class",
            "ObjectProperty",
            "DatatypeProperty",
            "AnnotationProperty",
            "NamedIndividual",
            "IrreflexiveProperty",
            "SymmetricProperty",
            "AsymmetricProperty",
        )
    }
    assert {kind for (kind,) in rows("SELECT ?k { ?t a ?k }")} - allowed == {
        PREFIXES["sosa"] + "ObservableProperty"
    }
    used = {p for (p,) in rows("SELECT DISTINCT ?p { ?s ?p ?o }") if p.startswith((OWL, RDFS))}
    assert used == {RDFS + name for name in ("label", "domain", "range", "subClassOf", "subPropertyOf")} | {
        OWL + name for name in ("propertyDisjointWith", "disjointWith", "inverseOf")
    }


# What geometry keeps


@given(world=worlds())
def test_characteristics_hold_on_random_worlds(world: World) -> None:
    kb = KnowledgeBase(world.scene())
    held: dict[str, set[tuple[str, ...]]] = {name: set() for name in RDF_NAMES.values()}
    for one in kb.relations(relation=NAMES):
        held[RDF_NAMES[one.relation]].add((one.figure, one.reference, one.view or ""))
    held["_:completelyContainedBy"] = {(b, a, view) for a, b, view in held["completelyContains"]}
    pairs = {name: {row[:2] for row in found} for name, found in held.items()}
    for name, found in pairs.items():
        assert not {(a, b) for a, b in found if a == b}, name
    for name in SYMMETRIC:
        assert {(b, a) for a, b in pairs[name]} == pairs[name]
    for name in ASYMMETRIC:
        assert not {(b, a) for a, b in pairs[name]} & pairs[name]
    for name, more in IMPLIES.items():
        for other in more:
            assert held[name] <= held[other.removeprefix(":")], (name, other)
    for name, others in EXCLUDES.items():
        for other in others:
            assert not pairs[name] & pairs[other.removeprefix(":")], (name, other)


# The command


def test_the_command_prints_it_in_three_formats() -> None:
    assert call("ontology").out == ONTOLOGY.read_text(encoding="utf-8")
    expected = set(map(str, ox.parse(path=ONTOLOGY, format=ox.RdfFormat.TURTLE, rename_blank_nodes=False)))
    nt = ox.parse(
        call("ontology", "--format", "nt").out, format=ox.RdfFormat.N_TRIPLES, rename_blank_nodes=False
    )
    assert set(map(str, nt)) == expected
    xml = list(ox.parse(call("ontology", "--format", "owl").out, format=ox.RdfFormat.RDF_XML))
    assert len(xml) == len(expected)
    assert run("ontology", "--format", "owl").out == run("ontology", "--format", "owl").out


@pytest.mark.parametrize("term", TERMS, ids=lambda term: term.rdf)
def test_every_term_resolves_to_text(term: Any) -> None:
    said = definition(TERM + term.rdf)
    assert said.startswith(f":{term.rdf} a owl:")
    assert f":axiom {term.axiom} ;" in said
    assert call("ontology", term.rdf).out == said + "\n"


def test_an_unknown_term_is_refused_with_a_hint() -> None:
    with pytest.raises(QueryError, match="the ontology has no term 'onTopof': did you mean 'onTopOf'"):
        definition("onTopof")
    assert call("ontology", "onTopof").code == 2


def test_the_context_makes_plain_json_of_the_terms() -> None:
    document = {
        **json.loads(CONTEXT.read_text(encoding="utf-8")),
        "id": "urn:a:cup",
        "type": "SpatialObject",
        "label": "cup",
        "onTopOf": "urn:a:table",
        "minBoundBox": {"id": "urn:a:box", "sizeX": 0.5},
        "says": "so",
        "ordinal": 3,
    }
    found = {
        (quad.subject.value, quad.predicate.value.removeprefix(TERM), str(quad.object))
        for quad in ox.parse(json.dumps(document), format=ox.RdfFormat.JSON_LD)
    }
    assert found == {
        ("urn:a:cup", TYPE, f"<{TERM}SpatialObject>"),
        ("urn:a:cup", RDFS + "label", '"cup"'),
        ("urn:a:cup", "onTopOf", "<urn:a:table>"),
        ("urn:a:cup", "minBoundBox", "<urn:a:box>"),
        ("urn:a:box", "sizeX", f'"5.0E-1"^^<{PREFIXES["xsd"]}double>'),
        ("urn:a:cup", "says", '"so"'),
        ("urn:a:cup", "ordinal", f'"3"^^<{PREFIXES["xsd"]}integer>'),
    }


# An OWL reasoner: HermiT, which comes with owlready2 and runs on Java

needs_java = pytest.mark.skipif(
    shutil.which("java") is None, reason="HermiT needs Java: apt install default-jre-headless"
)


def triples(path: Path) -> str:
    found = [ox.Triple(one.subject, one.predicate, one.object) for one in ox.parse(path=path)]
    return ox.serialize(found, format=ox.RdfFormat.N_TRIPLES).decode()


def reasoned(*statements: tuple[str, str, str]) -> Any:
    """Return a world of the ontology, the SWRL rule and some relations of named things, after HermiT."""
    import owlready2

    things = {one for subject, _, thing in statements for one in (subject, thing)}
    swrl = "".join(
        line for line in triples(KB / "swrl.ttl").splitlines(keepends=True) if f"{OWL}imports" not in line
    )
    data = "".join(f"<urn:t:{thing}> <{TYPE}> <{OWL}NamedIndividual> .\n" for thing in sorted(things))
    data += "".join(f"<urn:t:{one}> <{TERM}{name}> <urn:t:{other}> .\n" for one, name, other in statements)
    world = owlready2.World()
    loaded = world.get_ontology("urn:deixis:test#")
    loaded.load(fileobj=io.BytesIO((ontology("nt") + swrl + data).encode()))
    with loaded:
        owlready2.sync_reasoner_hermit(world, infer_property_values=True, debug=0)
    return world


def follows(world: Any, one: str, name: str, other: str) -> bool:
    subject, thing, relation = (world[iri] for iri in (f"urn:t:{one}", f"urn:t:{other}", TERM + name))
    return thing in relation._get_indirect_values_for_individual(subject)


@needs_java
def test_hermit_finds_the_ontology_consistent_and_draws_the_owl_axioms() -> None:
    world = reasoned(
        ("left", "leftOf", "desk"),
        ("right", "rightOf", "desk"),
        ("jar", "inside", "cabinet"),
        ("jar", "near", "cabinet"),
        ("cup", "above", "table"),
        ("cup", "touches", "table"),
        ("book", "above", "shelf"),
    )
    assert list(world.inconsistent_classes()) == []
    assert follows(world, "left", "beside", "desk")  # axiom 35
    assert follows(world, "right", "beside", "desk")
    assert follows(world, "cabinet", "completelyContains", "jar")  # inside
    assert follows(world, "jar", "isClose", "cabinet")  # near
    assert follows(world, "cabinet", "isClose", "jar")
    assert follows(world, "cup", "onTopOf", "table")  # axiom 36, by SWRL
    assert not follows(world, "book", "onTopOf", "shelf")
    assert not follows(world, "desk", "beside", "left")


@needs_java
@pytest.mark.parametrize(
    "wrong",
    [
        [("a", "touches", "b"), ("b", "intersects", "a")],
        [("a", "leansOn", "b"), ("a", "above", "b")],
        [("a", "partIn", "b"), ("b", "partIn", "a")],
        [("a", "near", "a")],
    ],
    ids=["touches and intersects", "leans on and above", "part in each other", "near itself"],
)
def test_hermit_finds_contradictions(wrong: list[tuple[str, str, str]]) -> None:
    import owlready2

    with pytest.raises(owlready2.OwlReadyInconsistentOntologyError):
        reasoned(*wrong)


@needs_java
def test_hermit_agrees_with_what_holds_in_figure_3() -> None:
    """All that it concludes from what holds is held already: rules and ontology do not contradict."""
    with KnowledgeBase.from_scene(KB / "scenes" / "hans.json") as kb:
        held = {(one.figure, RDF_NAMES[one.relation], one.reference) for one in kb.relations(relation=NAMES)}
        seen = {(one.figure, RDF_NAMES[one.relation], one.reference) for one in kb.relations(view="v0")}
    world = reasoned(*sorted(held - {one for one in held if one[1] == "onTopOf"} | seen))
    things = {one for one, _, _ in held}
    asked = ("onTopOf", "beside", "completelyContains", "isClose")
    concluded = {
        (one, name, other)
        for one in things
        for other in things
        for name in asked
        if follows(world, one, name, other)
    }
    assert concluded == {
        one for one in held if one[1] in ("onTopOf", "beside", "completelyContains", "isClose")
    }


# SHACL


def violations(given_scene: Scene) -> list[tuple[str, str]]:
    """Return what pySHACL finds wrong: which thing, and what."""
    import pyshacl

    with KnowledgeBase(given_scene) as kb:
        whole = dataset(kb, proofs=False)
    flat = rdflib.Graph()
    for one, predicate, value, graph in whole.quads():
        if ":view:" not in str(graph):
            flat.add((one, predicate, value))
    conforms, report, _ = pyshacl.validate(flat, shacl_graph=str(KB / "shapes.ttl"))
    found = [
        (str(report.value(one, SH.focusNode)).rpartition(":")[2], str(report.value(one, SH.resultMessage)))
        for one in report.subjects(SH.resultSeverity, SH.Violation)
    ]
    assert conforms == (not found)
    return sorted(found)


UNLABELLED = ("extinguisher2", "fire extinguisher has no label nearby")


def test_shacl_finds_the_unlabelled_extinguisher_of_figure_3(figure_3: Scene) -> None:
    assert violations(figure_3) == [UNLABELLED]


def test_shacl_finds_exactly_the_planted_violations(figure_3: Scene) -> None:
    data = figure_3.to_dict()
    ring = [[1.0, 1.0, 0.0], [2.4, 1.0, 0.0], [2.4, 2.6, 0.0], [1.0, 2.6, 0.0]]
    exit_box = {"center": [-2.45, 0.0, 1.0], "size": [0.1, 0.9, 2.0]}
    planted = [
        {"id": "area", "kind": "surface", "label": "heater free area", "polygon": ring},
        {"id": "exit", "label": "fire exit", "box": exit_box},
    ]
    assert violations(Scene.from_dict({**data, "objects": data["objects"] + planted})) == [
        ("area", "electric heater can't be in heater free area"),
        ("exit", "fire exit has no fire action notice"),
        UNLABELLED,
    ]
    mended = [
        {**planted[0], "polygon": [[x - 3.0, y, z] for x, y, z in ring]},
        planted[1],
        box("notice", [-2.45, 0.8, 1.5], [0.02, 0.2, 0.3], label="fire action notice"),
        box("sign2", [-0.42, 2.99, 0.9], [0.2, 0.02, 0.2], label="fire extinguisher sign"),
    ]
    assert violations(Scene.from_dict({**data, "objects": data["objects"] + mended})) == []


@pytest.mark.parametrize("name", ["study", pytest.param("kitchen", marks=pytest.mark.long)])
def test_shacl_finds_nothing_in_the_other_samples(name: str) -> None:
    assert violations(Scene.load(KB / "scenes" / f"{name}.json")) == []


def test_shacl_finds_what_is_missing_from_a_node(figure_3: Scene) -> None:
    import pyshacl

    with KnowledgeBase(figure_3) as kb:
        whole = dataset(kb, proofs=False)
    graph = whole.graph(rdflib.URIRef("urn:deixis:scene:hans"))
    region = rdflib.URIRef("urn:deixis:scene:hans:thing:sign:region")
    graph.remove((region, rdflib.URIRef(TERM + "sizeX"), None))
    _, report, _ = pyshacl.validate(graph, shacl_graph=str(KB / "shapes.ttl"))
    found = {str(report.value(one, SH.focusNode)) for one in report.subjects(SH.resultSeverity, SH.Violation)}
    assert "urn:deixis:scene:hans:thing:sign" in found


def test_regions_are_of_one_kind() -> None:
    kinds = ("BoxRegion", "PointRegion", "MeshRegion", "PolygonRegion")
    apart = rows("SELECT ?a ?b { ?a owl:disjointWith ?b }")
    assert apart == sorted((TERM + one, TERM + other) for one, other in combinations(kinds, 2))
