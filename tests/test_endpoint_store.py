"""Scenes change while the server runs: readers see whole ones, and what was acknowledged outlives a crash."""

from __future__ import annotations

import http.client
import itertools
import json
import random
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest

from commands import run
from deixis.server.store import Store, StoreError
from endpoint import HANS, Server, serving, start

COUNT = "SELECT (COUNT(*) AS ?n) { GRAPH <urn:deixis:scene:%s> { ?t a <urn:deixis:term:SpatialObject> } }"


def scene(name: str, things: int, size: float = 0.1) -> dict[str, Any]:
    """Return a scene with a floor of its own and some boxes in a row, all of the same size."""
    boxes = [
        {"id": f"t{n}", "label": "box", "box": {"center": [n * 2.0, 0.0, size / 2], "size": [size] * 3}}
        for n in range(things)
    ]
    return {"deixis": 1, "id": name, "objects": boxes}


def count(server: Server, name: str) -> int:
    reply = server.query(COUNT % name)
    assert reply.status == 200
    return int(reply.json["results"]["bindings"][0]["n"]["value"])


def test_scenes_are_loaded_replaced_and_removed() -> None:
    with serving() as server:
        assert server.send("GET", "/scenes").json == {"scenes": []}
        assert (server.put("room", scene("room", 3)).status, count(server, "room")) == (201, 3)
        assert (server.put("room", scene("room", 2)).status, count(server, "room")) == (200, 2)
        assert server.put("flat%202", scene("room", 2)).status == 400
        assert server.put("flat%202", scene("flat 2", 2)).json["id"] == "flat 2"
        assert server.put("bad", {"deixis": 1, "id": "bad", "objects": [{"id": "a"}]}).status == 400
        found = server.send("GET", "/scenes").json["scenes"]
        assert [(one["id"], one["objects"]) for one in found] == [("room", 2), ("flat 2", 2)]
        assert server.send("GET", "/scenes/room").json["objects"][1]["id"] == "t1"
        assert server.send("DELETE", "/scenes/room", token=True).status == 204
        assert server.send("DELETE", "/scenes/room", token=True).status == 404
        assert server.send("GET", "/scenes/room").status == 404
        assert (count(server, "room"), count(server, "flat%202")) == (0, 2)


def test_a_reader_sees_whole_scenes_only() -> None:
    """Each version has n things, all of one size that tells n: no answer may mix two versions."""
    text = """PREFIX d: <urn:deixis:term:> SELECT (COUNT(*) AS ?n) (MIN(?x) AS ?low) (MAX(?x) AS ?high)
        { GRAPH <urn:deixis:scene:room> { ?t d:minBoundBox ?b . ?b d:sizeX ?x } }"""
    with serving() as server:
        server.put("room", scene("room", 1, 0.01))
        done, wrong, seen = threading.Event(), [], set()

        def read() -> None:
            while not done.is_set():
                (row,) = server.query(text).json["results"]["bindings"]
                n, low, high = (float(row[name]["value"]) for name in ("n", "low", "high"))
                seen.add(n)
                if not low == high == pytest.approx(n / 100):
                    wrong.append(row)

        readers = [threading.Thread(target=read) for _ in range(3)]
        for reader in readers:
            reader.start()
        try:
            for n in range(2, 14):
                assert server.put("room", scene("room", n, n / 100)).status == 200
                assert count(server, "room") == n
        finally:
            done.set()
            for reader in readers:
                reader.join()
        assert wrong == []
        assert len(seen) > 3


def test_an_old_snapshot_and_its_processes_are_given_up() -> None:
    with serving() as server:
        server.put("room", scene("room", 2))
        before = len(server.family())
        for n in range(3, 9):
            server.put("room", scene("room", n))
        deadline = time.monotonic() + 10
        while len(server.family()) > before and time.monotonic() < deadline:
            time.sleep(0.1)
        assert len(server.family()) <= before


