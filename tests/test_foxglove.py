"""Scenes for Foxglove: what is written is read with others' reader, and is what holds."""

from __future__ import annotations

import json
import sys
import time
from collections import Counter
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory
from scipy.spatial.transform import Rotation

from bags_written import SECOND, START, Box, Written, kitchen
from bench.job import scattered
from commands import call
from deixis.errors import MissingDependency, SceneError
from deixis.knowledge import KnowledgeBase
from deixis.logs import read_bag
from deixis.logs.foxglove import RELATIONS, THINGS, FoxgloveFile
from deixis.logs.telling import VERBS, Teller
from deixis.relations import Relation
from deixis.scene import Label, Scene
from deixis.vocabulary import RELATIONS as WORDS
from scenes import box, floor, scene, wall

HANS = Path(__file__).resolve().parent.parent / "kb" / "scenes" / "hans.json"

Messages = list[tuple[str, int, Any]]


def decoded(path: Path) -> Messages:
    """Return topic, time and value of each message of an MCAP file."""
    with path.open("rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        return [
            (channel.topic, message.log_time, value)
            for _, channel, message, value in reader.iter_decoded_messages()
        ]


def pairs(entity: Any) -> dict[str, str]:
    return {one.key: one.value for one in entity.metadata}


def nanoseconds(stamp: Any) -> int:
    return int(stamp.seconds) * SECOND + int(stamp.nanos)


def test_a_recording_for_foxglove_has_what_holds(tmp_path: Path) -> None:
    bag, target = kitchen(tmp_path / "bag"), tmp_path / "out.mcap"
    result = call("bag", bag, "--robot", "base_link", "-o", target, "--forget", "1")
    assert (result.code, result.out) == (0, "")
    messages = decoded(target)
    count = sum(len(value.entities) for topic, _, value in messages if hasattr(value, "entities"))
    assert result.err.endswith(f"{target}: 13 moments, {count} entities\n")
    things = [(at, value) for topic, at, value in messages if topic == THINGS]
    assert [at for at, _ in things] == [START + at * SECOND for at in range(13)]
    assert [len(value.entities) for _, value in things] == [3] * 11 + [2] * 2
    assert [one.id for _, value in things for one in value.deletions] == ["book_1"]
    for at, value in things:
        for entity in value.entities:
            assert (entity.frame_id, nanoseconds(entity.timestamp)) == ("map", at)
    table = things[0][1].entities[0]
    assert pairs(table) == {"id": "table_1", "kind": "object", "label 1": "table (0.9)"}
    assert table.texts[0].text == "table"
    cube = table.cubes[0]
    place = cube.pose.position
    assert np.allclose((place.x, place.y, place.z), (0.0, 0.0, 0.4))
    turn = cube.pose.orientation
    extent = np.abs(
        Rotation.from_quat([turn.x, turn.y, turn.z, turn.w]).apply([cube.size.x, cube.size.y, cube.size.z])
    )
    assert np.allclose(extent, (1.6, 0.8, 0.8))
    # From when to when something is on top of something, as the recording itself is told.
    on = [
        (at, sorted(one.id for one in value.entities), [one.id for one in value.deletions])
        for topic, at, value in messages
        if topic == f"{RELATIONS}/on_top_of"
    ]
    book, cup = "on_top_of|book_1|table_1", "on_top_of|cup_1|table_1"
    assert on == [
        *((START + at * SECOND, [book], []) for at in range(5)),
        *((START + at * SECOND, [book, cup], []) for at in range(5, 11)),
        (START + 11 * SECOND, [cup], [book]),
        (START + 12 * SECOND, [cup], []),
    ]
    (left,) = {
        json.dumps(pairs(one), sort_keys=True)
        for topic, _, value in messages
        if topic == f"{RELATIONS}/left_of"
        for one in value.entities
        if nanoseconds(one.timestamp) == START + 5 * SECOND
    }
    assert json.loads(left) == {
        "sentence": "The cup is left of the book as seen from the robot.",
        "relation": "left_of", "figure": "cup_1", "reference": "book_1", "view": "robot", "margin_m": "0.04",
    }  # fmt: skip
    robots = [value.pose for topic, _, value in messages if topic == "/deixis/views/robot"]
    assert np.allclose((robots[0].position.x, robots[0].position.y), (0.0, -2.5))
    assert len(robots) == 13


