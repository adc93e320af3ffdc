"""Minimum and contextualised boxes: they hold their points, turn with them, and are marked where a choice."""

from __future__ import annotations

import math

import numpy as np
import pytest
import shapely
from hypothesis import assume, given
from hypothesis import strategies as st
from numpy.typing import NDArray

from deixis.boxes import NO_NORMAL, Boxes, align_with_world, contextualise, min_bound_box
from deixis.errors import GeometryError
from deixis.frames import QUARTER
from scenes import box, scene
from worlds import World, worlds

Array = NDArray[np.float64]


def turned(points: Array, angle: float, shift: Array) -> Array:
    cos, sin = math.cos(angle), math.sin(angle)
    return np.asarray(points @ np.array([[cos, sin, 0.0], [-sin, cos, 0.0], [0.0, 0.0, 1.0]]) + shift)


def box_corners(center: Array, half: Array, yaw: float) -> Array:
    """Return the eight corners in an order that does not depend on which way round the box is told."""
    signs = np.array([[a, b, c] for a in (-1, 1) for b in (-1, 1) for c in (-1, 1)])
    return turned(signs * half, yaw, center)


def same_box(one: Array, other: Array, within: float) -> bool:
    distance = np.linalg.norm(one[:, None] - other[None], axis=2)
    return bool((distance.min(axis=0) < within).all() and (distance.min(axis=1) < within).all())


def clouds(rng: np.random.Generator) -> Array:
    """Return a random cloud: some vertices of a lattice, so that edges repeat, or any points."""
    count = int(rng.integers(3, 20))
    if rng.random() < 0.5:
        return np.asarray(rng.integers(-4, 5, (count, 3)) / 8.0)
    return rng.normal(size=(count, 3)) * rng.uniform(0.05, 1.0, 3)


def test_the_minimum_box_holds_its_points_and_turns_with_them() -> None:
    rng = np.random.default_rng(1)
    unsure = 0
    for _ in range(1000):
        points = clouds(rng)
        center, half, yaw, ambiguous = min_bound_box(points)
        local = np.abs(turned(points - center, -yaw, np.zeros(3)))
        assert (local <= half + 1e-9).all()
        assert np.allclose(local.max(axis=0), half, atol=1e-9)
        assert 0.0 <= yaw < QUARTER
        least = shapely.area(shapely.minimum_rotated_rectangle(shapely.multipoints(points[:, :2])))
        assert 4.0 * half[0] * half[1] == pytest.approx(least, abs=1e-6)
        angle, shift = rng.uniform(-4.0, 4.0), rng.uniform(-50.0, 50.0, 3)
        again = min_bound_box(turned(points, angle, shift))
        expected = turned(box_corners(center, half, yaw), angle, shift)
        assert again[3] == ambiguous
        assert same_box(box_corners(*again[:3]), expected, 1e-8)
        unsure += ambiguous
    assert 0 < unsure < 300


@pytest.mark.parametrize("sides", [3, 4, 5, 6, 8, 12])
def test_the_box_of_a_regular_polygon_turns_with_it_and_is_marked(sides: int) -> None:
    rng = np.random.default_rng(sides)
    around = 2.0 * np.pi * np.arange(sides) / sides
    level = np.stack([np.cos(around), np.sin(around)], axis=1)
    points = np.concatenate([np.column_stack([level, np.full(sides, z)]) for z in (0.0, 0.7)])
    first = box_corners(*min_bound_box(points)[:3])
    for angle in rng.uniform(-4.0, 4.0, 200):
        shift = rng.uniform(-5.0, 5.0, 3)
        *found, ambiguous = min_bound_box(turned(points, float(angle), shift))
        # The box of a square is a matter of choice only by what one calls its sides.
        assert ambiguous == (sides != 4)
        assert same_box(box_corners(*found), turned(first, float(angle), shift), 1e-8)


