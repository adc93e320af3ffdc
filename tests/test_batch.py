"""Data sets: the same as scene by scene, whatever they come in, and whatever happens to the processes."""

from __future__ import annotations

import json
import math
import multiprocessing
import os
import re
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any

import duckdb
import numpy as np
import pyarrow as pa
import pyarrow.dataset
import pyarrow.parquet as pq
import pytest
from hypothesis import given

from commands import call
from datasets import as_lines, crowd, rooms
from deixis import KnowledgeBase, Scene
from deixis.batch import ERRORS, RELATIONS, SCENES, Relate
from deixis.batch.folder import Counts, Folder
from deixis.batch.processes import Ended, Processes
from deixis.batch.run import run as batch
from deixis.batch.sources import files, shards
from deixis.batch.work import Work
from deixis.errors import QueryError, ReaderError, RuleError
from deixis.strict_json import MAX_FILE_BYTES
from deixis.vocabulary import BASE
from worlds import World, worlds

Row = dict[str, Any]


def one_by_one(
    scenes: Iterable[tuple[str, Scene]], rules: Sequence[str] = (), region: str = "box", **asked: Any
) -> list[tuple[Any, ...]]:
    """Return what a knowledge base of each scene says, as rows of the table but for the rule."""
    rows = []
    for source, scene in scenes:
        labels = {thing.id: thing.label or None for thing in scene.objects}
        with KnowledgeBase(scene, rules=rules, region=region) as kb:
            for one in kb.relations(**asked):
                unsure = one.margin is not None and one.margin < scene.thresholds.pose_noise
                rows.append(
                    (
                        source, scene.id, one.relation, one.figure, one.reference, one.view,
                        labels.get(one.figure), labels.get(one.reference), one.margin, unsure,
                    )
                )  # fmt: skip
    return rows


def rows(table: pa.Table | pa.RecordBatch) -> list[tuple[Any, ...]]:
    """Return the rows of relations, but for the rule."""
    return list(zip(*(table.column(name).to_pylist() for name in RELATIONS.names[:-1]), strict=True))


def found(folder: Path) -> tuple[pa.Table, pa.Table]:
    """Return the relations and errors of a folder, in the order of the shards."""
    return pq.read_table(folder), pq.read_table(folder / "_errors")


def of(scenes: Sequence[dict[str, Any] | bytes]) -> pa.RecordBatch:
    """Return scenes as a batch."""
    texts = [one if isinstance(one, bytes) else json.dumps(one).encode() for one in scenes]
    columns = {"source": [str(at) for at in range(len(texts))], "scene": texts, "file": [None] * len(texts)}
    return pa.RecordBatch.from_pydict(columns, schema=SCENES)


# The function on record batches


def test_many_scenes_are_told_as_each_alone() -> None:
    scenes = rooms(6)
    relations, errors = Relate()(of(scenes))
    assert (relations.schema, errors.schema, len(errors)) == (RELATIONS, ERRORS, 0)
    assert rows(relations) == one_by_one((str(at), Scene.from_dict(one)) for at, one in enumerate(scenes))


@given(worlds())
def test_any_scene_is_told_as_alone(world: World) -> None:
    scene = world.scene()
    names = tuple(term.name for term in BASE)
    relations, _ = Relate(relations=names)(of([scene.to_dict()]))
    assert rows(relations) == one_by_one([("0", scene)], relation=names)


def test_rules_region_and_view_are_those_of_one_scene(root: Path) -> None:
    scenes = root / "kb" / "scenes"
    study, kitchen, hans = (Scene.load(scenes / f"{name}.json") for name in ("study", "inspection", "hans"))
    asked = {"relation": ("below", "part_in", "inside")}
    relations, _ = Relate(relations=asked["relation"], region="mesh")(of([study.to_dict()]))
    assert rows(relations) == one_by_one([("0", study)], region="mesh", **asked)
    relations, _ = Relate(relations="supports", rules=("support",))(of([kitchen.to_dict()]))
    assert rows(relations) == one_by_one([("0", kitchen)], rules=("support",), relation=("supports",))
    relations, errors = Relate(view="v1")(of([hans.to_dict(), *rooms(1, 8)]))
    assert rows(relations) == one_by_one([("0", hans)], view="v1")
    assert [one["kind"] for one in errors.to_pylist()] == ["QueryError"]