def test_arrows_go_from_the_figure_to_the_nearest_of_the_reference(tmp_path: Path) -> None:
    room = scene(
        floor(),
        box("table", (1, 0, 0.4), (1, 1, 0.8)),
        box("cup", (1.2, 0.1, 0.85), (0.1, 0.1, 0.1)),
        views=[],
    )
    target = tmp_path / "out.mcap"
    with KnowledgeBase(room) as kb, FoxgloveFile(target) as file:
        file.write(START, room, kb.relations())
    found = {
        one.id: one.arrows[0]
        for topic, _, value in decoded(target)
        if topic.startswith(RELATIONS)
        for one in value.entities
    }
    for name, start, end in (
        ("on_top_of|cup|table", (1.2, 0.1, 0.85), (1.2, 0.1, 0.8)),
        ("on_top_of|table|floor", (1.0, 0.0, 0.4), (1.0, 0.0, 0.0)),
    ):
        arrow = found[name]
        place, turn = arrow.pose.position, arrow.pose.orientation
        long = arrow.shaft_length + arrow.head_length
        tip = Rotation.from_quat([turn.x, turn.y, turn.z, turn.w]).apply([long, 0, 0])
        assert np.allclose((place.x, place.y, place.z), start)
        assert np.allclose(np.array(start) + tip, end)


def test_every_kind_of_region_is_drawn(tmp_path: Path) -> None:
    mesh = {"vertices": [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]],
            "faces": [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]}  # fmt: skip
    cloud = [[x, y, z] for x in (0, 0.01) for y in (0, 0.01) for z in (0, 0.01)]
    room = scene(
        floor(), box("b", (0, 0, 1), (1, 2, 3), 0.5), {"id": "m", "mesh": mesh}, {"id": "p", "points": cloud}
    )
    target = tmp_path / "out.mcap"
    with FoxgloveFile(target, "world") as file:
        file.write(
            0, room, [Relation("odd", "of", "rules", None, None), Relation("odd", "b", "m", None, None)]
        )
    messages = decoded(target)
    kinds = {
        one.id: [kind for kind in ("cubes", "lines", "triangles") if len(getattr(one, kind))]
        for topic, _, value in messages
        if topic == THINGS
        for one in value.entities
    }
    assert kinds == {"floor": ["lines"], "b": ["cubes"], "m": ["triangles"], "p": ["cubes"]}
    (told,) = [pairs(one) for topic, _, value in messages if topic.endswith("/odd") for one in value.entities]
    assert told == {"sentence": "The b odd m.", "relation": "odd", "figure": "b", "reference": "m"}


def test_a_scene_is_exported_with_its_reasons(tmp_path: Path) -> None:
    target = tmp_path / "hans.mcap"
    told = call("export", HANS, "-o", target)
    assert (told.code, told.err) == (0, f"{target}: 53 entities\n")
    sentences = {
        pairs(one)["sentence"]
        for topic, _, value in decoded(target)
        if topic.startswith(RELATIONS)
        for one in value.entities
    }
    with KnowledgeBase.from_scene(HANS) as kb:
        assert sentences == {one.sentence() for one in kb.proofs().values()}
    assert call("export", HANS, "--no-proofs", "-o", target).code == 0
    short = [
        pairs(one)["sentence"]
        for topic, _, value in decoded(target)
        if topic.endswith("/leans_on")
        for one in value.entities
    ]
    assert short == ["The fire extinguisher (extinguisher2) leans on the wall."]


def test_plain_sentences_are_those_of_the_rules() -> None:
    assert VERBS.keys() == {term.name for term in WORDS}
    strewn = scattered(40, 2)
    things = tuple(replace(one, labels=(Label(f"thing {one.id}"),)) for one in strewn.objects)
    room = scene(floor(half=9.0), wall(x=6.6))
    # A picture on the wall, and something in something else.
    more = scene(box("picture", (6.57, 1.0, 1.5), (0.04, 0.4, 0.4)), box("chest", (9.0, 9.0, 0.5), (1, 1, 1)),
                 box("coin", (9.0, 9.0, 0.5), (0.1, 0.1, 0.1)), box("ladder", (6.55, -2, 1), (0.08, 0.4, 2)),
                 views=[])  # fmt: skip
    said = set()
    with KnowledgeBase(replace(strewn, objects=(*room.objects, *more.objects, *things))) as kb:
        plain = Teller(kb.scene)
        proofs = kb.proofs()
        for one in kb.relations():
            proof = proofs[(one.relation, one.figure, one.reference, *([one.view] if one.view else []))]
            assert proof.sentence().startswith(plain(one).removesuffix("."))
            said.add(one.relation)
    assert said == VERBS.keys()


