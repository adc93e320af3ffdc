"""Scenes: the format's door, the runtime model, files beside the scene, surfaces."""

from __future__ import annotations

import json
import struct
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import pytest
import trimesh
from hypothesis import given
from hypothesis import strategies as st

from deixis import mesh_file
from deixis.errors import SceneError, ThresholdError
from deixis.scene import (
    BoxRegion,
    Label,
    MeshRegion,
    PointRegion,
    Scene,
    SpatialObject,
    SurfaceRegion,
    View,
    scene_schema,
)

KB = Path(__file__).resolve().parents[1] / "kb"
BOX = {"center": [0.0, 0.0, 0.5], "size": [1.0, 1.0, 1.0]}
SQUARE = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
TRIANGLE = {"vertices": [[0, 0, 0], [1, 0, 0], [0, 1, 0]], "faces": [[0, 1, 2]]}


def scene(*objects: Any, **rest: Any) -> dict[str, Any]:
    return {"deixis": 1, "id": "room", "objects": list(objects), **rest}


def cup(**changes: Any) -> dict[str, Any]:
    values = {"id": "cup", "box": BOX, **changes}
    return {key: value for key, value in values.items() if value is not ...}


def box(**changes: Any) -> dict[str, Any]:
    return cup(box={key: value for key, value in {**BOX, **changes}.items() if value is not ...})


def view(**changes: Any) -> dict[str, Any]:
    values = {"id": "v0", "position": [0, 0, 1], **changes}
    return {key: value for key, value in values.items() if value is not ...}


REFUSED: list[tuple[str, Any, tuple[str, ...]]] = [
    ("not an object", [1], ("JSON object",)),
    ("no version", {"id": "room"}, ("'deixis' is missing", "deixis import")),
    ("later version", {"deixis": 2, "id": "room"}, ("2", "version 1")),
    ("true is no version", {"deixis": True, "id": "room"}, ("version 1",)),
    ("no scene id", {"deixis": 1}, ("id is missing",)),
    ("unknown key", scene(cup(colour="red")), ("'cup'", "'colour'", "known keys")),
    ("misspelt key", scene(cup(boxx=1)), ("'cup'", "did you mean 'box'")),
    ("key named as a union's branch", scene(cup(file=1)), ("'cup'", "'file'")),
    ("misspelt key in box", scene(box(centre=[0, 0, 0])), ("'cup'", "did you mean 'center'")),
    ("misspelt top key", {"deixis": 1, "id": "room", "object": []}, ("'room'", "did you mean 'objects'")),
    ("misspelt threshold", scene(thresholds={"granularty": 0.1}), ("did you mean 'granularity'",)),
    ("bad threshold", scene(thresholds={"granularity": -1}), ("'room'", "granularity")),
    ("thresholds out of order", scene(thresholds={"granularity": 2.0}), ("'room'", "penetration")),
    ("object is a number", scene(3), ("object number 1",)),
    ("objects is an object", {"deixis": 1, "id": "room", "objects": {}}, ("objects", "give a list")),
    ("null region", scene(cup(box=None)), ("'cup'", "box is null")),
    ("no region", scene(cup(box=...)), ("'cup'", "no region")),
    ("two regions", scene(cup(points=SQUARE)), ("'cup'", "box and points", "exactly one")),
    ("no size", scene(box(size=...)), ("'cup'", "box.size is missing")),
    ("negative size", scene(box(size=[1, 1, -0.1])), ("'cup'", "box.size[2]", "-0.1")),
    ("NaN", scene(box(center=[0, float("nan"), 0])), ("'cup'", "box.center[1]", "finite")),
    ("infinity", scene(box(size=[float("inf"), 1, 1])), ("'cup'", "box.size[0]", "finite")),
    ("NaN yaw", scene(box(yaw=float("nan"))), ("'cup'", "box.yaw", "finite")),
    ("too far", scene(box(center=[1.1e7, 0, 0])), ("'cup'", "box.center[0]", "limits")),
    ("whole number too large", scene(box(center=[10**400, 0, 0])), ("'cup'", "too large")),
    ("string for a number", scene(box(center=["1", 0, 0])), ("'cup'", "the string '1'", "a number")),
    ("true for a number", scene(box(center=[True, 0, 0])), ("'cup'", "is true", "a number")),
    ("two coordinates", scene(box(center=[0, 0])), ("'cup'", "box.center has 2")),
    ("four coordinates", scene(box(center=[0, 0, 0, 0])), ("'cup'", "box.center has 4")),
    ("quaternion", scene(box(quaternion=[0, 0, 0, 0])), ("'cup'", "'quaternion'")),
    ("unknown kind", scene(cup(kind="wall")), ("'cup'", "kind is 'wall'", "'surface'")),
    ("empty cloud", scene(cup(box=..., points=[])), ("'cup'", "points has 0")),
    ("ragged cloud", scene(cup(box=..., points=[[0, 0, 0], [1]])), ("'cup'", "points[1] has 1")),
    ("NaN in cloud", scene(cup(box=..., points=[[0, 0, float("nan")]])), ("'cup'", "points[0][2]", "finite")),
    ("no faces", scene(cup(box=..., mesh={**TRIANGLE, "faces": []})), ("'cup'", "mesh.faces has 0")),
    ("face out of range", scene(cup(box=..., mesh={**TRIANGLE, "faces": [[0, 1, 3]]})), ("'cup'", "0..2")),
    ("negative face", scene(cup(box=..., mesh={**TRIANGLE, "faces": [[0, 1, -1]]})), ("'cup'", "mesh.faces")),
    ("polygon of an object", scene(cup(box=..., polygon=SQUARE)), ("'cup'", '"kind": "surface"')),
    ("two corners", scene(cup(box=..., kind="surface", polygon=SQUARE[:2])), ("'cup'", "polygon has 2")),
    (
        "corners on one line",
        scene(cup(box=..., kind="surface", polygon=[[0, 0, 0], [1, 2, 3], [3, 6, 9], [2, 4, 6]])),
        ("'cup'", "one line"),
    ),
    ("duplicate object", scene(cup(), cup()), ("object 'cup'", "more than once")),
    ("duplicate view", scene(views=[view(), view()]), ("view 'v0'", "more than once")),
    ("world as a view", scene(views=[view(id="world")]), ("'world'", "rename")),
    ("view without position", scene(views=[view(position=...)]), ("view 'v0'", "position is missing")),
    ("view in NaN", scene(views=[view(position=[0, 0, float("nan")])]), ("view 'v0'", "finite")),
    ("stamp as text", scene(views=[view(stamp="noon")]), ("view 'v0'", "stamp")),
    ("label and labels", scene(cup(label="a", labels=[{"name": "a", "score": 1}])), ("'cup'", "keep one")),
    ("no labels", scene(cup(labels=[])), ("'cup'", "labels has 0")),
    ("six labels", scene(cup(labels=[{"name": "a", "score": 0.1}] * 6)), ("'cup'", "at most 5")),
    ("sure beyond 1", scene(cup(labels=[{"name": "a", "score": 1.1}])), ("'cup'", "labels[0].score")),
    ("empty label", scene(cup(label="")), ("'cup'", "label")),
    ("no id", scene(cup(id=...)), ("object number 1", "id is missing")),
    ("number as id", scene(cup(id=7)), ("object number 1", "id", "string")),
    ("empty id", scene(cup(id="")), ("id is ''",)),
    ("long id", scene(cup(id="x" * 257)), ("id", "256")),
    ("escaping path", scene(cup(box=..., mesh="../secret.ply")), ("'cup'", "folder")),
]


