"""Golden scenes: what holds in each is written down, and every surface says just that, no more and no less.

A scene is ``golden/NAME.json``; what holds in it are the rows of ``golden/NAME/RELATION.csv``, and no file
means no row. ``DEIXIS_BLESS=1 pytest tests/test_golden.py`` writes the files anew: read the difference.
"""

from __future__ import annotations

import csv
import io
import json
import os
from pathlib import Path
from urllib.parse import quote

import pyoxigraph as ox
import pytest

from commands import call, run
from deixis import KnowledgeBase
from deixis.rdf.export import nquads
from deixis.rdf.formats import FORMATS
from deixis.rdf.namespaces import PREFIXES
from deixis.vocabulary import BY_NAME, RELATIONS, Term

HERE = Path(__file__).resolve().parent / "golden"
SAMPLES = HERE.parent.parent / "kb" / "scenes"

SCENES = {path.stem: path for path in sorted(HERE.glob("*.json"))} | {"figure_3": SAMPLES / "hans.json"}

TERMS = [*(BY_NAME[name] for name in ("is_close", "touches", "intersects", "compl_cont")), *RELATIONS]
NAMES = [term.name for term in TERMS]

Row = tuple[str, ...]
Rows = dict[str, list[Row]]

GOAL = "(" + " ; ".join(
    f"R = {term.name}, {term.name}(F, G, V)" if term.view else f"R = {term.name}, {term.name}(F, G), V = ''"
    for term in TERMS
) + ")"  # fmt: skip
"""A question whose answers are all rows of all relations: relation R, figure F, reference G, view V."""


IN_RDF = """
SELECT ?name ?figure ?reference ?view {
  VALUES (?name ?relation) { TERMS }
  GRAPH ?graph { ?one ?relation ?other }
  GRAPH ?scene { ?one a :SpatialObject ; dcterms:identifier ?figure .
                 ?other a :SpatialObject ; dcterms:identifier ?reference . }
  OPTIONAL { GRAPH ?metadata { ?graph a :View ; dcterms:identifier ?view } }
}""".replace("TERMS", " ".join(f'("{term.name}" :{term.rdf})' for term in TERMS))
"""The same question to an export."""


def header(term: Term) -> list[str]:
    return ["figure", "reference", "view"] if term.view else ["figure", "reference"]


def gather(found: list[tuple[str, str, str, str | None]]) -> Rows:
    """Return the rows of each relation, sorted; those of a relation that depends on no view are pairs."""
    rows: Rows = {name: [] for name in NAMES}
    for name, figure, reference, view in found:
        assert bool(view) == BY_NAME[name].view
        rows[name].append((figure, reference, view) if view else (figure, reference))
    return {name: sorted(of_name) for name, of_name in rows.items()}


def by_python(path: Path) -> Rows:
    with KnowledgeBase.from_scene(path) as kb:
        found = kb.relations(relation=NAMES)
    return gather([(one.relation, one.figure, one.reference, one.view) for one in found])


def bless(name: str) -> None:
    folder = HERE / name
    folder.mkdir(exist_ok=True)
    for relation, rows in by_python(SCENES[name]).items():
        path = folder / f"{relation}.csv"
        if not rows:
            path.unlink(missing_ok=True)
            continue
        with path.open("w", encoding="utf-8", newline="") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerows([header(BY_NAME[relation]), *rows])


@pytest.fixture(params=SCENES)
def name(request: pytest.FixtureRequest) -> str:
    if os.environ.get("DEIXIS_BLESS") == "1":
        bless(request.param)
    return str(request.param)


def golden(name: str) -> Rows:
    """Return what is written down for a scene."""
    rows: Rows = {relation: [] for relation in NAMES}
    for path in sorted((HERE / name).iterdir()):
        with path.open(encoding="utf-8", newline="") as file:
            first, *rest = csv.reader(file)
        assert path.suffix == ".csv"
        assert first == header(BY_NAME[path.stem])
        assert rest
        rows[path.stem] = [tuple(row) for row in rest]
        assert rows[path.stem] == sorted(set(rows[path.stem]))
    return rows


def test_a_golden_scene_is_called_as_its_file() -> None:
    assert {path.name for path in HERE.iterdir() if path.is_dir()} == set(SCENES)
    for name, path in SCENES.items():
        if name not in ("figure_3", "names_are_only_names"):
            assert json.loads(path.read_text(encoding="utf-8"))["id"] == name