def test_namesakes_of_constants_keep_their_names() -> None:
    box = {"center": [0, 0, 0.5], "size": [1, 1, 1]}
    small = {"center": [0, 0, 1.1], "size": [0.2, 0.2, 0.2]}
    scene = {
        "deixis": 1,
        "id": "e\u0301 \U0001f6cb",
        "objects": [
            {"id": "world", "label": "world", "box": box},
            {"id": "granularity", "labels": [{"name": "cup", "score": 0.4}], "box": small},
        ],
        "views": [{"id": "Z+", "position": [3, 0, 1]}],
    }
    relations, _ = Relate()(of([scene]))
    assert rows(relations) == one_by_one([("0", Scene.from_dict(scene))])


def test_each_relation_says_where_it_is_stated(root: Path, figure_3: Scene) -> None:
    relations, _ = Relate()(of([figure_3.to_dict()]))
    for one in relations.to_pylist():
        name, _, line = one["rule"].partition(":")
        text = (root / "rules" / name).read_text(encoding="utf-8").splitlines()[int(line) - 1]
        assert text.startswith(f"{one['relation']}(")


def test_what_is_refused_says_why_and_costs_no_other() -> None:
    (room,) = rooms(1, 8)
    huge = json.loads(json.dumps(room))
    huge["objects"][4]["box"]["center"] = [1e300, 0, 0]
    bad: dict[bytes, str] = {
        b"": "not JSON",
        b"{": "not JSON",
        b"\x00\xff\xfe": "not UTF-8",
        b"NaN": "NaN",
        b"[" * 100_000: "nested too deeply",
        b'{"deixis": 1, "id": "\\ud800"}': "id",
        b'{"deixis": 2, "id": "a"}': "deixis",
        json.dumps(room).encode()[:-30]: "not JSON",
        json.dumps(huge).encode(): huge["objects"][4]["id"],
        json.dumps({**room, "objects": room["objects"][:1] * 2}).encode(): "more than once",
        json.dumps({**room, "objects": [{"id": "a", "mesh": "../../a.ply"}]}).encode(): "'a'",
    }
    relations, errors = Relate()(of([room, *bad, room]))
    assert set(relations.column("source").to_pylist()) == {"0", str(len(bad) + 1)}
    told = errors.to_pylist()
    assert [one["source"] for one in told] == [str(at + 1) for at in range(len(bad))]
    assert {one["kind"] for one in told} == {"SceneError"}
    reasons = [one["reason"] for one in told]
    assert [reason for reason, part in zip(reasons, bad.values(), strict=True) if part not in reason] == []


def test_a_row_without_a_scene_is_refused() -> None:
    columns = {"source": ["a", "b"], "scene": [None, None], "file": [None, "/nowhere/a.json"]}
    relations, errors = Relate()(pa.RecordBatch.from_pydict(columns, schema=SCENES))
    assert len(relations) == 0
    assert [one["source"] for one in errors.to_pylist()] == ["a", "b"]
    assert {one["kind"] for one in errors.to_pylist()} == {"ReaderError"}


@pytest.mark.parametrize(
    ("relate", "error"),
    [
        (Relate(relations=("on_topof",)), QueryError),
        (Relate(rules=("nowhere.pl",)), RuleError),
        (Relate(rules=("saftey",)), RuleError),
    ],
)
def test_what_is_wrong_with_all_is_said_first(tmp_path: Path, relate: Relate, error: type[Exception]) -> None:
    place = as_lines(tmp_path / "rooms.jsonl", rooms(2, 8))
    with pytest.raises(error):
        batch([place], tmp_path / "out", relate)
    assert not (tmp_path / "out").exists()


# Where scenes come from


def read(*places: Path, size: int = 4) -> list[tuple[str, bytes | None]]:
    """Return source and text of all scenes, read shard by shard."""
    every = list(shards(files(places), size))
    assert [one.number for one in every] == list(range(len(every)))
    assert all(0 < len(one) <= size for one in every)
    batches = [one.read() for one in every]
    assert [refused for _, refused in batches] == [[] for _ in every]
    return [
        pair for one, _ in batches for pair in zip(*map(pa.Array.to_pylist, one.columns[:2]), strict=True)
    ]