@pytest.mark.parametrize(("data", "said"), [case[1:] for case in REFUSED], ids=[case[0] for case in REFUSED])
def test_what_is_wrong_is_refused_and_named(data: Any, said: tuple[str, ...]) -> None:
    with pytest.raises(SceneError) as caught:
        Scene.from_dict(data)
    message = str(caught.value)
    assert all(part in message for part in said), message
    assert len(message) < 400
    assert "\n" not in message


@pytest.mark.parametrize(
    "character",
    ["\0", "\n", "\x1b", "\x7f", "\x85", "\u2028", "\u202e", "\u2066", "\u200f", "\u061c", "\ud800"],
    ids=lambda character: f"U+{ord(character):04X}",
)
def test_ids_that_could_deceive_a_reader_are_refused(character: str) -> None:
    for place in ({"id": f"a{character}b"}, {"label": f"a{character}b"}):
        with pytest.raises(SceneError) as caught:
            Scene.from_dict(scene(cup(**place)))
        assert character not in str(caught.value)
        assert str(caught.value).isprintable()


@pytest.mark.parametrize(
    "name", ["Egg|-00.21|+00.36", "'; drop", 'a"b', "naïve Übung", "杯子", "🥚", "a b", "x" * 256]
)
def test_ids_are_data(name: str) -> None:
    made = Scene.from_dict(scene(cup(id=name, label=name)))
    assert made.objects[0].id == name
    assert Scene.from_dict(json.loads(made.to_json())).objects[0].label == name


def test_many_problems_make_one_sentence() -> None:
    with pytest.raises(SceneError, match=r"'cup'.*\(and 2 more\)"):
        Scene.from_dict(scene(cup(a=1, b=2, c=3)))


