"""The kernel against second opinions: shapely, exact fractions, point sets, and its own turned image."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
import pytest
import shapely
from numpy.typing import NDArray

from deixis import halfspaces, measures
from deixis.boxes import NO_NORMAL, Boxes, contextualise
from deixis.broadphase import candidate_rows
from deixis.frames import QUARTER
from deixis.grounding import ground, measure_pairs
from deixis.thresholds import Thresholds
from scenes import box, scene
from worlds import TRIPLES

Array = NDArray[np.float64]

PAIRS = 4000
LIMITS = Thresholds()
D, P = LIMITS.granularity, LIMITS.penetration


def boxes(center: Array, half: Array, yaw: Array) -> Boxes:
    n = len(yaw)
    return Boxes(center, half, yaw, np.full(n, NO_NORMAL), np.zeros(n, dtype=bool))


def random_boxes(rng: np.random.Generator, count: int, spread: float = 0.35) -> Boxes:
    """Return boxes near the origin: blocks, rods, sheets, points, a fifth of them square to the axes."""
    half = np.exp(rng.uniform(np.log(0.02), np.log(0.8), (count, 3)))
    half[rng.random((count, 3)) < 0.05] = 0.0
    yaw = rng.uniform(-4.0, 4.0, count)
    yaw = np.where(rng.random(count) < 0.2, np.round(yaw) * QUARTER, yaw)
    return boxes(rng.uniform(-spread, spread, (count, 3)), half, yaw)


def random_pairs(seed: int) -> tuple[Boxes, Boxes]:
    rng = np.random.default_rng(seed)
    return random_boxes(rng, PAIRS), random_boxes(rng, PAIRS)


def agree(found: Array, expected: Array, within: float = 1e-12) -> None:
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=within)


def corners(some: Boxes, half: Array | None = None) -> Array:
    """Return the plan corners in the world frame, counter-clockwise, (n, 4, 2)."""
    half = some.half if half is None else half
    signs = np.array([[1, 1], [-1, 1], [-1, -1], [1, -1]])
    local = signs * half[:, None, :2]
    cos, sin = np.cos(some.yaw)[:, None], np.sin(some.yaw)[:, None]
    x, y = local[..., 0], local[..., 1]
    return np.stack([cos * x - sin * y, sin * x + cos * y], axis=2) + some.center[:, None, :2]


def plans(some: Boxes, half: Array | None = None) -> Array:
    return np.asarray(shapely.polygons(corners(some, half)))


def in_frame(points: Array, reference: Boxes) -> Array:
    """Return world points (n, m, 2) in the frames of n references."""
    offset = points - reference.center[:, None, :2]
    cos, sin = np.cos(reference.yaw)[:, None], np.sin(reference.yaw)[:, None]
    x, y = offset[..., 0], offset[..., 1]
    return np.stack([cos * x + sin * y, cos * y - sin * x], axis=2)


# Two boxes, against shapely and points.


def test_plan_areas_and_outlines_are_shapely_s() -> None:
    a, b = random_pairs(1)
    there = measures.place(a, b)
    one, other = plans(a), plans(b)
    area = shapely.area(shapely.intersection(one, other))
    assert (area > 0.0).mean() > 0.3
    agree(measures.plan_area(there, a.half, b.half), area)
    # Shapely's rings of flat rectangles run there and back, as ours do.
    rings = shapely.linestrings(np.concatenate([corners(a), corners(a)[:, :1]], axis=1))
    solid = (a.half[:, :2] > 0.0).all(axis=1) & (b.half[:, :2] > 0.0).all(axis=1)
    length = shapely.length(shapely.intersection(rings, other))
    inside = measures.perimeter_inside(there, a.half, b.half)
    agree(inside[solid], length[solid], 1e-9)


def test_intersections_and_frontiers_are_shapely_s_slice_by_slice() -> None:
    a, b = random_pairs(2)
    there = measures.place(a, b)
    low = np.maximum(a.center[:, 2] - a.half[:, 2], b.center[:, 2] - b.half[:, 2])
    high = np.minimum(a.center[:, 2] + a.half[:, 2], b.center[:, 2] + b.half[:, 2])
    area = shapely.area(shapely.intersection(plans(a), plans(b)))
    volume = measures.intersection_volume(there, a.half, b.half)
    agree(volume, area * np.maximum(high - low, 0.0))

    # The figure's faces that run at least D/2 within the reference: four sides and two ends.
    inner = np.maximum(b.half - D / 2, 0.0)
    solid = (a.half[:, :2] > 0.0).all(axis=1) & (inner > 0.0).all(axis=1)
    core = plans(b, inner)
    rings = shapely.linestrings(np.concatenate([corners(a), corners(a)[:, :1]], axis=1))
    bottom, top = a.center[:, 2] - a.half[:, 2], a.center[:, 2] + a.half[:, 2]
    floor, ceiling = b.center[:, 2] - inner[:, 2], b.center[:, 2] + inner[:, 2]
    sides = shapely.length(shapely.intersection(rings, core))
    sides *= np.maximum(np.minimum(top, ceiling) - np.maximum(bottom, floor), 0.0)
    ends = shapely.area(shapely.intersection(plans(a), core))
    ends *= sum(((level >= floor) & (level <= ceiling)).astype(float) for level in (bottom, top))
    found = measures.surface_inside(there, a.half, b.half, D)
    assert ((sides + ends)[solid] > 0.0).mean() > 0.2
    agree(found[solid], (sides + ends)[solid], 1e-7)


def test_distances_are_shapely_s_and_depths_those_of_minkowski() -> None:
    a, b = random_pairs(3)
    there = measures.place(a, b)
    tall = a.half[:, 2] + b.half[:, 2]
    signed, normal = measures.separation(there, a.half, b.half, tall - there.z, tall + there.z)
    level = shapely.distance(plans(a), plans(b))
    upright = np.maximum(np.abs(there.z) - tall, 0.0)
    distance = np.hypot(level, upright)
    apart = distance > 1.0e-9
    assert 0.2 < apart.mean() < 0.8
    agree(signed[apart], distance[apart])
    # Overlapping plans: how deep the origin lies in the difference of the two, a convex polygon.
    differences = corners(a)[:, :, None] - corners(b)[:, None, :]
    hulls = shapely.convex_hull(shapely.multipoints(differences.reshape(PAIRS, 16, 2)))
    depth = shapely.distance(shapely.boundary(hulls), shapely.Point(0.0, 0.0))
    deepest = np.minimum(depth, tall - np.abs(there.z))
    agree(-signed[~apart], deepest[~apart], 1e-9)
    # The normal is a direction, and the way by which the two come to touch.
    agree(np.hypot(np.hypot(*normal[:, :2].T), normal[:, 2]), 1.0)
    cos, sin = np.cos(b.yaw), np.sin(b.yaw)
    step = np.stack([cos * normal[:, 0] - sin * normal[:, 1], sin * normal[:, 0] + cos * normal[:, 1]])
    met = boxes(a.center - signed[:, None] * np.stack([*step, normal[:, 2]], axis=1), a.half, a.yaw)
    there = measures.place(met, b)
    left, _ = measures.separation(there, a.half, b.half, tall - there.z, tall + there.z)
    agree(left, 0.0, 1e-9)


def test_protrusion_is_that_of_the_farthest_of_many_points() -> None:
    a, b = random_pairs(4)
    rng = np.random.default_rng(44)
    found = measures.protrusion(measures.place(a, b), a.half, b.half)
    # Convex: no point of a box sticks out further than its corners.
    weights = rng.dirichlet(np.ones(4) * 0.3, (PAIRS, 50))
    weights[:, :4] = np.eye(4)
    local = np.abs(in_frame(weights @ corners(a), b)) - b.half[:, None, :2]
    height = np.abs(a.center[:, 2] - b.center[:, 2]) + a.half[:, 2] - b.half[:, 2]
    out = np.maximum(local.max(axis=(1, 2)), height)
    agree(found, out)


def test_horizontal_halfspaces_are_their_definition() -> None:
    """A figure meets a halfspace as kb/conventions.md has it, with the strip cut out by shapely."""
    a, b = random_pairs(5)
    rng = np.random.default_rng(55)
    # A quarter of them thin and flush: a sheet on a thin wall is on one side of it.
    flush, axis = rng.random(PAIRS) < 0.25, int(rng.integers(2))
    cos, sin = np.cos(b.yaw), np.sin(b.yaw)
    across = rng.uniform(-0.03, 0.03, PAIRS)[:, None] * np.stack(
        [cos, sin, 0 * cos] if axis == 0 else [-sin, cos, 0 * cos], axis=1
    )
    for some in (a, b):
        some.half[flush, axis] = rng.uniform(0.0, 0.02, flush.sum())
    a = boxes(np.where(flush[:, None], b.center + across, a.center), a.half, np.where(flush, b.yaw, a.yaw))
    normal = rng.choice([NO_NORMAL, NO_NORMAL, 0, 1, 2], PAIRS)
    apart = rng.choice([-1.0, 0.0], PAIRS)
    there = measures.place(a, b)
    relaxed, strict = halfspaces.meets_horizontal(there, a.half, b.half, normal, apart, LIMITS)
    thick_a, thick_b = np.maximum(a.half, D / 2), np.maximum(b.half, D / 2)
    figure = in_frame(corners(a, thick_a), b)
    for column, (axis, side) in enumerate(((0, 1), (0, -1), (1, 1), (1, -1))):
        points = figure if axis == 0 else figure[..., ::-1]
        points = points * np.array([side, 1.0])
        along, across = points[..., 0], points[..., 1]
        width, face = thick_b[:, 1 - axis], b.half[:, axis]
        depth = np.where(normal == axis, np.inf, 2 * LIMITS.halfspace_scale * thick_b[:, axis])
        core = np.maximum(width - D / 2, 0.0)
        strips = shapely.box(-9.0, -core - 1e-9, 9.0, core + 1e-9)
        cut = shapely.bounds(shapely.intersection(shapely.polygons(points), strips))
        near, far = cut[:, 0], cut[:, 2]
        level = np.minimum(width, across.max(axis=1)) - np.maximum(-width, across.min(axis=1)) >= D / 2
        tall_a = a.center[:, 2, None] + thick_a[:, 2, None] * np.array([-1, 1])
        tall_b = b.center[:, 2, None] + thick_b[:, 2, None] * np.array([-1, 1])
        upright = np.minimum(tall_a[:, 1], tall_b[:, 1]) - np.maximum(tall_a[:, 0], tall_b[:, 0]) >= D / 2
        beyond = (near >= face - D) & (along.mean(axis=1) >= 0.0) & (apart >= -P)
        meets = level & upright & (beyond | (far >= face + D)) & (near <= face + depth)
        out = np.maximum(
            np.abs(across).max(axis=1) - width,
            np.abs(tall_a - b.center[:, 2, None]).max(axis=1) - thick_b[:, 2],
        )
        within = (out <= D) & (along.min(axis=1) >= face - D) & (along.max(axis=1) <= face + depth + D)
        sure = np.abs(relaxed[:, column]) > 1e-6
        assert 0.02 < meets[sure].mean() < 0.9
        np.testing.assert_array_equal(relaxed[sure, column] >= 0.0, meets[sure])
        sure &= np.abs(strict[:, column]) > 1e-6
        np.testing.assert_array_equal(strict[sure, column] >= 0.0, (meets & within)[sure])


def test_vertical_halfspaces_are_their_definition() -> None:
    a, b = random_pairs(6)
    rng = np.random.default_rng(66)
    # Near the contact, where most of the cases are.
    level = rng.choice([-1.0, 1.0], PAIRS) * (a.half[:, 2] + b.half[:, 2]) + rng.uniform(-0.06, 0.06, PAIRS)
    usual = rng.random(PAIRS) < 0.3
    height = np.where(usual, a.center[:, 2], b.center[:, 2] + level)
    a = boxes(np.column_stack([a.center[:, :2], height]), a.half, a.yaw)
    normal = rng.choice([NO_NORMAL, 0, 2], PAIRS)
    there = measures.place(a, b)
    neither = np.zeros(PAIRS, dtype=bool)
    up, down = measures.vertical_escapes(there, a.half, b.half, neither, normal != NO_NORMAL, D)
    signed, _ = measures.separation(there, a.half, b.half, up, down)
    relaxed, strict = halfspaces.meets_vertical(there, a.half, b.half, normal, signed, up, down, LIMITS)

    thick_a, thick_b = np.maximum(a.half, D / 2), np.maximum(b.half, D / 2)
    figure = corners(a, thick_a)
    differences = figure[:, :, None] - corners(b, thick_b)[:, None, :]
    hulls = shapely.convex_hull(shapely.multipoints(differences.reshape(PAIRS, 16, 2)))
    origin = shapely.Point(0.0, 0.0)
    shared = shapely.distance(shapely.boundary(hulls), origin) * np.where(
        shapely.covers(hulls, origin), 1, -1
    )
    out = (np.abs(in_frame(figure, b)) - thick_b[:, None, :2]).max(axis=(1, 2))
    touching = (signed >= -P) & (signed <= D)
    assert 0.1 < touching.mean() < 0.9
    for column, (side, way, back) in enumerate(((1.0, up, down), (-1.0, down, up))):
        bottom = side * (a.center[:, 2] - b.center[:, 2]) - a.half[:, 2]
        top, face = bottom + 2 * a.half[:, 2], b.half[:, 2]
        depth = np.where(normal == 2, np.inf, 2 * LIMITS.halfspace_scale * thick_b[:, 2])
        beyond = (top >= face + D) | ((bottom >= face - D) & (signed >= -P))
        facing = (way <= P) & (way <= back) & (way <= shared)
        meets = (shared >= D / 2) & np.where(touching, facing, beyond) & (bottom <= face + depth)
        within = (out <= D) & (bottom >= face - D) & (top <= face + depth + D)
        sure = np.abs(relaxed[:, column]) > 1e-6
        assert 0.1 < meets[sure].mean() < 0.9
        np.testing.assert_array_equal(relaxed[sure, column] >= 0.0, meets[sure])
        sure &= np.abs(strict[:, column]) > 1e-6
        np.testing.assert_array_equal(strict[sure, column] >= 0.0, (meets & within)[sure])


# Two boxes, exactly.

Exact = tuple[tuple[int, int, int], tuple[int, int, int], tuple[Fraction, Fraction]]
"""Centre and half extents in whole millimetres, cosine and sine as fractions."""


def exact_boxes(rng: np.random.Generator, count: int) -> list[Exact]:
    result: list[Exact] = []
    for _ in range(count):
        c, s, whole = TRIPLES[rng.integers(len(TRIPLES))]
        if rng.integers(3) == 0:
            c, s, whole = 1, 0, 1
        if rng.integers(2):
            c, s = -s, c
        center = tuple(int(v) for v in rng.integers(-30, 31, 3) * 5)
        half = tuple(int(v) for v in rng.choice([0, 5, 20, 50, 120, 200, 200], 3))
        result.append((center, half, (Fraction(c, whole), Fraction(s, whole))))
    return result


def exact_separation(a: Exact, b: Exact) -> tuple[Fraction, bool]:
    """Return the squared distance, or 0 and whether the two overlap in more than their outlines."""
    (x, y, z), (cos, sin) = (p - q for p, q in zip(a[0], b[0], strict=True)), b[2]
    at = (cos * x + sin * y, cos * y - sin * x)
    turn = (a[2][0] * cos + a[2][1] * sin, a[2][1] * cos - a[2][0] * sin)
    gap_z = abs(z) - a[1][2] - b[1][2]
    from_b = _exact_plan(at, turn, a[1], b[1])
    back = (-(turn[0] * at[0] + turn[1] * at[1]), turn[1] * at[0] - turn[0] * at[1])
    from_a = _exact_plan(back, (turn[0], -turn[1]), b[1], a[1])
    squared = max(gap_z, 0) ** 2 + (min(from_b[0], from_a[0]) if max(from_b[1], from_a[1]) > 0 else 0)
    return Fraction(squared), gap_z < 0 and max(from_b[1], from_a[1]) < 0


def _exact_plan(
    at: tuple[Fraction, Fraction],
    turn: tuple[Fraction, Fraction],
    half_a: tuple[int, ...],
    half_b: tuple[int, ...],
) -> tuple[Fraction, Fraction]:
    """Return the least squared distance from a corner of the figure, and the widest gap along b's axes."""
    points = [
        (
            at[0] + i * half_a[0] * turn[0] - j * half_a[1] * turn[1],
            at[1] + i * half_a[0] * turn[1] + j * half_a[1] * turn[0],
        )
        for i in (1, -1)
        for j in (1, -1)
    ]
    squared = min(sum(max(abs(p[k]) - half_b[k], 0) ** 2 for k in (0, 1)) for p in points)
    gap = max(
        max(min(p[k] for p in points) - half_b[k], -half_b[k] - max(p[k] for p in points)) for k in (0, 1)
    )
    return Fraction(squared), gap


