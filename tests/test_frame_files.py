"""Frame files: what is read, what is refused, how long a refusal takes, and `deixis perceive`."""

from __future__ import annotations

import io
import json
import os
import struct
import time
import zipfile
import zlib
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import pytest
import trimesh

from commands import call, run
from deixis import Scene
from deixis.errors import SceneError
from deixis.perception import Camera, CloudFrame, Frame, load_frame, perceive
from deixis.perception.clouds import open_cloud
from deixis.perception.frame_format import frame_schema
from deixis.perception.thinning import thinned
from deixis.scene import Label
from frames_written import save_points, write_cloud, write_frame
from render import Body, looking, noisy, placed, render

KB = Path(__file__).resolve().parent.parent / "kb"

SECONDS = 2.0
"""A refusal takes milliseconds; the machine may be busy."""


@pytest.fixture(scope="module")
def seen() -> Frame:
    """Return a small frame: a cup on a table, and a floor."""
    camera = Camera(160, 120, 130.0, 130.0, 79.5, 59.5, looking((0.0, -1.6, 1.4), (0.0, 0.0, 0.6)))
    meshes = [
        placed(trimesh.creation.box([1.2, 0.7, 0.7]), (0.0, 0.0, 0.0)),
        placed(trimesh.creation.cylinder(0.06, 0.15), (0.1, 0.0, 0.7)),
        (np.array([[-3, -3, 0], [3, -3, 0], [3, 3, 0], [-3, 3, 0.0]]), np.array([[0, 1, 2], [0, 2, 3]])),
    ]
    picture = render(camera, [Body(1 + i, *mesh) for i, mesh in enumerate(meshes)])
    labels = {1: (Label("table", 0.8), Label("desk", 0.1)), 2: (Label("cup", 0.9),)}
    depth = noisy(picture, 0.005, np.random.default_rng(0))
    numbers = np.where(picture.instances == 3, 0, picture.instances)
    return Frame(
        1_583_236_000.25, camera, depth, numbers, labels, np.array([0.0, -1.6, 0.0]), 1.5, "hans", 0.005
    )


def changed(path: Path, **values: Any) -> Path:
    """Change a frame file; None drops a key."""
    data = {**json.loads(path.read_text(encoding="utf-8")), **values}
    path.write_text(json.dumps({key: value for key, value in data.items() if value is not None}), "utf-8")
    return path


def refused(path: Path, words: str) -> None:
    start = time.monotonic()
    with pytest.raises(SceneError, match=words):
        perceive([load_frame(path)])
    assert time.monotonic() - start < SECONDS


# What is read


@pytest.mark.parametrize("images", [".png", ".npy"])
def test_a_frame_comes_back_from_its_file(seen: Frame, tmp_path: Path, images: str) -> None:
    found = load_frame(write_frame(seen, tmp_path / "one.json", images=images))
    assert isinstance(found, Frame)
    assert np.abs(found.depth - seen.depth).max() <= 0.0005001
    assert (found.instances == seen.instances).all()
    assert (found.labels, found.stamp, found.robot, found.heading, found.noise) == (
        seen.labels,
        seen.stamp,
        "hans",
        1.5,
        0.005,
    )
    assert found.camera.camera2world == pytest.approx(seen.camera.camera2world)


def test_a_pose_is_a_matrix_or_a_quaternion(seen: Frame, tmp_path: Path) -> None:
    from scipy.spatial.transform import Rotation

    path = write_frame(seen, tmp_path / "one.json")
    quaternion = Rotation.from_matrix(seen.camera.camera2world[:3, :3]).as_quat()
    pose = {"position": seen.camera.position.tolist(), "quaternion": (2.0 * quaternion).tolist()}
    found = load_frame(changed(path, pose=pose))
    assert isinstance(found, Frame)
    assert found.camera.camera2world == pytest.approx(seen.camera.camera2world)


@pytest.mark.parametrize("kind", [".ply", ".pcd", ".npz"])
def test_a_cloud_is_a_frame_too(seen: Frame, tmp_path: Path, kind: str) -> None:
    frame = load_frame(write_cloud(seen, tmp_path / "one.json", kind))
    assert isinstance(frame, CloudFrame)
    scene = perceive([frame])
    assert [thing.label for thing in scene.objects] == ["table", "cup", "floor"]
    assert scene.boxes.center[1] == pytest.approx([0.1, 0.0, 0.775], abs=0.06)


