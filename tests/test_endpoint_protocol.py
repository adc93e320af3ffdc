"""The endpoint keeps to the SPARQL 1.1 protocol: the W3C's own tests, and what they leave out."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest
from rdflib import RDF, Dataset, Graph, Namespace, URIRef
from rdflib.compare import isomorphic
from rdflib.plugins.stores.sparqlstore import SPARQLStore
from SPARQLWrapper import JSON, SPARQLWrapper

from deixis.knowledge import KnowledgeBase
from deixis.rdf.export import nquads
from deixis.server.screening import screen
from deixis.server.terms import unknown_terms
from endpoint import HANS, Server, serving
from w3c_protocol import SUITE, Case, GraphStep, cases, graph_cases, graph_path

CASES, GRAPH_CASES = cases(), graph_cases()
SD = Namespace("http://www.w3.org/ns/sparql-service-description#")
ON_TOP = "PREFIX d: <urn:deixis:term:> SELECT ?a { ?a d:onTopOf ?b } ORDER BY ?a"
TABULAR = ("application/sparql-results+json", "application/sparql-results+xml", "text/csv")

needs_suite = pytest.mark.skipif(not CASES, reason=f"the W3C's tests are not at {SUITE}")


@pytest.fixture(scope="module")
def writable() -> Iterator[Server]:
    with serving("--writable") as server:
        yield server


@pytest.fixture(scope="module")
def server() -> Iterator[Server]:
    with serving(HANS) as running:
        yield running


def run(server: Server, case: Case, *, token: bool) -> list[str]:
    """Run the requests of a test; return what was not as it must be."""
    wrong = []
    for step in case.steps:
        headers = {name.replace("-", "_"): value for name, value in step.headers.items()}
        reply = server.send(step.method, step.path, step.body, token=token, **headers)
        told = f"{case.name}: {reply.status} {reply.body[:200]!r}"
        right = f"{reply.status // 100}xx" in step.statuses
        if not right or (step.boolean is not None and reply.json["boolean"] != step.boolean):
            wrong.append(told)
        media = reply.headers.get("content-type", "").partition(";")[0]
        match step.form:
            case "boolean" | "tabular" if media not in TABULAR:
                wrong.append(f"{told} is {media}")
            case "RDF":
                Graph().parse(data=reply.body, format=media)
    return wrong


@needs_suite
def test_the_suite_is_whole() -> None:
    assert (len(CASES), len(GRAPH_CASES)) == (34, 13)


@needs_suite
@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_w3c_with_updates(writable: Server, case: Case) -> None:
    assert writable.update("CLEAR ALL").status == 204
    for name, data in case.graphs.items():
        put = writable.send("PUT", graph_path(name), data, token=True, content_type="application/n-triples")
        assert put.status in (201, 204)
    assert run(writable, case, token=True) == []


@needs_suite
@pytest.mark.parametrize("case", [one for one in CASES if one.writes], ids=lambda case: case.name)
def test_w3c_updates_are_refused_when_read_only(server: Server, case: Case) -> None:
    before = server.send("GET", "/graphs").body
    step = case.steps[0]
    headers = {name.replace("-", "_"): value for name, value in step.headers.items()}
    reply = server.send(step.method, step.path, step.body, token=True, **headers)
    assert 400 <= reply.status < 500
    assert server.send("GET", "/graphs").body == before


@needs_suite
@pytest.mark.parametrize("steps", GRAPH_CASES.values(), ids=list(GRAPH_CASES))
def test_w3c_graph_store(writable: Server, steps: list[GraphStep]) -> None:
    assert writable.update("CLEAR ALL").status == 204
    assert writable.update("DROP ALL").status == 204
    known: dict[str, str] = {}
    for step in steps:
        path = step.path
        for name, value in known.items():
            path = path.replace(name, value)
        headers = {name.replace("-", "_"): value for name, value in step.headers.items()}
        reply = writable.send(step.method, path, step.body, token=True, **headers)
        assert reply.status in step.statuses, (path, reply.body)
        if step.location:
            known[step.location] = reply.headers["location"]
        if step.media:
            assert reply.headers["content-type"] == step.media
        if step.graph is not None:
            assert isomorphic(Graph().parse(data=reply.body, format="turtle"), step.graph)


@pytest.mark.parametrize(
    ("form", "kind", "status", "told"),
    [
        (
            b"--x\r\nContent-Type: text/turtle\r\n\r\n<urn:a> a <urn:b> .\r\n--x--",
            "",
            400,
            "needs a boundary",
        ),
        (b"--x\r\nContent-Type: text/turtle\r\n\r\n<urn:a> a", "; boundary=x", 400, "ends before its last"),
        (b"--x\r\n\r\n<urn:a> a <urn:b> .\r\n--x--", "; boundary=x", 400, "no Content-Type"),
        (
            b"--x\r\nContent-Type: text/html\r\n\r\n<p>\r\n--x--",
            "; boundary=x",
            415,
            "'text/html' is not read",
        ),
        (b"--x\r\nContent-Type: text/turtle\r\n--x--", "; boundary=x", 400, "no empty line"),
        (b"--x\r\nContent-Type: text/turtle\r\n\r\n<urn:a\r\n--x--", "; boundary=x", 400, "not well formed"),
        (b"\r\n--x" * 10_000, "; boundary=x", 400, "more than 100 parts"),
    ],
)
def test_forms_that_are_wrong_say_what(
    writable: Server, form: bytes, kind: str, status: int, told: str
) -> None:
    reply = writable.send(
        "POST", graph_path("urn:g"), form, token=True, content_type=f"multipart/form-data{kind}"
    )
    assert (reply.status, told in reply.detail) == (status, True), reply.detail
    assert writable.send("GET", graph_path("urn:g")).status == 404


def test_blank_nodes_of_two_texts_are_two(writable: Server) -> None:
    path = graph_path("urn:test:blank")
    for _ in range(2):
        sent = writable.send("POST", path, b"_:a <urn:b> 1 .", token=True, content_type="text/turtle")
        assert sent.status in (201, 204)
    assert writable.query("SELECT ?a { ?a <urn:b> 1 }", "text/csv").body.count(b"\n") == 3
    assert writable.send("DELETE", path, token=True).status == 204


def test_the_service_description_names_this_endpoint(server: Server) -> None:
    reply = server.send("GET", "/sparql", accept="text/turtle")
    told = Graph().parse(data=reply.body, format="turtle")
    (service,) = told.subjects(RDF.type, SD.Service)
    assert told.value(service, SD.endpoint) == URIRef(f"{server.url}/sparql")
    assert (service, SD.supportedLanguage, SD.SPARQL11Update) not in told
    assert (service, SD.feature, SD.BasicFederatedQuery) not in told
    functions = {str(one).rpartition(":")[2] for one in told.objects(service, SD.extensionFunction)}
    assert functions == {"distance3D", "separation3D", "intersects3D", "volume"}
    names = {str(one) for one in told.objects(None, SD.name)}
    assert "urn:deixis:scene:hans:view:v0" in names


@pytest.mark.parametrize(
    ("accept", "media"),
    [
        ("", "application/sparql-results+json"),
        ("*/*", "application/sparql-results+json"),
        ("application/sparql-results+xml", "application/sparql-results+xml"),
        ("text/csv", "text/csv"),
        ("text/tab-separated-values, text/csv;q=0.9", "text/tab-separated-values"),
        ("text/*;q=0.5, application/sparql-results+xml;q=0.4", "text/csv"),
        ("application/json", "application/json"),
    ],
)
def test_tables_in_the_format_that_is_liked_best(server: Server, accept: str, media: str) -> None:
    reply = server.query(ON_TOP, accept)
    assert (reply.status, reply.headers["content-type"].partition(";")[0]) == (200, media)
    assert b"sweater" in reply.body


@pytest.mark.filterwarnings("ignore:ConjunctiveGraph")  # rdflib warns of itself
@pytest.mark.parametrize(
    "media",
    [
        "text/turtle",
        "application/n-triples",
        "application/rdf+xml",
        "application/ld+json",
        "application/trig",
    ],
)
def test_graphs_in_each_format(server: Server, media: str) -> None:
    reply = server.query("CONSTRUCT { ?a <urn:p> ?b } { ?a <urn:deixis:term:onTopOf> ?b }", media)
    assert (reply.status, reply.headers["content-type"].partition(";")[0]) == (200, media)
    form = {"application/ld+json": "json-ld"}.get(media, media)
    assert len(Dataset().parse(data=reply.body, format=form)) == 3


@pytest.mark.parametrize(
    "accept", ["image/png", "text/turtle", "garbage", ";;;", ",".join(["a/b;q=0.1"] * 1000)]
)
def test_what_cannot_be_sent_is_not_acceptable(server: Server, accept: str) -> None:
    reply = server.query(ON_TOP, accept)
    assert (reply.status, "offered" in reply.detail) == (406, True)


@pytest.mark.parametrize("end", ["", " LIMIT 99999"])
def test_what_is_wrong_is_said_of_the_query_as_it_was_written(server: Server, end: str) -> None:
    """A limit of the server's own is put into most queries; nobody is told of it where they fail."""
    query = f"SELECT ?a {{ ?a <urn:p> ?b . {end}"
    reply = server.query(query)
    assert reply.status == 400
    place = f"line 1, column {len(query) + 1}, after" if not end else "line 1, column "
    assert place in reply.detail
    assert reply.detail.split('"')[1] in query


