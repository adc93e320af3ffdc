"""Living scenes over HTTP: updates in, changes out; whole, in order, on the disk, and bounded."""

from __future__ import annotations

import asyncio
import http.client
import json
import random
import re
import signal
import socket
import threading
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest

from commands import run
from deixis import KnowledgeBase, Scene
from deixis.server.events import Events
from deixis.server.store import Store
from deixis.updates import Update
from endpoint import HANS, Reply, Server, serving, start
from scenes import box
from test_endpoint_store import count, scene

LIFTED = {"moves": {"sweater": [0, 0, 0.1]}, "stamp": 7}
ON_TOP = "SELECT ?o { <urn:deixis:scene:hans:thing:sweater> <urn:deixis:term:onTopOf> ?o }"
PROGRAM = (
    "import sys; from pathlib import Path; from deixis.server import Limits, Settings;"
    "from deixis.server.serve import serve;"
    "limits = Limits(streams=3, heartbeat=0.2, kept=2000, event=20_000, send_seconds=1.0);"
    "settings = Settings(port=int(sys.argv[-1]), limits=limits, token='let me in', writable=True);"
    "serve([Path(sys.argv[1])], settings)"
)


@dataclass
class Told:
    """An event that a server sent."""

    kind: str = ""
    data: str = ""
    id: str = ""

    @property
    def json(self) -> Any:
        return json.loads(self.data)


@dataclass
class Listener:
    """A client that follows a scene."""

    response: http.client.HTTPResponse
    comments: list[str] = field(default_factory=list)

    def next(self) -> Told | None:
        """Return the next event; None where the stream ends."""
        told, deadline = Told(), time.monotonic() + 60.0
        while line := self.response.readline().decode():
            name, _, value = line.rstrip("\n").partition(": ")
            if name == "event":
                told.kind = value
            elif name == "data":
                told.data += value
            elif name == "id":
                told.id = value
            elif line == "\n" and (told.data or told.id):
                return told
            elif line.startswith(":"):
                self.comments.append(line)
                assert time.monotonic() < deadline
        return None

    def rest(self) -> Iterator[Told]:
        while (told := self.next()) is not None:
            yield told


@contextmanager
def listening(server: Server, path: str = "/scenes/hans/changes", **headers: str) -> Iterator[Listener]:
    connection = http.client.HTTPConnection("127.0.0.1", server.port, timeout=30)
    connection.request(
        "GET", path, headers={name.replace("_", "-"): value for name, value in headers.items()}
    )
    response = connection.getresponse()
    assert response.status == 200, response.read()
    try:
        yield Listener(response)
    finally:
        response.close()
        connection.close()


@pytest.fixture(scope="module")
def server() -> Iterator[Server]:
    with serving(HANS, command=["-c", PROGRAM]) as running:
        yield running


@pytest.fixture(autouse=True)
def as_it_was(request: pytest.FixtureRequest) -> None:
    if "server" in request.fixturenames:
        assert request.getfixturevalue("server").put("hans", json.loads(HANS.read_text())).status == 200


def test_an_update_answers_what_changed_and_followers_hear_it(server: Server) -> None:
    with KnowledgeBase.from_scene(HANS) as kb, listening(server) as listener:
        headers = dict(listener.response.getheaders())
        assert headers["content-type"] == "text/event-stream; charset=utf-8"
        assert headers["cache-control"] == "no-store"
        first = listener.next()
        assert first is not None
        assert (first.kind, first.data) == ("", "")
        for update in (
            LIFTED,
            {"removed": ["radiator"]},
            {"views": [{"id": "v9", "position": [0, 0, 1], "heading": 0}]},
            {},
        ):
            expected = kb.update(Update.from_dict(update, kb.scene)).to_dict()
            reply = server.change("hans", update)
            assert reply.status == 200
            answer = reply.json
            told = listener.next()
            assert told is not None
            assert (told.kind, told.id, told.json) == ("changes", answer["event"], expected)
            assert (answer["gained"], answer["lost"]) == (expected["gained"], expected["lost"])
            assert answer["stamp"] == expected.get("stamp")
            assert answer["count"] == len(answer["gained"]) + len(answer["lost"])
            assert answer["truncated"] is False
        assert Scene.from_dict(server.send("GET", "/scenes/hans").json).to_dict() == kb.scene.to_dict()