@pytest.mark.parametrize("form", ["ascii", "binary_big_endian"])
def test_other_plys_are_read(tmp_path: Path, form: str) -> None:
    path = tmp_path / "a.ply"
    head = (
        f"ply\nformat {form} 1.0\nelement vertex 3\nproperty double x\nproperty double y\nproperty double z\n"
    )
    rows = [(0.0, 0.0, 1.0, 5), (float("nan"), 0.0, 1.0, 5), (0.5, 0.25, 1.0, 0)]
    if form == "ascii":
        body = "".join(" ".join(map(str, row)) + "\n" for row in rows).encode()
    else:
        body = b"".join(struct.pack(">dddi", *row) for row in rows)
    path.write_bytes((head + "property int objectId\nend_header\n").encode() + body)
    (part,) = open_cloud(path).parts()
    assert part[0].tolist() == [[0.0, 0.0, 1.0], [0.5, 0.25, 1.0]]
    assert part[1].tolist() == [5, 0]


@pytest.mark.parametrize("encoding", ["ascii", "binary_compressed"])
def test_other_pcds_are_read(tmp_path: Path, encoding: str) -> None:
    from pypcd4.pypcd4 import Encoding, PointCloud

    path = tmp_path / "a.pcd"
    points = np.array([[0.0, 0.0, 1.0, 5.0], [0.5, 0.25, 1.0, 0.0]], dtype=np.float32)
    PointCloud.from_xyzl_points(points, np.float32).save(path, Encoding(encoding))
    (part,) = open_cloud(path).parts()
    assert part[0].tolist() == points[:, :3].tolist()
    assert part[1].tolist() == [5, 0]


def test_a_thinned_cloud_is_its_surface_without_lone_points(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    sheet = np.stack([*rng.uniform(0.0, 1.0, (2, 200_000)), np.zeros(200_000)], axis=1)
    points = np.concatenate([sheet, [[0.5, 0.5, 3.0]]])
    told: list[int] = []
    things, rest = thinned(open_cloud(save_points(tmp_path / "a.npz", points, np.ones(200_001))), told.append)
    assert sum(told) == 200_001
    assert 9_900 < len(things[1]) < 10_300
    assert things[1][:, 2].max() < 0.01
    assert len(rest) == 0


# The schema


def test_the_exported_schema_is_current() -> None:
    text = json.dumps(frame_schema(), indent=1) + "\n"
    assert (KB / "frame.schema.json").read_text(encoding="utf-8") == text, "export frame_schema() to kb again"
    jsonschema.Draft202012Validator.check_schema(frame_schema())


@pytest.mark.parametrize("path", sorted((KB / "frames").glob("*.json")), ids=lambda path: path.stem)
def test_the_samples_are_of_the_schema(path: Path) -> None:
    jsonschema.validate(json.loads(path.read_text(encoding="utf-8")), frame_schema())
    assert isinstance(load_frame(path), Frame)


# What is refused


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"deixis_frame": 2}, "'deixis_frame' is 2: give 1"),
        ({"deixis_frame": None}, "is it one"),
        ({"stamp": None}, "stamp is missing: add it"),
        ({"stamp": "now"}, "stamp is 'now'"),
        ({"depht": 1}, "unknown key 'depht'"),
        ({"depth": None}, "neither or both of depth and cloud"),
        ({"cloud": "a.ply"}, "neither or both of depth and cloud"),
        ({"intrinsics": None}, "has a depth image but no intrinsics"),
        ({"pose": {"position": [0, 0, 0]}}, "pose takes position and quaternion, or matrix"),
        ({"pose": {"position": [0, 0, 0], "quaternion": [0, 0, 0, 0]}}, "quaternion is zero"),
        ({"pose": {"matrix": [[1, 0, 0, 0]] * 4}}, "pose"),
        ({"noise": -1.0}, "noise is -1.0"),
        ({"depth_scale": 0.0}, "depth_scale is 0.0"),
        (
            {"things": [{"instance": 1, "labels": [{"name": "a", "score": 1.0}]}] * 2},
            "instance 1 more than once",
        ),
        ({"things": [{"instance": 0, "labels": [{"name": "a", "score": 1.0}]}]}, "things"),
        ({"depth": "../x.png"}, "not a path inside the frame's folder"),
        ({"depth": "/etc/passwd.png"}, "not a path inside the frame's folder"),
        ({"depth": "file:///x.png"}, "not a path inside the frame's folder"),
        ({"depth": "x.exr"}, "of no kind that is read: use .png, .npy"),
        ({"depth": "none.png"}, "does not exist"),
        ({"instances": "none.npy"}, "is not a file"),
    ],
)
def test_what_a_frame_may_not_say(seen: Frame, tmp_path: Path, values: dict[str, Any], words: str) -> None:
    path = changed(write_frame(seen, tmp_path / "one.json"), **values)
    refused(path, words)