@pytest.mark.parametrize("size", [1, 3, 4, 100])
def test_lines_are_read_each_once_wherever_they_are_cut(tmp_path: Path, size: int) -> None:
    texts = [b'{"n": %d}' % number for number in range(9)]
    place = tmp_path / "a.jsonl"
    place.write_bytes(texts[0] + b"\r\n\n \n" + b"\n".join(texts[1:]))
    wanted = [(f"{place}:{number}", text) for number, text in zip([1, *range(4, 12)], texts, strict=True)]
    assert [(name, (text or b"").strip()) for name, text in read(place, size=size)] == wanted


@pytest.mark.parametrize("size", [1, 3, 4, 100])
@pytest.mark.parametrize("kind", [pa.string(), pa.large_string(), pa.binary(), pa.string_view()])
def test_rows_are_read_each_once_wherever_they_are_cut(tmp_path: Path, size: int, kind: pa.DataType) -> None:
    texts = [f"{number}" for number in range(10)]
    place = tmp_path / "a.parquet"
    table = pa.table({"more": range(10), "scene": pa.array([*texts[:-1], None], pa.string()).cast(kind)})
    pq.write_table(table, place, row_group_size=4)
    wanted = [*(text.encode() for text in texts[:-1]), b""]
    assert read(place, size=size) == [(f"{place}:{at}", text) for at, text in enumerate(wanted, 1)]
    pq.write_table(table.append_column("source", pa.array(texts)), place, row_group_size=4)
    assert read(place, size=size) == list(zip(texts, wanted, strict=True))


def test_a_name_in_another_encoding_costs_no_scene(tmp_path: Path) -> None:
    text = b"caf\xe9caf\xc3\xa9"
    names = pa.Array.from_buffers(
        pa.string(), 2, [None, pa.py_buffer(np.array([0, 4, 9], np.int32)), pa.py_buffer(text)]
    )
    place = tmp_path / "a.parquet"
    pq.write_table(pa.table({"source": names, "scene": ["{}", "{}"]}), place)
    assert [name for name, _ in read(place, size=9)] == ["caf\ufffd", "caf\xe9"]


def test_a_line_longer_than_is_parsed_is_refused_alone(tmp_path: Path) -> None:
    room = json.dumps(rooms(1, 8)[0]).encode()
    place = as_lines(tmp_path / "a.jsonl", [room, b" " * (MAX_FILE_BYTES + 10) + room, room])
    done = batch([place], tmp_path / "out", Relate(), workers=1)
    relations, errors = found(tmp_path / "out")
    assert (done.scenes, done.refused) == (3, 1)
    assert set(relations["source"].to_pylist()) == {f"{place}:1", f"{place}:3"}
    assert errors["source"].to_pylist() == [f"{place}:2"]