def test_all_answer_from_what_was_acknowledged(server: Server) -> None:
    for way in (0.1, -0.1, 0.1):
        assert server.change("hans", {"moves": {"sweater": [0, 0, way]}}).status == 200
        on = way < 0
        assert len(server.query(ON_TOP).json["results"]["bindings"]) == on
        found = server.send("GET", "/scenes/hans/relations?relation=on_top_of&figure=sweater").json
        assert found["total"] == on
        answer = server.send("GET", "/scenes/hans/why?goal=on_top_of(sweater,heater)").json
        assert answer["holds"] is on
    view = {"id": "v9", "label": "Ada", "position": [0, 0, 1], "heading": 0}
    assert server.change("hans", {"views": [view], "removed": ["sweater"]}).status == 200
    (told,) = server.send("GET", "/scenes").json["scenes"]
    assert told["objects"] == 7
    assert "view:v9" in told["graphs"]
    assert {"id": "v9", "label": "Ada"} in told["views"]
    graph = "urn:deixis:scene:hans:view:v9"
    assert server.send("GET", f"/graphs?graph={graph}", accept="text/turtle").status == 200
    assert server.query(f"ASK {{ GRAPH <{graph}> {{ ?a ?b ?c }} }}").json["boolean"] is True
    refused = server.update(f"INSERT DATA {{ GRAPH <{graph}> {{ <urn:a> <urn:b> 'c' }} }}")
    assert refused.status == 409
    assert server.change("hans", {"removed_views": ["v9"]}).status == 200
    assert server.query(f"ASK {{ GRAPH <{graph}> {{ ?a ?b ?c }} }}").json["boolean"] is False


GARBAGE = [
    b"",
    b"{",
    b"[]",
    b"null",
    b"7",
    b"\xff\xfe",
    b'{"moves": {"nobody": [0, 0, 1]}}',
    b'{"moves": {"sweater": [0, 0]}}',
    b'{"moves": {"sweater": [0, 0, 1e999]}}',
    b'{"moves": {"sweater": [0, 0, NaN]}}',
    b'{"moves": []}',
    b'{"removed": "sweater"}',
    b'{"moves": {"sweater": [0, 0, 1e300]}}',
    b'{"removed": ["nobody"]}',
    b'{"removed": ["sweater", 1]}',
    b'{"removed_views": ["v77"]}',
    b'{"evil": 1}',
    b'{"stamp": "now"}',
    b'{"stamp": ' + b"9" * 5000 + b"}",
    b'{"objects": [{"id": "a"}]}',
    b'{"objects": [{"id": "a", "points": "/etc/passwd"}]}',
    b'{"objects": [{"id": "a", "mesh": "../x.ply"}]}',
    b'{"removed": ["sweater"], "moves": {"sweater": [0, 0, 1]}}',
    b'{"removed": ["sweater"], "removed": []}',
    b"[" * 100_000,
    b'{"views": [{"id": "v9", "position": [0, 0, 1e400], "heading": 0}]}',
    b'{"objects": [{"id": "a\\ud800", "box": {"center": [0, 0, 0], "size": [1, 1, 1]}}]}',
]


def test_what_is_refused_changes_nothing_and_nobody_hears_of_it(server: Server) -> None:
    before = server.send("GET", "/scenes/hans").body
    with listening(server) as listener:
        listener.next()
        for text in GARBAGE:
            reply = server.send("POST", "/scenes/hans/updates", text, token=True)
            assert reply.status == 400, (text[:100], reply.body)
            assert "Traceback" not in reply.detail
        assert server.send("GET", "/scenes/hans").body == before
        event = server.change("hans", LIFTED).json["event"]
        told = listener.next()
        assert told is not None
        assert told.id == event


def test_who_may_update(server: Server) -> None:
    assert server.change("hans", LIFTED, token=False).status == 401
    wrong = server.send("POST", "/scenes/hans/updates", b"{}", authorization="Bearer wrong")
    assert wrong.status == 401
    assert server.change("nobody", LIFTED).status == 404
    with serving(HANS) as other:
        assert other.change("hans", LIFTED).status == 403
        assert other.send("GET", "/scenes/nobody/changes").status == 404