def test_scenes_and_graphs_outlive_the_server(tmp_path: Path) -> None:
    with serving(HANS, "--store", tmp_path, "--writable") as server:
        assert server.put("room", scene("room", 3)).status == 201
        assert server.update("INSERT DATA { GRAPH <urn:g> { <urn:a> <urn:b> 'c' } }").status == 204
        assert server.send("DELETE", "/scenes/hans", token=True).status == 204
        second = run("serve", "--store", tmp_path, "--port", "1024")
        assert (second.code, str(server.process.pid) in second.err) == (2, True)
    with serving("--store", tmp_path) as server:
        assert [one["id"] for one in server.send("GET", "/scenes").json["scenes"]] == ["room"]
        assert count(server, "room") == 3
        assert server.query("ASK { GRAPH <urn:g> { <urn:a> <urn:b> 'c' } }").json["boolean"] is True


def test_what_is_half_written_is_not_there(tmp_path: Path) -> None:
    store = Store(tmp_path)
    store.save("room", json.dumps(scene("room", 1)))
    (file,) = (tmp_path / "scenes").iterdir()
    file.with_name("x.json.part").write_bytes(b'{"deixis": 1')
    store.close()
    again = Store(tmp_path)
    assert [name for name, _ in again.scenes()] == ["room"]
    assert len(list((tmp_path / "scenes").iterdir())) == 1
    file.write_bytes(b"not json")
    with pytest.raises(StoreError, match="repair it"):
        list(again.scenes())
    again.close()


def crash(folder: Path, times: int, seed: int) -> None:
    """Load and replace scenes, and kill the server at any moment; see that nothing it told is lost."""
    chance = random.Random(seed)  # noqa: S311 - a test
    told: dict[str, int] = {}
    for _ in range(times):
        server = start("--store", folder)
        for name, things in told.items():
            assert count(server, name) == things
        known = {one["id"]: one["objects"] for one in server.send("GET", "/scenes").json["scenes"]}
        assert known == told
        pending: list[tuple[str, int]] = []
        writer = threading.Thread(target=write, args=(server, chance, told, pending))
        writer.start()
        time.sleep(chance.uniform(0.05, 0.6))
        server.kill()
        writer.join()
        assert server.process.stderr is not None
        server.process.stderr.close()
        # What was on its way may be there or not, but whole: the last request was never acknowledged.
        store = Store(folder)
        found = {name: len(json.loads(text)["objects"]) for name, text in store.scenes()}
        store.close()
        told |= {name: things for name, things in pending if found.get(name) == things}
        assert found == told


def write(
    server: Server, chance: random.Random, told: dict[str, int], pending: list[tuple[str, int]]
) -> None:
    """Load scenes until the server is gone; note what it acknowledged, and what it did not any more."""
    for step in itertools.count():
        name, things = f"s{chance.randrange(3)}", step % 7 + 1
        pending.append((name, things))
        try:
            reply = server.put(name, scene(name, things))
        except (OSError, http.client.HTTPException):
            return
        assert reply.status in (200, 201)
        told[name] = things
        pending.pop()


def test_acknowledged_scenes_outlive_kill_9(tmp_path: Path) -> None:
    crash(tmp_path, 6, 1)


@pytest.mark.long
def test_acknowledged_scenes_outlive_kill_9_many_times(tmp_path: Path) -> None:
    """Four servers side by side: most of the time is spent waiting for them to start."""
    with ThreadPoolExecutor(4) as pool:
        for done in [pool.submit(crash, tmp_path / str(n), 50, n) for n in range(4)]:
            done.result()


def test_a_killed_server_leaves_no_process_behind() -> None:
    with serving(HANS) as server:
        family = server.family()
        server.query("SELECT (COUNT(*) AS ?n) { ?a ?b ?c . ?d ?e ?f . ?g ?h ?i }", timeout="0.2")
        server.send("GET", "/scenes/hans/why?goal=leans_on(extinguisher2,wall)")
        family = sorted({*family, *server.family()})
        server.kill()
        deadline = time.monotonic() + 10
        left = family
        while left and time.monotonic() < deadline:
            left = [pid for pid in left if _runs(pid)]
            time.sleep(0.05)
        assert left == []


def _runs(pid: int) -> bool:
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False
