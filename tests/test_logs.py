"""Recordings of robots: every frame, stamp and unit counts, and nothing is left out in silence."""

from __future__ import annotations

import json
import math
import shutil
import sqlite3
import sys
import tracemalloc
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from bags_written import SECOND, START, Box, Written, forget_definitions, kitchen
from commands import call
from deixis.errors import MissingDependency, ReaderError, SceneError
from deixis.knowledge import KnowledgeBase
from deixis.logs import Log, read_bag
from deixis.logs.intervals import Intervals
from deixis.logs.transforms import Transforms, Unknown, seconds
from deixis.regions import MeshRegion
from deixis.scene import Scene

CUP = Box("cup", (1.0, 2.0, 0.5), (0.1, 0.1, 0.1), track="7")


def intervals(log: Log, **choices: Any) -> list[tuple[Any, ...]]:
    """Return what holds from when to when, in seconds after the start of what tests write."""
    kept, found = Intervals(), []
    with KnowledgeBase(log.start, **choices) as kb:
        for stamp, update in log.updates():
            found += kept.take(stamp, kb.update(update))
    rows = []
    for one in [*found, *kept.rest()]:
        since, until = ((at - START) / SECOND if at is not None else None for at in (one.since, one.until))
        told = one.relation
        rows.append((told.relation, told.figure, told.reference, told.view, since, until))
    return rows


@pytest.mark.parametrize("version", ["4", "2", "1"])
@pytest.mark.parametrize("storage", ["sqlite3", "mcap", "sqlite3 without definitions"])
def test_what_holds_in_the_kitchen_and_when(tmp_path: Path, storage: str, version: str) -> None:
    bag = kitchen(tmp_path / "bag", storage.split()[0], version)
    if "without" in storage:
        forget_definitions(bag)
    with read_bag(bag, robot="base_link") as log:
        found = intervals(log)
    assert log.report.to_dict() == {"frames": 13, "detections": 36, "skipped": [], "notes": []}
    assert (log.report.first, log.report.last) == (START, START + 12 * SECOND)
    assert {row for row in found if row[0] in ("on_top_of", "left_of", "right_of", "behind")} == {
        ("on_top_of", "book_1", "table_1", None, 0.0, None),
        ("on_top_of", "cup_1", "table_1", None, 5.0, None),
        # The robot drives round the table from 6 s on: what was on the left is behind, then on the right.
        ("left_of", "cup_1", "book_1", "robot", 5.0, 8.0),
        ("behind", "cup_1", "book_1", "robot", 8.0, 11.0),
        ("right_of", "cup_1", "book_1", "robot", 11.0, None),
    }


def test_things_are_where_they_are_in_the_fixed_frame(tmp_path: Path) -> None:
    with read_bag(kitchen(tmp_path / "bag"), robot="base_link") as log:
        scenes = dict(log)
    last = scenes[START + 9 * SECOND]
    book = last.objects[last.index("book_1")].region
    assert np.allclose(book.center, (0.4, 0.1, 0.825), atol=1e-9)
    assert sorted(book.size.tolist()) == pytest.approx([0.05, 0.2, 0.3])
    assert book.size[2] == pytest.approx(0.05)
    turn = Rotation.from_euler("z", book.yaw).apply([1, 0, 0])
    long = 0 if book.size[0] > book.size[1] else 1
    assert abs(turn[1 - long]) == pytest.approx(1.0)
    robot = last.views[0]
    assert (robot.id, robot.label, robot.stamp) == ("robot", "robot", (START + 9 * SECOND) / 1e9)
    assert np.allclose(robot.position, (2.5, 0.0, 0.0), atol=0.01)
    assert abs(math.remainder(robot.heading - math.pi, math.tau)) < 1e-9


@pytest.mark.parametrize("storage", ["sqlite3", "mcap"])
def test_stamps_are_exact_to_a_nanosecond(tmp_path: Path, storage: str) -> None:
    stamps = [START + 1, START + 2, START + SECOND + 999_999_999]
    with Written(tmp_path / "bag", storage) as bag:
        for stamp in stamps:
            bag.detections(stamp, [CUP], recorded=stamp + SECOND)
    with read_bag(tmp_path / "bag") as log:
        assert [stamp for stamp, _ in log] == stamps
    result = call("bag", tmp_path / "bag", "--format", "intervals", "--relation", "near")
    assert result.code == 0
    assert seconds(stamps[2]) == "1700000001.999999999"


