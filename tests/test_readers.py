"""Readers: the registry, AI2-THOR rooms and VirtualHome graphs, hostile files, handedness."""

from __future__ import annotations

import json
import re
from importlib.metadata import EntryPoint, EntryPoints
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from deixis import readers
from deixis.errors import DeixisError, ReaderError, SceneError
from deixis.readers import ithor, virtualhome
from deixis.scene import Scene

ROOT = Path(__file__).resolve().parents[1]
KB = ROOT / "kb"
DATA = ROOT.parent / "shared" / "data"
ROOMS = DATA / "ithor" / "scenes.jsonl"
HOMES = [DATA / "virtualhome" / f"TestScene{number}_graph.json" for number in (1, 2)]

thor = pytest.mark.skipif(not ROOMS.exists(), reason="../shared/data/ithor is absent")
homes = pytest.mark.skipif(not HOMES[0].exists(), reason="../shared/data/virtualhome is absent")

EGG = {
    "id": "Egg|-02.00|+00.50|+01.00",
    "label": "Egg",
    "aabb_min": [0.9, 1.9, 0.4],
    "aabb_max": [1.1, 2.1, 0.6],
    "parents": [],
    "pickupable": True,
}


def rooms(folder: Path, *lines: Any) -> Path:
    path = folder / "rooms.jsonl"
    path.write_text("\n".join(json.dumps(line) for line in lines) + "\n", encoding="utf-8")
    return path


def room(*objects: Any, **rest: Any) -> dict[str, Any]:
    return {"scene": "Plan1", "objects": list(objects), **rest}


def node(number: Any = 1, **rest: Any) -> dict[str, Any]:
    place = {"center": [1.0, 2.0, 3.0], "size": [0.1, 0.2, 0.3]}
    values = {"id": number, "class_name": "plate", "category": "Props", "bounding_box": place, **rest}
    return {key: value for key, value in values.items() if value is not ...}


def home(folder: Path, *nodes: Any, **rest: Any) -> Path:
    path = folder / "home.json"
    path.write_text(json.dumps({"nodes": list(nodes), "edges": [], **rest}), encoding="utf-8")
    return path


# The registry


def test_formats_are_found_and_misspelt_ones_are_suggested(tmp_path: Path) -> None:
    assert readers.formats()[:3] == ("deixis", "ithor", "virtualhome")
    with pytest.raises(ReaderError, match="did you mean 'ithor'"):
        readers.read("ithro", tmp_path)
    with pytest.raises(ReaderError, match="known are deixis, ithor"):
        readers.read("zzzzzz", tmp_path)


def test_the_own_format_is_read() -> None:
    scene = readers.read_one("deixis", KB / "scenes" / "hans.json")
    assert scene.to_dict() == Scene.load(KB / "scenes" / "hans.json").to_dict()


def test_unknown_options_are_refused(tmp_path: Path) -> None:
    with pytest.raises(ReaderError, match="no option 'room': it has scene"):
        readers.read("ithor", rooms(tmp_path, room(EGG)), room="Plan1")
    with pytest.raises(ReaderError, match="no option 'view': it has none"):
        readers.read("deixis", tmp_path, view="0,0,0,0")