def test_images_must_be_the_cameras(seen: Frame, tmp_path: Path) -> None:
    path = write_frame(seen, tmp_path / "one.json")
    lens = json.loads(path.read_text(encoding="utf-8"))["intrinsics"]
    refused(changed(path, intrinsics={**lens, "width": 161}), "is 160 x 120, the camera 161 x 120 pixels")
    refused(changed(path, intrinsics={**lens, "width": 60_000, "height": 60_000}), "too large")


def test_links_out_of_the_folder_are_not_followed(seen: Frame, tmp_path: Path) -> None:
    (tmp_path / "in").mkdir()
    path = write_frame(seen, tmp_path / "in" / "one.json")
    (tmp_path / "in" / "one.depth.png").rename(tmp_path / "out.png")
    (tmp_path / "in" / "one.depth.png").symlink_to(tmp_path / "out.png")
    refused(path, "links out of the frame's folder")


def test_what_is_no_file_is_not_waited_for(seen: Frame, tmp_path: Path) -> None:
    path = write_frame(seen, tmp_path / "one.json")
    for kind in (".png", ".npy", ".ply", ".pcd", ".npz"):
        os.mkfifo(tmp_path / f"pipe{kind}")
    refused(changed(path, depth="pipe.png"), "is not a file")
    refused(changed(path, depth="pipe.npy"), "is not a file")
    for kind in (".ply", ".pcd", ".npz"):
        with pytest.raises(SceneError, match="is not a file"):
            open_cloud(tmp_path / f"pipe{kind}")


def bomb(width: int, height: int) -> bytes:
    """Return a PNG that unfolds to many pixels."""

    def chunk(kind: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    head = chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 16, 0, 0, 0, 0))
    return b"\x89PNG\r\n\x1a\n" + head + chunk(b"IDAT", zlib.compress(bytes(1 << 24))) + chunk(b"IEND", b"")


@pytest.mark.parametrize(
    ("name", "data", "words"),
    [
        ("a.png", b"", "no sound PNG"),
        ("a.png", b"GIF89a" + bytes(100), "no sound PNG"),
        ("a.png", bomb(60_000, 60_000), "unfolds to too many pixels|is 60000 x 60000"),
        ("a.png", bomb(160, 120)[:60], "no sound PNG"),
        ("a.npy", b"\x93NUMPY\x01\x00" + struct.pack("<H", 20) + b"{'descr': '<f8', 'fo", "no sound NPY"),
        ("a.npy", b"PK\x03\x04" + bytes(50), "no sound NPY|no NPY"),
    ],
)
def test_damaged_images(seen: Frame, tmp_path: Path, name: str, data: bytes, words: str) -> None:
    path = write_frame(seen, tmp_path / "one.json")
    (tmp_path / name).write_bytes(data)
    refused(changed(path, depth=name), words)


def test_arrays_that_are_programs_or_lie(seen: Frame, tmp_path: Path) -> None:
    path = write_frame(seen, tmp_path / "one.json")
    np.save(tmp_path / "a.npy", np.array([print, print], dtype=object), allow_pickle=True)
    refused(changed(path, depth="a.npy"), "no sound NPY")
    np.save(tmp_path / "b.npy", np.zeros((120, 160), dtype=np.int16))
    refused(changed(path, depth="b.npy"), "give depths as float metres")
    head = io.BytesIO()
    np.lib.format.write_array_header_1_0(
        head, {"descr": "<f8", "fortran_order": False, "shape": (1_000_000, 1_000_000)}
    )
    (tmp_path / "c.npy").write_bytes(head.getvalue() + bytes(64))
    refused(changed(path, depth="c.npy"), "no sound NPY")


