"""Perception: what is recovered of known scenes, from pictures of them with noise and flying pixels."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import trimesh
from hypothesis import given
from hypothesis import strategies as st

from deixis.errors import SceneError
from deixis.frames import Array
from deixis.perception import Camera, Frame, Map, perceive
from deixis.perception.association import associate, boxes_of, fused, likeness
from deixis.perception.planes import find_planes
from deixis.perception.smoothing import noise_of, smooth
from deixis.perception.surfaces import find_surfaces
from deixis.scene import BoxRegion, Label, MeshRegion, SurfaceRegion
from memory import MOST
from recovery import Score, relations, room_score, score
from render import Body, looking, noisy, placed, render
from rooms import furnished, observe

STAMP = 1_583_236_000.0


def camera(eye: tuple[float, ...] = (0.0, -2.0, 1.4), target: tuple[float, ...] = (0.0, 0.0, 0.7)) -> Camera:
    return Camera(640, 480, 525.0, 525.0, 319.5, 239.5, looking(eye, target))


def picture(
    meshes: list[tuple[Array, np.ndarray]],
    eye: tuple[float, ...] = (0.0, -2.0, 1.4),
    noise: float = 0.01,
    flying: float = 0.3,
    stamp: float = STAMP,
    labels: tuple[str, ...] = (),
    target: tuple[float, ...] = (0.0, 0.0, 0.7),
) -> Frame:
    """Return a frame of some meshes; instance 1 is the first."""
    view = camera(eye, target)
    seen = render(view, [Body(i + 1, *mesh) for i, mesh in enumerate(meshes)])
    depth = noisy(seen, noise, np.random.default_rng(0), flying)
    ranked = {i + 1: (Label(name, 0.9),) for i, name in enumerate(labels)}
    return Frame(stamp, view, depth, seen.instances, ranked, np.array([*eye[:2], 0.0]), noise=noise)


TABLE = placed(trimesh.creation.box([1.2, 0.7, 0.7]), (0.0, 0.0, 0.0))


def cup(x: float = 0.0, y: float = 0.0) -> tuple[Array, np.ndarray]:
    return placed(trimesh.creation.cylinder(0.05, 0.1, sections=48), (x, y, 0.7))


# The camera


@given(
    st.tuples(st.floats(-3, 3), st.floats(-3, 3), st.floats(0.5, 2)),
    st.integers(0, 639),
    st.integers(0, 479),
    st.floats(0.3, 8.0),
)
def test_a_point_is_seen_where_it_was_seen(eye: tuple[float, ...], u: int, v: int, depth: float) -> None:
    view = camera(eye, (eye[0] + 1.0, eye[1] + 0.2, 0.1))
    (point,) = view.points(np.array([u]), np.array([v]), np.array([depth]))
    x, y, z = (point - view.position) @ view.camera2world[:3, :3]
    assert [view.fx * x / z + view.cx, view.fy * y / z + view.cy, z] == pytest.approx([u, v, depth])


@pytest.mark.parametrize(
    "pose",
    [np.eye(3), np.diag([1.0, 1.0, -1.0, 1.0]), np.diag([2.0, 1.0, 1.0, 1.0]), np.full((4, 4), np.nan)],
)
def test_a_pose_is_a_rigid_motion(pose: Array) -> None:
    with pytest.raises(SceneError, match="pose"):
        Camera(4, 4, 1.0, 1.0, 0.0, 0.0, pose)


def test_images_are_of_the_camera() -> None:
    with pytest.raises(SceneError, match="the depth image is 3 x 2 pixels, the camera 640 x 480"):
        Frame(0.0, camera(), np.zeros((2, 3)), np.zeros((2, 3), dtype=int))


# Noise


def test_a_slanted_plane_loses_its_noise_and_nothing_else() -> None:
    rng = np.random.default_rng(0)
    v, u = np.mgrid[:60, :80]
    true = 1.0 / (0.5 + 0.002 * u - 0.001 * v)
    found = smooth(true + rng.normal(0.0, 0.01, true.shape), np.ones(true.shape, dtype=bool), 0.01)
    off = found.depth - true[found.v, found.u]
    assert len(off) > 0.99 * true.size
    assert (abs(off.mean()), off.std()) < (0.0005, 0.002)
    # The errors that are claimed are those that are made.
    assert np.abs(off / found.error).std() < 1.2


def test_depth_edges_within_a_mask_are_not_smeared() -> None:
    true = np.full((60, 80), 2.0)
    true[:, 40:] = 2.5
    depth = true + np.random.default_rng(0).normal(0.0, 0.01, true.shape)
    found = smooth(depth, np.ones(true.shape, dtype=bool), 0.01)
    assert np.abs(found.depth - true[found.v, found.u]).max() < 0.02


def test_flying_pixels_are_dropped_or_brought_back() -> None:
    rng = np.random.default_rng(0)
    depth = np.full((40, 40), 2.0)
    depth[:, -1] = rng.uniform(2.05, 4.0, 40)
    found = smooth(depth + rng.normal(0.0, 0.01, depth.shape), np.ones(depth.shape, dtype=bool), 0.01)
    assert np.abs(found.depth - 2.0).max() < 0.03
    assert found.dropped > 20


@pytest.mark.parametrize("sigma", [0.0, 0.002, 0.01, 0.03])
def test_noise_is_measured(sigma: float) -> None:
    frame = picture([TABLE, cup()], noise=sigma, flying=0.0)
    assert noise_of(frame.depth, frame.depth > 0.0) == pytest.approx(sigma, rel=0.1, abs=1.0e-4)


@pytest.mark.parametrize("flying", [0.0, 0.5])
def test_noise_does_not_blow_up_a_cup(flying: float) -> None:
    """1 cm of noise on a 10 cm cup: its cloud is 16 cm deep, its box is not."""
    frame = picture([TABLE, cup()], flying=flying, labels=("table", "cup"))
    scene = perceive([frame])
    shown = {thing.label: 2.0 * half for thing, half in zip(scene.objects, scene.boxes.half, strict=True)}
    assert np.abs(shown["cup"] - 0.1).max() < 0.02
    assert np.abs(np.sort(shown["table"]) - np.array([0.7, 0.7, 1.2])).max() < 0.05


def test_without_noise_nothing_is_lost() -> None:
    boxes = perceive([picture([TABLE, cup()], noise=0.0, flying=0.0)]).boxes
    assert 2.0 * boxes.half[1] == pytest.approx([0.1, 0.1, 0.1], abs=0.008)


# What was not seen


def test_a_box_seen_from_a_corner_is_a_box() -> None:
    """At the height of the camera, so that its top is not seen: its plan is two sides of a triangle."""
    crate = placed(trimesh.creation.box([0.4, 0.3, 0.5]), (0.0, 0.0, 1.6), 0.6)
    (thing,) = perceive([picture([crate], eye=(0.0, -2.0, 1.85), target=(0.0, 0.0, 1.84))]).objects
    assert isinstance(thing.region, BoxRegion)
    assert sorted(thing.region.size) == pytest.approx([0.3, 0.4, 0.5], abs=0.03)


def test_a_round_thing_has_another_side() -> None:
    pot = placed(trimesh.creation.cylinder(0.15, 0.4, sections=64), (0.0, 0.0, 1.5))
    (thing,) = perceive([picture([pot], eye=(0.0, -2.0, 1.3), target=(0.0, 0.0, 1.7))]).objects
    assert isinstance(thing.region, MeshRegion)
    assert np.ptp(thing.region.vertices, axis=0) == pytest.approx([0.3, 0.3, 0.4], abs=0.03)


def test_a_table_on_four_legs_is_not_round() -> None:
    parts = [trimesh.creation.box([0.8, 0.8, 0.04], trimesh.transformations.translation_matrix([0, 0, 0.7]))]
    for x in (-0.37, 0.37):
        for y in (-0.37, 0.37):
            place = trimesh.transformations.translation_matrix([x, y, 0.35])
            parts.append(trimesh.creation.box([0.05, 0.05, 0.7], place))
    stand = placed(trimesh.util.concatenate(parts), (0.0, 0.0, 0.0), 0.3)
    scene = perceive([picture([stand], eye=(0.5, -1.8, 1.4))])
    assert 2.0 * scene.boxes.half[0] == pytest.approx([0.8, 0.8, 0.72], abs=0.05)


# Surfaces


def test_planes_of_a_noisy_room() -> None:
    rng = np.random.default_rng(3)
    a, b = rng.uniform(0.0, 1.0, (2, 6000))
    floor = np.stack([4 * a, 3 * b, 0 * a], axis=1)[:3000]
    wall = np.stack([4 * a, 0 * a + 3.0, 2.5 * b], axis=1)[:2000]
    shelf = np.stack([1 + a, 1 + b, 0 * a + 0.72], axis=1)[:800]
    clutter = rng.uniform(0.0, 3.0, (1500, 3))
    points = np.concatenate([floor, wall, shelf, clutter]) + rng.normal(0.0, 0.01, (7300, 3))
    planes = find_planes(points, 0.03, 150)
    assert [plane.level for plane in planes[:3]] == [True, False, True]
    surfaces, notes = find_surfaces(points, np.broadcast_to([2.0, 1.0, 1.5], points.shape), 0.01)
    assert [one.name for one in surfaces] == ["floor", "wall"]
    assert surfaces[0].normal == pytest.approx([0.0, 0.0, 1.0], abs=0.01)
    assert surfaces[1].normal == pytest.approx([0.0, -1.0, 0.0], abs=0.01)
    assert notes == ["a level plane at 0.72 m is no floor: left out"]


def test_the_same_cloud_has_the_same_planes() -> None:
    points = np.random.default_rng(0).uniform(0.0, 1.0, (500, 3)) * [3.0, 3.0, 0.01]
    one, other = (find_planes(points, 0.02, 100) for _ in range(2))
    assert [(*plane.normal, plane.offset) for plane in one] == [
        (*plane.normal, plane.offset) for plane in other
    ]


def test_nothing_is_no_plane() -> None:
    assert find_planes(np.empty((0, 3)), 0.02, 100) == []
    assert find_planes(np.zeros((500, 3)), 0.02, 100) == []


# Several frames


def test_two_views_of_one_cup_are_one_cup() -> None:
    frames = [
        picture([TABLE, cup()], labels=("table", "cup")),
        picture([TABLE, cup()], eye=(1.5, 1.5, 1.5), stamp=STAMP + 2.0, labels=("table", "mug")),
    ]
    frames[1] = replace(frames[1], labels={**frames[1].labels, 2: (Label("mug", 0.5), Label("cup", 0.3))})
    scene = perceive(reversed(frames))
    things = [thing for thing in scene.objects if thing.kind == "object"]
    assert [thing.id for thing in things] == ["t1583236000000_1", "t1583236000000_2"]
    assert {thing.seen_in for thing in things} == {("t1583236000000", "t1583236002000")}
    assert [label.name for label in things[1].labels] == ["cup", "mug"]
    assert [(view.id, view.stamp) for view in scene.views] == [
        ("t1583236000000", STAMP),
        ("t1583236002000", STAMP + 2.0),
    ]


def test_cups_side_by_side_stay_two() -> None:
    cups = [cup(-0.07), cup(0.07)]
    frames = [
        picture([TABLE, *cups], labels=("table", "cup", "cup")),
        picture(
            [TABLE, *cups[::-1]], eye=(1.2, -1.6, 1.5), stamp=STAMP + 2.0, labels=("table", "cup", "cup")
        ),
    ]
    scene = perceive(frames)
    middles = sorted(scene.boxes.center[i, 0] for i, one in enumerate(scene.objects) if one.label == "cup")
    assert middles == pytest.approx([-0.07, 0.07], abs=0.02)


def test_two_frames_of_one_moment_are_refused() -> None:
    frame = picture([TABLE])
    with pytest.raises(SceneError, match="two frames have the stamp"):
        perceive([frame, frame])


def test_what_is_on_a_table_stays_apart_from_it() -> None:
    boxes = boxes_of([TABLE[0], cup()[0]])
    labels = [[Label("table", 0.9)], [Label("cup", 0.9)]]
    assert associate(boxes, labels, boxes, labels, 0.02) == {0: 0, 1: 1}


def test_labels_agree_or_not() -> None:
    one, other = [Label("cup", 0.6), Label("jar", 0.2)], [Label("lamp", 0.9)]
    assert (likeness(one, one), likeness(one, other)) == (1.0, 0.0)
    assert likeness(one, []) > 0.0
    assert fused([([], 5.0), (one, 2.0)])[0] == Label("cup", 0.6)


def test_what_is_too_small_is_noted() -> None:
    far = placed(trimesh.creation.box([0.02, 0.02, 0.02]), (0.0, 3.0, 0.7))
    scene = perceive([picture([TABLE, far], eye=(0.0, -2.0, 2.5), labels=("table", "die"))])
    assert [thing.label for thing in scene.objects if thing.kind == "object"] == ["table"]
    assert "die (instance 2)" in scene.diagnostics[0]


def test_an_empty_map_is_a_scene() -> None:
    assert Map("nothing").scene().objects == ()


# Rooms


def _good(total: Score) -> None:
    print(total.text())
    assert total.recovered >= 0.95 * total.visible
    assert total.f1 >= 0.9
    assert (max(total.tilts), max(total.offsets), total.missed_surfaces) < (2.0, 0.02, 1)


def test_a_room_is_recovered() -> None:
    """30 things, 5 poses, 1 cm of noise and flying pixels; more rooms in the long test below."""
    _good(room_score(0))


@pytest.mark.long
def test_rooms_are_recovered() -> None:
    total = Score()
    for seed in range(10, 22):
        total.add(room_score(seed))
    _good(total)


def test_a_room_whose_noise_is_not_told() -> None:
    room = furnished(2)
    seen = observe(room, 2, known_noise=False, flying=0.0)
    found = score(room, seen, perceive(seen.frames))
    assert (found.recovered / found.visible, found.f1) >= (0.9, 0.9)


@pytest.mark.long
def test_a_frame_becomes_relations_in_no_time() -> None:
    """Printed: a warm process, the least of many, since the machine may be busy."""
    frame = observe(furnished(7, 20), 7, count=1).frames[0]
    best = np.inf
    for _ in range(30):
        start = time.process_time()
        found = relations(perceive([frame]))
        best = min(best, time.process_time() - start)
    print(f"{len(np.unique(frame.instances))} things in view, {len(found)} relations: {best * 1000:.0f} ms")
    assert len(found) > 100


@pytest.mark.long
def test_fifty_million_points_in_bounded_memory(tmp_path: Path) -> None:
    path = tmp_path / "many.ply"
    count, block = 50_000_000, 1_000_000
    kind = [("x", "<f4"), ("y", "<f4"), ("z", "<f4"), ("instance", "<u2")]
    fields = "".join(f"property float {name}\n" for name in "xyz") + "property ushort instance\n"
    head = f"ply\nformat binary_little_endian 1.0\nelement vertex {count}\n{fields}end_header\n"
    rng = np.random.default_rng(0)
    with path.open("wb") as file:
        file.write(head.encode())
        for number in range(count // block):
            rows = np.empty(block, kind)
            rows["x"], rows["y"] = rng.uniform(0, 1, (2, block)) + number % 5
            rows["z"] = np.where(rng.random(block) < 0.5, 0.0, 0.5)
            rows["instance"] = 1 + number % 10
            rows.tofile(file)
    code = (
        f"{MOST}\n"
        "import sys\n"
        "from deixis.perception.clouds import open_cloud\n"
        "from deixis.perception.thinning import thinned\n"
        "from pathlib import Path\n"
        "things, rest = thinned(open_cloud(Path(sys.argv[1])))\n"
        "print(len(things), most())\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", code, str(path)], capture_output=True, text=True, check=True, env=os.environ
    )
    things, peak = map(int, done.stdout.split())
    print(f"50 million points: at most {peak / (1 << 20):.0f} MiB")
    assert things == 10
    assert peak < 700 << 20


def test_a_surface_is_seen_in_the_views_that_showed_it() -> None:
    floor = (np.array([[-2, -3, 0], [2, -3, 0], [2, 2, 0], [-2, 2, 0.0]]), np.array([[0, 1, 2], [0, 2, 3]]))
    view = camera()
    seen = render(view, [Body(1, *TABLE), Body(9, *floor)])
    shown = np.where(seen.instances == 9, 0, seen.instances)
    depth = noisy(seen, 0.01, np.random.default_rng(0))
    scene = perceive([Frame(STAMP, view, depth, shown, {1: (Label("table"),)}, np.zeros(3))])
    (surface,) = (one for one in scene.objects if one.kind == "surface")
    assert isinstance(surface.region, SurfaceRegion)
    assert (surface.label, surface.seen_in) == ("floor", ("t1583236000000",))
    assert ("on_top_of", "t1583236000000_1", surface.id) in relations(scene)