def test_a_bag_of_ros_1_with_numbers_for_classes(tmp_path: Path) -> None:
    with Written(tmp_path / "log.bag") as bag:
        bag.tf(START, "/map", "/base", (1.0, 0.0, 0.0), static=True)
        bag.detections(START, [Box("47", (0, 0, 0.5), (0.1, 0.1, 0.1))], "/base")
    names = tmp_path / "names.json"
    names.write_text('{"47": "cup"}', encoding="utf-8")
    with read_bag(tmp_path / "log.bag", names={"47": "cup"}) as log:
        ((_, scene),) = list(log)
    assert (scene.objects[0].id, scene.objects[0].label) == ("cup_1", "cup")
    assert scene.objects[0].region.center.tolist() == [1.0, 0.0, 0.5]
    assert call("bag", tmp_path / "log.bag", "--labels", names).code == 0
    names.write_text('["cup"]', encoding="utf-8")
    refused = call("bag", tmp_path / "log.bag", "--labels", names)
    assert (refused.code, refused.out) == (2, "")
    assert "names of classes are a JSON object" in refused.err


def test_a_file_without_its_folder_is_read_too(tmp_path: Path) -> None:
    for storage, ending in (("sqlite3", "db3"), ("mcap", "mcap")):
        (place,) = kitchen(tmp_path / storage, storage).glob(f"*.{ending}")
        with read_bag(place) as log:
            assert len(list(log)) == 13
    (tmp_path / "sqlite3" / "metadata.yaml").unlink()
    with pytest.raises(ReaderError, match=r"has no metadata.yaml: give the .mcap or .db3 file"):
        read_bag(tmp_path / "sqlite3")


