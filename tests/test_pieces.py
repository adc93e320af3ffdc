"""Proper regions (axioms 3, 6-8): a cloud is one piece, its strays are told from the thing, and said so."""

from __future__ import annotations

import subprocess
import sys
from itertools import pairwise
from typing import Any

import jsonschema
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

import deixis.pieces
from deixis.errors import GeometryError, SceneError, ThresholdError
from deixis.frames import Array
from deixis.pieces import one_piece, pieces
from deixis.regions import MeshRegion, PointRegion, region_box
from deixis.scene import Scene, SpatialObject, scene_schema
from deixis.thresholds import Thresholds

GAP = 0.1
LIMITS = Thresholds()


def block(x: float = 0.0, size: float = 0.3, step: float = 0.05) -> Array:
    """Return a cube of points with its least corner at x."""
    along = np.arange(0.0, size + step / 2, step)
    return np.stack(np.meshgrid(along + x, along, along, indexing="ij"), axis=-1).reshape(-1, 3)


def cloud(points: Any, **rest: Any) -> dict[str, Any]:
    thing = {"id": "cup", "points": np.asarray(points).tolist(), **rest.pop("thing", {})}
    return {"deixis": 1, "id": "room", "objects": [thing], **rest}


def by_all_pairs(points: Array, gap: float) -> list[set[int]]:
    """Return the pieces by brute force: every pair of points within the gap is a link."""
    one, other = cKDTree(points).query_pairs(gap + 0.5e-9, output_type="ndarray").T
    links = coo_array((np.ones(len(one)), (one, other)), shape=(len(points), len(points)))
    return grouped(connected_components(links, directed=False)[1])


def grouped(label: Any) -> list[set[int]]:
    """Return the positions with each label, in an order of their own."""
    return sorted((set(np.flatnonzero(label == one).tolist()) for one in np.unique(label)), key=min)


KINDS = ("anywhere", "lattice", "clusters", "plane", "line")


def drawn(kind: str, rng: np.random.Generator, gap: float) -> Array:
    """Return a random cloud with many steps about as long as the gap."""
    count = int(rng.integers(1, 300))
    points = rng.random((count, 3)) * gap * rng.uniform(0.5, 12.0)
    match kind:
        case "lattice":
            return rng.integers(0, 8, (count, 3)) * gap * rng.choice([0.25, 1 / 3, 0.5, 1.0, 1.0001])
        case "clusters":
            centres = rng.random((5, 3)) * gap * 4.0
            return centres[rng.integers(0, 5, count)] + rng.random((count, 3)) * gap * 0.3
        case "plane":
            points[:, rng.integers(0, 3)] = 0.0
        case "line":
            points *= [[1.0, 0.0, 0.0]]
    return points


@pytest.mark.parametrize("kind", KINDS)
@given(seed=st.integers(0, 2**32 - 1))
def test_pieces_are_those_of_all_pairs(kind: str, seed: int) -> None:
    rng = np.random.default_rng(seed)
    gap = 10.0 ** rng.uniform(-3, 1)
    points = drawn(kind, rng, gap) + rng.choice([0.0, 1.0, 1e3])
    label, size = pieces(points, gap)
    expected = by_all_pairs(points, gap)
    assert grouped(label) == expected
    assert size.tolist() == sorted(map(len, expected), reverse=True) == np.bincount(label).tolist()


@given(seed=st.integers(0, 2**32 - 1))
def test_pieces_turn_with_the_cloud_and_with_its_order(seed: int) -> None:
    rng = np.random.default_rng(seed)
    points = drawn("anywhere", rng, 1.0)
    turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    order = rng.permutation(len(points))
    found = grouped(pieces(points, 1.0)[0])
    assert grouped(pieces(points @ turn.T + [1.0e3, -2.0e3, 5.0], 1.0)[0]) == found
    shuffled = pieces(points[order], 1.0)[0]
    assert grouped(shuffled[np.argsort(order)]) == found


@pytest.mark.parametrize("count", [2, 31, 400])
def test_a_step_of_just_the_gap_is_a_link(count: int) -> None:
    """Three tenths less two tenths is more than one tenth in float64: bounds are closed to a nanometre."""
    line = np.arange(count)[:, None] * [GAP, 0.0, 0.0]
    assert pieces(line, GAP)[1].tolist() == [count]
    assert pieces(line * (1.0 + 1e-6), GAP)[1].tolist() == [1] * count


