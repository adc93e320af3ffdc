"""Scenes as RDF: what the graphs hold, and that a scene exported and read again is the scene."""

from __future__ import annotations

import json
import re
import subprocess
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

import pyoxigraph as ox
import pytest
import rdflib
from hypothesis import given, settings
from hypothesis import strategies as st

from commands import call
from deixis import KnowledgeBase, Scene, readers
from deixis.errors import QueryError, ReaderError
from deixis.rdf import dataset
from deixis.rdf.export import graph_names, nquads, quads, save, serialised
from deixis.rdf.formats import DATASETS, FORMATS, MAX_DEPTH
from deixis.rdf.namespaces import PREFIXES
from deixis.rdf.relations import names_of, relation_names
from deixis.rdf.terms import IDENTIFIER
from scenes import ROBOT, box, floor, scene, wall
from worlds import World, worlds

ROOT = Path(__file__).resolve().parent.parent
SCENES = sorted([*(ROOT / "kb" / "scenes").glob("*.json"), *(ROOT / "tests" / "golden").glob("*.json")])

CLOUD = [[0.1 * x, 0.1 * y, 1.0 / 3.0] for x in range(3) for y in range(3)]
TETRAHEDRON = {
    "vertices": [[0, 0, 2], [1, 0, 2], [0, 1, 2], [0, 0, 1e-7 + 3]],
    "faces": [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]],
}

TEXT = st.text(st.characters(exclude_categories=["Cc", "Cs", "Zl", "Zp"]), min_size=1, max_size=12).filter(
    lambda text: (
        not any(
            one in "\u061c\u200e\u200f\u202a\u202b\u202c\u202d\u202e\u2066\u2067\u2068\u2069" for one in text
        )
    )
)


def store(text: bytes, form: ox.RdfFormat = ox.RdfFormat.N_QUADS) -> ox.Store:
    result = ox.Store()
    result.load(text, format=form)
    return result


def rows(of: ox.Store, query: str) -> list[tuple[str | None, ...]]:
    found = of.query(query, prefixes=PREFIXES)
    return sorted(tuple(one and one.value for one in row) for row in found)


def exported(given: Scene, **options: bool) -> ox.Store:
    with KnowledgeBase(given) as kb:
        return store(nquads(kb, **options))


@pytest.fixture(scope="module")
def hans() -> ox.Store:
    return exported(Scene.load(ROOT / "kb" / "scenes" / "hans.json"))


# There and back


@pytest.mark.parametrize("path", SCENES, ids=lambda path: path.stem)
def test_a_scene_comes_back_equal_from_every_format(path: Path, tmp_path: Path) -> None:
    with KnowledgeBase.from_scene(path) as kb:
        found = quads(kb, proofs=False)
        for form in DATASETS:
            file = tmp_path / f"scene.{form}"
            file.write_bytes(serialised(found, form, names_of(kb)))
            assert readers.sniff(file) == "rdf"
            assert readers.read_one("rdf", file).to_json() == kb.scene.to_json()


def test_all_kinds_of_regions_come_back_to_the_last_bit(tmp_path: Path) -> None:
    objects = [
        floor(),
        wall(),
        {**box("slab", [0, 0, 2], [1, 1, 0.1]), "kind": "surface"},
        {
            "id": "cloud",
            "points": CLOUD,
            "labels": [{"name": "rug", "score": 1 / 3}, {"name": "mat", "score": 0.1}],
        },
        {"id": "tetra", "mesh": TETRAHEDRON},
        {
            "id": "flat",
            "label": "x",
            "box": {"center": [-0.0, 1e-300, 0.1 + 0.2], "size": [0, 1, 1], "yaw": 1e-17},
        },
    ]
    views = [ROBOT, {**ROBOT, "id": "v1", "stamp": 1700000000.25}, {**ROBOT, "id": "v2", "stamp": -1e300}]
    data = {
        "deixis": 1,
        "id": "all kinds",
        "strays": "refuse",
        "objects": objects,
        "views": views,
        "thresholds": {"closeness": 0.7, "pose_noise": 0.0},
    }
    given = Scene.from_dict(data)
    with KnowledgeBase(given, region="mesh") as kb:
        for form in DATASETS:
            save(kb, tmp_path / f"scene.{form}")
            assert readers.read_one("rdf", tmp_path / f"scene.{form}").to_json() == given.to_json()
    said = store((tmp_path / "scene.nq").read_bytes())
    assert rows(said, "SELECT ?when { GRAPH ?g { ?v sosa:resultTime ?when } }") == [
        ("2023-11-14T22:13:20.25Z",)
    ]


