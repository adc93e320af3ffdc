"""Point queries on loopback, with and without hostile ones among them: Deixis beside other endpoints.

    PYTHONPATH=tests python -m bench.server_bench [SECONDS [HOW_MANY_SYSTEMS]]

The same data, the same load, one after the other. ``oxigraph`` and ``rdflib-endpoint`` are of the group
``bench``; what is not installed is left out.
"""

from __future__ import annotations

import json
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from http.client import HTTPConnection, HTTPException
from pathlib import Path
from urllib.parse import quote

from bench.job import room
from deixis.knowledge import KnowledgeBase
from deixis.rdf.export import nquads
from endpoint import free_port

CONNECTIONS = 9

POINT = "SELECT ?b {{ GRAPH ?g {{ <{}> <urn:deixis:term:near> ?b }} }}"

NEAR = "<urn:deixis:term:near>"

BOMB = (
    "SELECT (STRLEN(?c) AS ?n) {{ BIND(REPLACE('xxxxxxxx','x','xxxxxxxxxxxxxxxx') AS ?a) "
    "BIND(REPLACE(?a,'x',?a) AS ?b) BIND(REPLACE(?b,'x',?a) AS ?c) }} # {}"
)

HOSTILE = (
    "SELECT (COUNT(*) AS ?n) {{ GRAPH ?g {{ ?a ?b ?c . ?d ?e ?f . ?h ?i ?j }} }} # {}",
    "SELECT * {{ SERVICE <http://127.0.0.1:9/> {{ ?s ?p ?o }} }} # {}",
    f"SELECT (COUNT(*) AS ?n) {{{{ GRAPH ?g {{{{ ?a {NEAR}*/{NEAR}* ?b . ?c {NEAR}* ?d }}}} }}}} # {{}}",
    BOMB,
    "ASK {{ FILTER(" + "(" * 60 + "1" + ")" * 60 + ") }} # {}",
    "SELECT * {{ GRAPH ?g {{ ?a ?b ?c . ?d ?e ?f }} }} ORDER BY ?c ?f # {}",
)
"""Cases of the catalogue; the number at the end makes each a new one."""


def request(text: str) -> str:
    """Return a GET request as it is sent."""
    return (
        f"GET /?query={quote(text, safe='')} HTTP/1.1\r\nHost: 127.0.0.1\r\n"
        "Accept: application/sparql-results+json\r\n\r\n"
    )


@contextmanager
def running(command: Sequence[str | Path], port: int, path: str) -> Iterator[None]:
    """Run a server until the block ends; it answers when the block begins."""
    process = subprocess.Popen(list(map(str, command)), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        for _ in range(400):
            try:
                connection = HTTPConnection("127.0.0.1", port, timeout=5)
                connection.request("GET", f"{path}?query=ASK%20%7B%7D")
                if connection.getresponse().status == 200:
                    break
            except (OSError, HTTPException):
                time.sleep(0.1)
        yield
    finally:
        process.kill()
        process.wait()


def measure(port: int, path: str, seconds: float, things: Sequence[str], *, hostile: bool) -> tuple[str, ...]:
    """Return queries a second, median and 99th percentile, how many failed, and how many were hostile."""
    honest = [request(POINT.format(one)) for one in things]
    bad = [request(text.format(n)) for n in range(2000) for text in HOSTILE] if hostile else []
    given = {"honest": honest, "hostile": bad}
    sent = json.dumps(given).replace("GET /?query=", f"GET {path}?query=")
    line = [sys.executable, "-m", "bench.load", str(port), str(CONNECTIONS), str(seconds)]
    done = subprocess.run(line, input=sent, capture_output=True, text=True, check=True)
    found = json.loads(done.stdout)
    taken = sorted(found["taken"])
    tail = str(found["failed"]), str(found["hostile"])
    if not taken:
        return "0", "", "", *tail
    return (
        f"{len(taken) / seconds:,.0f}",
        f"{1000 * statistics.median(taken):.1f} ms",
        f"{1000 * taken[min(len(taken) - 1, len(taken) * 99 // 100)]:.1f} ms",
        *tail,
    )


def lines(seconds: float = 5.0, most: int | None = None) -> Iterator[str]:
    """Yield the table, of the first systems only where ``most`` is given."""
    scene = room(100)
    things = [f"urn:deixis:scene:{scene.id}:thing:{one.id}" for one in scene.objects]
    bin_ = Path(sys.executable).parent
    with tempfile.TemporaryDirectory() as place, KnowledgeBase(scene) as kb:
        folder = Path(place)
        data, file = folder / "scene.nq", folder / "scene.json"
        data.write_bytes(nquads(kb))
        scene.save(file)
        port = free_port()
        deixis = [sys.executable, "-m", "deixis", "serve", file, "--port", str(port), "--timeout", "2"]
        systems: list[tuple[str, list[str | Path], str]] = [("Deixis", deixis, "/sparql")]
        if (bin_ / "oxigraph").exists():
            at = folder / "oxigraph"
            load = [bin_ / "oxigraph", "load", "--location", at, "--file", data]
            subprocess.run(load, check=True, capture_output=True)
            serve = [bin_ / "oxigraph", "serve-read-only", "--location", at, "--timeout-s", "2"]
            systems.append(("oxigraph serve", [*serve, "--bind", f"127.0.0.1:{port}"], "/query"))
        if (bin_ / "rdflib-endpoint").exists():
            serve = [bin_ / "rdflib-endpoint", "serve", "--host", "127.0.0.1"]
            systems.append(("rdflib-endpoint", [*serve, "--port", str(port), data], "/"))
        count = len(data.read_bytes().splitlines())
        yield f"{len(things)} things, {count} quads, {CONNECTIONS} connections."
        yield ""
        yield "| endpoint | load | queries/s | median | p99 | failed | hostile sent |"
        yield "|---|---|--:|--:|--:|--:|--:|"
        for name, command, path in systems[:most]:
            for hostile in (False, True):
                # A server of its own for each: what hostile requests leave behind is not carried over.
                with running(command, port, path):
                    measure(port, path, 1.0, things, hostile=False)
                    told = measure(port, path, seconds, things, hostile=hostile)
                load_name = "1 hostile to 9 honest" if hostile else "honest"
                yield f"| {name} | {load_name} | " + " | ".join(told) + " |"


if __name__ == "__main__":
    for line in lines(
        float(sys.argv[1]) if sys.argv[1:] else 5.0, int(sys.argv[2]) if sys.argv[2:] else None
    ):
        print(line, flush=True)