@pytest.mark.parametrize(
    ("points", "half", "ambiguous"),
    [
        ([[1, 2, 3]], (0, 0, 0), True),
        ([[1, 2, 3]] * 5, (0, 0, 0), True),
        ([[1, 2, 0], [1, 2, 4]], (0, 0, 2), True),
        ([[0, 0, 0], [3, 4, 0], [1.5, 2, 0]], (0, 2.5, 0), False),
        ([[0, 0, 0], [3, 4, 12]], (0, 2.5, 6), False),
        ([[0, 0, 0], [4, 0, 3], [4, 1, 3], [0, 1, 0]], (0.5, 2, 1.5), False),
    ],
    ids=["one point", "identical", "upright line", "level line", "slanting line", "slanting plane"],
)
@pytest.mark.parametrize("angle", [0.0, 0.3, math.pi / 2, -2.2])
def test_flat_and_thin_clouds_have_flat_and_thin_boxes(
    points: list[list[float]], half: tuple[float, float, float], ambiguous: bool, angle: float
) -> None:
    cloud = turned(np.array(points, dtype=float), angle, np.array([5.0, -7.0, 1.0]))
    center, found, _, marked = min_bound_box(cloud)
    assert np.allclose(center, 0.5 * (cloud.min(axis=0) + cloud.max(axis=0)), atol=1e-9) or len(points) == 4
    assert np.allclose([*sorted(found[:2]), found[2]], half, atol=1e-9)
    assert marked == ambiguous


@pytest.mark.parametrize(
    "points", [np.zeros((0, 3)), np.zeros((2, 2)), [[0, 0, math.nan]], [[0, math.inf, 0]]]
)
def test_what_is_no_cloud_is_refused(points: Array) -> None:
    with pytest.raises(GeometryError, match="finite points"):
        min_bound_box(points)


def test_far_from_the_origin_the_box_keeps_a_millimetre() -> None:
    rng = np.random.default_rng(3)
    for _ in range(50):
        points = rng.integers(-500, 500, (12, 3)) / 1000
        near = min_bound_box(points)
        far = min_bound_box(points + 1.0e6)
        assert same_box(box_corners(*near[:3]) + 1.0e6, box_corners(*far[:3]), 1e-8)


# Contextualised boxes.


def one_box(half: tuple[float, float, float], yaw: float, normal: int = NO_NORMAL) -> Boxes:
    return Boxes(np.zeros((1, 3)), np.array([half]), np.array([yaw]), np.array([normal]), np.array([False]))


@given(
    half=st.tuples(st.floats(0.01, 2.0), st.floats(0.01, 2.0), st.just(0.5)),
    yaw=st.floats(-7.0, 7.0),
    bearing=st.floats(-math.pi, math.pi),
)
def test_a_box_turns_to_the_line_of_sight_by_the_least_angle(
    half: tuple[float, float, float], yaw: float, bearing: float
) -> None:
    position = np.array([-10.0 * math.cos(bearing), -10.0 * math.sin(bearing), 1.0])
    framed, clearance, tie = contextualise(one_box(half, yaw), position)
    # All turns that lay a side along the line of sight, by brute force.
    turns = {k: math.remainder(bearing - k * QUARTER - yaw, 2.0 * math.pi) for k in range(4)}
    least = min(turns, key=lambda k: abs(turns[k]))
    assume(abs(abs(turns[least]) - math.pi / 4) > 1e-6)
    expected = (half[0], half[1]) if least % 2 == 0 else (half[1], half[0])
    assert tuple(framed.half[0, :2]) == expected
    assert math.remainder(framed.yaw[0] - bearing, 2.0 * math.pi) == pytest.approx(0.0, abs=1e-12)
    assert not tie[0]
    assert clearance[0] > 0.0


