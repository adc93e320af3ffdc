"""The query page in a browser: an example is asked and answered, and nothing comes from elsewhere."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path
from urllib.parse import quote

import pytest

from deixis import Scene
from deixis.moments import seconds
from deixis.semantic_map import create_map
from endpoint import HANS, Server, serving
from scenes import box, scene

PAGE = Path(__file__).resolve().parent.parent / "src" / "deixis" / "server" / "page"
EXAMPLES = json.loads((PAGE / "examples.json").read_text(encoding="utf-8"))
PREFIXES = "".join(f"PREFIX {name}: <{iri}>\n" for name, iri in EXAMPLES["prefixes"].items())
BROWSER = shutil.which("chromium") or shutil.which("chromium-browser")

built = pytest.mark.skipif(not (PAGE / "vendor").is_dir(), reason="the query page is not built: make page")


@pytest.fixture(scope="module")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Server]:
    """Serve a map: some examples ask for times."""
    place, shown = tmp_path_factory.mktemp("map") / "hans.duckdb", Scene.load(HANS)
    with create_map(place, shown) as kept:
        kept.add(shown, stamp=seconds("2026-11-22T10:00:00Z"))
        kept.add(
            scene(box("sign", (0, 0, 0.2), (0.1, 0.1, 0.4)), views=[]), stamp=seconds("2026-11-22T10:42:00Z")
        )
    with serving(place) as running:
        yield running


@pytest.mark.parametrize("example", EXAMPLES["examples"], ids=lambda example: example["title"])
def test_examples_have_answers(server: Server, example: dict[str, str]) -> None:
    reply = server.query(PREFIXES + example["query"])
    assert reply.status == 200
    assert reply.json["results"]["bindings"]


def test_nothing_is_named_that_is_not_here() -> None:
    for name in ("query.html", "query.css", "query.js"):
        assert "http" not in (PAGE / name).read_text(encoding="utf-8")
    locked = (PAGE / "package-lock.json").read_text(encoding="utf-8")
    assert "http" not in locked
    whole = [one for name, one in json.loads(locked)["packages"].items() if name]
    assert all(one["integrity"].startswith("sha512-") for one in whole)


@built
def test_the_files_of_the_page_and_no_others_are_served(server: Server) -> None:
    for path in ("/", "/page/query.js", "/page/vendor/yasgui.min.js", "/page/vendor/LICENSES.txt"):
        reply = server.send("GET", path)
        assert (reply.status, "script-src 'self';" in reply.headers["content-security-policy"]) == (200, True)
    for path in ("/page/../app.py", "/page/__init__.py", "/page/vendor/../../app.py", "/page//etc/passwd"):
        assert server.send("GET", path).status == 404
    licences = server.send("GET", "/page/vendor/LICENSES.txt").body.decode()
    assert {"@zazuko/yasgui", "codemirror", "dompurify", "datatables.net"} <= set(
        re.findall(r"^(\S+) \d\S*: ", licences, re.MULTILINE)
    )


@built
@pytest.mark.skipif(BROWSER is None, reason="there is no chromium on the PATH")
def test_an_example_is_answered_in_a_browser(server: Server, tmp_path: Path) -> None:
    query = PREFIXES + EXAMPLES["examples"][0]["query"]
    done = subprocess.run(
        [
            str(BROWSER),
            "--headless",
            "--no-sandbox",
            "--disable-gpu",
            f"--user-data-dir={tmp_path}",
            "--enable-logging=stderr",
            "--virtual-time-budget=10000",
            "--dump-dom",
            f"{server.url}/#query={quote(query)}",
        ],
        capture_output=True,
        text=True,
        timeout=120,
        check=True,
    )
    table = done.stdout.partition("yasr")[2]
    assert "sweater" in table
    assert "electric heater" in table
    console = [line for line in done.stderr.splitlines() if "CONSOLE" in line]
    assert [line for line in console if "Content Security Policy" in line or "Uncaught" in line] == []
    # Links for the reader may lead elsewhere; what is loaded may not.
    loaded = re.findall(r'src="([^"]+)"|<link[^>]* href="([^"]+)"', done.stdout)
    assert [one for pair in loaded for one in pair if "//" in one and not one.startswith("data:")] == []