def test_a_folder_holds_scenes_of_any_format(tmp_path: Path, root: Path) -> None:
    folder = tmp_path / "scenes"
    (folder / "more").mkdir(parents=True)
    hans = Scene.load(root / "kb" / "scenes" / "hans.json")
    hans.save(folder / "hans.json")
    assert call("export", folder / "hans.json", "-o", folder / "more" / "hans.trig").code == 0
    egg = {"id": "Egg|1", "label": "Egg", "aabb_min": [0.9, 1.9, 0.4], "aabb_max": [1.0, 2.0, 0.5]}
    thor = [{"scene": name, "objects": [egg, {**egg, "id": "Egg|2"}]} for name in ("Plan1", "Plan2")]
    as_lines(folder / "thor.jsonl", thor)
    mesh = {"id": "stone", "mesh": "stone.ply"}
    (folder / "stone.ply").write_text(
        "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
        "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
        "0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 1 2\n",
        encoding="ascii",
    )
    lines = as_lines(folder / "stones.jsonl", [{"deixis": 1, "id": "beach", "objects": [mesh], "views": []}])
    (folder / "notes.json").write_text('{"written": "by hand"}', encoding="utf-8")
    done = batch([folder, lines], tmp_path / "out", Relate(relations=("near",)), workers=1)
    relations, errors = found(tmp_path / "out")
    assert (done.scenes, done.refused) == (5, 1)
    assert errors["source"].to_pylist() == [f"{folder}/notes.json"]
    assert "no format that a reader knows" in errors["reason"][0].as_py()
    places = relations.select(["source", "scene"]).group_by(["source", "scene"]).aggregate([]).to_pylist()
    assert sorted(tuple(one.values()) for one in places) == [
        (f"{folder}/hans.json", "hans"),
        (f"{folder}/more/hans.trig", "hans"),
        (f"{folder}/thor.jsonl", "Plan1"),
        (f"{folder}/thor.jsonl", "Plan2"),
    ]


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda place: place.with_name("other").mkdir(), "does not exist"),
        (lambda place: place.mkdir(), "holds no scenes"),
        (lambda place: pq.write_table(pa.table({"text": ["{}"]}), place), "no column scene"),
        (lambda place: pq.write_table(pa.table({"scene": [1]}), place), "is int64"),
        (lambda place: place.write_bytes(b"PAR1 and no more"), "is no Parquet file"),
        (lambda place: pq.write_table(RELATIONS.empty_table(), place), "holds relations"),
    ],
)
def test_what_is_no_data_set_is_refused(tmp_path: Path, make: Callable[[Path], object], said: str) -> None:
    make(tmp_path / "a.parquet")
    with pytest.raises(ReaderError, match=said):
        batch([tmp_path / "a.parquet"], tmp_path / "out", Relate(relations=("near",)))


def test_a_file_that_breaks_after_it_was_counted_is_in_the_errors(tmp_path: Path) -> None:
    place = tmp_path / "a.parquet"
    pq.write_table(pa.table({"scene": [json.dumps(one) for one in rooms(40, 5)]}), place, compression="none")
    (shard,) = shards(files([place]), 100)
    text = bytearray(place.read_bytes())
    text[4:200] = b"\xff" * 196
    place.write_bytes(text)
    scenes, refused = shard.read()
    assert len(scenes) == 0
    assert [(one.source, one.kind) for one in refused] == [(f"{place}:1-40", "ReaderError")]


# Whatever happens to the processes


def test_what_a_function_raises_is_raised_here() -> None:
    with Processes(2) as processes, pytest.raises(ValueError, match="invalid literal"):
        list(processes.each(int, ["1", "x"]))


def test_a_process_that_ended_while_idle_is_another() -> None:
    with Processes(1) as processes:
        assert list(processes.each(int, ["1"])) == [1]
        (child,) = multiprocessing.active_children()
        child.kill()
        child.join()
        assert list(processes.each(int, ["2", "3"])) == [2, 3]
        assert list(processes.each(os._exit, [7, 0])) == [Ended(7, 7), Ended(0, 0)]
    assert multiprocessing.active_children() == []


def test_a_scene_that_hangs_is_refused_and_the_others_are_told(tmp_path: Path) -> None:
    every = rooms(6, 8)
    place = as_lines(tmp_path / "rooms.jsonl", [*every[:2], crowd(), b"garbage", *every[2:]])
    done = batch([place], tmp_path / "out", Relate(), limit=2.5, shard=4, workers=2)
    relations, errors = found(tmp_path / "out")
    numbers = [1, 2, 5, 6, 7, 8]
    sources = [(f"{place}:{at}", Scene.from_dict(one)) for at, one in zip(numbers, every, strict=True)]
    assert rows(relations) == one_by_one(sources)
    assert done == Counts(8, relations.num_rows, 2)
    assert {one["source"]: one["kind"] for one in errors.to_pylist()} == {
        f"{place}:3": "QueryTimeout",
        f"{place}:4": "SceneError",
    }
    assert "it took longer than 2.5 s: allow more with --limit" in errors["reason"].to_pylist()