PLY = "ply\nformat {form} 1.0\nelement vertex {count}\n{fields}end_header\n"
XYZI = "".join(f"property float {name}\n" for name in "xyz") + "property int instance\n"
PCD = (
    "VERSION 0.7\nFIELDS x y z instance\nSIZE 4 4 4 4\nTYPE F F F U\nCOUNT 1 1 1 1\nWIDTH {count}\nHEIGHT 1\n"
    "VIEWPOINT 0 0 0 1 0 0 0\nPOINTS {count}\nDATA {form}\n"
)


@pytest.mark.parametrize(
    ("name", "data"),
    [
        ("a.ply", PLY.format(form="binary_little_endian", count=10**9, fields=XYZI).encode() + bytes(64)),
        ("a.ply", PLY.format(form="ascii", count=10**8, fields=XYZI).encode() + b"0 0 0 1\n"),
        ("a.ply", PLY.format(form="binary_little_endian", count=-1, fields=XYZI).encode() + bytes(64)),
        ("a.ply", PLY.format(form="utf8", count=1, fields=XYZI).encode() + bytes(64)),
        ("a.ply", PLY.format(form="ascii", count=1, fields="property list uchar int x\n").encode() + b"0\n"),
        ("a.ply", PLY.format(form="ascii", count=1, fields="property float x\n").encode() + b"0\n"),
        ("a.ply", b"ply\n" + bytes(100)),
        ("a.pcd", PCD.format(form="binary", count=10**9).encode() + bytes(64)),
        ("a.pcd", PCD.format(form="ascii", count=10**9).encode() + b"0 0 0 1\n"),
        (
            "a.pcd",
            PCD.format(form="binary_compressed", count=10**8).encode()
            + struct.pack("<II", 8, 16 * 10**8)
            + bytes(8),
        ),
        (
            "a.pcd",
            PCD.format(form="binary_compressed", count=4).encode() + struct.pack("<II", 8, 64) + bytes(8),
        ),
        ("a.pcd", PCD.format(form="magic", count=4).encode() + bytes(64)),
        ("a.pcd", bytes(200)),
        ("a.npz", b"PK\x03\x04" + bytes(64)),
    ],
)
def test_damaged_clouds(tmp_path: Path, name: str, data: bytes) -> None:
    path = tmp_path / name
    path.write_bytes(data)
    start = time.monotonic()
    with pytest.raises(SceneError, match=name):
        thinned(open_cloud(path))
    assert time.monotonic() - start < SECONDS


def test_archives_that_are_programs_or_bombs(tmp_path: Path) -> None:
    path = tmp_path / "a.npz"
    np.savez(path, points=np.array([[print] * 3], dtype=object), instances=np.ones(1, dtype=int))
    with pytest.raises(SceneError, match="Python objects"):
        open_cloud(path)
    head = io.BytesIO()
    np.lib.format.write_array_header_1_0(
        head, {"descr": "<f4", "fortran_order": False, "shape": (10_000_000_000, 3)}
    )
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("points.npy", head.getvalue() + bytes(1 << 24))
        archive.writestr("instances.npy", head.getvalue())
    with pytest.raises(SceneError, match="not as long as they say"):
        open_cloud(path)
    np.savez(path, cloud=np.zeros((3, 3)))
    with pytest.raises(SceneError, match="no array 'points'"):
        open_cloud(path)