def test_a_file_is_written_whole_or_not_at_all(tmp_path: Path) -> None:
    target = tmp_path / "out.mcap"
    target.write_bytes(b"before")
    room = scene(floor())
    with pytest.raises(SceneError, match="is not between 1970 and 2106"), FoxgloveFile(target) as file:
        file.write(-1, room, [])
    assert target.read_bytes() == b"before"
    assert list(tmp_path.iterdir()) == [target]
    with FoxgloveFile(target) as file:
        file.write(START, room, [])
    assert len(decoded(target)) == 2
    for bad, reason in ((tmp_path, "is no file"), (tmp_path / "none" / "out.mcap", "cannot be written")):
        with pytest.raises(SceneError, match=reason):
            FoxgloveFile(bad)
    device = Path("/dev/null")
    if device.exists():
        with pytest.raises(SceneError, match="is no file"):
            FoxgloveFile(device)
        assert not device.is_file()


def test_strange_names_are_data(tmp_path: Path) -> None:
    odd = "../../a b|'\"<\u00e9>"
    views = [{"id": odd, "position": [0, 0, 0]}]
    room = Scene.from_dict(
        {"deixis": 1, "id": "s", "objects": [{**box("x", (0, 0, 0), (1, 1, 1)), "id": odd}], "views": views}
    )
    target = tmp_path / "out.mcap"
    with FoxgloveFile(target, odd) as file:
        file.write(START, room, [])
    things, view = decoded(target)
    assert (things[2].entities[0].id, things[2].entities[0].frame_id) == (odd, odd)
    assert view[0] == "/deixis/views/______a_b______"


def test_without_the_sdk_it_says_what_to_install(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "foxglove", None)
    with pytest.raises(MissingDependency, match=r"pip install 'deixis\[ros\]'"):
        FoxgloveFile(tmp_path / "out.mcap")


def strewn(path: Path, frames: int, things: int) -> None:
    """Write a bag of a robot that drives past things strewn about a room, at 10 Hz, with noise of 3 mm."""
    draw = np.random.default_rng(1)
    room = scattered(things, 1)
    center, size = room.boxes.center, 2.0 * room.boxes.half
    yaw = Rotation.from_euler("z", room.boxes.yaw[:, None])
    side = 0.4 * things**0.5
    with Written(path, "mcap") as bag:
        bag.tf(START, "base_link", "camera", (0.2, 0.0, 0.5), static=True)
        for at in range(frames):
            stamp = START + at * SECOND // 10
            base = np.array([-2.0 + 0.005 * at, side, 0.0])
            bag.tf(stamp, "map", "base_link", base)
            seen = center + draw.normal(0.0, 0.003, center.shape) - base - [0.2, 0.0, 0.5]
            boxes = [
                Box("thing", *each, track=f"t{number}")
                for number, each in enumerate(zip(seen, size, yaw.as_quat(), strict=True))
            ]
            bag.detections(stamp, boxes, "camera")


def follow(tmp_path: Path, frames: int, things: int) -> None:
    """Follow a recording and write it for Foxglove; print how long that takes."""
    strewn(tmp_path / "bag", frames, things)
    target, written = tmp_path / "out.mcap", 0
    start, busy = time.perf_counter(), time.process_time()
    file = FoxgloveFile(target)
    with read_bag(tmp_path / "bag", robot="base_link") as log, KnowledgeBase(log.start) as kb, file:
        for stamp, update in log.updates():
            kb.update(update)
            held = kb.kept
            file.write(stamp, kb.scene, held)
            written += things + len(held)
    took, busy = time.perf_counter() - start, time.process_time() - busy
    with KnowledgeBase(kb.scene) as fresh:
        assert fresh.relations() == kb.kept
    counts: Counter[str] = Counter()
    with target.open("rb") as source:
        reader = make_reader(source, decoder_factories=[DecoderFactory()])
        for _, channel, _, value in reader.iter_decoded_messages():
            counts[channel.topic] += len(value.entities) if hasattr(value, "entities") else 0
    assert counts[THINGS] == frames * things
    assert sum(counts.values()) == written == file.entities
    assert (log.report.frames, log.report.detections) == (frames, frames * things)
    megabytes = target.stat().st_size / 1e6
    print(
        f"\n{frames} frames of {things}: {took:.1f} s, {busy:.1f} s of them of the processor; "
        f"{written} entities, {megabytes:.1f} MB"
    )


def test_a_recording_is_followed_and_its_entities_counted(tmp_path: Path) -> None:
    follow(tmp_path, 20, 12)


@pytest.mark.long
def test_a_thousand_frames_of_fifty(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    follow(tmp_path, 1000, 50)
    with capfd.disabled():
        print(capfd.readouterr().out)