def test_a_process_that_is_ended_costs_nothing(tmp_path: Path) -> None:
    place = as_lines(tmp_path / "rooms.jsonl", rooms(24, 8))
    ended = []

    def end_one(done: Counts, total: int) -> None:
        if 0 < done.scenes < total and not ended:
            ended.append(multiprocessing.active_children()[0].pid)
            os.kill(ended[0], signal.SIGKILL)

    batch([place], tmp_path / "calm", Relate(), shard=4, workers=2)
    assert batch([place], tmp_path / "out", Relate(), shard=4, workers=2, progress=end_one).scenes == 24
    assert ended
    assert_same(tmp_path / "calm", tmp_path / "out")


def test_what_ends_its_process_twice_is_refused(tmp_path: Path) -> None:
    place = as_lines(tmp_path / "rooms.jsonl", rooms(3, 8))
    folder = Folder(tmp_path / "out")
    folder.begin(files([place]), Relate(), 60.0, 8)
    (shard,) = shards(files([place]), 8)
    done: list[Counts] = []
    with Processes(1) as processes:
        work = Work(Relate(), folder, 60.0)
        working = threading.Thread(target=lambda: done.append(work.scenes(processes, shard)))
        working.start()
        while working.is_alive():
            for child in multiprocessing.active_children():
                child.kill()
            time.sleep(0.01)
    assert done == [Counts(3, 0, 3)]
    assert {one["kind"] for one in found(folder.path)[1].to_pylist()} == {"EngineError"}
    assert "ended with code -9" in found(folder.path)[1]["reason"][0].as_py()


def test_a_run_that_was_killed_goes_on_where_it_was(tmp_path: Path) -> None:
    place = as_lines(tmp_path / "rooms.jsonl", rooms(96))
    out = tmp_path / "out"
    command = [sys.executable, "-m", "deixis", "batch", place, "-o", out, "--shard", "4", "--workers", "2"]
    running = subprocess.Popen(command, stderr=subprocess.PIPE)
    errors = out / "_errors"
    while running.poll() is None and len(list(errors.glob("*.parquet"))) < 4:
        time.sleep(0.02)
    running.kill()
    running.communicate()
    # Its processes have lost whom they work for, and end.
    time.sleep(2.0)
    before = {one.name: one.stat().st_mtime_ns for one in errors.glob("*.parquet")}
    assert 4 <= len(before) < 24
    done = call("batch", place, "-o", out, "--shard", "4", "--workers", "2")
    assert (done.code, done.out) == (0, "")
    assert f"96 scenes, {found(out)[0].num_rows:,} relations" in done.err
    assert {name: (errors / name).stat().st_mtime_ns for name in before} == before
    batch([place], tmp_path / "calm", Relate(), shard=4, workers=2)
    assert_same(tmp_path / "calm", out)
    assert len(set(found(out)[0]["source"].to_pylist())) == 96


def assert_same(one: Path, other: Path) -> None:
    """Two folders hold the same files, to the byte."""
    here, there = (
        {place.relative_to(top): place.read_bytes() for place in top.rglob("[!.]*.parquet")}
        for top in (one, other)
    )
    assert here.keys() == there.keys()
    assert [name for name in here if here[name] != there[name]] == []


# The folder


def test_a_folder_is_of_one_data_set(tmp_path: Path) -> None:
    place, out = as_lines(tmp_path / "rooms.jsonl", rooms(3, 8)), tmp_path / "out"
    own = tmp_path / "own.pl"
    own.write_text("%!  by(?A, ?B) is nondet.\nby(A, B) :- near(A, B).\n", encoding="utf-8")
    relate = Relate(relations=("by",), rules=(str(own),))
    batch([place], out, relate, workers=1)
    assert batch([place], out, relate, workers=1).scenes == 3
    for other, said in [
        ({"relate": Relate(relations=("near",), rules=(str(own),))}, "relations"),
        ({"relate": Relate(relations=("by",), rules=(str(own),), region="hull")}, "region"),
        ({"limit": 3.0}, "limit"),
        ({"shard": 2}, "shard"),
        ({"places": [place, as_lines(tmp_path / "more.jsonl", rooms(1, 8))]}, "inputs"),
    ]:
        with pytest.raises(ReaderError, match=rf"begun with other {said} .*another folder with -o"):
            batch(**{"places": [place], "target": out, "relate": relate, "workers": 1, **other})
    own.write_text("%!  by(?A, ?B) is nondet.\nby(A, B) :- above(A, B).\n", encoding="utf-8")
    with pytest.raises(ReaderError, match="other rules"):
        batch([place], out, relate, workers=1)
    as_lines(place, rooms(4, 8))
    with pytest.raises(ReaderError, match=r"other rules .* and inputs"):
        batch([place], out, relate, workers=1)