def test_head_has_the_headers_and_no_body(server: Server) -> None:
    for path in ("/sparql", "/sparql?query=ASK%20%7B%7D", "/graphs?default"):
        reply = server.send("HEAD", path)
        assert (reply.status, reply.body) == (200, b"")
        assert server.send("GET", path).headers["content-type"] == reply.headers["content-type"]


def test_the_protocol_overrides_from(server: Server) -> None:
    view = "urn:deixis:scene:hans:view:v0"
    text = "ASK FROM <urn:deixis:scene:hans> { ?a <urn:deixis:term:leftOf> ?b }"
    assert server.query(text).json["boolean"] is False
    assert server.query(text, **{"default-graph-uri": view}).json["boolean"] is True
    assert server.query("ASK { ?a <urn:deixis:term:leftOf> ?b }", **{"default-graph-uri": "urn:x"}).json == {
        "head": {},
        "boolean": False,
    }


def test_graphs_are_read_by_their_names(server: Server) -> None:
    reply = server.send("GET", graph_path("urn:deixis:scene:hans:view:v0"), accept="text/turtle")
    assert (reply.status, b"leftOf" in reply.body) == (200, True)
    assert server.send("GET", graph_path("urn:none")).status == 404
    assert server.send("GET", "/graphs?graph=no+iri").status == 400
    assert server.send("GET", "/graphs?default&graph=urn:a").status == 400
    everything = server.send("GET", "/graphs", accept="application/n-quads").body
    assert everything.count(b"\n") == server.send("GET", "/health").json["quads"]