@settings(max_examples=20)
@given(ids=st.lists(TEXT, min_size=4, max_size=4, unique=True), label=TEXT)
def test_any_id_the_door_lets_in_survives(ids: list[str], label: str) -> None:
    name, table, cup, view = ids
    if view == "world":
        return
    given = scene(
        box(table, [0, 0, 0.36], [1.2, 0.8, 0.72], label=label),
        box(cup, [0, 0, 0.77], [0.08, 0.08, 0.1]),
        views=[{**ROBOT, "id": view, "label": label}],
        name=name,
    )
    with KnowledgeBase(given) as kb:
        found, names = quads(kb, proofs=False), names_of(kb)
    for form in DATASETS:
        (again,) = _read(serialised(found, form, names), form)
        assert again.to_json() == given.to_json()
        said = rows(
            store(serialised(found, form, names), FORMATS[form]),
            "SELECT ?one ?other { GRAPH ?g { ?a :onTopOf ?b . ?a dcterms:identifier ?one . "
            "?b dcterms:identifier ?other } }",
        )
        assert said == [(cup, table)]


def _read(text: bytes, form: str) -> tuple[Scene, ...]:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"scene.{form}"
        path.write_bytes(text)
        return readers.read("rdf", path)


@settings(max_examples=20)
@given(world=worlds(most=4))
def test_random_worlds_come_back_equal(world: World) -> None:
    given = world.scene()
    with KnowledgeBase(given) as kb:
        (again,) = _read(nquads(kb, proofs=False), "nq")
    assert again.to_json() == given.to_json()


def test_the_same_scene_gives_the_same_bytes(tmp_path: Path) -> None:
    script = (
        "import sys; from pathlib import Path\n"
        "from deixis import KnowledgeBase\n"
        "from deixis.rdf.export import save\n"
        "with KnowledgeBase.from_scene(sys.argv[1]) as kb:\n"
        "    for path in sys.argv[2:]: save(kb, Path(path))"
    )
    source = ROOT / "tests" / "golden" / "two_views_two_lefts.json"
    texts = []
    for turn in ("a", "b"):
        files = [tmp_path / f"{turn}.{form}" for form in DATASETS]
        subprocess.run([sys.executable, "-c", script, source, *files], check=True)
        texts.append([file.read_bytes() for file in files])
    assert texts[0] == texts[1]


def test_several_scenes_in_one_file_are_told_apart(tmp_path: Path) -> None:
    path = tmp_path / "both.nq"
    one, two = (scene(floor(), box("cup", [0, 0, at], [0.1, 0.1, 0.1]), name=f"s{at}") for at in (1, 2))
    with KnowledgeBase(one) as first, KnowledgeBase(two) as second:
        path.write_bytes(nquads(first, proofs=False) + nquads(second, proofs=False))
    assert [found.id for found in readers.read("rdf", path)] == ["s1", "s2"]
    assert readers.read_one("rdf", f"{path}#s2").to_json() == two.to_json()
    with pytest.raises(ReaderError, match="holds 2 scenes: add # and one of s1, s2"):
        readers.read_one("rdf", path)
    with pytest.raises(ReaderError, match="has no scene 's3': it has s1, s2"):
        readers.read_one("rdf", f"{path}#s3")


# What the graphs hold


def test_each_view_has_its_graph_and_the_rest_one(hans: ox.Store) -> None:
    horizontal = {
        f"urn:deixis:term:{name}" for name in ("leftOf", "rightOf", "inFrontOf", "behind", "beside")
    }
    found = {(row[0], row[1]) for row in rows(hans, "SELECT ?g ?p { GRAPH ?g { ?a ?p ?b . ?b ?q ?c } }")}
    for name in horizontal:
        assert {graph for graph, predicate in found if predicate == name} <= {
            "urn:deixis:scene:hans:view:v0",
            "urn:deixis:scene:hans:view:v1",
        }
    seen = rows(hans, "SELECT DISTINCT ?p { GRAPH <urn:deixis:scene:hans:view:v0> { ?a ?p ?b } }")
    assert {name for (name,) in seen} <= horizontal
    assert rows(hans, "SELECT * { ?a ?p ?b }") == []