def test_relations_that_were_removed_are_derived_again(tmp_path: Path) -> None:
    place, out = as_lines(tmp_path / "rooms.jsonl", rooms(4, 8)), tmp_path / "out"
    whole = batch([place], out, Relate(relations=("near",)), shard=2, workers=1)
    (out / "00000001.parquet").unlink()
    assert batch([place], out, Relate(relations=("near",)), shard=2, workers=1) == whole
    assert found(out)[0].num_rows == whole.relations
    for one in out.glob("*.parquet"):
        one.unlink()
    # Nothing is left of the one before, so that it may be something else.
    other = batch([place], out, Relate(relations=("above",)), shard=4, workers=1)
    assert set(found(out)[0]["relation"].to_pylist()) == {"above"}
    assert (other.scenes, found(out)[0].num_rows) == (4, other.relations)
    assert [one.name for one in (out / "_errors").iterdir()] == ["00000000.parquet"]


def test_a_limit_may_be_infinite(tmp_path: Path) -> None:
    place, out = as_lines(tmp_path / "rooms.jsonl", rooms(2, 8)), tmp_path / "out"
    for _ in range(2):
        done = batch([place], out, Relate(relations=("near",)), limit=math.inf, workers=1)
        assert (done.scenes, done.refused) == (2, 0)


def test_other_folders_are_left_alone(tmp_path: Path) -> None:
    place, out = as_lines(tmp_path / "rooms.jsonl", rooms(3, 8)), tmp_path / "out"
    out.mkdir()
    pq.write_table(pa.table({"a": [1]}), out / "mine.parquet")
    with pytest.raises(ReaderError, match="holds other Parquet files"):
        batch([place], out, Relate(relations=("near",)))
    (tmp_path / "file").write_text("", encoding="utf-8")
    with pytest.raises(ReaderError, match="cannot be written to"):
        batch([place], tmp_path / "file", Relate(relations=("near",)))


def test_what_was_written_is_not_read_again(tmp_path: Path) -> None:
    as_lines(tmp_path / "rooms.jsonl", rooms(3, 8))
    out = tmp_path / "out"
    for _ in range(2):
        assert batch([tmp_path], out, Relate(relations=("near",)), workers=1).scenes == 3


def test_a_broken_part_names_itself(tmp_path: Path) -> None:
    place, out = as_lines(tmp_path / "rooms.jsonl", rooms(3, 8)), tmp_path / "out"
    batch([place], out, Relate(relations=("near",)), workers=1)
    (out / "_errors" / "00000000.parquet").write_bytes(b"PAR1")
    with pytest.raises(ReaderError, match=r"00000000.parquet.*remove it, and its shard is done again"):
        batch([place], out, Relate(relations=("near",)), workers=1)


def test_what_is_written_is_read_in_a_line_by_others(tmp_path: Path) -> None:
    place, out = as_lines(tmp_path / "rooms.jsonl", [*rooms(6, 8), b"{"]), tmp_path / "out"
    done = batch([place], out, Relate(), shard=2, workers=1)
    assert pyarrow.dataset.dataset(out).count_rows() == done.relations
    assert pyarrow.dataset.dataset(out).schema.equals(RELATIONS)
    assert pyarrow.dataset.dataset(out / "_errors").count_rows() == done.refused == 1
    assert len(duckdb.read_parquet(f"{out}/*.parquet")) == done.relations
    pandas = pytest.importorskip("pandas")
    assert len(pandas.read_parquet(out)) == done.relations