def test_what_touches_overlaps_and_is_apart_is_decided_as_in_whole_numbers() -> None:
    rng = np.random.default_rng(7)
    a, b = exact_boxes(rng, 2500), exact_boxes(rng, 2500)
    # Half of them are pushed until they meet along an axis of one of the two.
    for at in range(0, 2500, 2):
        b[at] = (b[at][0], b[at][1], (Fraction(1), Fraction(0)))
        half, (cos, sin) = a[at][1], a[at][2]
        own = (
            half[0] * abs(cos) + half[1] * abs(sin),
            half[0] * abs(sin) + half[1] * abs(cos),
            Fraction(half[2]),
        )
        axis, side = int(rng.integers(3)), int(rng.choice([-1, 1]))
        center = [Fraction(c) for c in a[at][0]]
        center[axis] = b[at][0][axis] + side * (b[at][1][axis] + own[axis])
        a[at] = (tuple(center), half, a[at][2])

    def floats(some: list[Exact]) -> Boxes:
        center = np.array([[float(c / Fraction(1000)) for c in map(Fraction, one[0])] for one in some])
        half = np.array([one[1] for one in some]) / 1000
        return boxes(center, half, np.array([math.atan2(one[2][1], one[2][0]) for one in some]))

    first, second = floats(a), floats(b)
    there = measures.place(first, second)
    tall = first.half[:, 2] + second.half[:, 2]
    signed, _ = measures.separation(there, first.half, second.half, tall - there.z, tall + there.z)
    exact = [exact_separation(one, other) for one, other in zip(a, b, strict=True)]
    apart = np.array([float(squared) ** 0.5 / 1000 for squared, _ in exact])
    deep = np.array([overlaps for _, overlaps in exact])
    agree(np.maximum(signed, 0.0), apart, 1e-12)
    assert (signed[deep] < -1e-9).all()
    assert 200 < deep.sum() < 2000
    met = ~deep & (apart == 0.0)
    assert met.sum() > 200
    agree(signed[met], 0.0)