def test_left_depends_on_the_graph(hans: ox.Store) -> None:
    query = "SELECT ?g { GRAPH ?g { <urn:deixis:scene:hans:thing:extinguisher2> :leftOf ?of } }"
    assert rows(hans, query) == [("urn:deixis:scene:hans:view:v0",)]


def test_graph_names_name_the_graphs(figure_3: Scene, hans: ox.Store) -> None:
    with KnowledgeBase(figure_3) as kb:
        names = graph_names(kb)
    assert list(names) == ["scene", "metadata", "derivations", "view:v0", "view:v1"]
    assert {str(graph) for graph in hans.named_graphs()} == {f"<{iri}>" for iri in names.values()}


def test_every_relation_has_a_derivation_with_its_margin_and_a_reason(
    figure_3: Scene, hans: ox.Store
) -> None:
    with KnowledgeBase(figure_3) as kb:
        held = kb.relations(relation=relation_names(kb))
        names = names_of(kb)
    found = hans.query(
        "SELECT ?relation ?figure ?reference ?graph ?margin { "
        "GRAPH ?g { ?d a :Derivation ; :relation ?relation ; :figure ?figure ; :reference ?reference ; "
        ":inGraph ?graph ; :margin ?margin ; :premise ?why } "
        "GRAPH ?graph { ?figure ?relation ?reference } }",
        prefixes=PREFIXES,
    )
    derived = {(*(one.value for one in list(row)[:4]), float(row["margin"].value)) for row in found}
    assert len(derived) == len(held)
    assert {(figure, reference, margin) for _, figure, reference, _, margin in derived} == {
        (names.thing(one.figure), names.thing(one.reference), one.margin) for one in held
    }


def test_premises_lead_to_steps_that_say_something(hans: ox.Store) -> None:
    assert rows(hans, "SELECT ?p { GRAPH ?g { ?d :premise ?p FILTER NOT EXISTS { ?p :says ?w } } }") == []
    why = rows(
        hans,
        "SELECT ?kind ?says { GRAPH ?g { ?d :relation :leansOn ; :premise ?p . ?p a ?kind ; :says ?says } }",
    )
    assert Counter(kind.removeprefix("urn:deixis:term:") for kind, _ in why if kind) == {
        "Derivation": 3,
        "Absence": 2,
        "Measurement": 1,
    }
    assert ("urn:deixis:term:Derivation", "the fire extinguisher on the floor touches the wall") in why


def test_every_leaf_says_its_rule_its_numbers_and_where_it_was_measured(hans: ox.Store) -> None:
    leaves = "?p a ?kind FILTER(?kind IN (:Measurement, :Comparison, :Absence))"
    bare = f"SELECT ?p {{ GRAPH ?g {{ {leaves} FILTER NOT EXISTS {{ ?p :ruleFile ?f ; :ruleLine ?l }} }} }}"
    assert rows(hans, bare) == []
    lost = "SELECT ?p { GRAPH ?g { ?p a :Comparison FILTER NOT EXISTS { ?p :value ?v ; :threshold ?t ; "
    assert rows(hans, lost + ":comparedWith ?n ; :margin ?m ; :axiom ?a ; :witness/geo:asWKT ?w } } }") == []
    touch = (
        "SELECT ?quantity ?value ?threshold ?limit ?wkt ?direction ?file ?axiom { GRAPH ?g { "
        "?d :relation :touches ; :figure <urn:deixis:scene:hans:thing:sign> ; "
        ":reference <urn:deixis:scene:hans:thing:wall> ; :premise ?p . ?p a :Comparison ; "
        ":quantity ?quantity ; :value ?value ; :threshold ?threshold ; :comparedWith ?limit ; "
        ":witness/geo:asWKT ?wkt ; :direction ?direction ; :ruleFile ?file ; :axiom ?axiom } } "
    )
    assert {row[2:4] for row in rows(hans, touch)} == {("granularity", "0.02"), ("penetration", "0.04")}
    for quantity, value, _, _, wkt, direction, file, axiom in rows(hans, touch):
        assert (quantity, float(value), file, axiom) == ("separation", 0.0, "topology.pl", "16")
        assert wkt.startswith("<urn:deixis:scene:hans:frame> POINT Z (")
        assert list(map(float, direction.split())) == [0.0, -1.0, 0.0]