def test_crowds_are_linked_by_their_nearest_points() -> None:
    """Two dense clusters: the one pair of points that is near enough is among thousands that are not."""
    rng = np.random.default_rng(1)
    left, right = rng.random((400, 3)) * 0.06, rng.random((400, 3)) * 0.06 + [0.18, 0.0, 0.0]
    left[7], right[3] = [0.06, 0.03, 0.03], [0.18, 0.03, 0.03]
    both = np.concatenate([left, right])
    nearest = cKDTree(left).query(right)[0].min()
    assert pieces(both, nearest)[1].tolist() == [800]
    assert pieces(both, nearest - 1e-6)[1].tolist() == [400, 400]


def test_a_chunk_at_a_time_is_as_good(monkeypatch: pytest.MonkeyPatch) -> None:
    rng = np.random.default_rng(2)
    points = np.concatenate([drawn(kind, rng, GAP) for kind in KINDS])
    whole = pieces(points, GAP)
    box = region_box(PointRegion(points), "object", LIMITS)
    monkeypatch.setattr(deixis.pieces, "CHUNK", 7)
    label, size = pieces(points, GAP)
    assert (label.tolist(), size.tolist()) == (whole[0].tolist(), whole[1].tolist())
    again = region_box(PointRegion(points), "object", LIMITS)
    assert again.half.tolist() == box.half.tolist()


def test_of_pieces_equally_large_the_first_given_comes_first() -> None:
    points = np.array([[5, 0, 0], [0, 0, 0], [9, 0, 0], [9, 0, 0], [0, 0, 0], [7, 0, 0]], dtype=float)
    assert pieces(points, 1.0)[0].tolist() == [2, 0, 1, 1, 0, 3]


@pytest.mark.parametrize(
    "points",
    [
        [[1.0, 2.0, 3.0]],
        [[1.0, 2.0, 3.0]] * 50,
        np.linspace(0, 3, 31)[:, None] * [[1.0, 0.0, 0.0]],
        np.linspace(0, 3, 90)[:, None] * [[0.3, 0.5, 0.7]],
        block(),
        [[0.0, 0.0, 0.0], [GAP, 0.0, 0.0]],
    ],
    ids=["one point", "all the same", "a line", "a line askew", "a cube", "two points"],
)
def test_one_piece_is_left_alone(points: Any) -> None:
    made = Scene.from_dict(cloud(points))
    assert not [note for note in made.diagnostics if "points" in note]
    assert made.regions[0] is made.objects[0].region
    assert Scene.from_dict(cloud(points, strays="refuse")).diagnostics == made.diagnostics


def test_an_empty_cloud_has_no_pieces_and_is_refused() -> None:
    with pytest.raises(SceneError, match="empty"):
        PointRegion(np.empty((0, 3)))


def test_stray_points_are_left_out_and_named() -> None:
    thing = block()
    strays = np.array([[9.0, 0, 0], [0, -7.0, 0], [0.1, 0.1, 0.31 + GAP]])
    made = Scene.from_dict(cloud(np.concatenate([strays[:2], thing, strays[2:]])))
    total = len(thing) + 3
    said = f"3 of its {total} points are strays, in 3 pieces more than 0.1 m from the rest: left out"
    assert made.diagnostics == (f"object 'cup': {said}",)
    alone = Scene.from_dict(cloud(thing))
    assert made.boxes.center.tolist() == alone.boxes.center.tolist()
    assert made.boxes.half.tolist() == alone.boxes.half.tolist()
    assert made.regions[0].points.tolist() == thing.tolist()  # type: ignore[union-attr]
    assert len(made.objects[0].region.points) == total  # type: ignore[union-attr]
    again = Scene.from_dict(made.to_dict())
    assert again.diagnostics == made.diagnostics


def test_of_two_pieces_the_larger_is_the_thing() -> None:
    large, small = block(5.0), block(0.0, size=0.25)
    made = Scene.from_dict(cloud(np.concatenate([small, large])))
    assert made.boxes.half.tolist() == Scene.from_dict(cloud(large)).boxes.half.tolist()
    assert f"{len(small)} of its {len(small) + len(large)} points are strays" in made.diagnostics[0]
    # Just within the gap they are one thing.
    near = block(0.25 + GAP)
    made = Scene.from_dict(cloud(np.concatenate([small, near])))
    assert made.diagnostics == ()
    assert made.boxes.half[0].max() == pytest.approx((0.25 + GAP + 0.3) / 2)


CORNERS = [[x, y, z] for x in (0.0, 2.0) for y in (0.0, 1.0) for z in (0.0, 0.5)]