def test_graphs_are_written_and_dropped_with_the_token(writable: Server) -> None:
    path, turtle = graph_path("urn:test:g"), b"<urn:a> <urn:b> 1 ."
    refused = writable.send("PUT", path, turtle, content_type="text/turtle")
    assert (refused.status, refused.headers["www-authenticate"]) == (401, "Bearer")
    assert writable.send("PUT", path, turtle, token=True, content_type="text/turtle").status == 201
    assert (
        writable.send("POST", path, b"<urn:a> <urn:b> 2 .", token=True, content_type="text/turtle").status
        == 204
    )
    assert (
        writable.query("SELECT ?o { <urn:a> <urn:b> ?o } ORDER BY ?o", "text/csv").body == b"o\r\n1\r\n2\r\n"
    )
    assert writable.send("PUT", path, b"<urn:a", token=True, content_type="text/turtle").status == 400
    assert writable.send("DELETE", path, token=True).status == 204
    assert writable.send("DELETE", path, token=True).status == 404


def test_a_scene_is_not_written_to() -> None:
    with serving(HANS, "--writable") as server:
        quads = server.send("GET", "/health").json["quads"]
        for text in (
            "CLEAR ALL",
            "DELETE WHERE { GRAPH ?g { ?a <urn:deixis:term:onTopOf> ?b } }",
            "INSERT DATA { GRAPH <urn:deixis:scene:hans> { <urn:a> <urn:b> <urn:c> } }",
        ):
            reply = server.update(text)
            assert (reply.status, "PUT the scene" in reply.detail) == (409, True)
        assert server.update("INSERT DATA { <urn:a> <urn:b> <urn:c> }").status == 204
        assert server.send("GET", "/health").json["quads"] == quads + 1
        assert server.put("hans", json.loads(HANS.read_text())).status == 200
        assert server.query("ASK { <urn:a> <urn:b> <urn:c> }").json["boolean"] is True