def test_what_depends_on_a_view_is_seen_from_it(hans: ox.Store) -> None:
    asked = (
        "SELECT ?view ?wkt ?bound { GRAPH ?g { ?d :relation :leftOf ; :premise ?p . "
        "?p :seenFrom ?view ; :witness/geo:asWKT ?wkt ; :bound ?bound } }"
    )
    found = rows(hans, asked)
    assert found
    assert {view for view, _, _ in found} <= {f"urn:deixis:scene:hans:view:v{number}" for number in (0, 1)}
    assert all(" LINESTRING Z (" in wkt for _, wkt, _ in found)


def test_hostile_labels_are_text_in_derivations(tmp_path: Path) -> None:
    label = '<script>alert(1)</script> \'); halt. """ \\ > .'
    made = scene(box("cup", [0, 0, 0.05], [0.1, 0.1, 0.1], label=label), floor())
    for form in ("nq", "trig", "jsonld"):
        with KnowledgeBase(made) as kb:
            save(kb, tmp_path / f"made.{form}")
        read = ox.Store()
        read.load(path=tmp_path / f"made.{form}")
        said = rows(read, "SELECT ?s { GRAPH ?g { ?d :relation :onTopOf ; :says ?s } }")
        assert said == [(f"the {label} is on top of the floor",)]


def test_without_proofs_the_margins_are_there_all_the_same(figure_3: Scene) -> None:
    found = exported(figure_3, proofs=False)
    assert rows(found, "SELECT ?p { GRAPH ?g { ?d :premise ?p } }") == []
    query = "SELECT ?m { GRAPH ?g { ?d :relation :leansOn ; :margin ?m } }"
    assert [float(margin) for (margin,) in rows(found, query) if margin] == [0.02]


def test_metadata_say_who_saw_and_who_concluded(hans: ox.Store) -> None:
    (view,) = rows(
        hans,
        "SELECT ?of ?sensor ?y { GRAPH <urn:deixis:scene:hans:metadata> { <urn:deixis:scene:hans:view:v0> "
        "a sosa:Observation ; sosa:hasFeatureOfInterest ?of ; sosa:madeBySensor ?sensor ; :positionY ?y } }",
    )
    assert view == ("urn:deixis:scene:hans", "urn:deixis:scene:hans:view:v0:sensor", "0.5")
    plans = rows(
        hans,
        "SELECT ?file ?sha { GRAPH ?g { <urn:deixis:scene:hans:view:v0> prov:wasGeneratedBy ?run . "
        "?run prov:qualifiedAssociation/prov:hadPlan ?plan ; prov:wasAssociatedWith ?engine . "
        "?plan dcterms:identifier ?file ; :sha256 ?sha . ?engine dcterms:hasVersion ?version } }",
    )
    assert [name for name, _ in plans] == ["commonsense.pl", "direction.pl", "facts.pl", "topology.pl"]
    limits = rows(hans, "SELECT ?d { GRAPH ?g { ?run prov:used ?t . ?t :granularity ?d } }")
    assert limits == [("0.02",)]


def test_withheld_references_are_said(hans: ox.Store) -> None:
    found = rows(hans, "SELECT ?v ?of ?why { GRAPH ?g { ?v :withholds [ :reference ?of ; :reason ?why ] } }")
    assert [(view, of) for view, of, _ in found] == [
        (f"urn:deixis:scene:hans:view:{view}", "urn:deixis:scene:hans:thing:floor") for view in ("v0", "v1")
    ]
    assert all(why and "footprint" in why for *_, why in found)