TEXTS = {
    "empty": (b"", "not JSON"),
    "cut": (b'{"deixis": 1, "id": ', "line 1, column"),
    "duplicate key": (b'{"deixis": 1, "id": "a", "id": "b"}', "'id' is given twice"),
    "NaN": (b'{"deixis": 1, "id": NaN}', "NaN"),
    "Infinity": (b'{"deixis": 1, "id": -Infinity}', "-Infinity"),
    "1e400": (b'{"deixis": 1, "id": 1e400}', "1e400"),
    "endless digits": (b'{"deixis": ' + b"1" * 100_000 + b"}", "too large"),
    "deep": (b'{"deixis": 1, "id": ' + b"[" * 200_000, "nested"),
    "not UTF-8": (b'{"deixis": 1, "id": "\xff"}', "not UTF-8 at byte 21"),
    "UTF-16": ('{"deixis": 1}'.encode("utf-16"), "not UTF-8"),
    "after the end": (b'{"deixis": 1, "id": "a"} {}', "Extra data"),
}


@pytest.mark.parametrize("name", TEXTS)
def test_texts_that_are_not_json_are_refused(name: str, tmp_path: Path) -> None:
    text, said = TEXTS[name]
    path = tmp_path / "scene.json"
    path.write_bytes(text)
    with pytest.raises(SceneError) as caught:
        Scene.load(path)
    assert said in str(caught.value)
    assert "scene.json" in str(caught.value)
    assert len(str(caught.value)) < 400


def test_a_missing_or_oversized_file_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(SceneError, match="does not exist"):
        Scene.load(tmp_path / "none.json")
    with pytest.raises(SceneError, match="is not a file"):
        Scene.load(tmp_path)
    with pytest.raises(SceneError, match=r"cannot be read|does not exist"):
        Scene.load("a\0b")
    path = tmp_path / "scene.json"
    path.write_text(json.dumps(scene()), encoding="utf-8")
    monkeypatch.setattr(Scene.load.__globals__["read_bytes"], "__defaults__", (10, None))
    with pytest.raises(SceneError, match="limit is 10"):
        Scene.load(path)


def test_a_byte_order_mark_is_no_content(tmp_path: Path) -> None:
    path = tmp_path / "scene.json"
    path.write_bytes(b"\xef\xbb\xbf" + json.dumps(scene(cup())).encode())
    assert Scene.load(path).objects[0].id == "cup"


def test_empty_scenes_are_legal() -> None:
    empty = Scene.from_dict(scene())
    assert len(empty.boxes) == 0
    assert empty.boxes.center.shape == (0, 3)
    assert (empty.objects, empty.views, empty.diagnostics) == ((), (), ())


def everything() -> dict[str, Any]:
    return scene(
        {
            "id": "table",
            "label": "table",
            "box": {"center": [0.1, 0.2, 0.3], "size": [1.0, 2.0, 0.0], "yaw": 0.7},
        },
        {
            "id": "wall",
            "kind": "surface",
            "label": "wall",
            "polygon": [[0.0, 3.0, 0.0], [4.0, 3.0, 0.0], [4.0, 3.0, 2.0]],
        },
        {
            "id": "cloud",
            "labels": [{"name": "cup", "score": 0.8}, {"name": "mug", "score": 0.1}],
            "points": [[0.1, 0.2, 0.3]],
        },
        {
            "id": "mesh",
            "mesh": {"vertices": [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 1e-3]], "faces": [[0, 1, 2]]},
        },
        views=[
            {"id": "v0", "label": "robot", "position": [0.0, 0.5, 1.0], "heading": 1.5, "stamp": 1.7e9},
            {"id": "v1", "position": [0.0, 0.0, 0.0], "heading": 0.0},
        ],
        thresholds={"closeness": 1.5},
    )


def test_scenes_round_trip(tmp_path: Path) -> None:
    made = Scene.from_dict(everything())
    assert made.to_dict() == everything()
    assert json.loads(made.to_json()) == everything()
    made.save(tmp_path / "scene.json")
    again = Scene.load(tmp_path / "scene.json")
    assert again.to_json() == made.to_json()
    assert [path.name for path in tmp_path.iterdir()] == ["scene.json"]
    for old, new in zip(made.boxes.half, again.boxes.half, strict=True):
        assert old.tolist() == new.tolist()


number = st.floats(-1e7, 1e7)