def test_others_can_add_readers_but_not_replace_ours(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    points = EntryPoints(
        [
            EntryPoint("mine", "deixis.readers.native", readers.GROUP),
            EntryPoint("ithor", "deixis.readers.native", readers.GROUP),
            EntryPoint("gone", "deixis_no_such_module", readers.GROUP),
            EntryPoint("hollow", "json", readers.GROUP),
        ]
    )
    monkeypatch.setattr(readers, "entry_points", lambda group: points.select(group=group))
    assert readers.formats() == ("deixis", "ithor", "virtualhome", "rdf", "gone", "hollow", "mine")
    assert readers.read_one("mine", KB / "scenes" / "hans.json").id == "hans"
    assert readers.reader("ithor") is ithor
    with pytest.raises(ReaderError, match="deixis_no_such_module, cannot be loaded"):
        readers.read("gone", tmp_path)
    with pytest.raises(ReaderError, match="json, has no function read"):
        readers.read("hollow", tmp_path)


def test_formats_are_recognised_by_their_beginning(tmp_path: Path) -> None:
    assert readers.sniff(KB / "scenes" / "hans.json") == "deixis"
    assert readers.sniff(rooms(tmp_path, room(EGG))) == "ithor"
    assert readers.sniff(home(tmp_path, node())) == "virtualhome"
    assert readers.sniff(KB / "scene.schema.json") is None
    with pytest.raises(ReaderError, match="cannot be read"):
        readers.sniff(tmp_path / "none")
    with pytest.raises(ReaderError, match="cannot be read"):
        readers.sniff(tmp_path)


def test_the_packages_entry_points_are_the_registry() -> None:
    text = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    section = text.split('[project.entry-points."deixis.readers"]')[1].split("[", 1)[0]
    assert dict(re.findall(r'^(\w+) = "(.+)"$', section, re.MULTILINE)) == readers.BUILT_IN


# AI2-THOR


def test_a_room_becomes_a_scene(tmp_path: Path) -> None:
    floor = {"id": "Floor|0", "label": "Floor", "aabb_min": [0, 0, -0.7], "aabb_max": [4, 4, 0.01]}
    other = {**EGG, "id": "Egg|-03.00|+00.50|+01.00"}
    path = rooms(tmp_path, room(EGG, floor, other, agent_position_trilaterated=[2.0, 0.0, 0.9]))
    scene = readers.read_one("ithor", path)
    assert [(thing.id, thing.label, thing.kind) for thing in scene.objects] == [
        ("egg1", "egg", "object"),
        ("floor1", "floor", "surface"),
        ("egg2", "egg", "object"),
    ]
    assert scene.boxes.center[1].tolist() == [2.0, 2.0, 0.01]
    assert scene.boxes.half[1, 2] == 0.0
    assert np.allclose(scene.boxes.center[0], [1.0, 2.0, 0.5])
    assert (scene.views[0].id, scene.views[0].label) == ("robot", "robot")
    assert abs(scene.views[0].heading - np.pi / 2) < 1e-4
    assert ithor.original_ids(path, "Plan1")["egg2"] == other["id"]


def test_ids_do_not_hang_on_the_order_of_the_file(tmp_path: Path) -> None:
    other = {**EGG, "id": "Egg|-03.00|+00.50|+01.00"}
    first = ithor.original_ids(rooms(tmp_path, room(EGG, other)), "Plan1")
    assert first == ithor.original_ids(rooms(tmp_path, room(other, EGG)), "Plan1")


def test_the_tighter_box_is_kept_at_its_true_height(tmp_path: Path) -> None:
    turn = 0.5
    spin = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    plan = np.array([[-1, -0.1], [1, -0.1], [1, 0.1], [-1, 0.1]]) @ spin.T
    corners = [[*point, z] for z in (0.0, 0.3) for point in plan.tolist()]
    low, high = [*plan.min(axis=0), 0.1], [*plan.max(axis=0), 0.2]
    scene = readers.read_one(
        "ithor", rooms(tmp_path, room({**EGG, "aabb_min": low, "aabb_max": high, "obb_corners": corners}))
    )
    assert np.allclose(sorted(scene.boxes.half[0]), [0.05, 0.1, 1.0], atol=1e-4)
    assert abs(scene.boxes.yaw[0] - turn) < 1e-3
    loose = [[-9, -9, 0], [9, -9, 0], [9, 9, 1], [-9, 9, 1]]
    scene = readers.read_one("ithor", rooms(tmp_path, room({**EGG, "obb_corners": loose})))
    assert np.allclose(scene.boxes.half[0], 0.1)
    assert scene.boxes.yaw[0] == 0.0


def test_one_room_of_many_is_chosen(tmp_path: Path) -> None:
    path = rooms(tmp_path, room(EGG), {**room(EGG), "scene": "Plan2"})
    assert [scene.id for scene in readers.read("ithor", path)] == ["Plan1", "Plan2"]
    assert readers.read_one("ithor", f"{path}#Plan2").id == "Plan2"
    assert readers.read_one("ithor", path, scene="Plan1").id == "Plan1"
    with pytest.raises(ReaderError, match="holds 2 scenes: add # and one of Plan1, Plan2"):
        readers.read_one("ithor", path)
    with pytest.raises(ReaderError, match="no room 'Plan3': it has Plan1, Plan2"):
        readers.read("ithor", f"{path}#Plan3")
    path.write_text("\n\n", encoding="utf-8")
    with pytest.raises(ReaderError, match="holds no scene"):
        readers.read("ithor", path)


@pytest.mark.parametrize(
    ("line", "said"),
    [
        (3, "line 1 is not a JSON object"),
        ({"objects": []}, "no text 'scene'"),
        ({"scene": "a"}, "no list 'objects'"),
        (room(3), "object number 1 is not"),
        (room({**EGG, "id": 3}), "no text 'id'"),
        (room({**EGG, "label": None}), r"Egg\|.*no text 'label'"),
        (room(EGG, EGG), r"Egg\|.*more than once"),
        (room({**EGG, "aabb_min": None}), r"Egg\|.*aabb_min is not a list of three"),
        (room({**EGG, "aabb_min": [0, 0, "a"]}), r"Egg\|.*aabb_min is not a list of three"),
        (room({**EGG, "aabb_min": [0, 0, True]}), r"Egg\|.*aabb_min is not a list of three"),
        (room({**EGG, "aabb_max": [0, 0, 0]}), r"Egg\|.*swap"),
        (room({**EGG, "obb_corners": [[0, 0]]}), r"Egg\|.*obb_corners"),
        (room({**EGG, "obb_corners": []}), r"Egg\|.*obb_corners is empty"),
        (room({**EGG, "obb_corners": 3}), r"Egg\|.*obb_corners"),
        (room({**EGG, "parents": "a"}), r"Egg\|.*parents"),
        (room(EGG, frame="left-handed"), "left-handed"),
        (room(EGG, agent_position_trilaterated=[1]), "agent's position"),
    ],
)
def test_rooms_that_are_wrong_are_refused(line: Any, said: str, tmp_path: Path) -> None:
    with pytest.raises(ReaderError, match=said):
        readers.read("ithor", rooms(tmp_path, line))


def test_the_door_checks_what_readers_bring(tmp_path: Path) -> None:
    with pytest.raises(SceneError, match=r"'egg1'.*limits"):
        readers.read("ithor", rooms(tmp_path, room({**EGG, "aabb_max": [1e9, 1e9, 1e9]})))
    path = tmp_path / "a.jsonl"
    path.write_text('{"scene": "a", "objects": []}\n{"scene": NaN}\n', encoding="utf-8")
    with pytest.raises(ReaderError, match="line 2: NaN"):
        readers.read("ithor", path)
    with pytest.raises(ReaderError, match="does not exist"):
        readers.read("ithor", tmp_path / "none.jsonl")


@thor
def test_all_rooms_load() -> None:
    scenes = readers.read("ithor", ROOMS)
    assert len(scenes) == 13
    assert sum(len(scene.objects) for scene in scenes) == 659
    for scene in scenes:
        assert np.isfinite(scene.boxes.center).all()
        assert len(scene.views) == 1
        assert Scene.from_dict(json.loads(scene.to_json())).to_dict() == scene.to_dict()
        floors = [thing for thing in scene.objects if thing.kind == "surface"]
        assert len(floors) == (0 if scene.id.startswith("robothor") else 1)
        assert [note for note in scene.diagnostics if "no floor" in note] == list(scene.diagnostics)
        assert len(scene.diagnostics) == 1 - len(floors)
        for floor in floors:
            # The agent's centre is 0.901 m above what it stands on.
            height = scene.boxes.center[scene.index(floor.id), 2]
            assert abs(scene.views[0].position[2] - 0.901 - height) < 2e-4


@thor
def test_rooms_are_not_mirrored() -> None:
    """A THOR id holds Unity's x, y, z of the thing: the one conversion must lead from there to its box."""
    true, mirrored = [], []
    for scene in readers.read("ithor", ROOMS):
        for short, original in ithor.original_ids(ROOMS, scene.id).items():
            unity = np.array([float(part) for part in original.split("|")[1:4]])
            row = scene.index(short)
            for result, sign in ((true, [1, 1]), (mirrored, [1, -1])):
                offset = virtualhome.to_world(unity)[:2] * sign - scene.boxes.center[row, :2]
                # A thing's origin is in or beside its box; hinges and basins are the exceptions.
                result.append(np.hypot(*offset) < 0.3 + np.hypot(*scene.boxes.half[row, :2]))
    assert np.mean(true) > 0.98
    assert np.mean(mirrored) < 0.4


@thor
def test_labels_come_with_short_ids() -> None:
    told = {record.id: record for record in ithor.parents(ROOMS, "FloorPlan1")}
    scene = readers.read_one("ithor", f"{ROOMS}#FloorPlan1")
    assert list(told) == [thing.id for thing in scene.objects]
    assert told["egg1"].receptacles == ("fridge1",)
    assert told["egg1"].pickupable
    assert told["egg1"].label == scene.objects[scene.index("egg1")].label
    assert not told["fridge1"].pickupable
    assert all(scene.index(name) >= 0 for record in told.values() for name in record.receptacles)
    with pytest.raises(ReaderError, match="no room"):
        ithor.parents(ROOMS, "FloorPlan9")


@thor
def test_the_sample_kitchen_is_the_converted_room() -> None:
    made = readers.read_one("ithor", f"{ROOMS}#FloorPlan1")
    assert (KB / "scenes" / "kitchen.json").read_text(encoding="utf-8") == made.to_json()


# VirtualHome


def test_handedness_is_turned_once() -> None:
    """Who faces forward with the head up has the right hand at forward x up in a right-handed frame."""
    right, up, forward = virtualhome.to_world(np.eye(3))
    assert np.allclose(np.cross(forward, up), right)
    assert up.tolist() == [0.0, 0.0, 1.0]


def test_a_graph_becomes_a_scene(tmp_path: Path) -> None:
    tile = {"center": [0.0, 0.0, 0.0], "size": [2.5, 9e-6, 2.0]}
    straight = {"center": [0.0, 1.25, 1.0], "size": [2.5, 2.5, 0.06]}
    corner = {"center": [0.0, 1.25, 1.0], "size": [2.5, 2.5, 2.5]}
    links = [
        {"from_id": 1, "to_id": 2, "relation_type": "ON"},
        {"from_id": 1, "to_id": 5, "relation_type": "INSIDE"},
    ]
    path = home(
        tmp_path,
        node(1),
        node(2, class_name="floor", category="Floor", bounding_box=tile),
        node(3, class_name="wall", category="Walls", bounding_box=straight),
        node(4, class_name="wall", category="Walls", bounding_box=corner),
        node(5, class_name="kitchen", category="Rooms"),
        node(6, bounding_box=None),
        node(7, class_name="mp3"),
        edges=links,
    )
    scene = readers.read_one("virtualhome", path)
    assert [thing.id for thing in scene.objects] == ["plate1", "floor2", "wall3", "mp3_7"]
    assert [thing.kind for thing in scene.objects] == ["object", "surface", "surface", "object"]
    assert scene.boxes.center[0].tolist() == [3.0, -1.0, 2.0]
    assert (2 * scene.boxes.half[0]).tolist() == [0.3, 0.1, 0.2]
    assert scene.boxes.normal.tolist() == [-1, 2, 0, -1]
    assert scene.views == ()
    assert len(scene.diagnostics) == 3
    assert all("left out" in note for note in scene.diagnostics)
    assert virtualhome.edges(path) == (("plate1", "ON", "floor2"),)


def test_the_robots_pose_can_be_given(tmp_path: Path) -> None:
    path = home(tmp_path, node())
    for pose in ("1, 2, 0.5, -1.5", (1, 2, 0.5, -1.5)):
        (view,) = readers.read_one("virtualhome", path, view=pose).views
        assert (view.id, view.position.tolist(), view.heading) == ("robot", [1.0, 2.0, 0.5], -1.5)
    for pose in ("1,2,3", "a,b,c,d", 7, (1, 2, 3, 4, 5)):
        with pytest.raises(ReaderError, match="give four numbers"):
            readers.read("virtualhome", path, view=pose)
    with pytest.raises(SceneError, match=r"view 'robot'.*finite"):
        readers.read("virtualhome", path, view="nan,0,0,0")


@pytest.mark.parametrize(
    ("nodes", "rest", "said"),
    [
        ([3], {}, "node number 1 is not"),
        ([node("1")], {}, "node number 1 has no whole number"),
        ([node(True)], {}, "node number 1 has no whole number"),
        ([node(1), node(1)], {}, "node 1 is given more than once"),
        ([node(class_name="")], {}, "node 1 has no text 'class_name'"),
        ([node(bounding_box=3)], {}, "node 1: bounding_box is not"),
        ([node(bounding_box={"center": [0, 0, 0]})], {}, "node 1: bounding_box.size"),
        ([node(bounding_box={"center": [0, 0, 0], "size": [1, -1, 1]})], {}, r"node 1.*negative"),
        ([node()], {"edges": None}, "no list 'edges'"),
        ([node()], {"nodes": None}, "no list 'nodes'"),
    ],
)
def test_graphs_that_are_wrong_are_refused(nodes: Any, rest: Any, said: str, tmp_path: Path) -> None:
    with pytest.raises(ReaderError, match=said):
        readers.read("virtualhome", home(tmp_path, *nodes, **rest))


def test_edges_that_are_wrong_are_refused(tmp_path: Path) -> None:
    for link in (3, {"from_id": 1, "to_id": 1}):
        with pytest.raises(ReaderError, match="edge number 1"):
            virtualhome.edges(home(tmp_path, node(), edges=[link]))


@homes
@pytest.mark.parametrize(
    ("path", "things", "left_out"), [(HOMES[0], 415, 22), (HOMES[1], 290, 20)], ids=["1", "2"]
)
def test_both_homes_load(path: Path, things: int, left_out: int) -> None:
    scene = readers.read_one("virtualhome", path)
    assert len(scene.objects) == things
    assert sum(int(note.split(": ")[1].split()[0]) for note in scene.diagnostics) == left_out
    assert np.isfinite(scene.boxes.center).all()
    surfaces = {thing.label for thing in scene.objects if thing.kind == "surface"}
    assert surfaces == {"floor", "wall", "ceiling"}
    ids = {thing.id for thing in scene.objects}
    told = virtualhome.edges(path)
    assert {relation for _, relation, _ in told} >= {"ON", "INSIDE", "CLOSE"}
    assert all(figure in ids and reference in ids for figure, _, reference in told)
    assert Scene.from_dict(json.loads(scene.to_json())).to_dict() == scene.to_dict()


@pytest.mark.parametrize("name", ["deixis", "ithor", "virtualhome"])
@pytest.mark.parametrize(
    "data", [b"", b"\xff\xfe", b"[" * 100_000, b"{}", b"[]", b'{"scene": "a"}', b'{"deixis": 1}', b"\0"]
)
def test_no_reader_lets_rubbish_through(name: str, data: bytes, tmp_path: Path) -> None:
    path = tmp_path / "a.json"
    path.write_bytes(data)
    with pytest.raises(DeixisError):
        readers.read(name, path)
    readers.sniff(path)