def test_a_box_has_its_shape_in_a_frame_of_its_own(hans: ox.Store) -> None:
    ((shape,),) = rows(
        hans, "SELECT ?w { GRAPH ?g { <urn:deixis:scene:hans:thing:sign> :minBoundBox/geo:asWKT ?w } }"
    )
    assert shape is not None
    assert shape.startswith("<urn:deixis:scene:hans:frame> POLYHEDRALSURFACE Z (((")
    assert shape.count("((") == 6 + 1 - 1
    assert "-1.0 3.0 1.85" in shape


def test_what_a_user_defines_is_exported_too(tmp_path: Path, figure_3: Scene) -> None:
    rules = tmp_path / "own.pl"
    rules.write_text(
        "dries(A, B) :- on_top_of(A, B), label(B, 'electric heater', _).\n"
        "guarded(A, B, V) :- left_of(A, B, V).\n"
        "kind(A, B, red) :- dries(A, B).\n",
        encoding="utf-8",
    )
    with KnowledgeBase(figure_3, rules=[rules]) as kb:
        found = store(nquads(kb))
    thing = "urn:deixis:scene:hans:thing:"
    assert rows(found, "SELECT ?g ?a ?b { GRAPH ?g { ?a <urn:deixis:term:dries.2> ?b } }") == [
        ("urn:deixis:scene:hans", f"{thing}sweater", f"{thing}heater")
    ]
    assert rows(found, "SELECT ?g ?a { GRAPH ?g { ?a <urn:deixis:term:guarded.3> ?b } }") == [
        ("urn:deixis:scene:hans:view:v0", f"{thing}extinguisher2")
    ]
    node = rows(
        found,
        "SELECT ?a ?b ?c { GRAPH ?g { ?n a <urn:deixis:term:kind.3> ; <urn:deixis:term:kind.3.1> ?a ; "
        "<urn:deixis:term:kind.3.2> ?b ; <urn:deixis:term:kind.3.3> ?c } }",
    )
    assert node == [(f"{thing}sweater", f"{thing}heater", "urn:deixis:id:red")]


# rdflib


@pytest.mark.parametrize("name", ["kb/scenes/hans.json", "tests/golden/names_are_only_names.json"])
def test_rdflib_reads_the_same_from_every_format(name: str) -> None:
    with KnowledgeBase.from_scene(ROOT / name) as kb:
        expected = _plain(dataset(kb))
        found, names = quads(kb), names_of(kb)
    assert len(expected) == len(found)
    for form, theirs in (("trig", "trig"), ("nq", "nquads"), ("jsonld", "json-ld")):
        again = rdflib.Dataset()
        again.parse(data=serialised(found, form, names), format=theirs)
        assert _plain(again) == expected


def _plain(given: rdflib.Dataset) -> set[tuple[str, ...]]:
    return {
        (str(s), str(p), str(o), str(getattr(o, "datatype", None)), str(g)) for s, p, o, g in given.quads()
    }


def test_rdflib_is_loaded_only_when_asked_for() -> None:
    script = (
        "import sys, deixis.cli.commands, deixis.rdf, deixis.rdf.export, deixis.rdf.reader\n"
        "assert 'rdflib' not in sys.modules\n"
    )
    subprocess.run([sys.executable, "-c", script], check=True)


# One graph only


def test_one_graph_cannot_hold_two_views(figure_3: Scene, tmp_path: Path) -> None:
    with KnowledgeBase(figure_3) as kb:
        with pytest.raises(QueryError, match="ttl holds one graph, in which the relations of 2 views"):
            save(kb, tmp_path / "scene.ttl", proofs=False)
        assert not list(tmp_path.iterdir())
        save(kb, tmp_path / "scene.ttl", proofs=False, view="v1")
    assert readers.read_one("rdf", tmp_path / "scene.ttl").to_json() == figure_3.to_json()
    found = store((tmp_path / "scene.ttl").read_bytes(), ox.RdfFormat.TURTLE)
    assert rows(found, "SELECT ?a { ?a :leftOf ?b }") == []
    assert rows(found, "SELECT ?a { ?a :leansOn ?b }") == [("urn:deixis:scene:hans:thing:extinguisher2",)]


# The door