@given(
    st.tuples(number, number, number),
    st.tuples(st.floats(0, 1e7), st.floats(0, 1e7), st.floats(0, 1e7)),
    st.floats(-10, 10),
)
def test_boxes_come_through_bit_for_bit(center: Any, size: Any, yaw: float) -> None:
    made = Scene.from_dict(scene(box(center=center, size=size, yaw=yaw)))
    again = Scene.from_dict(json.loads(made.to_json()))
    assert again.objects[0].region.center.tolist() == list(center)  # type: ignore[union-attr]
    assert again.boxes.half.tolist() == [[0.5 * extent for extent in size]]
    assert again.boxes.yaw.tolist() == [yaw]


def test_a_failed_save_leaves_the_old_file(tmp_path: Path) -> None:
    with pytest.raises(SceneError, match="cannot be written"):
        Scene("room").save(tmp_path / "none" / "scene.json")
    assert list(tmp_path.iterdir()) == []


def test_labels_are_ranked() -> None:
    labels = [{"name": "jug", "score": 0.2}, {"name": "cup", "score": 0.7}]
    thing = Scene.from_dict(scene(cup(labels=labels))).objects[0]
    assert thing.labels == (Label("cup", 0.7), Label("jug", 0.2))
    assert thing.label == "cup"
    assert Scene.from_dict(scene(cup())).objects[0].label == ""


def test_index_suggests_the_nearest_names() -> None:
    made = Scene.from_dict(scene(cup(id="extinguisher1"), cup(id="table")))
    assert made.index("table") == 1
    with pytest.raises(SceneError, match=r"no object 'extinguisher': did you mean 'extinguisher1'"):
        made.index("extinguisher")
    with pytest.raises(SceneError, match="'zzz'"):
        made.index("zzz")
    several = Scene.from_dict(scene(cup(id="cup1"), cup(id="cup2"), cup(id="cup3")))
    with pytest.raises(SceneError, match="did you mean 'cup3', 'cup2' or 'cup1'"):
        several.index("cup")


def test_what_is_in_a_scene_does_not_change() -> None:
    points = np.zeros((2, 3))
    region = PointRegion(points)
    points[0, 0] = 9.0
    assert region.points[0, 0] == 0.0
    made = Scene.from_dict(everything())
    regions = [thing.region for thing in made.objects]
    assert isinstance(regions[0], BoxRegion)
    assert isinstance(regions[1], SurfaceRegion)
    assert isinstance(regions[3], MeshRegion)
    for array in (regions[0].center, regions[1].polygon, regions[3].vertices, made.views[0].position):
        with pytest.raises(ValueError, match="read-only"):
            array[...] = 1.0


def test_scenes_made_by_hand_are_checked_too() -> None:
    for make in (
        lambda: BoxRegion(np.array([0, 0, np.nan]), np.ones(3)),
        lambda: BoxRegion(np.zeros(3), -np.ones(3)),
        lambda: BoxRegion(np.zeros(2), np.ones(3)),
        lambda: BoxRegion(np.zeros(3), np.ones(3), float("inf")),
        lambda: PointRegion(np.empty((0, 3))),
        lambda: PointRegion(np.zeros((2, 2))),
        lambda: PointRegion(np.array([["a", "b", "c"]])),
        lambda: MeshRegion(np.zeros((3, 3)), np.array([[0, 1, 2.0]])),
        lambda: SurfaceRegion(np.zeros((3, 3))),
        lambda: View("v", "", np.array([0, 0, np.inf])),
        lambda: Scene("s", views=(View("world", "", np.zeros(3)),)),
    ):
        with pytest.raises(SceneError):
            make()
    thing = SpatialObject("a", (), "object", BoxRegion(np.zeros(3), np.ones(3)))
    with pytest.raises(SceneError, match="'a'"):
        Scene("s", (thing, thing))


def test_thresholds_come_with_the_scene() -> None:
    assert Scene.from_dict(everything()).thresholds.closeness == 1.5
    with pytest.raises(SceneError, match="room") as caught:
        Scene.from_dict(scene(thresholds={"closeness": 0.001}))
    assert isinstance(caught.value.__cause__, ThresholdError)


@pytest.mark.parametrize(
    ("data", "said"),
    [
        (scene(box(size=[2e4, 1, 1])), "millimetres"),
        (scene(box(size=[5e-4, 1e-4, 1e-4])), "kilometres"),
        (scene(box(yaw=90.0)), "degrees"),
        (scene(cup(), views=[view(heading=-90.0)]), "degrees"),
        (
            scene(cup(box=..., kind="surface", polygon=[[0, 0, 0], [1, 0, 1], [1, 1, 1], [0, 1, 0]])),
            "slopes by 45",
        ),
        (
            scene(cup(box=..., kind="surface", polygon=[[0, 0, 0], [4, 0, 0.2], [4, 4, 0.2], [0, 4, 0]])),
            "read as level",
        ),
        (
            scene(cup(box=..., kind="surface", polygon=[[0, 0, 0], [4, 0, 0], [4, 0.2, 3], [0, 0.2, 3]])),
            "read as upright",
        ),
    ],
)
def test_what_is_odd_but_allowed_is_said(data: Any, said: str) -> None:
    (note,) = Scene.from_dict(data).diagnostics
    assert said in note
    assert "'cup'" in note or "'room'" in note or "'v0'" in note