def test_who_was_away_goes_on_where_it_was(server: Server) -> None:
    events = [server.change("hans", {"stamp": n}).json["event"] for n in range(5)]
    for given in ({"path": f"/scenes/hans/changes?since={events[1]}"}, {"last_event_id": events[1]}):
        with listening(server, **given) as listener:
            told = [listener.next() for _ in range(4)]
            assert [one and one.id for one in told] == events[1:]
            assert [one and one.json["stamp"] for one in told[1:]] == [2.0, 3.0, 4.0]
    life = events[0].partition("-")[0]
    for unknown in (
        "x",
        "",
        f"{life}-99999999",
        f"{life}--1",
        "deadbeef-1",
        f"{life}-" + "9" * 50,
        f"{life}-²",
    ):
        with listening(server, last_event_id=unknown.encode().decode("latin-1")) as listener:
            told_now = listener.next()
            assert told_now is not None
            assert (told_now.kind, told_now.id) == ("reload", events[-1]), unknown
    for n in range(60):
        server.change("hans", {"stamp": n})
    with listening(server, last_event_id=events[1]) as listener:
        listener.next()
        told_now = listener.next()
        assert told_now is not None
        assert (told_now.kind, "not kept" in told_now.json["because"]) == ("reload", True)


def test_a_replaced_scene_is_told_as_such_and_a_removed_one_is_gone(server: Server) -> None:
    room = scene("room", 3)
    server.put("room", room)
    with listening(server, "/scenes/room/changes") as listener:
        listener.next()
        server.put("room", room)
        reply = server.change("room", {"removed": ["t2"]})
        server.send("DELETE", "/scenes/room", token=True)
        told = list(listener.rest())
        assert [one.kind for one in told] == ["reload", "changes", "gone"]
        assert told[1].id == reply.json["event"]
    assert server.change("room", {}).status == 404
    assert server.send("GET", "/scenes/room/changes").status == 404
    server.put("room", room)
    # Another life: what was heard of the one before is no place in this one.
    with listening(server, "/scenes/room/changes", last_event_id=told[1].id) as listener:
        again = listener.next()
        assert again is not None
        assert again.kind == "reload"
    server.send("DELETE", "/scenes/room", token=True)