def test_functions_of_three_dimensions(server: Server) -> None:
    reply = server.query(
        """PREFIX d: <urn:deixis:term:>
        SELECT (d:distance3D(?a, ?b) AS ?far) (d:intersects3D(?a, ?b) AS ?meet) (d:volume(?a) AS ?size)
               (d:separation3D(?a, ?b) AS ?gap) (d:volume(<urn:none>) AS ?none) (d:distance3D(?a) AS ?one) {
          BIND(<urn:deixis:scene:hans:thing:sweater> AS ?a) BIND(<urn:deixis:scene:hans:thing:heater> AS ?b)
        }"""
    )
    (row,) = reply.json["results"]["bindings"]
    assert {"far", "meet", "size", "gap"} == row.keys()
    assert (float(row["far"]["value"]), row["meet"]["value"]) == (0.0, "true")
    objects = {one["id"]: one for one in server.send("GET", "/scenes/hans/objects").json["objects"]}
    x, y, z = objects["sweater"]["box"]["size"]
    assert float(row["size"]["value"]) == pytest.approx(x * y * z)


def test_sparqlwrapper_works_unmodified(server: Server) -> None:
    for method in ("GET", "POST"):
        client = SPARQLWrapper(f"{server.url}/sparql")
        client.setQuery(ON_TOP)
        client.setMethod(method)
        client.setReturnFormat(JSON)
        rows = client.queryAndConvert()["results"]["bindings"]
        assert [row["a"]["value"].rpartition(":")[2] for row in rows] == [
            "extinguisher2",
            "heater",
            "sweater",
        ]


@pytest.mark.parametrize("form", ["xml", "json", "csv", "tsv"])
def test_rdflib_sparqlstore_works_unmodified(server: Server, form: str) -> None:
    graph = Graph(SPARQLStore(f"{server.url}/sparql", returnFormat=form))
    assert len(list(graph.query(ON_TOP))) == 3
    assert (None, URIRef("urn:deixis:term:onTopOf"), None) in graph


@pytest.mark.skipif(shutil.which("curl") is None, reason="curl is not on the PATH")
def test_curl_works_unmodified(server: Server) -> None:
    command = [
        "curl",
        "-sS",
        "-H",
        "Accept: text/csv",
        f"{server.url}/sparql",
        "--data-urlencode",
        f"query={ON_TOP}",
    ]
    for more in ([], ["-G"]):
        done = subprocess.run([*command, *more], capture_output=True, check=True)
        assert done.stdout.splitlines()[0] == b"a"
        assert len(done.stdout.splitlines()) == 4


@pytest.mark.parametrize(
    ("query", "note"),
    [
        (
            "PREFIX d: <urn:deixis:term:> ASK { ?a d:left_of ?b }",
            "unknown term left_of: did you mean leftOf?",
        ),
        (
            "PREFIX : <urn:deixis:term:> ASK { ?a :ontopof ?b. }",
            "unknown term ontopof: did you mean onTopOf?",
        ),
        ("ASK { ?a <urn:deixis:term:east_r> ?b }", "unknown term east_r: did you mean eastRelaxed?"),
        (
            "PREFIX d: <urn:deixis:term:> ASK { ?a d:nere ?b; d:touches ?c; d:xyzzy%20\u00e9 ?d; d:nere ?e }",
            "unknown term nere: did you mean near?; unknown term xyzzy%2520%C3%A9",
        ),
        (ON_TOP, None),
        ("PREFIX d: <urn:deixis:term:> SELECT * { ?a d:distance3D ?b; d:violation.2 ?c; d: ?d }", None),
        ("PREFIX d: <urn:x:> SELECT * { ?a d:left_of ?b, 'urn:deixis:term:left_of' }", None),
    ],
)
def test_a_term_that_there_is_not_is_told_beside_the_answer(
    server: Server, query: str, note: str | None
) -> None:
    for _ in range(2):  # the second time the query is known already
        reply = server.query(query)
        assert (reply.status, reply.headers.get("deixis-note")) == (200, note)


def test_no_note_on_what_an_export_or_an_example_says(root: Path) -> None:
    with KnowledgeBase.from_scene(HANS) as kb:
        stated = sorted(set(re.findall(r"<urn:deixis:term:\S+>", nquads(kb).decode())))
    asked = [" ".join(stated)]
    told = json.loads((root / "src/deixis/server/page/examples.json").read_text())
    prefixes = "".join(f"PREFIX {name}: <{iri}> " for name, iri in told["prefixes"].items())
    asked += [prefixes + one["query"] for one in told["examples"]]
    assert len(stated) > 40
    assert [note for one in asked for note in unknown_terms(screen(one, 1 << 20, 99))] == []