# Surfaces


def surface(points: Any) -> tuple[list[float], list[float], float, int]:
    boxes = Scene("s", (SpatialObject("a", (), "surface", SurfaceRegion(points)),)).boxes
    return boxes.center[0].tolist(), boxes.half[0].tolist(), float(boxes.yaw[0]), int(boxes.normal[0])


def test_a_level_polygon_has_no_thickness() -> None:
    center, half, yaw, normal = surface([[0, 0, 0.1], [4, 0, 0.1], [4, 3, 0.1], [2, 3, 0.1], [0, 3, 0.1]])
    assert (normal, half[2], center[2]) == (2, 0.0, 0.1)
    assert (center[:2], sorted(half[:2]), yaw) == ([2.0, 1.5], [1.5, 2.0], 0.0)


@pytest.mark.parametrize("degrees", [0.0, 17.0, 45.0, 90.0, 133.0, 180.0, 270.0, 301.0])
def test_an_upright_polygon_lies_in_its_plane(degrees: float) -> None:
    turn = np.radians(degrees)
    along, outward = np.array([np.cos(turn), np.sin(turn), 0]), np.array([-np.sin(turn), np.cos(turn), 0])
    middle = 7.0 * outward + np.array([1.0, 2.0, 1.3])
    corners = [
        middle + x * along + np.array([0, 0, z])
        for x, z in ((-2, -1.3), (2, -1.3), (2, 1.3), (0, 1.3), (-2, 1.3))
    ]
    center, half, yaw, normal = surface(corners)
    assert normal in (0, 1)
    assert half[normal] == 0.0
    assert np.allclose(center, middle)
    assert np.allclose((half[1 - normal], half[2]), (2.0, 1.3))
    facing = yaw + normal * np.pi / 2
    assert abs(abs(np.cos(facing) * outward[0] + np.sin(facing) * outward[1]) - 1.0) < 1e-12


@given(st.floats(-0.15, 0.15), st.floats(-np.pi, np.pi))
def test_a_nearly_level_floor_is_level_at_its_middle(tilt: float, turn: float) -> None:
    flat = np.array([[-2, -1, 0], [2, -1, 0], [2, 1, 0], [-2, 1, 0.0]])
    lean = np.array([[np.cos(tilt), 0, np.sin(tilt)], [0, 1, 0], [-np.sin(tilt), 0, np.cos(tilt)]])
    spin = np.array([[np.cos(turn), -np.sin(turn), 0], [np.sin(turn), np.cos(turn), 0], [0, 0, 1]])
    center, half, _, normal = surface(flat @ lean.T @ spin.T + np.array([5.0, 6.0, 0.7]))
    assert normal == 2
    assert half[2] == 0.0
    assert np.allclose(center, [5.0, 6.0, 0.7])


@given(st.floats(-0.15, 0.15), st.floats(-np.pi, np.pi))
def test_a_leaning_wall_is_upright_about_its_middle(tilt: float, turn: float) -> None:
    flat = np.array([[-2, 0, -1], [2, 0, -1], [2, 0, 1], [-2, 0, 1.0]])
    lean = np.array([[1, 0, 0], [0, np.cos(tilt), -np.sin(tilt)], [0, np.sin(tilt), np.cos(tilt)]])
    spin = np.array([[np.cos(turn), -np.sin(turn), 0], [np.sin(turn), np.cos(turn), 0], [0, 0, 1]])
    center, half, _, normal = surface(flat @ lean.T @ spin.T + np.array([5.0, 6.0, 0.7]))
    assert normal in (0, 1)
    assert half[normal] == 0.0
    assert np.allclose(center, [5.0, 6.0, 0.7])
    assert np.allclose(half[1 - normal], 2.0)


def test_a_bumpy_surface_is_as_thick_as_its_scatter() -> None:
    _, half, _, normal = surface([[0, 0, 0], [4, 0, 0.01], [4, 4, 0], [0, 4, 0.01], [2, 2, 0.01]])
    assert normal == 2
    assert 0.004 < half[2] < 0.006