def test_what_is_too_much_for_an_event_is_told_as_reload(server: Server) -> None:
    crowd = [box(f"c{n}", (n % 15 * 0.3, n // 15 * 0.3, 0.1), (0.2, 0.2, 0.2)) for n in range(150)]
    with listening(server) as listener:
        listener.next()
        answer = server.change("hans", {"objects": crowd}).json
        told = listener.next()
        assert told is not None
        assert (told.kind, told.id) == ("reload", answer["event"])
        assert str(answer["count"]) in told.json["because"]
        assert (answer["gained"], answer["lost"], answer["truncated"]) == ([], [], True)
        assert answer["count"] > 500
        assert (
            server.change("hans", {"removed": [one["id"] for one in crowd]}).json["count"] == answer["count"]
        )


def test_silence_is_told_too(server: Server) -> None:
    with listening(server) as listener:
        listener.next()
        threading.Timer(1.0, server.change, ("hans", {})).start()
        listener.next()
        assert len(listener.comments) >= 2


def test_only_so_many_may_follow(server: Server) -> None:
    with ExitStack() as stack:
        for _ in range(3):
            stack.enter_context(listening(server)).next()
        reply = server.send("GET", "/scenes/hans/changes")
        assert (reply.status, bool(reply.headers["retry-after"])) == (429, True)
    deadline = time.monotonic() + 10
    while server.send("GET", "/health").json["following"] and time.monotonic() < deadline:
        time.sleep(0.05)
    with listening(server) as listener:
        assert listener.next() is not None


def test_who_may_listen(server: Server) -> None:
    assert server.send("GET", "/scenes/hans/changes", host="evil.example").status == 400
    assert server.send("POST", "/scenes/hans/updates", b"{}", token=True, host="evil.example").status == 400
    with listening(server, origin="http://evil.example") as listener:
        assert listener.response.getheader("access-control-allow-origin") is None
    page = "http://page.example"
    with serving(HANS, "--cors", page) as other:
        with listening(other, origin=page) as listener:
            assert listener.response.getheader("access-control-allow-origin") == page
        asked = other.send(
            "OPTIONS", "/scenes/hans/changes", origin=page,
            access_control_request_method="GET", access_control_request_headers="Last-Event-ID",
        )  # fmt: skip
        assert asked.status == 200


def test_it_is_described(server: Server) -> None:
    paths = server.send("GET", "/openapi.json").json["paths"]
    assert list(paths["/scenes/{scene}/changes"]["get"]["responses"]["200"]["content"]) == [
        "text/event-stream"
    ]
    body = paths["/scenes/{scene}/updates"]["post"]["requestBody"]["content"]["application/json"]["schema"]
    assert set(body["properties"]) == {"objects", "moves", "removed", "views", "removed_views", "stamp"}
    assert "/scenes/{scene}/view/data" in paths


def test_two_writers_lose_nothing_of_each_other(server: Server) -> None:
    things = ("sweater", "extinguisher1")
    at = {
        one["id"]: one["box"]["center"][2]
        for one in server.send("GET", "/scenes/hans/objects").json["objects"]
    }

    def move(name: str) -> list[str]:
        return [server.change("hans", {"moves": {name: [0, 0, 0.001]}}).json["event"] for _ in range(25)]

    with listening(server) as listener, ThreadPoolExecutor(4) as pool:
        listener.next()
        told = [event for some in pool.map(move, things * 2) for event in some]
        heard = [listener.next() for _ in told]
    assert sorted(told) == sorted(one.id for one in heard if one is not None)
    numbers = [int(one.id.partition("-")[2]) for one in heard if one is not None]
    assert numbers == list(range(numbers[0], numbers[0] + 100))
    now = {
        one["id"]: one["box"]["center"][2]
        for one in server.send("GET", "/scenes/hans/objects").json["objects"]
    }
    for name in things:
        assert now[name] - at[name] == pytest.approx(0.05)


def test_a_scene_that_comes_and_goes_while_it_is_updated(server: Server) -> None:
    done = threading.Event()
    replies: list[Reply] = []

    def write() -> None:
        while not done.is_set():
            replies.append(server.change("room", {"moves": {"t1": [0, 0, 0.1]}}))

    writers = [threading.Thread(target=write) for _ in range(2)]
    server.put("room", scene("room", 2))
    for writer in writers:
        writer.start()
    try:
        for n in range(6):
            if n % 2:
                assert server.send("DELETE", "/scenes/room", token=True).status == 204
            assert server.put("room", scene("room", 2, 0.1 + n / 100)).status in (200, 201)
            assert count(server, "room") == 2
    finally:
        done.set()
        for writer in writers:
            writer.join()
    assert {reply.status for reply in replies} <= {200, 404}, {reply.body for reply in replies}
    # No update may bring back what was replaced.
    sizes = {one["box"]["size"][0] for one in server.send("GET", "/scenes/room/objects").json["objects"]}
    assert list(sizes) == [pytest.approx(0.15)]
    server.send("DELETE", "/scenes/room", token=True)


def test_a_reader_sees_whole_scenes_only_while_it_is_updated() -> None:
    """Each version has n things, all of one size that tells n: no answer may mix two versions."""
    text = """PREFIX d: <urn:deixis:term:> SELECT (COUNT(*) AS ?n) (MIN(?x) AS ?low) (MAX(?x) AS ?high)
        { GRAPH <urn:deixis:scene:room> { ?t d:minBoundBox ?b . ?b d:sizeX ?x } }"""
    with serving("--writable") as server:
        server.put("room", scene("room", 1, 0.01))
        done, wrong, seen = threading.Event(), [], set()

        def read() -> None:
            while not done.is_set():
                (row,) = server.query(text).json["results"]["bindings"]
                n, low, high = (float(row[name]["value"]) for name in ("n", "low", "high"))
                seen.add(n)
                if not low == high == pytest.approx(n / 100):
                    wrong.append(row)
                things = server.send("GET", "/scenes/room/objects").json["objects"]
                if {one["box"]["size"][0] for one in things} != {len(things) / 100}:
                    wrong.append(things)

        readers = [threading.Thread(target=read) for _ in range(2)]
        for reader in readers:
            reader.start()
        try:
            for n in range(2, 30):
                assert server.change("room", {"objects": scene("room", n, n / 100)["objects"]}).status == 200
                if n % 5 == 0:
                    assert count(server, "room") == n
        finally:
            done.set()
            for reader in readers:
                reader.join()
        assert wrong == []
        assert len(seen) > 1


def test_many_pages_that_are_open_ask_at_the_same_time(server: Server) -> None:
    event = server.change("hans", LIFTED).json["event"]
    with ThreadPoolExecutor(12) as pool:
        replies = list(pool.map(lambda _: server.send("GET", "/scenes/hans/view/data"), range(24)))
    assert {reply.status for reply in replies} == {200}
    assert {reply.json["now"]["event"] for reply in replies} == {event}


def test_streams_end_with_the_server_at_once() -> None:
    with ExitStack() as stack:
        server = start(HANS, "--writable")
        listeners = [stack.enter_context(listening(server)) for _ in range(5)]
        for listener in listeners:
            listener.next()
        server.process.terminate()
        assert [listener.next() for listener in listeners] == [None] * 5
        assert server.process.wait(10) == -signal.SIGTERM
        assert server.process.stderr is not None
        assert b"ERROR" not in server.process.stderr.read()
        server.process.stderr.close()


def test_it_says_that_it_serves_when_it_listens() -> None:
    server = start(HANS)
    with socket.create_connection(("127.0.0.1", server.port)):
        server.process.terminate()
    assert server.process.stderr is not None
    said = server.process.stderr.read().decode()
    assert said == f"deixis: serving http://127.0.0.1:{server.port}/sparql and /scenes; stop with Ctrl-C\n"
    server.process.wait(10)
    server.process.stderr.close()
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        refused = run("serve", HANS, "--port", str(taken.getsockname()[1]))
    assert refused.code == 2
    assert re.fullmatch(r"deixis: the server could not start on [\d.:]+: is the port taken\?\n", refused.err)
    # An address that no machine has.
    refused = run("serve", HANS, "--host", "192.0.2.1")
    assert (refused.code, len(refused.err.splitlines())) == (2, 1)
    assert "could not start on 192.0.2.1:7878: cannot assign" in refused.err
    assert "serving" not in refused.err


def crash(folder: Path, times: int, seed: int) -> None:
    """Update a scene, and kill the server at any moment; see that no acknowledged update is lost."""
    chance = random.Random(seed)  # noqa: S311 - a test
    height = 0.05
    for _ in range(times):
        server = start("--store", folder, "--writable")
        if not server.send("GET", "/scenes").json["scenes"]:
            server.put("room", scene("room", 3))
        (found,) = (
            one for one in server.send("GET", "/scenes/room/objects").json["objects"] if one["id"] == "t1"
        )
        assert found["box"]["center"][2] == pytest.approx(height)
        told = 0

        def write(server: Server = server) -> None:
            nonlocal told
            while True:
                try:
                    reply = server.change("room", {"moves": {"t1": [0, 0, 0.001]}})
                except (OSError, http.client.HTTPException):
                    return
                assert reply.status == 200
                told += 1

        writer = threading.Thread(target=write)
        writer.start()
        time.sleep(chance.uniform(0.05, 0.8))
        server.kill()
        writer.join()
        assert server.process.stderr is not None
        server.process.stderr.close()
        store = Store(folder)
        ((_, text),) = store.scenes()
        store.close()
        kept = next(one for one in json.loads(text)["objects"] if one["id"] == "t1")["box"]["center"][2]
        # The one that was on its way may be there or not.
        steps = round((kept - height) / 0.001)
        assert told <= steps <= told + 1
        height = kept


def test_acknowledged_updates_outlive_kill_9(tmp_path: Path) -> None:
    crash(tmp_path, 4, 1)


@pytest.mark.long
def test_acknowledged_updates_outlive_kill_9_many_times(tmp_path: Path) -> None:
    with ThreadPoolExecutor(4) as pool:
        for done in [pool.submit(crash, tmp_path / str(n), 40, n) for n in range(4)]:
            done.result()


def test_an_event_that_is_not_kept_any_more_is_not_taken_for_another() -> None:
    events = Events(300)
    for n in range(20):
        events.add("changes", f'{{"n": {n}}}')
    # Events are counted from 1: the one after number n says n.
    oldest = 20 - len(events._kept)
    assert 0 < oldest < 20
    number, text = events.after(oldest) or (0, b"")
    assert (number, f'data: {{"n": {oldest}}}' in text.decode()) == (oldest + 1, True)
    for gone in (oldest - 1, 0, -1):
        with pytest.raises(LookupError):
            events.after(gone)


def test_who_reads_too_slowly_is_told_to_load_anew() -> None:
    async def follow() -> list[bytes]:
        events = Events(300)
        stream = events.since(None, 60.0)
        heard = [await anext(stream)]
        for n in range(3):
            events.add("changes", f'{{"n": {n}}}')
        heard += [await anext(stream), await anext(stream)]
        for n in range(100):
            events.add("changes", f'{{"n": {n}}}')
        assert sum(map(len, events._kept)) <= 300
        heard.append(await anext(stream))
        events.add("changes", '{"n": "last"}')
        heard.append(await anext(stream))
        events.end()
        return heard + [one async for one in stream]

    heard = [one.decode() for one in asyncio.run(follow())]
    assert [one.partition("\n")[0] for one in heard[1:]] == [
        "event: changes", "event: changes", "event: reload", "event: changes"
    ]  # fmt: skip
    assert "last" in heard[-1]
