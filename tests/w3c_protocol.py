"""The W3C tests of the SPARQL protocol, read from their manifest."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from urllib.parse import quote

from rdflib import RDF, RDFS, Graph, Namespace, URIRef
from rdflib.collection import Collection
from rdflib.term import Node

SUITE = Path(__file__).resolve().parent.parent.parent / "shared" / "data" / "w3c-sparql"

_MF = Namespace("http://www.w3.org/2001/sw/DataAccess/tests/test-manifest#")
_HT = Namespace("http://www.w3.org/2011/http#")
_CNT = Namespace("http://www.w3.org/2011/content#")
_UT = Namespace("http://www.w3.org/2009/sparql/tests/test-update#")

_CODES = {"OK": 200, "Created": 201, "NoContent": 204, "NotFound": 404}


@dataclass(frozen=True)
class Step:
    """A request of a test, and what must come back."""

    method: str
    path: str
    headers: dict[str, str]
    body: bytes | None
    statuses: frozenset[str]
    boolean: bool | None
    form: str


@dataclass(frozen=True)
class Case:
    """A test: graphs to load first, by their names, and requests."""

    name: str
    graphs: dict[str, bytes]
    steps: tuple[Step, ...]

    @property
    def writes(self) -> bool:
        """Return whether it updates, or asks what an update left behind."""
        return "update" in self.name


def cases() -> list[Case]:
    """Return all tests, or none where the suite is absent."""
    folder = SUITE / "protocol"
    if not folder.is_dir():
        return []
    manifest = Graph().parse(folder / "manifest.ttl", format="turtle")
    (entries,) = manifest.objects(None, _MF.entries)
    return [_case(manifest, folder, entry) for entry in Collection(manifest, entries)]


@dataclass(frozen=True)
class GraphStep:
    """A request to a graph store: the statuses and the graph that may come back, and a name for Location."""

    method: str
    path: str
    headers: dict[str, str]
    body: bytes | None
    statuses: frozenset[int]
    location: str
    media: str
    graph: Graph | None


def graph_cases() -> dict[str, list[GraphStep]]:
    """Return all tests of the Graph Store Protocol by their names, or none where the suite is absent."""
    found = {}
    for file in sorted((SUITE / "graph-store-protocol").glob("manifest-*.ttl")):
        manifest = Graph().parse(file, format="turtle")
        (entries,) = manifest.objects(None, _MF.entries)
        for entry in Collection(manifest, entries):
            action = manifest.value(entry, _MF.action)
            requests = Collection(manifest, manifest.value(action, _HT.requests))
            found[str(entry).rpartition("#")[2]] = [_graph_step(manifest, one) for one in requests]
    return found


def _graph_step(manifest: Graph, request: Node) -> GraphStep:
    told = manifest.value(request, _HT.resp)
    answered, media = manifest.value(told, _HT.body), _headers(manifest, told).get("content-type", "")
    graph = None
    if answered is not None:
        graph = Graph().parse(data=str(manifest.value(answered, _CNT.chars)), format=media.partition(";")[0])
    body = manifest.value(request, _HT.body)
    return GraphStep(
        str(manifest.value(request, _HT.methodName)),
        str(manifest.value(request, _HT.absolutePath)).replace("/gsp", "/graphs", 1),
        _headers(manifest, request),
        None if body is None else str(manifest.value(body, _CNT.chars)).encode(),
        frozenset(_CODES[str(one).rpartition("#")[2]] for one in manifest.objects(told, _MF.expectedStatus)),
        str(manifest.value(told, _MF.expectedLocation) or ""),
        media,
        graph,
    )


def _headers(manifest: Graph, message: Node) -> dict[str, str]:
    listed = manifest.value(message, _HT.headers)
    return {
        str(manifest.value(one, _HT.fieldName)): str(manifest.value(one, _HT.fieldValue))
        for one in (Collection(manifest, listed) if listed else ())
    }


def _case(manifest: Graph, folder: Path, entry: Node) -> Case:
    graphs = {}
    for data in manifest.objects(entry, _UT.graphData):
        name = str(manifest.value(data, RDFS.label))
        file = str(manifest.value(data, _UT.graph)).rpartition("/")[2]
        graphs[name] = (folder / file).read_bytes()
    action = manifest.value(entry, _MF.action)
    requests = Collection(manifest, manifest.value(action, _HT.requests))
    return Case(
        str(entry).rpartition("#")[2], graphs, tuple(_step(manifest, request) for request in requests)
    )


def _step(manifest: Graph, request: Node) -> Step:
    assert (request, RDF.type, _HT.Request) in manifest
    body = manifest.value(request, _HT.body)
    encoding = "utf-8" if body is None else str(manifest.value(body, _CNT.characterEncoding) or "utf-8")
    text = None if body is None else str(manifest.value(body, _CNT.chars)).encode(encoding)
    told = manifest.value(request, _HT.resp)
    boolean = manifest.value(told, _MF.expectedBoolean)
    return Step(
        str(manifest.value(request, _HT.methodName)),
        str(manifest.value(request, _HT.absolutePath)),
        _headers(manifest, request),
        text,
        frozenset(_status(one) for one in manifest.objects(told, _MF.expectedStatus)),
        None if boolean is None else bool(boolean.toPython()),
        str(manifest.value(told, _MF.expectedFormat) or ""),
    )


def _status(one: Node) -> str:
    """Return the class of a status: ``2xx``."""
    assert isinstance(one, URIRef)
    return str(one).rpartition("StatusCode")[2]


def graph_path(name: str) -> str:
    """Return where a graph is in the graph store."""
    return f"/graphs?graph={quote(name, safe='')}"
