"""The laws of the theory, over every relation, on random worlds; and what looks like a law and is none.

A law relates the answers in one world to those in another, so it needs no second opinion on what is true.
Every test runs twice: quickly, and (marked ``long``) as a campaign with the profile of that name.

Lengths are rounded to a nanometre (decision 0011). Worlds have whole millimetres, or lengths without any
pattern, and scales are small whole numbers or their halves: no bound is within a nanometre by design
without being met exactly.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from deixis.boxes import align_with_world, contextualise
from deixis.facts import Facts
from deixis.grounding import ground
from deixis.prolog import Atom, PrologEngine
from deixis.vocabulary import BASE, RELATIONS
from scenes import box, scene, turned
from worlds import Data, World, mirrored, moved, scaled, worlds, yaws

Row = tuple[str, ...]
Reason = Callable[..., set[Row]]
Answers = Callable[[World], set[Row]]

BASE_NAMES = tuple(term.name for term in BASE)
ALL_NAMES = (*BASE_NAMES, *(term.name for term in RELATIONS))
CARDINAL = {f"{side}_{kind}" for side in ("east", "west", "north", "south") for kind in ("r", "s")}
VIEWED = {term.name for term in RELATIONS if term.view} | {"withheld", "tie"}
"""What depends on where one stands, with the two notices that go with it."""

METRES = st.integers(-5000, 5000).map(lambda millimetres: millimetres / 1000)


@pytest.fixture(scope="module", params=["quick", pytest.param("long", marks=pytest.mark.long)], autouse=True)
def effort(request: pytest.FixtureRequest) -> str:
    """Run every law in the quick profile, and again among the tests that take minutes."""
    return str(request.param)


@pytest.fixture(scope="session")
def answers(reason: Reason) -> Answers:
    """Return a function from a world to all that holds in it, notices of views included."""

    def rows(world: World) -> set[Row]:
        it = world.scene()
        found = reason(it, *BASE_NAMES)
        for view in ground(it).views:
            found |= {("withheld", "", world.names[at], view.view) for at, _ in view.withheld}
            found |= {("tie", "", world.names[at], view.view) for at in view.ambiguous}
        return found

    return rows


def swapped(rows: set[Row], *pairs: tuple[str, str]) -> set[Row]:
    """Exchange the names of relations, pair by pair."""
    names = {old: new for one, other in pairs for old, new in ((one, other), (other, one))}
    return {(names.get(row[0], row[0]), *row[1:]) for row in rows}


def only(rows: set[Row], names: set[str]) -> set[Row]:
    return {row for row in rows if row[0] in names}


def apart_from(rows: set[Row], names: set[str]) -> set[Row]:
    return {row for row in rows if row[0] not in names}


LEFT_RIGHT = ("left_of", "right_of")
FRONT_BEHIND = ("in_front_of", "behind")


def test_the_worlds_show_every_relation(answers: Answers) -> None:
    seen: set[str] = set()

    @settings(max_examples=250)
    @given(worlds())
    def look(world: World) -> None:
        seen.update(row[0] for row in answers(world))

    look()
    assert seen >= {*ALL_NAMES, "withheld", "tie"}


# How a world lies on the map.


@given(world=worlds(), angle=yaws(), shift=st.tuples(METRES, METRES, METRES))
def test_turning_and_shifting_all_changes_nothing(
    answers: Answers, world: World, angle: float, shift: tuple[float, float, float]
) -> None:
    before, after = answers(world), answers(moved(world, angle, shift))
    assert upright(after) == upright(before)


def upright(rows: set[Row]) -> set[Row]:
    """Return what does not depend on the axes of the map."""
    return {row for row in rows if row[0] not in CARDINAL and row[-1] != "world"}


@given(world=worlds(), shift=st.tuples(METRES, METRES, METRES))
def test_shifting_all_changes_no_cardinal_direction(
    answers: Answers, world: World, shift: tuple[float, float, float]
) -> None:
    assert answers(moved(world, 0.0, shift)) == answers(world)


@given(world=worlds())
def test_a_thousand_kilometres_away_all_is_as_it_was(answers: Answers, world: World) -> None:
    assert answers(moved(world, 0.0, (1.0e6, -1.0e6, 1.0e5))) == answers(world)


@given(world=worlds(), height=METRES)
def test_the_origin_of_heights_changes_nothing(answers: Answers, world: World, height: float) -> None:
    assert answers(moved(world, 0.0, (0.0, 0.0, height))) == answers(world)


@given(world=worlds(), factor=st.sampled_from([0.25, 0.5, 2, 3, 4, 10]))
def test_the_unit_of_length_changes_nothing(answers: Answers, world: World, factor: float) -> None:
    larger = scaled(world, factor)
    # The nanometre does not scale: a bound that is all but met in one world is met in the other.
    assume(not any(nearly_met(ground(one.scene())) for one in (world, larger)))
    assert answers(larger) == answers(world)


def nearly_met(facts: Facts) -> bool:
    """Return whether a bound is missed, or exceeded, by a few nanometres."""
    limits = facts.thresholds
    bounds = np.array([limits.closeness, limits.granularity, -limits.penetration])
    margins = [
        facts.separation[:, None] - bounds,
        facts.protrusion - limits.granularity,
        facts.vertical,
        facts.vertical_strict,
        *(margin for view in facts.views for margin in (view.int_hs, view.cont_hs)),
    ]
    return any(((np.abs(margin) > 1.0e-12) & (np.abs(margin) < 1.0e-8)).any() for margin in margins)


@given(world=worlds())
def test_a_mirror_swaps_left_and_right_north_and_south(answers: Answers, world: World) -> None:
    swaps = (LEFT_RIGHT, ("north_r", "south_r"), ("north_s", "south_s"))
    before, after = swapped(answers(world), *swaps), answers(mirrored(world))
    # A level square seen at 45 degrees is the one thing whose sides a mirror may choose otherwise.
    square = {name for name, thing in zip(world.names, world.things, strict=True) if level_square(thing)}
    unsure = {row[2:] for row in before if row[0] == "tie" and row[2] in square}
    assert clear(after, unsure) == clear(before, unsure)


def level_square(thing: Data) -> bool:
    if thing.get("kind") != "surface":
        return False
    (row,) = scene(thing).boxes.half
    return bool(row[2] == row.min() and math.isclose(row[0], row[1], rel_tol=1.0e-6))


def clear(rows: set[Row], unsure: set[Row]) -> set[Row]:
    """Leave out what is said of some references in some views, the cardinal directions among them."""
    kept = {row for row in rows if row[2:] not in unsure or row[0] == "tie"}
    return {row for row in kept if row[0] not in CARDINAL or (row[2], "world") not in unsure}


@given(world=worlds())
def test_a_quarter_turn_of_the_map_passes_the_cardinal_directions_on(answers: Answers, world: World) -> None:
    before = answers(world)
    # Askew by 45 degrees a box could be laid along the map's axes either way.
    unsure = {row[2:] for row in before if row[0] == "tie"}
    following = dict(zip(("east", "north", "west", "south"), ("north", "west", "south", "east"), strict=True))
    after = answers(moved(world, math.pi / 2, (0.0, 0.0, 0.0)))
    expected = {(f"{following[row[0][:-2]]}{row[0][-2:]}", *row[1:]) for row in only(before, CARDINAL)}
    assert clear(only(after, CARDINAL), unsure) == clear(expected, unsure)


# Where one stands.


def around(world: World, place: Callable[[np.ndarray, np.ndarray], np.ndarray]) -> World:
    """Add for each thing and view another view, found from the view's position and the thing's centre."""
    centers = world.scene().boxes.center
    views = list(world.views)
    for name, center in zip(world.names, centers, strict=True):
        for view in world.views:
            old = np.array(view["position"])
            new = place(old[:2], center[:2])
            views.append({**view, "id": f"{view['id']} {name}", "position": [*new.tolist(), old[2]]})
    return replace(world, views=tuple(views))


def seen_from(world: World, rows: set[Row]) -> list[tuple[set[Row], set[Row]]]:
    """Return, of each thing in each view, the rows of the view and those of the view added for the thing."""
    viewed = only(rows, VIEWED)

    def of(reference: str, view: str) -> set[Row]:
        return {(row[0], row[1]) for row in viewed if row[2] == reference and row[3] == view}

    views = {view["id"].split()[0] for view in world.views}
    return [(of(name, view), of(name, f"{view} {name}")) for name in world.names for view in views]


@given(world=worlds())
def test_from_the_opposite_side_left_is_right_and_front_is_behind(answers: Answers, world: World) -> None:
    opposite = around(world, lambda old, center: 2.0 * center - old)
    for before, after in seen_from(opposite, answers(opposite)):
        assert after == swapped(before, LEFT_RIGHT, FRONT_BEHIND)


@given(world=worlds())
def test_a_quarter_of_the_way_round_each_side_follows_the_other(answers: Answers, world: World) -> None:
    quarter = around(world, lambda old, center: center + (old - center)[::-1] * np.array([-1.0, 1.0]))
    rows = answers(quarter)
    boxes = quarter.scene().boxes
    walls = {name for name, normal in zip(world.names, boxes.normal, strict=True) if normal in (0, 1)}
    sides = {"in_front_of": "left_of", "left_of": "behind", "behind": "right_of", "right_of": "in_front_of"}
    others = replace(quarter, things=tuple(thing for thing in world.things if thing["id"] not in walls))
    for before, after in seen_from(others, apart_from(rows, {"beside"})):
        # A choice between two turns is made anew by each view, and within a footprint there is none.
        if not only(before | after, {"withheld", "tie"}):
            assert after == {(sides[relation], figure) for relation, figure in before}


@given(world=worlds(), share=st.sampled_from([0.5, 0.9, 1.5, 4.0]))
def test_going_along_the_line_of_sight_changes_nothing(answers: Answers, world: World, share: float) -> None:
    along = around(world, lambda old, center: center + share * (old - center))
    for before, after in seen_from(along, answers(along)):
        if not only(before | after, {"withheld"}):
            assert after == before


@given(world=worlds(), heading=yaws())
def test_turning_on_the_spot_changes_nothing(answers: Answers, world: World, heading: float) -> None:
    views = tuple({**view, "heading": heading, "label": "you"} for view in world.views)
    assert answers(replace(world, views=views)) == answers(world)


@given(world=worlds())
def test_no_view_changes_another_nor_what_needs_none(answers: Answers, world: World) -> None:
    alone = answers(replace(world, views=()))
    assert all(row[-1] == "world" for row in only(alone, VIEWED))
    one, other = (answers(replace(world, views=(view,))) for view in world.views)
    here, there = (view["id"] for view in world.views)
    assert {row for row in one if here not in row} == {row for row in other if there not in row} == alone
    assert answers(world) == one | other


# What the things are called, and how many there are.


@given(world=worlds(), data=st.data())
def test_names_and_order_mean_nothing(answers: Answers, world: World, data: st.DataObject) -> None:
    order = data.draw(st.permutations(range(len(world.things))))
    names = dict(zip(world.names, ["Zoe's", "_", "w\u00e4nd", "[]", "9"], strict=False))
    things = tuple({**world.things[at], "id": names[world.names[at]]} for at in order)
    expected = {(row[0], names.get(row[1], ""), names[row[2]], *row[3:]) for row in answers(world)}
    assert answers(replace(world, things=things)) == expected


@given(world=worlds())
def test_a_thing_far_away_changes_nothing(answers: Answers, world: World) -> None:
    far = box("far", (7.0e4, 9.0e4, 3.0e4), (1.0, 2.0, 0.5), 0.3)
    rows = answers(replace(world, things=(far, *world.things)))
    assert {row for row in rows if "far" not in row} == answers(world)


@given(world=worlds(least=3))
def test_one_more_thing_takes_away_no_more_than_affixed_on(answers: Answers, world: World) -> None:
    more = answers(world)
    for name in world.names:
        fewer = answers(world.without(name))
        rest = {row for row in more if name not in row}
        negated = {"affixed_on", "leans_on"}
        assert apart_from(rest, negated) == apart_from(fewer, negated)
        assert only(rest, {"affixed_on"}) <= only(fewer, {"affixed_on"})
        assert only(rest, {"leans_on"}) >= only(fewer, {"leans_on"})


@given(world=worlds(surfaces=False))
def test_a_box_is_its_corners(answers: Answers, world: World) -> None:
    # Without extent in the plane there is no yaw to find again.
    assume(all(max(thing["box"]["size"][:2]) > 0.0 for thing in world.things))
    faces = [[a, b, c] for a in range(8) for b in range(a) for c in range(b)]
    for kind in ("points", "mesh"):
        things = []
        for thing in world.things:
            center, size, yaw = (thing["box"][key] for key in ("center", "size", "yaw"))
            signs = np.array([[a, b, c] for a in (-1, 1) for b in (-1, 1) for c in (-1, 1)])
            local = 0.5 * signs * size
            cos, sin = math.cos(yaw), math.sin(yaw)
            corners = (local @ np.array([[cos, sin, 0], [-sin, cos, 0], [0, 0, 1]]) + center).tolist()
            region = corners if kind == "points" else {"vertices": corners, "faces": faces}
            things.append({"id": thing["id"], "label": thing["label"], kind: region})
        assert answers(replace(world, things=tuple(things))) == answers(world)


# The thresholds.

BASE_SET = set(BASE_NAMES)


@given(world=worlds(), factor=st.sampled_from([1.001, 1.5, 4.0]))
def test_deeper_halfspaces_take_no_base_relation_away(answers: Answers, world: World, factor: float) -> None:
    limits = {**world.limits, "halfspace_scale": factor * world.limits["halfspace_scale"]}
    assert only(answers(replace(world, limits=limits)), BASE_SET) >= only(answers(world), BASE_SET)


@given(world=worlds(), more=st.sampled_from([0.001, 0.5, 3.0]))
def test_a_wider_nearness_adds_near_things_and_nothing_else(
    answers: Answers, world: World, more: float
) -> None:
    limits = {**world.limits, "closeness": more + world.limits["closeness"]}
    close = {"is_close", "near"}
    rows, wider = answers(world), answers(replace(world, limits=limits))
    assert only(wider, close) >= only(rows, close)
    assert apart_from(wider, close) == apart_from(rows, close)


# What the relations say of each other.


@given(world=worlds())
def test_how_the_relations_hang_together(answers: Answers, world: World) -> None:
    rows = answers(world)
    of = {name: {row[1:] for row in rows if row[0] == name} for name in ALL_NAMES}
    surfaces = {thing["id"] for thing in world.things if thing.get("kind") == "surface"}
    for name in ("touches", "is_close", "intersects"):
        assert of[name] == {(b, a) for a, b in of[name]}
    assert not of["touches"] & of["intersects"]
    assert of["touches"] | of["intersects"] <= of["is_close"]
    assert of["compl_cont"] <= of["intersects"]
    for side in ("east", "west", "north", "south", "above", "below"):
        assert of[f"{side}_s"] <= of[f"{side}_r"]
    assert of["beside"] == of["left_of"] | of["right_of"]
    assert of["on_top_of"] == of["above"] & of["touches"]
    assert of["above"] <= of["above_r"]
    assert of["below"] <= of["below_r"]
    assert of["near"] <= of["is_close"]
    assert of["inside"] <= {(content, container) for container, content in of["compl_cont"]}
    assert of["part_in"] <= of["intersects"]
    assert not of["part_in"] & {(b, a) for a, b in of["part_in"]}
    assert of["leans_on"] | of["affixed_on"] <= of["touches"]
    assert not of["on_top_of"] & (of["leans_on"] | of["affixed_on"])
    assert not of["leans_on"] & of["below"]
    for row in rows:
        if row[0] not in BASE_SET and row[1]:
            assert row[1] not in surfaces
            assert row[1] != row[2]
    # Of two things at least one is said to be near the other, unless both are surfaces.
    for a, b in of["is_close"]:
        assert {(a, b), (b, a)} & of["near"] or {a, b} <= surfaces


# Margins.


@given(world=worlds())
def test_what_holds_has_a_margin_that_is_not_negative(
    reason: Reason, engine: PrologEngine, world: World
) -> None:
    it = world.scene()
    rows = reason(it, *BASE_NAMES)
    wanted = [[Atom(term.name), term.arity] for term in (*BASE, *RELATIONS)]
    found: Any = engine.call("margins", *wanted)
    margins = {tuple(row[:-1]): row[-1] for row in found}
    assert set(margins) == rows
    assert all(margin is None or margin >= 0.0 for margin in margins.values())
    facts, limits = ground(it), it.thresholds
    for i, j, gap in zip(facts.figure, facts.reference, facts.separation, strict=True):
        pair = (facts.ids[i], facts.ids[j])
        close = limits.closeness - max(gap, 0.0)
        contact = min(limits.granularity - gap, gap + limits.penetration)
        deep = -limits.penetration - gap
        for name, margin in (("is_close", close), ("touches", contact), ("intersects", deep)):
            if (name, *pair) in rows:
                assert margins[name, *pair] == pytest.approx(margin, abs=1e-12)
            else:
                assert margin < 0.0 or (name == "intersects" and margin == 0.0)


@given(
    world=worlds(most=2, surfaces=False),
    direction=st.tuples(*[st.floats(-1.0, 1.0)] * 3),
    share=st.sampled_from([0.05, 0.5, 0.99]),
)
def test_a_move_shorter_than_the_margin_keeps_contact_and_nearness(
    world: World, direction: tuple[float, float, float], share: float
) -> None:
    length = math.hypot(*direction)
    assume(length > 1.0e-3)
    limits = world.scene().thresholds
    before = ground(world.scene())
    assume(len(before) == 2)
    gap, held = float(before.separation[0]), contained(before)
    margins = {
        "is_close": abs(gap - limits.closeness),
        "touches": min(abs(gap - limits.granularity), abs(gap + limits.penetration)),
        "intersects": abs(gap + limits.penetration),
    }
    for name, margin in margins.items():
        if margin < 1.0e-6:
            continue
        way = share * (margin - 1.0e-6) / length
        first = world.things[0]
        center = [c + way * step for c, step in zip(first["box"]["center"], direction, strict=True)]
        there = {**first, "box": {**first["box"], "center": center}}
        after = ground(replace(world, things=(there, *world.things[1:])).scene())
        if contained(after) == held:
            assert {*getattr(after, name)} == {*getattr(before, name)}


def contained(facts: Any) -> list[bool]:
    """Return which of a pair lies within the other up to D: the way out through its bottom may be closed."""
    return [bool(out <= facts.thresholds.granularity) for out in facts.protrusion]


@given(world=worlds(most=2), share=st.sampled_from([-0.99, -0.5, 0.05, 0.5, 0.99]))
def test_a_move_along_an_axis_shorter_than_the_margin_keeps_the_side(world: World, share: float) -> None:
    it = world.scene()
    before = ground(it)
    frames = [align_with_world(it.boxes)[0]]
    frames += [contextualise(it.boxes, view.position)[0] for view in it.views]
    for number, (view, framed) in enumerate(zip(before.views, frames, strict=True)):
        for row, margins in zip(view.rows, view.int_hs, strict=True):
            figure, reference = before.figure[row], before.reference[row]
            for column, margin in enumerate(margins):
                if abs(margin) < 1.0e-6:
                    continue
                angle = framed.yaw[reference] + column // 2 * math.pi / 2
                way = share * (abs(margin) - 1.0e-6)
                thing = turned(world.things[figure], 0.0, (way * math.cos(angle), way * math.sin(angle), 0.0))
                things = list(world.things)
                things[figure] = thing
                after = ground(replace(world, things=tuple(things)).scene())
                same = np.flatnonzero((after.figure == figure) & (after.reference == reference))
                # Beyond reach nothing is met; sunk deeper than contact, a side is what sticks out of it.
                if not len(same):
                    assert margin < 0.0
                elif after.intersects[same[0]] == before.intersects[row]:
                    there = after.views[number]
                    found = there.int_hs[np.flatnonzero(there.rows == same[0])[0], column]
                    assert (found >= 0.0) == (margin >= 0.0)


# What looks like a law and is none: one counter-example each.

SQUARE_ON = {"id": "v0", "label": "robot", "position": [-9.0, 0.0, 0.5], "heading": 0.0}
CUBE = box("cube", (0, 0, 0.5), (1, 1, 1))


@pytest.mark.parametrize(
    ("relation", "inverse", "plank"),
    [
        ("left_of", "right_of", box("plank", (0, 1.4, 0.5), (5, 0.2, 1))),
        ("behind", "in_front_of", box("plank", (1.4, 0, 0.5), (0.2, 5, 1))),
        ("above", "below", box("plank", (0, 0, 2.1), (5, 1, 0.2))),
    ],
)
def test_opposite_relations_are_no_inverses(reason: Reason, relation: str, inverse: str, plank: Data) -> None:
    rows = reason(scene(CUBE, plank, views=[SQUARE_ON]))
    view = () if relation == "above" else ("v0",)
    # The plank is as large as the cube, and thinner: it lies in what the cube spreads, not the other way.
    assert (relation, "plank", "cube", *view) in rows
    assert (inverse, "cube", "plank", *view) not in rows


def test_opposite_relations_do_not_exclude_each_other(reason: Reason) -> None:
    rows = reason(scene(CUBE, box("pole", (0, 0, 0.5), (0.1, 3, 0.1)), views=[SQUARE_ON]))
    assert {("left_of", "pole", "cube", "v0"), ("right_of", "pole", "cube", "v0")} <= rows


def test_not_everything_near_is_on_some_side(reason: Reason) -> None:
    rows = reason(scene(CUBE, box("ball", (0.8, 0.8, 1.3), (0.2, 0.2, 0.2)), views=[SQUARE_ON]))
    assert rows == {("near", "ball", "cube")}


def test_up_and_down_cannot_be_exchanged(reason: Reason) -> None:
    # What lies at the bottom of a box is in it; as close to its lid, it touches it from within.
    box_of, sheet = (0, 0, 0.5), (0.5, 0.5, 0.02)
    low = reason(scene(box("box", box_of, (1, 1, 1)), box("sheet", (0, 0, 0.02), sheet)))
    high = reason(scene(box("box", box_of, (1, 1, 1)), box("sheet", (0, 0, 0.98), sheet)))
    assert ("inside", "sheet", "box") in low
    assert ("on_top_of", "sheet", "box") in high


def test_a_margin_of_contact_does_not_foresee_the_way_out_through_the_bottom() -> None:
    # Two centimetres sideways, and the knife no longer lies within the drawer: then it hangs through it.
    def separation(aside: float) -> float:
        knife = box("knife", (0.11 + aside, 0, 0.74), (0.2, 0.03, 0.03))
        facts = ground(scene(box("drawer", (0, 0, 0.8), (0.4, 0.4, 0.15)), knife))
        return float(facts.separation[0])

    assert separation(0.0) == pytest.approx(-0.15)
    assert separation(0.02) == pytest.approx(-0.03)


@pytest.mark.parametrize("shift", [(0.0, 0.0, 0.0), (12.0, -7.0, 3.0)])
@pytest.mark.parametrize("down", [0.0, 1.0e-16, -1.0e-16])
def test_a_sheet_in_the_very_plane_of_the_bottom_touches(shift: tuple[float, ...], down: float) -> None:
    """No thickness, the height of the bottom itself: rounding must not turn contact into overlap."""
    x, y, z = shift
    facts = ground(
        scene(
            box("chest", (x, y, z + 1.082), (1, 1, 0.466)),
            box("sheet", (x + 0.1, y, z + 0.849 + down), (0.3, 0.2, 0.0)),
        )
    )
    row = facts.row("chest", "sheet")
    assert row is not None
    assert (facts.touches[row], facts.intersects[row], facts.separation[row]) == (True, False, 0.0)