def refuse(tmp_path: Path, text: str, form: str, match: str) -> None:
    path = tmp_path / f"x.{form}"
    path.write_text(text, encoding="utf-8")
    start = time.monotonic()
    with pytest.raises(ReaderError, match=match):
        readers.read_one("rdf", path)
    assert time.monotonic() - start < 5.0


def test_triple_terms_are_refused_before_they_end_the_process(tmp_path: Path) -> None:
    deep = "<urn:a> <urn:b> " + "<<( <urn:a> <urn:b> " * 100_000 + "1" + " )>>" * 100_000 + " ."
    for form in ("ttl", "trig", "nt", "nq"):
        refuse(tmp_path, deep, form, "triple terms, which are RDF 1.2")
    refuse(tmp_path, '<urn:a> <urn:b> "x", << <urn:a> <urn:b> 1 >> .', "ttl", "RDF 1.2")


def test_what_only_looks_like_a_triple_term_is_read(tmp_path: Path) -> None:
    given = scene(floor(), box("<<( \"\" ''' #", [0, 0, 1], [1, 1, 1], label="<< a >>"))
    with KnowledgeBase(given) as kb:
        save(kb, tmp_path / "x.trig", view="v0")
        save(kb, tmp_path / "x.ttl", view="v0")
    for form in ("trig", "ttl"):
        path = tmp_path / f"x.{form}"
        path.write_text("# << not one\n" + path.read_text(encoding="utf-8"), encoding="utf-8")
        assert readers.read_one("rdf", path).to_json() == given.to_json()


def test_deep_json_and_foreign_contexts_are_refused(tmp_path: Path) -> None:
    refuse(
        tmp_path, '{"urn:b":' * 60_000 + "1" + "}" * 60_000, "jsonld", f"nested more than {MAX_DEPTH} deep"
    )
    remote = {"@context": "http://127.0.0.1:9/context", "@id": "urn:a", "b": 1}
    refuse(tmp_path, json.dumps(remote), "jsonld", "remote contexts")


@pytest.mark.parametrize(
    ("change", "match"),
    [
        ((" :Scene ,", " :Place ,"), "holds no scene"),
        (("a :BoxRegion", "a :Sphere"), "is of 1 kinds of region"),
        ((':sizeX "1.0"', ':sizeX "wide"'), "'wide' for urn:deixis:term:sizeX: give a number"),
        (
            (':sizeX "1.0"', ':sizeX "1.0"^^xsd:double ; :sizeX "2.0"'),
            "has 2 values of urn:deixis:term:sizeX",
        ),
        ((':sizeX "1.0"', ':sizeQ "1.0"'), "has no urn:deixis:term:sizeX: add it"),
        ((":region ", ":regions "), "has no urn:deixis:term:region: add it"),
        (("@prefix :", "@prefox :"), "is not ttl"),
    ],
)
def test_what_is_incomplete_is_named(tmp_path: Path, change: tuple[str, str], match: str) -> None:
    with KnowledgeBase(scene(box("cup", [0, 0, 0], [1, 2, 3]))) as kb:
        save(kb, tmp_path / "x.ttl", proofs=False)
    text = (tmp_path / "x.ttl").read_text(encoding="utf-8")
    assert change[0] in text
    refuse(tmp_path, text.replace(*change), "ttl", match)


def test_the_doors_of_scenes_stands_behind(tmp_path: Path) -> None:
    with KnowledgeBase(scene(box("cup", [0, 0, 0], [1, 2, 3]))) as kb:
        save(kb, tmp_path / "x.ttl", proofs=False)
    text = (tmp_path / "x.ttl").read_text(encoding="utf-8").replace(':sizeX "1.0"', ':sizeX "-1.0"')
    (tmp_path / "x.ttl").write_text(text, encoding="utf-8")
    result = call("import", "rdf", tmp_path / "x.ttl", "-o", tmp_path / "x.json")
    assert result.code == 2
    assert "object 'cup'" in result.err
    assert not (tmp_path / "x.json").exists()


# The command line