def test_a_slope_keeps_its_true_height() -> None:
    _, half, _, normal = surface([[0, 0, 0], [2, 0, 2], [2, 3, 2], [0, 3, 0]])
    assert (normal, half[2]) == (2, 1.0)


@pytest.mark.parametrize(
    ("size", "normal"), [([4, 3, 0.1], 2), ([0.1, 3, 2], 0), ([3, 0.1, 2], 1), ([1, 1, 1], 2)]
)
def test_a_surface_given_as_a_box_faces_its_thinnest_way(size: list[float], normal: int) -> None:
    assert Scene.from_dict(scene(cup(kind="surface", box={**BOX, "size": size}))).boxes.normal.tolist() == [
        normal
    ]


def test_things_have_no_normal_and_clouds_get_their_least_box() -> None:
    spin = np.array([[0.6, -0.8, 0], [0.8, 0.6, 0], [0, 0, 1]])
    corners = np.array([[x, y, z] for x in (-2, 2) for y in (-1, 1) for z in (0, 3.0)]) @ spin.T
    boxes = Scene.from_dict(scene(cup(box=..., points=corners), cup(id="b"))).boxes
    assert boxes.normal.tolist() == [-1, -1]
    assert np.allclose(sorted(boxes.half[0]), [1.0, 1.5, 2.0])


def test_a_vertex_that_no_face_uses_is_no_part_of_the_thing() -> None:
    mesh = {"vertices": [*TRIANGLE["vertices"], [9, 9, 9]], "faces": [[0, 1, 2]]}
    assert Scene.from_dict(scene(cup(box=..., mesh=mesh))).boxes.half.max() < 1.0


# Files beside the scene


def beside(folder: Path, name: str, data: bytes, key: str = "mesh") -> Scene:
    (folder / name).write_bytes(data)
    path = folder / "scene.json"
    path.write_text(json.dumps(scene(cup(box=..., **{key: name}))), encoding="utf-8")
    return Scene.load(path)


def exported(kind: str) -> bytes:
    made = trimesh.creation.box(extents=[2.0, 1.0, 0.5]).export(file_type=kind)
    return made.encode() if isinstance(made, str) else made


@pytest.mark.parametrize("kind", ["ply", "obj", "stl", "stl_ascii", "glb", "off"])
@pytest.mark.parametrize("key", ["mesh", "points"])
def test_point_and_mesh_files_are_read(kind: str, key: str, tmp_path: Path) -> None:
    made = beside(tmp_path, f"thing.{kind.removesuffix('_ascii')}", exported(kind), key)
    assert np.allclose(sorted(made.boxes.half[0]), [0.25, 0.5, 1.0])
    assert isinstance(made.objects[0].region, MeshRegion if key == "mesh" else PointRegion)
    assert Scene.from_dict(made.to_dict()).boxes.half.tolist() == made.boxes.half.tolist()


def test_a_glb_part_stands_where_its_node_says(tmp_path: Path) -> None:
    world = trimesh.Scene()
    ball = trimesh.creation.box(extents=[1, 1, 1])
    for x in (0.0, 4.0):
        world.add_geometry(ball, transform=trimesh.transformations.translation_matrix([x, 0, 0]))
    made = beside(tmp_path, "two.glb", world.export(file_type="glb"))
    assert np.allclose(made.boxes.half[0].max(), 2.5)


PLY = (
    b"ply\nformat ascii 1.0\nelement vertex %d\n"
    b"property float x\nproperty float y\nproperty float z\nend_header\n"
)


def glb(head: dict[str, Any], binary: bytes = b"") -> bytes:
    text = json.dumps({"asset": {"version": "2.0"}, **head}).encode()
    text += b" " * (-len(text) % 4)
    chunk = struct.pack("<I4s", len(binary), b"BIN\0") + binary if binary else b""
    return struct.pack("<4sIII4s", b"glTF", 2, 20 + len(text) + len(chunk), len(text), b"JSON") + text + chunk


POSITION = {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}
TREE = {
    "buffers": [{"byteLength": 36}],
    "bufferViews": [{"buffer": 0, "byteLength": 36}],
    "accessors": [POSITION],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
}