def contacts(rng: np.random.Generator, count: int) -> tuple[Boxes, Boxes]:
    """Return pairs that meet in a face, an edge or a vertex, each pair turned as one by any angle."""
    half_a, half_b = rng.integers(1, 800, (2, count, 3)) / 1000
    side = rng.choice([-1, 1], (count, 3))
    meets = rng.random((count, 3)) < 0.5
    meets[np.arange(count), rng.integers(0, 3, count)] = True
    whole = half_a + half_b
    offset = side * np.where(meets, whole, rng.integers(0, 1000, (count, 3)) / 1000 * whole * 0.9)
    angle = rng.uniform(-np.pi, np.pi, count)
    cos, sin = np.cos(angle), np.sin(angle)
    shift = rng.uniform(-20.0, 20.0, (count, 3))
    turned_x, turned_y = cos * offset[:, 0] - sin * offset[:, 1], sin * offset[:, 0] + cos * offset[:, 1]
    quarter = rng.integers(0, 4, count)
    swapped = np.where((quarter % 2 == 1)[:, None], half_a[:, [1, 0, 2]], half_a)
    figure = boxes(
        shift + np.stack([turned_x, turned_y, offset[:, 2]], axis=1), swapped, angle + quarter * QUARTER
    )
    return figure, boxes(shift, half_b, angle)