def test_the_page_on_data_sets_shows_the_schemas(root: Path) -> None:
    page = (root / "kb" / "datasets.md").read_text(encoding="utf-8")
    for name, schema in (("SCENES", SCENES), ("RELATIONS", RELATIONS), ("ERRORS", ERRORS)):
        lines = [
            f"| `{field.name}` | {shown(field.type)}{', or null' if field.nullable else ''} "
            f"| {field.metadata[b'says'].decode()} |"
            for field in schema
        ]
        assert "\n".join(lines) in page, f"{name}:\n" + "\n".join(lines)


def shown(kind: pa.DataType) -> str:
    return str(kind.value_type) if pa.types.is_dictionary(kind) else str(kind)


# The command


def test_the_command_says_what_became_of_it(tmp_path: Path) -> None:
    place = as_lines(tmp_path / "rooms.jsonl", [*rooms(3, 8), b"{"])
    result = call("batch", place, "-o", tmp_path / "out", "--workers", "1", "--relation", "near")
    assert (result.code, result.out) == (1, "")
    pattern = rf"deixis: {tmp_path}/out: 4 scenes, [\d,]+ relations, 1 refused: see {tmp_path}/out/_errors\n"
    assert re.fullmatch(pattern, result.err)
    assert call("batch", tmp_path / "none", "-o", tmp_path / "out").code == 2
    assert call("batch", place, "-o", tmp_path / "other", "--rules", "nowhere.pl").code == 2


@pytest.mark.parametrize(("module", "options"), [("pyarrow", []), ("ray", ["--engine", "ray"])])
def test_what_is_not_installed_is_named(tmp_path: Path, module: str, options: list[str]) -> None:
    place = as_lines(tmp_path / "rooms.jsonl", rooms(1, 8))
    script = f"import sys; sys.modules[{module!r}] = None\nfrom deixis.cli import main\nsys.exit(main())"
    command = [sys.executable, "-c", script, "batch", place, "-o", tmp_path / "out", *options]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    extra = "batch" if module == "pyarrow" else "ray"
    assert done.returncode == 2
    assert f"pip install 'deixis[{extra}]'" in done.stderr
    assert "Traceback" not in done.stderr


# All of it, large


@pytest.mark.long
def test_fifteen_hundred_rooms_one_that_hangs_and_one_that_is_garbage(tmp_path: Path) -> None:
    """Killed half way and started again: each room once, and as it is alone."""
    every = rooms(1500)
    place = as_lines(tmp_path / "rooms.jsonl", [*every[:700], crowd(), b"garbage", *every[700:]])
    out = tmp_path / "out"
    command = [sys.executable, "-m", "deixis", "batch", place, "-o", out, "--limit", "5"]
    running = subprocess.Popen(command)
    while running.poll() is None and len(list((out / "_errors").glob("*.parquet"))) < 5:
        time.sleep(0.05)
    running.kill()
    assert running.wait() == -signal.SIGKILL
    done = batch([place], out, Relate(), limit=5.0)
    relations, errors = found(out)
    numbers = [*range(1, 701), *range(703, 1503)]
    alone = [(f"{place}:{at}", Scene.from_dict(one)) for at, one in zip(numbers, every, strict=True)]
    assert rows(relations) == one_by_one(alone)
    assert done == Counts(1502, relations.num_rows, 2)
    assert sorted(errors["kind"].to_pylist()) == ["QueryTimeout", "SceneError"]


@pytest.mark.long
def test_whatever_is_ended_whenever_each_scene_is_told_once(tmp_path: Path) -> None:
    place = as_lines(tmp_path / "rooms.jsonl", rooms(300))
    done: list[Counts] = []
    working = threading.Thread(
        target=lambda: done.append(batch([place], tmp_path / "out", Relate(), shard=10))
    )
    working.start()
    chance = np.random.default_rng(0)
    while working.is_alive():
        time.sleep(chance.uniform(0.0, 3.0))
        for child in multiprocessing.active_children()[:1]:
            child.kill()
    relations, errors = found(tmp_path / "out")
    told = [*dict.fromkeys(relations["source"].to_pylist()), *errors["source"].to_pylist()]
    assert sorted(told) == sorted(f"{place}:{at}" for at in range(1, 301))
    assert set(errors["kind"].to_pylist()) <= {"EngineError"}
    assert done == [Counts(300, relations.num_rows, errors.num_rows)]