LYING: dict[str, tuple[str, bytes]] = {
    "empty ply": ("a.ply", b""),
    "ply of a billion points": ("a.ply", PLY % 1_000_000_000 + b"0 0 0\n"),
    "ply of one point too many": ("a.ply", PLY % 3 + b"0 0 0\n1 1 1\n"),
    "ply of minus one point": ("a.ply", PLY % -1),
    "ply of no point": ("a.ply", PLY % 0),
    "ply with nan": ("a.ply", PLY % 1 + b"nan 0 0\n"),
    "ply without end": ("a.ply", b"ply\nformat ascii 1.0\n"),
    "binary ply cut": ("a.ply", exported("ply")[:-20]),
    "ply of unknown type": (
        "a.ply",
        b"ply\nformat ascii 1.0\nelement vertex 1\nproperty complex x\nend_header\n0\n",
    ),
    "ply property first": ("a.ply", b"ply\nformat ascii 1.0\nproperty float x\nend_header\n0\n"),
    "stl of four billion": ("a.stl", b"\0" * 80 + struct.pack("<I", 4_000_000_000) + b"\0" * 50),
    "stl cut": ("a.stl", exported("stl")[:-1]),
    "stl of nothing": ("a.stl", b"\0" * 84),
    "ascii stl cut": ("a.stl", exported("stl_ascii")[:-60]),
    "empty ascii stl": ("a.stl", b"solid a\nendsolid a\n"),
    "empty obj": ("a.obj", b""),
    "obj face out of range": ("a.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n"),
    "obj with nan": ("a.obj", b"v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"),
    "obj that is binary": ("a.obj", b"\0\1\2"),
    "empty off": ("a.off", b"OFF\n0 0 0\n"),
    "off of a billion": ("a.off", b"OFF\n1000000000 1 0\n0 0 0\n"),
    "off that is not": ("a.off", b"hello"),
    "glb that is not": ("a.glb", b"hello"),
    "glb cut": ("a.glb", exported("glb")[:-4]),
    "glb of nothing": ("a.glb", glb({})),
    "glb with a far accessor": (
        "a.glb",
        glb({**TREE, "accessors": [{**POSITION, "count": 2_000_000_000}]}, b"\0" * 36),
    ),
    "glb accessor of nothing": (
        "a.glb",
        glb({"accessors": [{"componentType": 5126, "count": 2**31, "type": "VEC3"}]}),
    ),
    "glb view outside": (
        "a.glb",
        glb({**TREE, "bufferViews": [{"buffer": 0, "byteLength": 9999}]}, b"\0" * 36),
    ),
    "glb of other files": ("a.glb", glb({"buffers": [{"byteLength": 1, "uri": "../secret"}]})),
    "glb that doubles": (
        "a.glb",
        glb({**TREE, "nodes": [*({"children": [n + 1, n + 1]} for n in range(40)), {"mesh": 0}]}, b"\0" * 36),
    ),
    "glb with a JSON cut": ("a.glb", glb({"extras": [[1]]}).replace(b"]]", b"] ")),
    "ply in an obj": ("a.obj", exported("ply")),
}


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("key", ["mesh", "points"])
@pytest.mark.parametrize("name", LYING)
def test_files_that_lie_are_refused(name: str, key: str, tmp_path: Path) -> None:
    file, data = LYING[name]
    with pytest.raises(SceneError, match="object 'cup': the file") as caught:
        beside(tmp_path, file, data, key)
    assert str(tmp_path) not in str(caught.value)


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("kind", ["ply", "obj", "stl", "stl_ascii", "glb", "off"])
@given(data=st.data())
def test_damaged_files_are_read_or_refused(kind: str, data: st.DataObject, tmp_path_factory: Any) -> None:
    whole = bytearray(exported(kind))
    for _ in range(data.draw(st.integers(1, 4))):
        start = data.draw(st.integers(0, len(whole)))
        end = start + data.draw(st.integers(0, 12))
        whole[start:end] = data.draw(st.binary(max_size=12))
    path = tmp_path_factory.getbasetemp() / f"damaged.{kind.removesuffix('_ascii')}"
    path.write_bytes(whole)
    try:
        vertices, faces = mesh_file.read_geometry(path)
    except SceneError:
        return
    assert len(vertices) > 0
    assert np.isfinite(vertices).all()
    assert faces.shape[1] == 3


def test_a_file_that_unfolds_beyond_the_limit_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(mesh_file, "MAX_VERTICES", 5)
    for kind in ("ply", "stl", "off", "glb"):
        with pytest.raises(SceneError, match="thin it out"):
            beside(tmp_path, f"a.{kind}", exported(kind))


def test_a_cloud_is_no_mesh(tmp_path: Path) -> None:
    data = PLY % 2 + b"0 0 0\n1 1 1\n"
    assert beside(tmp_path, "a.ply", data, "points").boxes.half[0].max() > 0
    with pytest.raises(SceneError, match=r"'cup'.*no triangles"):
        beside(tmp_path, "a.ply", data)