@pytest.mark.parametrize("kind", [".ply", ".pcd", ".npz", ".png", ".npy"])
def test_files_cut_anywhere(seen: Frame, tmp_path: Path, kind: str) -> None:
    """At every length of a small file: an error of ours, or all that it said."""
    if kind in (".png", ".npy"):
        path = write_frame(seen, tmp_path / "one.json", images=kind)
        victim = tmp_path / f"one.depth{kind}"
    else:
        points = np.random.default_rng(0).uniform(0.0, 1.0, (40, 3))
        victim = save_points(tmp_path / f"one{kind}", points, np.ones(40))
    whole = victim.read_bytes()
    for length in range(0, len(whole), max(1, len(whole) // 150)):
        victim.write_bytes(whole[:length])
        with pytest.raises(SceneError):
            load_frame(path) if kind in (".png", ".npy") else thinned(open_cloud(victim))


def test_bits_turned_over(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    for kind in (".ply", ".pcd", ".npz"):
        points = rng.uniform(0.0, 1.0, (40, 3))
        victim = save_points(tmp_path / f"one{kind}", points, np.ones(40))
        whole = victim.read_bytes()
        for _ in range(200):
            data = bytearray(whole)
            data[rng.integers(len(data))] ^= 1 << int(rng.integers(8))
            victim.write_bytes(data)
            try:
                thinned(open_cloud(victim))
            except SceneError:
                continue


def test_too_much_is_refused(tmp_path: Path) -> None:
    path = save_points(tmp_path / "a.npz", np.zeros((5000, 3)), np.arange(5000))
    with pytest.raises(SceneError, match="more than 4,095 instances"):
        thinned(open_cloud(path))
    path = save_points(tmp_path / "a.npz", np.full((2, 3), 1.0e6), np.ones(2))
    with pytest.raises(SceneError, match="away: use a local frame"):
        thinned(open_cloud(path))
    path = save_points(tmp_path / "a.npz", np.zeros((2, 3)), np.array([-1, 1]))
    with pytest.raises(SceneError, match="negative"):
        thinned(open_cloud(path))


# In which views a thing was seen


def test_what_was_seen_where_survives_files(tmp_path: Path) -> None:
    data = {
        "deixis": 1,
        "id": "room",
        "objects": [
            {"id": "cup", "box": {"center": [0, 0, 1], "size": [0.1, 0.1, 0.1]}, "seen_in": ["b", "a", "b"]},
            {"id": "jar", "box": {"center": [1, 0, 1], "size": [0.1, 0.1, 0.1]}},
        ],
        "views": [{"id": "a", "position": [0, 3, 0]}, {"id": "b", "position": [0, -3, 0]}],
    }
    scene = Scene.from_dict(data)
    assert [thing.seen_in for thing in scene.objects] == [("b", "a"), ()]
    scene.save(tmp_path / "room.json")
    assert [one.seen_in for one in Scene.load(tmp_path / "room.json").objects] == [("b", "a"), ()]
    for kind in ("trig", "ttl", "jsonld"):
        assert call("export", str(tmp_path / "room.json"), "-o", str(tmp_path / f"room.{kind}")).code == 0
        assert (
            call("import", "rdf", str(tmp_path / f"room.{kind}"), "-o", str(tmp_path / "back.json")).code == 0
        )
        assert [one.seen_in for one in Scene.load(tmp_path / "back.json").objects] == [("a", "b"), ()]


def test_a_thing_is_seen_in_views_there_are() -> None:
    box = {"center": [0, 0, 1], "size": [0.1, 0.1, 0.1]}
    data = {"deixis": 1, "id": "room", "objects": [{"id": "cup", "box": box, "seen_in": ["a"]}]}
    with pytest.raises(
        SceneError, match="object 'cup': seen in 'a', which is no view of the scene: add it or leave it out"
    ):
        Scene.from_dict(data)


# The command


def test_perceive_writes_a_scene(seen: Frame, tmp_path: Path) -> None:
    path = write_frame(seen, tmp_path / "one.json")
    result = run("perceive", str(path), "-o", "room.json", cwd=tmp_path)
    assert (result.code, result.out) == (0, "")
    assert result.err.splitlines()[-1] == "room.json: 2 objects, 1 surface, 1 view"
    scene = Scene.load(tmp_path / "room.json")
    assert (scene.id, scene.views[0].label) == ("room", "hans")
    assert [(thing.id, thing.label, thing.seen_in) for thing in scene.objects] == [
        ("t1583236000250_1", "table", ("t1583236000250",)),
        ("t1583236000250_2", "cup", ("t1583236000250",)),
        ("t1583236000250_s1", "floor", ("t1583236000250",)),
    ]
    told = call("relations", str(tmp_path / "room.json"), "--relation", "on_top_of")
    assert "t1583236000250_2" in told.out


def test_perceive_exits_as_it_says(seen: Frame, tmp_path: Path) -> None:
    path = write_frame(seen, tmp_path / "one.json")
    target = tmp_path / "room.json"
    assert call("perceive", str(path), str(tmp_path / "two.json"), "-o", str(target)).code == 2
    assert not target.exists()
    empty = write_frame(
        Frame(0.0, seen.camera, 0.0 * seen.depth, 0 * seen.instances, noise=0.0), tmp_path / "empty.json"
    )
    assert call("perceive", str(empty), "-o", str(target)).code == 1
    twice = call("perceive", str(path), str(path), "-o", str(target))
    assert (twice.code, "two frames have the stamp" in twice.err) == (2, True)


def test_the_schema_of_frames_is_printed() -> None:
    assert json.loads(call("schema", "frame").out) == frame_schema()