def test_python(name: str) -> None:
    assert by_python(SCENES[name]) == golden(name)


def test_command_line_json(name: str) -> None:
    options = [word for relation in NAMES for word in ("--relation", relation)]
    result = call("relations", SCENES[name], *options, "--format", "json")
    assert result.code == 0
    said = json.loads(result.out)
    assert said["scene"] == json.loads(SCENES[name].read_text(encoding="utf-8"))["id"]
    found = [(one["relation"], one["figure"], one["reference"], one["view"]) for one in said["relations"]]
    assert gather(found) == golden(name)


def test_command_line_csv(name: str) -> None:
    options = [word for relation in NAMES for word in ("--relation", relation)]
    result = call("relations", SCENES[name], *options, "--format", "csv")
    assert (result.code, result.err) == (0, "")
    first, *rest = csv.reader(io.StringIO(result.out))
    assert first == ["relation", "figure", "reference", "view", "margin"]
    assert gather([(row[0], row[1], row[2], row[3]) for row in rest]) == golden(name)


def test_questions(name: str) -> None:
    result = call("ask", SCENES[name], GOAL, "--format", "json")
    assert (result.code, result.err) == (0, "")
    said = json.loads(result.out)
    assert not said["truncated"]
    assert gather([(one["R"], one["F"], one["G"], one["V"]) for one in said["answers"]]) == golden(name)


def by_sparql(text: bytes, form: ox.RdfFormat) -> Rows:
    store = ox.Store()
    store.load(text, format=form)
    found = store.query(IN_RDF, prefixes=PREFIXES)
    return gather([tuple(None if one is None else one.value for one in row) for row in found])


def test_sparql_over_the_export(name: str) -> None:
    with KnowledgeBase.from_scene(SCENES[name]) as kb:
        text = nquads(kb)
    assert by_sparql(text, ox.RdfFormat.N_QUADS) == golden(name)


@pytest.mark.parametrize("form", ["trig", "jsonld"])
def test_command_line_rdf(name: str, form: str) -> None:
    options = [word for relation in NAMES for word in ("--relation", relation)]
    result = call("relations", SCENES[name], *options, "--format", form)
    assert (result.code, result.err) == (0, "")
    # What a view is called stands in an export's metadata.
    views = {
        f"urn:deixis:scene:{quote(scene['id'], safe='')}:view:{quote(view['id'], safe='')}": view["id"]
        for scene in [json.loads(SCENES[name].read_text(encoding="utf-8"))]
        for view in scene["views"]
    }
    named = "".join(
        f"<{iri}> a <urn:deixis:term:View> ; <{PREFIXES['dcterms']}identifier> {json.dumps(view)} ."
        for iri, view in views.items()
    )
    store = ox.Store()
    store.load(result.out.encode(), format=FORMATS[form])
    store.load(f"<urn:metadata> {{ {named} }}".encode(), format=ox.RdfFormat.TRIG)
    found = store.query(IN_RDF, prefixes=PREFIXES)
    assert gather([tuple(one and one.value for one in row) for row in found]) == golden(name)


def test_prolog_shell(name: str) -> None:
    # No id holds a tab or a line's end: the door refuses them.
    told = run(
        "shell", SCENES[name], stdin=rf'forall({GOAL}, format("row\t~w\t~w\t~w\t~w~n", [R, F, G, V])).'
    )
    assert (told.code, told.err.strip()) == (0, "")
    # A relation may hold for several reasons, and then is found several times.
    found = {tuple(line.split("\t")[1:]) for line in told.out.splitlines() if line.startswith("row\t")}
    assert gather([(row[0], row[1], row[2], row[3]) for row in found]) == golden(name)


def test_facts_agree_on_what_they_decide(name: str) -> None:
    """The truth columns of the facts are computed apart from the rules, by the same thresholds."""
    result = call("facts", SCENES[name], "--format", "json")
    assert result.code == 0
    facts = json.loads(result.out)["facts"]
    expected = golden(name)
    for relation in ("is_close", "touches", "intersects", "compl_cont"):
        pairs = [(one["figure"], one["reference"]) for one in facts if one[relation]]
        if relation == "compl_cont":
            pairs = [(container, content) for content, container in pairs]
        assert sorted(pairs) == expected[relation]