def test_detections_have_headers_of_their_own(tmp_path: Path) -> None:
    with Written(tmp_path / "bag") as bag:
        for at in (0, 1):
            bag.tf(START + at * SECOND, "map", "left", (at, 0, 0))
        own = Box("cup", (0, 0, 0), (1, 1, 1), frame="left", stamp=START + SECOND // 4, track="own")
        bag.detections(START + SECOND // 2, [own, CUP])
    with read_bag(tmp_path / "bag") as log:
        ((stamp, scene),) = list(log)
    assert stamp == START + SECOND // 2
    assert scene.objects[scene.index("own")].region.center.tolist() == [0.25, 0.0, 0.0]
    assert scene.objects[scene.index("7")].region.center.tolist() == [1.0, 2.0, 0.5]


def test_a_message_without_a_stamp_is_of_when_it_was_recorded(tmp_path: Path) -> None:
    with Written(tmp_path / "bag") as bag:
        bag.detections(0, [CUP], recorded=START + 5)
    with read_bag(tmp_path / "bag") as log:
        assert [stamp for stamp, _ in log] == [START + 5]
    (line,) = log.report.lines()
    assert line.startswith("1 taken in, but: a message has no stamp: the time of recording counts")


def test_poses_of_a_topic_say_where_the_robot_is(tmp_path: Path) -> None:
    quarter = Rotation.from_euler("z", 90, degrees=True).as_quat()
    with Written(tmp_path / "bag") as bag:
        bag.tf(START, "map", "odom", (0, 0, 1), static=True)
        bag.pose(START, "/pose", "odom", (0, 0, 0))
        bag.pose(START + 2 * SECOND, "/pose", "odom", (2, 0, 0), quarter)
        bag.detections(START + SECOND, [CUP])
    with read_bag(tmp_path / "bag", robot="/pose") as log:
        ((_, scene),) = list(log)
    assert np.allclose(scene.views[0].position, (1, 0, 1))
    assert scene.views[0].heading == pytest.approx(math.pi / 4)
    with pytest.raises(
        ReaderError, match=r"topic '/detections' tells no poses: topics with poses are '/pose'"
    ):
        read_bag(tmp_path / "bag", robot="/detections")


def test_other_messages_that_tell_poses_and_boxes(tmp_path: Path) -> None:
    with Written(tmp_path / "bag") as bag:
        pose = bag._make(
            "geometry_msgs/msg/PoseWithCovariance",
            pose=bag._pose((3, 0, 0), (0, 0, 0, 1)),
            covariance=np.zeros(36),
        )
        kind = "geometry_msgs/msg/PoseWithCovarianceStamped"
        bag.write("/amcl", kind, bag._make(kind, header=bag._header(START, "map"), pose=pose), START)
        still = bag._make(
            "geometry_msgs/msg/Twist",
            linear=bag._xyz("Vector3", (0, 0, 0)),
            angular=bag._xyz("Vector3", (0, 0, 0)),
        )
        twist = bag._make("geometry_msgs/msg/TwistWithCovariance", twist=still, covariance=np.zeros(36))
        kind = "nav_msgs/msg/Odometry"
        odometry = bag._make(
            kind, header=bag._header(START, "map"), child_frame_id="base", pose=pose, twist=twist
        )
        bag.write("/odom", kind, odometry, START)
        one = Box("cup", (1, 0, 0), (1, 1, 1), frame="map", stamp=START)
        bag.write("/one", "vision_msgs/msg/Detection3D", bag._detection(one), START)
    for topic in ("/amcl", "/odom"):
        with read_bag(tmp_path / "bag", robot=topic) as log:
            ((stamp, scene),) = list(log)
            with pytest.raises(ReaderError, match="was read already: open it anew"):
                list(log)
        assert (stamp, scene.views[0].position.tolist()) == (START, [3.0, 0.0, 0.0])
        assert scene.objects[0].region.center.tolist() == [1.0, 0.0, 0.0]


# What tf knows, and what it does not.


def test_turns_between_two_stamps_go_the_shortest_way() -> None:
    known = Transforms()
    for stamp, angle in ((0, -170), (10, 170)):
        known.tell("a", "map", stamp, (0, 0, 0), Rotation.from_euler("z", angle, degrees=True).as_quat())
    pose = known.pose("a", "map", 5)
    assert not isinstance(pose, Unknown)
    assert np.allclose(pose.turn.apply([1, 0, 0]), (-1, 0, 0))


def test_frames_on_two_branches_are_connected_where_they_meet() -> None:
    known = Transforms()
    known.tell("base", "odom", 0, (5, 0, 0), (0, 0, 0, 1))
    known.tell("left", "base", 0, (0, 1, 0), (0, 0, 0, 1), static=True)
    known.tell(
        "right", "base", 0, (0, -1, 0), Rotation.from_euler("z", 90, degrees=True).as_quat(), static=True
    )
    # At 7 nobody knows where the base is, which does not matter here.
    pose = known.pose("left", "right", 7)
    assert not isinstance(pose, Unknown)
    assert np.allclose(pose.position, (2, 0, 0))
    far = known.pose("left", "odom", 7)
    assert isinstance(far, Unknown)
    assert far.detail == "'base' in 'odom' is known from 0.000000000 to 0.000000000, not at 0.000000007"
    lost = known.pose("left", "moon", 0)
    assert isinstance(lost, Unknown)
    assert lost.reason == "tf does not connect 'left' and 'moon'"
    assert lost.detail == "'left' hangs on 'odom', 'moon' on 'moon', at 0.000000000"


def test_loops_and_changed_parents_are_said() -> None:
    known = Transforms()
    for child, parent in (("a", "b"), ("b", "a")):
        known.tell(child, parent, 0, (0, 0, 0), (0, 0, 0, 1))
    assert known.pose("a", "map", 0) == Unknown("tf has a loop", "above 'a' at 0.000000000")
    # A frame beside the loop hangs on it too, and has no pose that counts how often one goes round.
    known.tell("beside", "b", 0, (0, 1, 0), (0, 0, 0, 1))
    assert known.pose("a", "beside", 0) == Unknown("tf has a loop", "above 'a' at 0.000000000")
    known.tell("c", "map", 0, (0, 0, 0), (0, 0, 0, 1))
    known.tell("c", "hand", 10, (0, 0, 0), (0, 0, 0, 1))
    assert known.pose("c", "map", 5) == Unknown(
        "a frame changes its parent", "'c' goes from 'map' to 'hand' between 0.000000000 and 0.000000010"
    )
    for bad in ((0, 0, 0, 0), (0, 0, 0, 2), (math.nan, 0, 0, 1), (0, 1e200, 0, 1)):
        assert not known.tell("d", "map", 0, (0, 0, 0), bad)
    assert not known.tell("d", "map", 0, (math.inf, 0, 0), (0, 0, 0, 1))
    assert not known.tell("d", "d", 0, (0, 0, 0), (0, 0, 0, 1))


def test_old_poses_are_dropped_and_late_ones_put_in_place() -> None:
    known = Transforms()
    for at in [*range(0, 200_000, 2), 199_999]:
        known.tell("a", "map", at * SECOND // 1000, (at, 0, 0), (0, 0, 0, 1))
    pose = known.pose("a", "map", 199_999 * SECOND // 1000)
    assert not isinstance(pose, Unknown)
    assert pose.position[0] == 199_999
    assert len(known._tracks["a"].stamps) < 40_000
    assert isinstance(known.pose("a", "map", 0), Unknown)


def test_what_tf_does_not_place_is_left_out_and_counted(tmp_path: Path) -> None:
    with Written(tmp_path / "bag") as bag:
        bag.tf(START, "map", "base", (0, 0, 0))
        bag.tf(START + SECOND, "map", "base", (1, 0, 0))
        bag.tf(START, "map", "bad", (0, 0, 0), (0, 0, 0, 0))
        for at in (0.5, 1.25, 2.0):
            bag.detections(START + round(at * SECOND), [CUP], "base")
        bag.detections(START + 3 * SECOND, [CUP, CUP], "moon")
        bag.detections(START + 4 * SECOND, [CUP], "")
    with read_bag(tmp_path / "bag", robot="base") as log:
        scenes = [scene for _, scene in log]
    assert [len(scene.views) for scene in scenes] == [1, 0, 0, 0, 0]
    assert log.report.skipped == {
        "a transform is none": 1,
        "tf does not reach the stamp": 2,
        "the robot is not placed: tf does not reach the stamp": 4,
        "tf does not connect 'moon' and 'map'": 2,
        "no frame is named": 1,
    }
    told = log.report.to_dict()["skipped"][1]
    assert told["first"] == (
        "'base' in 'map' is known from 1700000000.000000000 to 1700000001.000000000, not at "
        "1700000001.250000000"
    )
    with read_bag(tmp_path / "bag", hold=0.5) as log:
        held = [scene.objects[0].region.center[0] for _, scene in log]
    assert held[:2] == [1.5, 2.0]
    assert log.report.skipped["tf does not reach the stamp"] == 1


def test_tf_that_is_recorded_later_counts(tmp_path: Path) -> None:
    """Transforms of a stamp are published after it; and messages may be recorded in another order."""
    with Written(tmp_path / "bag", "mcap") as bag:
        for at in (1, 0, 2):
            bag.detections(START + at * SECOND, [CUP], "base", recorded=START + 2 * SECOND + at)
        for at in range(3):
            bag.tf(START + at * SECOND, "odom", "base", (at, 0, 0), recorded=START + 6 * SECOND)
        bag.tf(START, "map", "odom", (0, 0, 0), static=True, recorded=START + 60 * SECOND)
        bag.detections(START + SECOND, [CUP], "map", recorded=START + 61 * SECOND)
    with read_bag(tmp_path / "bag") as log:
        found = [(stamp, scene.objects[0].region.center[0]) for stamp, scene in log]
    assert found == [(START, 1.0), (START + SECOND, 2.0), (START + 2 * SECOND, 3.0)]
    assert log.report.skipped == {"a message is of no later moment than the one before it": 1}


# Boxes.


@pytest.mark.parametrize("axis", ["x", "y", "z"])
@pytest.mark.parametrize("turn", [0, 90, 180, 270])
def test_a_box_with_an_upright_edge_is_a_box(tmp_path: Path, axis: str, turn: int) -> None:
    rotation = Rotation.from_euler("z", 30, degrees=True) * Rotation.from_euler(axis, turn, degrees=True)
    size = np.array([0.2, 0.4, 0.6])
    with Written(tmp_path / "bag") as bag:
        bag.detections(START, [Box("brick", (1, 2, 3), size, rotation.as_quat())])
    with read_bag(tmp_path / "bag") as log:
        ((_, scene),) = list(log)
    corners = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
    expected = rotation.apply(corners * size) + np.array([1, 2, 3])
    box = scene.objects[0].region
    found = Rotation.from_euler("z", box.yaw).apply(corners * box.size) + box.center
    away = np.linalg.norm(expected[:, None] - found[None], axis=2)
    assert away.min(axis=1).max() < 1e-9
    assert log.report.lines() == []


def test_a_tilted_box_stays_tilted(tmp_path: Path) -> None:
    tilt = Rotation.from_euler("y", 30, degrees=True)
    with Written(tmp_path / "bag") as bag:
        bag.detections(START, [Box("plank", (0, 0, 1), (2, 0.2, 0.1), tilt.as_quat(), "p")])
    with read_bag(tmp_path / "bag") as log:
        ((_, scene),) = list(log)
    region = scene.objects[0].region
    assert isinstance(region, MeshRegion)
    spread = region.vertices - [0, 0, 1]
    assert np.allclose(np.abs(tilt.inv().apply(spread)), (1, 0.1, 0.05))
    # Outwards, so that the mesh has a volume.
    volume = np.einsum(
        "ij,ij->", *(np.cross(*(spread[region.faces[:, k]] for k in (0, 1))), spread[region.faces[:, 2]])
    )
    assert volume / 6 == pytest.approx(2 * 0.2 * 0.1)
    assert scene.boxes.half[0, 2] == pytest.approx(math.sin(math.pi / 6) + 0.05 * math.cos(math.pi / 6))
    (line,) = log.report.lines()
    assert line.startswith(
        "1 taken in, but: a box is tilted: relations of boxes are those of the upright box"
    )
    assert line.endswith("(the first: by 30.00 degrees at 1700000000.000000000)")
    with read_bag(tmp_path / "bag", level=31) as log:
        ((_, scene),) = list(log)
    assert scene.objects[0].region.size.tolist() == [2.0, 0.2, 0.1]
    assert "stood upright" in log.report.lines()[0]


def test_what_is_no_box_is_left_out_with_the_reason(tmp_path: Path) -> None:
    nan = math.nan
    bad = [
        Box("cup", (nan, 0, 0), (1, 1, 1)),
        Box("cup", (0, 0, 0), (1, -1, 1)),
        Box("cup", (1e300, 0, 0), (1, 1, 1)),
        Box("cup", (9e6, 0, 0), (9e6, 1, 1), (0.6, 0, 0, 0.8)),
        Box("cup", (0, 0, 0), (1, 1, 1), (0, 0, 0, 3)),
        Box("cup", (0, 0, 0), (1, 1, 1), stamp=-5),
        Box("cup", (0, 0, 0), (1, 1, 1), (0, 0, 0, 0), track="zero"),
        Box("c\aup", (0, 0, 5), (1, 1, 1), track="x" * 300, score=nan, more=[("mug", 7.0)]),
    ]
    with Written(tmp_path / "bag") as bag:
        bag.detections(START, bad)
    with read_bag(tmp_path / "bag") as log:
        ((_, scene),) = list(log)
    assert {one.id: [label.name for label in one.labels] for one in scene.objects} == {
        "zero": ["cup"],
        "mug_1": ["mug"],
    }
    assert scene.objects[-1].labels[0].score in (0.9, 1.0)
    assert log.report.skipped == {
        "a number is not finite": 1,
        "a size is negative": 1,
        "a number is beyond 1e+07 m": 1,
        "it is beyond 1e+07 m in 'map'": 1,
        "a quaternion is not of length one": 1,
        "its stamp is before 1970": 1,
    }
    notes = {one["reason"] for one in log.report.to_dict()["notes"]}
    assert notes == {
        "a box has no orientation, 0 0 0 0: it counts as unturned in its frame",
        "a label is no name: it is left out",
        "a score is not from 0 to 1: it counts as 0 or 1",
        "the id of a track is no name: it is left out",
    }


def test_five_labels_and_what_they_were_over_time(tmp_path: Path) -> None:
    with Written(tmp_path / "bag") as bag:
        many = [(f"l{at}", at / 10) for at in range(8)]
        bag.detections(START, [Box("", (0, 0, 0), (1, 1, 1), track="a", more=many)])
        bag.detections(START + 1, [Box("", (0, 0, 0), (1, 1, 1), track="a", more=[("l7", 0.1)])])
    with read_bag(tmp_path / "bag") as log:
        first, second = (scene.objects[0] for _, scene in log)
    assert [label.name for label in first.labels] == ["l7", "l6", "l5", "l4", "l3"]
    assert {label.name: label.score for label in second.labels}["l7"] == 0.4
    assert second.label == "l7"


# Which detections are of one thing.


def moved(tmp_path: Path, *frames: list[Box], every: float = 1.0, **choices: Any) -> list[Scene]:
    """Return the scenes of frames that follow each other."""
    with Written(tmp_path / "bag") as bag:
        for at, boxes in enumerate(frames):
            bag.detections(START + round(at * every * SECOND), boxes)
    with read_bag(tmp_path / "bag", **choices) as log:
        return [scene for _, scene in log]


def cup(x: float, label: str = "cup", track: str = "", score: float = 0.9) -> Box:
    return Box(label, (x, 0.0, 0.5), (0.1, 0.1, 0.1), track=track, score=score)


def test_things_without_ids_keep_theirs_by_overlap_and_by_way(tmp_path: Path) -> None:
    scenes = moved(tmp_path, [cup(0), cup(1)], [cup(1.04), cup(0.04)], [cup(1.3), cup(0.3)], [cup(2.0)])
    assert [one.id for one in scenes[-1].objects] == ["cup_1", "cup_2", "cup_3"]
    places = {one.id: one.region.center[0] for one in scenes[2].objects}
    assert places == {"cup_1": 0.3, "cup_2": 1.3}


def test_ids_of_trackers_count_unless_told_otherwise(tmp_path: Path) -> None:
    frames = [cup(0, track="a")], [cup(0, track="b")]
    assert [one.id for one in moved(tmp_path / "1", *frames)[-1].objects] == ["a", "b"]
    scenes = moved(tmp_path / "2", *frames, tracking="overlap")
    assert [one.id for one in scenes[-1].objects] == ["cup_1"]
    # An id as we make them, by a tracker.
    scenes = moved(tmp_path / "3", [cup(0)], [cup(3, track="cup_1")], [cup(0)])
    assert {one.id for one in scenes[-1].objects} >= {"cup_1", "cup_2"}


def test_of_two_with_one_id_the_better_counts(tmp_path: Path) -> None:
    for folder, scores in (("1", (0.5, 0.9, 0.7)), ("2", (0.9, 0.5, 0.7))):
        (scene,) = moved(tmp_path / folder, [cup(at, track="a", score=one) for at, one in enumerate(scores)])
        assert scene.objects[0].region.center[0] == scores.index(0.9)


def test_what_nothing_shows_is_forgotten_after_a_while(tmp_path: Path) -> None:
    frames = [cup(0, track="a"), cup(1)], *([[]] * 5)
    for forget, lengths in ((2.0, [2, 2, 2, 0, 0, 0]), (math.inf, [2] * 6), (0.0, [2, 0, 0, 0, 0, 0])):
        scenes = moved(tmp_path / str(forget), *frames, forget=forget)
        assert [len(scene.objects) for scene in scenes] == lengths


def test_floors_and_walls_are_surfaces(tmp_path: Path) -> None:
    ground = Box("floor", (0, 0, -0.05), (4, 4, 0.1))
    (scene,) = moved(tmp_path, [ground, Box("chair", (0, 0, 0.5), (0.5, 0.5, 1.0))])
    assert [one.kind for one in scene.objects] == ["surface", "object"]
    with KnowledgeBase(scene) as kb:
        assert [one.to_prolog() for one in kb.relations(relation=["on_top_of"])] == [
            "on_top_of('chair_1','floor_1')"
        ]


def test_what_is_always_there_is_in_every_scene(tmp_path: Path) -> None:
    table = {"id": "table", "label": "table", "box": {"center": [0, 0, 0.225], "size": [1, 1, 0.45]}}
    views = [{"id": "door", "position": [5, 5, 1]}]
    around = Scene.from_dict(
        {"deixis": 1, "id": "room", "objects": [table], "views": views, "thresholds": {"closeness": 0.3}}
    )
    around.save(tmp_path / "room.json")
    scenes = moved(tmp_path, [cup(0)], [cup(0.01)], around=around)
    assert [one.id for one in scenes[1].objects] == ["table", "cup_1"]
    assert scenes[1].views[0].id == "door"
    assert scenes[1].thresholds.closeness == 0.3
    result = call(
        "bag",
        tmp_path / "bag",
        "--scene",
        tmp_path / "room.json",
        "--format",
        "table",
        "--relation",
        "on_top_of",
    )
    assert result.out.splitlines()[1].split() == ["on_top_of", "cup_1", "table", "0.000", "0.020"]
    with pytest.raises(SceneError, match="both called 'table': rename the object"):
        moved(tmp_path / "2", [cup(0, track="table")], around=around)
    with pytest.raises(ReaderError, match="has a view 'robot': rename it"):
        read_bag(
            tmp_path / "bag", around=Scene.from_dict(
                {"deixis": 1, "id": "r", "views": [{"id": "robot", "position": [0, 0, 0]}]}
            )
        )  # fmt: skip


# Bags that are not as they should be.


def test_topics_are_chosen_or_listed(tmp_path: Path) -> None:
    with Written(tmp_path / "bag") as bag:
        bag.detections(START, [CUP])
        bag.topic = "/more"
        bag.detections(START, [CUP])
        bag.pose(START, "/pose", "map", (0, 0, 0))
    listed = "topics with detections are '/detections' \\(1 messages\\), '/more' \\(1 messages\\)"
    with pytest.raises(ReaderError, match=f"has several: give one of them: {listed}"):
        read_bag(tmp_path / "bag")
    with pytest.raises(ReaderError, match=f"topic '/none' is not in it: {listed}"):
        read_bag(tmp_path / "bag", topic="/none")
    with pytest.raises(
        ReaderError, match=f"topic '/pose' has messages of the type 'geometry_msgs/msg/PoseStamped': {listed}"
    ):
        read_bag(tmp_path / "bag", topic="/pose")
    with read_bag(tmp_path / "bag", topic="/more") as log:
        assert len(list(log)) == 1
    with Written(tmp_path / "poses") as bag:
        bag.pose(START, "/pose", "map", (0, 0, 0))
    with pytest.raises(ReaderError, match="its types are 'geometry_msgs/msg/PoseStamped'"):
        read_bag(tmp_path / "poses")


def test_damaged_bags_say_how_much_was_read(tmp_path: Path) -> None:
    bag = tmp_path / "bag"
    with Written(bag) as written:
        for at in range(100):
            written.detections(START + at * SECOND, [CUP] * 3)
    (place,) = bag.glob("*.db3")
    spoil(place, "UPDATE messages SET data = x'00010000ffffffffff' WHERE id = 51")
    result = call("bag", bag, "--relation", "near")
    assert result.code == 2
    assert "is damaged: 50 messages were read, the last of 1700000049.000000000: " in result.err
    assert json.loads(result.out.splitlines()[-1])["frames"] == 50
    place.write_bytes(place.read_bytes()[:1000])
    assert "cannot be read as a bag" in call("bag", bag).err
    assert call("bag", tmp_path / "none").err.endswith(
        "does not exist: give the folder of a bag, or its file\n"
    )


def spoil(place: Path, statement: str) -> None:
    with sqlite3.connect(place) as database:
        database.execute(statement)
    database.close()


@pytest.mark.parametrize("storage", ["sqlite3", "mcap", "ros1"])
def test_bytes_that_are_wrong_give_one_kind_of_error(tmp_path: Path, storage: str) -> None:
    draw = np.random.default_rng(3)
    if storage == "ros1":
        place = tmp_path / "log.bag"
        with Written(place) as bag:
            for at in range(5):
                bag.detections(START + at * SECOND, [Box("4", (0, 0, 0), (1, 1, 1))])
    else:
        (place,) = kitchen(tmp_path / "bag", storage).glob("*.db3" if storage == "sqlite3" else "*.mcap")
    whole = bytearray(place.read_bytes())
    outcomes = set()
    for _ in range(40):
        broken = bytearray(whole)
        if draw.random() < 0.3:
            del broken[int(draw.integers(len(whole))) :]
        else:
            for at in draw.integers(len(whole), size=5):
                broken[at] = draw.integers(256)
        place.write_bytes(broken)
        try:
            with read_bag(place) as log:
                outcomes.add(len(list(log)) > 0)
        except ReaderError as error:
            outcomes.add(type(error))
    assert ReaderError in outcomes


def test_messages_of_an_unknown_version_are_refused(tmp_path: Path) -> None:
    with Written(tmp_path / "bag") as bag:
        bag.detections(START, [CUP])
    forget_definitions(tmp_path / "bag")
    (place,) = (tmp_path / "bag").glob("*.db3")
    spoil(place, "UPDATE messages SET data = CAST(data || x'0102030405060708' AS BLOB)")
    with (
        read_bag(tmp_path / "bag") as log,
        pytest.raises(ReaderError, match="are of no version that is known"),
    ):
        list(log)


def test_memory_does_not_grow_with_the_bag(tmp_path: Path) -> None:
    peaks = []
    for count in (100, 800):
        bag = tmp_path / str(count)
        with Written(bag) as written:
            for at in range(count):
                stamp = START + at * SECOND
                written.tf(stamp, "map", "base", (0, 0, 0))
                written.detections(stamp, [cup(0, track=f"t{at}")], "base")
        tracemalloc.start()
        with read_bag(bag) as log:
            assert sum(1 for _ in log) == count
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    assert peaks[1] < peaks[0] * 2


def test_without_rosbags_it_says_what_to_install(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "rosbags", None)
    with pytest.raises(MissingDependency, match=r"pip install 'deixis\[ros\]'"):
        read_bag(tmp_path)


# The command.


@pytest.fixture(scope="module")
def bag(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    place = tmp_path_factory.mktemp("kitchen")
    yield kitchen(place / "bag")
    shutil.rmtree(place)


def test_changes_are_lines_of_json(bag: Path) -> None:
    result = call("bag", bag, "--robot", "base_link", "--relation", "left_of", "--relation", "right_of")
    assert (result.code, result.err) == (0, "")
    *lines, report = map(json.loads, result.out.splitlines())
    assert report == {"frames": 13, "detections": 36, "skipped": [], "notes": []}
    assert [(one["ns"] - START, len(one["gained"]), len(one["lost"])) for one in lines] == [
        (5 * SECOND, 1, 0),
        (8 * SECOND, 0, 1),
        (11 * SECOND, 1, 0),
    ]
    assert lines[0]["stamp"] == 1700000005.0
    assert lines[0]["gained"][0] == {
        "relation": "left_of", "figure": "cup_1", "reference": "book_1", "view": "robot", "margin": 0.04
    }  # fmt: skip


def test_intervals_tables_and_own_rules(bag: Path, tmp_path: Path) -> None:
    own = tmp_path / "own.pl"
    own.write_text("stands(A, B) :- on_top_of(A, B).\n", encoding="utf-8")
    told = call("bag", bag, "--rules", own, "--relation", "stands", "--format", "csv")
    assert told.out.splitlines() == [
        "relation,figure,reference,view,since,until,margin",
        f"stands,book_1,table_1,,{START},,0.02",
        f"stands,cup_1,table_1,,{START + 5 * SECOND},,0.02",
    ]
    lines = call("bag", bag, "--relation", "on_top_of", "--forget", "1", "--format", "intervals").out
    first = json.loads(lines.splitlines()[0])
    assert (first["figure"], first["since"], first["until"]) == ("book_1", START, START + 11 * SECOND)
    unknown = call("bag", bag, "--relation", "on_topof")
    assert unknown.code == 2
    assert "did you mean 'on_top_of'?" in unknown.err
    assert "is followed over time" in call("bag", bag, "--relation", "touches").err


def test_where_nothing_is_found_the_exit_code_is_1(bag: Path) -> None:
    result = call("bag", bag, "--frame", "moon")
    assert result.code == 1
    assert "36 left out: tf does not connect 'camera' and 'moon'" in result.err
    assert json.loads(result.out)["skipped"][0]["count"] == 36