def test_all_of_ten_thousand_turned_contacts_are_found() -> None:
    figure, reference = contacts(np.random.default_rng(8), 10_000)
    both = joined(figure, reference)
    index = np.arange(10_000)
    pairs = measure_pairs(
        both, np.concatenate([index, index + 10_000]), np.concatenate([index + 10_000, index]), LIMITS
    )
    assert len(pairs.figure) == 20_000
    assert (pairs.separation == 0.0).all()


def joined(*some: Boxes) -> Boxes:
    names = ("center", "half", "yaw", "normal", "ambiguous")
    return Boxes(*(np.concatenate([getattr(one, name) for one in some]) for name in names))


# Which pairs are looked at.


def test_no_pair_that_anything_is_said_of_is_left_out() -> None:
    rng = np.random.default_rng(9)
    # More things than are compared all with all, and fewer.
    for count in (60, 400):
        some = random_boxes(rng, count, spread=2.5)
        figure, reference = (index[~np.eye(count, dtype=bool)] for index in np.indices((count, count)))
        every = measure_pairs(some, figure, reference, LIMITS)
        found = measure_pairs(some, *candidate_rows(some, LIMITS), LIMITS)
        assert len(found.figure) < len(figure)
        np.testing.assert_array_equal(found.figure, every.figure)
        np.testing.assert_array_equal(found.reference, every.reference)
        # And what is left out meets no halfspace, from wherever one looks.
        kept = set(zip(found.figure.tolist(), found.reference.tolist(), strict=True))
        left = np.array([pair not in kept for pair in zip(figure.tolist(), reference.tolist(), strict=True)])
        volume = some.volume(D)
        left &= volume[reference] >= volume[figure]
        for position in ([-4.0, 0.3, 1.0], [3.0, 5.0, 1.0]):
            framed, _, _ = contextualise(some, np.array(position))
            a, b = some.take(figure[left]), framed.take(reference[left])
            there = measures.place(a, b)
            relaxed, _ = halfspaces.meets_horizontal(there, a.half, b.half, b.normal, np.ones(len(a)), LIMITS)
            assert (relaxed < 0.0).all()


@pytest.mark.parametrize("bound", ["closeness", "depth"])
def test_a_pair_just_within_reach_is_measured_wherever_it_stands(bound: str) -> None:
    rng = np.random.default_rng(10)
    missed = 0
    for _ in range(300):
        near = bound == "closeness"
        half = int(rng.integers(100, 400) if near else rng.integers(450, 900)) / 1000
        gap = LIMITS.closeness if near else round(2 * LIMITS.halfspace_scale * half, 6)
        low = box("low", rng.uniform(-9.0, 9.0, 3).round(3).tolist(), (0.02, 0.02, 2 * half))
        x, y, z = low["box"]["center"]
        high = box("high", (x, y, z + half + gap + 0.005), (0.01, 0.01, 0.01))
        facts = ground(scene(low, high))
        row = facts.row("high", "low")
        missed += row is None or not (facts.is_close[row] if near else facts.vertical[row, 0] >= 0.0)
    assert missed == 0