@pytest.mark.parametrize(
    ("points", "count"),
    [
        (CORNERS, 8),
        ([[x, y, z / 500] for x, y, z in CORNERS], 4),
        (CORNERS * 5, 8),
        (np.concatenate([block(), block(5.0)]), 2),
    ],
    ids=["corners", "corners of a sheet", "each corner five times", "two halves"],
)
def test_where_no_piece_has_most_of_the_points_all_are_kept(points: Any, count: int) -> None:
    made = Scene.from_dict(cloud(points))
    (note,) = made.diagnostics
    assert f"'cup': its {len(points)} points are in {count} pieces" in note
    assert "all are kept" in note
    extents = np.sort(np.ptp(np.asarray(points), axis=0))
    assert np.sort(2.0 * made.boxes.half[0]) == pytest.approx(extents, abs=1e-9)
    assert made.regions[0] is made.objects[0].region


@pytest.mark.parametrize(
    "points", [np.concatenate([block(), [[9.0, 0, 0]]]), CORNERS], ids=["stray", "corners"]
)
def test_pieces_are_refused_on_demand(points: Any) -> None:
    said = r"object 'cup': its \d+ points are in \d pieces .* piece_gap"
    with pytest.raises(SceneError, match=said) as caught:
        Scene.from_dict(cloud(points, strays="refuse"))
    assert isinstance(caught.value.__cause__, GeometryError)
    thing = SpatialObject("cup", (), "object", PointRegion(points))
    by_hand = Scene("room", (thing,), strays="refuse")
    with pytest.raises(SceneError, match="'cup'"):
        _ = by_hand.boxes


def test_the_policy_is_part_of_the_format() -> None:
    data = cloud(block(), strays="refuse")
    made = Scene.from_dict(data)
    assert made.to_dict()["strays"] == "refuse"
    assert Scene.from_dict(made.to_dict()).strays == "refuse"
    assert "strays" not in Scene.from_dict(cloud(block(), strays="drop")).to_dict()
    schema = jsonschema.Draft202012Validator(scene_schema())
    assert schema.is_valid(data)
    for wrong in ("keep", None, True):
        assert not schema.is_valid({**data, "strays": wrong})
        with pytest.raises(SceneError, match=r"'room': strays is .*give 'drop' or 'refuse'"):
            Scene.from_dict({**data, "strays": wrong})


def test_the_gap_is_a_threshold_and_never_below_the_granularity() -> None:
    points = np.concatenate([block(), block(0.45)[:4]])
    for limits, strays in (
        ({}, "4 of"),
        ({"piece_gap": 0.14}, "4 of"),
        ({"piece_gap": 0.16}, None),
        ({"piece_gap": 0.01, "granularity": 0.14, "penetration": 0.14}, "4 of"),
        ({"piece_gap": 0.01, "granularity": 0.16, "penetration": 0.16}, None),
        ({"piece_gap": 0.01}, "all are kept"),
    ):
        notes = Scene.from_dict(cloud(points, thresholds=limits)).diagnostics
        assert [strays in note for note in notes] == [True] if strays else notes == ()
    for wrong in (0.0, -1.0):
        with pytest.raises(ThresholdError, match="piece_gap"):
            Thresholds(piece_gap=wrong)


def test_surfaces_are_seen_in_patches() -> None:
    points = np.concatenate([block() * [1, 1, 0], block()[:60] * [1, 1, 0] + [3.0, 0, 0]])
    made = Scene.from_dict(cloud(points, strays="refuse", thing={"kind": "surface"}))
    assert made.diagnostics == ()
    assert made.boxes.half[0].max() > 1.0


def test_meshes_may_be_modelled_in_parts() -> None:
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [5, 0, 0], [6, 0, 0], [5, 1, 1.0]])
    region = MeshRegion(corners, np.array([[0, 1, 2], [3, 4, 5]]))
    made = Scene("room", (SpatialObject("table", (), "object", region),), strays="refuse")
    assert made.boxes.half[0].max() == pytest.approx(3.0)
    assert made.regions == (region,)


def test_a_far_stray_is_no_trouble() -> None:
    """At a million metres the cells between are too many to number; the empty ones are skipped."""
    points = np.concatenate([block(), [[1.0e6, 0, 0], [1.0e6 + 0.05, 0, 0], [0, -9.0e6, 7.0e6]]])
    label, size = pieces(points, GAP)
    assert size.tolist() == [len(block()), 2, 1]
    assert grouped(label) == by_all_pairs(points, GAP)