def test_export_and_import(tmp_path: Path, figure_3: Scene) -> None:
    source = ROOT / "kb" / "scenes" / "hans.json"
    done = call("export", source, "-o", tmp_path / "hans.trig")
    assert (done.code, done.out) == (0, "")
    assert re.search(r"hans.trig: \d{4} quads\n$", done.err)
    done = call("import", "rdf", tmp_path / "hans.trig", "-o", tmp_path / "hans.json")
    assert done.code == 0
    assert Scene.load(tmp_path / "hans.json").to_json() == figure_3.to_json()


def test_an_unknown_ending_is_refused(tmp_path: Path) -> None:
    done = call("export", ROOT / "kb" / "scenes" / "hans.json", "-o", tmp_path / "hans.xml")
    assert done.code == 2
    known = ".trig, .nq, .jsonld, .ttl, .nt, .mcap"
    assert done.err == f"deixis: 'hans.xml' ends in no known format: name it with one of {known}\n"
    with KnowledgeBase(Scene("empty")) as kb, pytest.raises(ReaderError, match=r"no format of RDF.*, \.nt$"):
        save(kb, tmp_path / "hans.mcap")


def test_an_unwritable_place_is_named(tmp_path: Path) -> None:
    done = call(
        "export", ROOT / "kb" / "scenes" / "hans.json", "-o", tmp_path / "none" / "hans.nq", "--no-proofs"
    )
    assert done.code == 2
    assert "cannot be written: No such file or directory" in done.err


@pytest.mark.parametrize("form", ["ttl", "trig", "nq", "jsonld"])
def test_nothing_found_is_a_dataset_that_names_the_scene_and_no(tmp_path: Path, form: str) -> None:
    path = tmp_path / "alone.json"
    alone = scene(box("cup", [0, 0, 0], [1, 1, 1]))
    alone.save(path)
    done = call("relations", path, "--format", form)
    assert (done.code, done.out[-1]) == (1, "\n")
    found = {(str(q.predicate), q.object.value) for q in ox.parse(done.out.encode(), format=FORMATS[form])}
    assert (f"<{IDENTIFIER}>", alone.id) in found
    assert len(found) == 2


def test_printed_relations_are_no_scene_to_read(tmp_path: Path) -> None:
    path = tmp_path / "some.trig"
    path.write_text(call("relations", ROOT / "kb" / "scenes" / "hans.json", "--format", "trig").out)
    done = call("import", "rdf", path, "-o", tmp_path / "x.json")
    assert (done.code, "`deixis export` writes" in done.err) == (2, True)


# Without pyoxigraph


def without(module: str, *arguments: str | Path) -> subprocess.CompletedProcess[str]:
    """Run a command in a process that cannot import a module."""
    script = f"import sys; sys.modules[{module!r}] = None\nfrom deixis.cli import main\nsys.exit(main())"
    return subprocess.run(
        [sys.executable, "-c", script, *arguments],
        capture_output=True,
        text=True,
        encoding="utf-8",
        check=False,
    )


def test_what_needs_a_triple_store_says_how_to_get_one(tmp_path: Path) -> None:
    source = ROOT / "kb" / "scenes" / "hans.json"
    for arguments in (
        ("export", source, "-o", tmp_path / "x.nq"),
        ("relations", source, "--format", "nq"),
        ("relations", source, "--engine", "sparql"),
        ("import", "rdf", source, "-o", tmp_path / "x.json"),
    ):
        done = without("pyoxigraph", *arguments)
        assert (done.returncode, done.stdout) == (2, "")
        assert done.stderr == "deixis: RDF needs pyoxigraph: pip install 'deixis[rdf]'\n"


def test_what_needs_none_works_without(tmp_path: Path) -> None:
    assert without("pyoxigraph", "ontology", "onTopOf").stdout.startswith(":onTopOf a owl:ObjectProperty")
    assert without("pyoxigraph", "rules", "compile", "--to", "sparql").returncode == 0
    script = (
        "import sys; sys.modules['pyoxigraph'] = None\n"
        "from deixis.readers import sniff\n"
        "print(*map(sniff, sys.argv[1:]))"
    )
    export = tmp_path / "scene.nq"
    with KnowledgeBase(scene(floor())) as kb:
        save(kb, export)
    command = [sys.executable, "-c", script, export, ROOT / "kb" / "ontology.ttl", ROOT / "README.md"]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    assert done.stdout == "rdf None None\n"