@given(
    long=st.floats(0.5, 2.0),
    yaw=st.floats(-7.0, 7.0),
    odd=st.integers(0, 3),
    crossed=st.booleans(),
    noise=st.floats(-1e-9, 1e-9),
)
def test_at_45_degrees_the_longer_side_faces_the_viewer_and_the_tie_is_marked(
    long: float, yaw: float, odd: int, crossed: bool, noise: float
) -> None:
    half = (0.3, long, 0.5) if crossed else (long, 0.3, 0.5)
    bearing = yaw + QUARTER / 2 + odd * QUARTER + noise
    position = np.array([-10.0 * math.cos(bearing), -10.0 * math.sin(bearing), 1.0])
    framed, _, tie = contextualise(one_box(half, yaw), position)
    assert tie[0]
    assert tuple(framed.half[0, :2]) == (0.3, long)
    square, _, unsure = contextualise(one_box((long, long, 0.5), yaw), position)
    assert tuple(square.half[0, :2]) == (long, long)
    assert not unsure[0]
    along, marked = align_with_world(one_box(half, QUARTER / 2 + odd * QUARTER + noise))
    assert marked[0]
    assert tuple(along.half[0, :2]) == (0.3, long)


@given(
    yaw=st.floats(-7.0, 7.0),
    normal=st.sampled_from([0, 1]),
    thick=st.sampled_from([0.0, 0.05]),
    ahead=st.floats(-5.0, 5.0),
    aside=st.floats(-9.0, 9.0),
)
def test_a_walls_front_is_the_side_one_is_on(
    yaw: float, normal: int, thick: float, ahead: float, aside: float
) -> None:
    half = (thick, 2.0, 1.0) if normal == 0 else (2.0, thick, 1.0)
    across = yaw + normal * QUARTER
    cos, sin = math.cos(across), math.sin(across)
    position = np.array([ahead * cos - aside * sin, ahead * sin + aside * cos, 1.0])
    assume(abs(abs(ahead) - thick) > 1e-6)
    framed, clearance, tie = contextualise(one_box(half, yaw, normal), position)
    assert not tie[0]
    assert clearance[0] == pytest.approx(abs(ahead) - thick, abs=1e-9)
    if abs(ahead) > thick:
        toward = across if ahead > 0.0 else across + math.pi
        assert math.cos(framed.yaw[0] - toward) == pytest.approx(-1.0)
        assert tuple(framed.half[0, :2]) == (thick, 2.0)
        assert framed.normal[0] == 0


@given(world=worlds())
def test_clearance_is_the_way_to_the_footprint(world: World) -> None:
    some = world.scene().boxes
    signs = np.array([[1, 1], [-1, 1], [-1, -1], [1, -1]])
    for view in world.views:
        _, clearance, _ = contextualise(some, np.array(view["position"]))
        for center, half, yaw, normal, found in zip(
            some.center, some.half, some.yaw, some.normal, clearance, strict=True
        ):
            if normal in (0, 1):
                continue
            flat = turned(np.column_stack([signs * half[:2], np.zeros(4)]), yaw, center)[:, :2]
            outline, here = shapely.Polygon(flat), shapely.Point(view["position"][:2])
            edge = shapely.distance(shapely.linearrings(flat), here)
            inside = shapely.covers(outline, here)
            assert found == pytest.approx(-edge if inside else edge, abs=1e-9)


def test_within_a_footprint_and_over_a_centre_the_view_relations_are_withheld() -> None:
    from deixis.grounding import ground

    table, cup = box("table", (1, 2, 0.4), (1.2, 0.8, 0.8), 0.3), box("cup", (1.8, 2, 0.4), (0.1, 0.1, 0.1))
    cos, sin = math.cos(0.3), math.sin(0.3)
    for x, y, withheld in ((0.0, 0.0, True), (0.59, 0.39, True), (0.6, 0.1, True), (0.601, 0.1, False)):
        position = [1 + cos * x - sin * y, 2 + sin * x + cos * y, 9.0]
        facts = ground(scene(table, cup, views=[{"id": "v0", "position": position, "heading": 0.0}]))
        (view,) = facts.views[1:]
        assert ([facts.ids[at] for at, _ in view.withheld] == ["table"]) == withheld
        spoken = {facts.ids[facts.reference[row]] for row in view.rows}
        assert spoken == (set() if withheld else {"table"})
        assert np.isfinite(view.int_hs).all()