@pytest.mark.parametrize(
    "name",
    [
        "/etc/passwd.ply",
        "../a.ply",
        "b/../../a.ply",
        "http://host/a.ply",
        "file:///a.ply",
        "C:\\a.ply",
        "C:a.ply",
        "b\\a.ply",
        "a\0.ply",
    ],
)
def test_files_outside_the_folder_are_refused(name: str, tmp_path: Path) -> None:
    with pytest.raises(SceneError, match=r"'cup'.*inside the scene's folder"):
        Scene.from_dict(scene(cup(box=..., points=name)), base=tmp_path)


@pytest.mark.parametrize("name", ["a.npy", "a.pkl", "a.zip", "a.3dxml", "a", "a.ply.gz", "a.gltf"])
def test_only_some_kinds_of_file_are_read(name: str, tmp_path: Path) -> None:
    with pytest.raises(SceneError, match=r"'cup'.*use \.ply"):
        Scene.from_dict(scene(cup(box=..., points=name)), base=tmp_path)


def test_a_link_out_of_the_folder_is_refused(tmp_path: Path) -> None:
    inner = tmp_path / "inner"
    inner.mkdir()
    (tmp_path / "a.ply").write_bytes(exported("ply"))
    (inner / "a.ply").symlink_to(tmp_path / "a.ply")
    with pytest.raises(SceneError, match=r"'cup'.*links out"):
        Scene.from_dict(scene(cup(box=..., points="a.ply")), base=inner)
    (inner / "loop.ply").symlink_to(inner / "loop.ply")
    with pytest.raises(SceneError, match="'cup'"):
        Scene.from_dict(scene(cup(box=..., points="loop.ply")), base=inner)
    with pytest.raises(SceneError, match=r"'cup'.*does not exist"):
        Scene.from_dict(scene(cup(box=..., points="none.ply")), base=inner)


def test_without_a_folder_no_file_is_read() -> None:
    with pytest.raises(SceneError, match=r"'cup'.*give base"):
        Scene.from_dict(scene(cup(box=..., mesh="a.ply")))


# The schema and the samples


def test_the_exported_schema_is_current() -> None:
    text = json.dumps(scene_schema(), indent=1) + "\n"
    assert (KB / "scene.schema.json").read_text(encoding="utf-8") == text, "export scene_schema() to kb again"


def described(part: Any, path: str = "") -> list[str]:
    missing = []
    if isinstance(part, dict):
        for name, field in part.get("properties", {}).items():
            if "description" not in field and set(field) - {"const"}:
                missing.append(f"{path}/{name}")
        for name, child in part.items():
            missing += described(child, f"{path}/{name}")
    elif isinstance(part, list):
        for child in part:
            missing += described(child, path)
    return missing


def test_the_schema_is_one_and_says_what_every_field_means() -> None:
    schema = scene_schema()
    jsonschema.Draft202012Validator.check_schema(schema)
    assert (schema["title"], schema["$id"]) == ("Deixis scene", "urn:deixis:schema:scene:1")
    assert described(schema) == []
    jsonschema.validate(everything(), schema)


# What a schema cannot say: numbers that are no JSON, uniqueness of ids, geometry, how thresholds compare.
BEYOND_SCHEMA = {
    "bad threshold",
    "thresholds out of order",
    "NaN",
    "NaN yaw",
    "NaN in cloud",
    "view in NaN",
    "face out of range",
    "corners on one line",
    "duplicate object",
    "duplicate view",
    "world as a view",
    "escaping path",
}


@pytest.mark.parametrize(("name", "data", "_said"), REFUSED, ids=[case[0] for case in REFUSED])
def test_the_schema_refuses_the_same(name: str, data: Any, _said: Any) -> None:
    valid = jsonschema.Draft202012Validator(scene_schema()).is_valid(data)
    assert valid == (name in BEYOND_SCHEMA)


@pytest.mark.parametrize("name", ["hans", "kitchen"])
def test_the_sample_scenes_are_sound(name: str) -> None:
    path = KB / "scenes" / f"{name}.json"
    made = Scene.load(path)
    jsonschema.validate(json.loads(path.read_text(encoding="utf-8")), scene_schema())
    assert made.diagnostics == ()
    assert made.to_json() == path.read_text(encoding="utf-8")


def test_the_robots_scene_has_the_papers_cast() -> None:
    made = Scene.load(KB / "scenes" / "hans.json")
    ids = ["floor", "wall", "radiator", "extinguisher1", "extinguisher2", "sign", "heater", "sweater"]
    assert [thing.id for thing in made.objects] == ids
    assert [(view.id, view.label) for view in made.views] == [("v0", "robot"), ("v1", "you")]
    assert made.boxes.normal[:2].tolist() == [2, 1]
    assert made.boxes.surface.sum() == 2