def test_a_cloud_too_wide_for_its_gap_is_refused() -> None:
    """No cell is empty for long, over 300 km: the names of the cells run out."""
    line = np.arange(0.0, 3.0e5, 0.5)[:, None] * [1.0, 0.0, 0.0]
    with pytest.raises(GeometryError, match=r"over 300,000 m, .* piece_gap"):
        pieces(line, GAP)
    assert pieces(line, 1.0)[1].tolist() == [len(line)]


@pytest.mark.parametrize("turn", [0.0, 0.4])
@pytest.mark.parametrize("shape", ["ball", "block", "line", "point", "octagon"])
def test_the_box_of_many_points_is_that_of_all(shape: str, turn: float) -> None:
    """Only the points that decide are kept before the box is computed; the answer is the same."""
    rng = np.random.default_rng(3)
    points = rng.normal(size=(5000, 3))
    match shape:
        case "block":
            points = rng.choice([-1.0, 0.0, 1.0], (5000, 3))
        case "line":
            points = points[:, :1] * [[1.0, 0.0, 0.5]]
        case "point":
            points = np.full((5000, 3), 0.3)
        case "octagon":
            angle = rng.integers(0, 8, 5000) * np.pi / 4
            points = np.stack([np.cos(angle), np.sin(angle), rng.random(5000)], axis=1)
    cos, sin = np.cos(turn), np.sin(turn)
    points = points @ np.array([[cos, sin, 0.0], [-sin, cos, 0.0], [0.0, 0.0, 1.0]])
    expected = deixis.regions.min_bound_box(points)
    found = region_box(PointRegion(points), "surface", LIMITS)
    assert np.allclose(found.center, expected[0], rtol=0.0, atol=1e-12)
    assert np.allclose(found.half, expected[1], rtol=0.0, atol=1e-12)
    assert (found.yaw, found.ambiguous) == (pytest.approx(expected[2], abs=1e-12), expected[3])


def test_a_scene_without_clouds_does_not_wait_for_scipy(root: Any) -> None:
    program = (
        "import sys; from deixis.scene import Scene; from deixis.grounding import ground; "
        f"ground(Scene.load({str(root / 'kb' / 'scenes' / 'hans.json')!r})); "
        "print(sorted(name for name in sys.modules if name.split('.')[0] == 'scipy'))"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout == "[]\n"


def room(count: int, seed: int = 4) -> Array:
    """Return points on the walls, floor and ceiling of a room, with one point in 100,000 outside it."""
    rng = np.random.default_rng(seed)
    points = rng.random((count, 3)) * [10.0, 10.0, 3.0]
    side = rng.integers(0, 3, count)
    points[np.arange(count), side] = np.where(rng.random(count) < 0.5, 0.0, np.array([10.0, 10.0, 3.0])[side])
    points[::100_000] += 20.0
    return points


def test_a_large_cloud_of_one_piece_and_some_strays() -> None:
    points = room(300_000)
    keep, note = one_piece(points, GAP)
    assert keep is not None
    assert np.flatnonzero(~keep).tolist() == [0, 100_000, 200_000]
    assert note.startswith("3 of its 300,000 points are strays, ")


WORST = {
    "lattice, each point its own cell": lambda: np.argwhere(np.ones((100, 100, 100))) * 0.8 * GAP,
    "lattice, each point its own piece": lambda: np.argwhere(np.ones((100, 100, 100))) * 1.2 * GAP,
    "two dense halves that almost meet": lambda: np.concatenate(
        [room(500_000) / 3.0, room(500_000) / 3.0 + [10.0 / 3.0 + 1.1 * GAP, 0.0, 0.0]]
    ),
    "clusters": lambda: (
        np.repeat(np.random.default_rng(5).random((25_000, 3)) * 6.0, 40, axis=0)
        + np.random.default_rng(6).random((1_000_000, 3)) * 0.06 * GAP
    ),
}


@pytest.mark.long
@pytest.mark.parametrize("shape", WORST)
def test_a_million_points_however_they_lie(shape: str) -> None:
    points = WORST[shape]()
    label, size = pieces(points, GAP)
    assert size.sum() == len(points) == 1_000_000
    assert all(more >= less for more, less in pairwise(size.tolist()))
    # Within a window no link is missed, and none is made between pieces that the whole keeps apart.
    some = np.flatnonzero((np.abs(points - points[len(points) // 2]) < 4 * GAP).all(axis=1))[:20_000]
    one, other = cKDTree(points[some]).query_pairs(GAP, output_type="ndarray").T
    assert (label[some][one] == label[some][other]).all()
    distance, _ = cKDTree(points[label == 0]).query(points[label != 0][:20_000])
    assert distance.size == 0 or distance.min() > GAP
