"""What would be otherwise: each change found is tried on the scene itself; none along an axis is smaller.

Unless the thing would collide there with another.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from deixis.counterfactual import FURTHEST, Change, moved
from deixis.errors import GeometryError, QueryError, SceneError
from deixis.facts import Facts
from deixis.grounding import ground
from deixis.knowledge import KnowledgeBase
from deixis.relations import Relation
from deixis.scene import Scene
from scenes import box, scene


@pytest.fixture(scope="module")
def hans(root: Path) -> KnowledgeBase:
    return KnowledgeBase.from_scene(root / "kb" / "scenes" / "hans.json")


def holds(kb: KnowledgeBase, goal: str) -> bool:
    name = goal.partition("(")[0]
    args = tuple(goal.partition("(")[2].removesuffix(")").split(", "))
    found = {
        (one.figure, one.reference, *([one.view] if one.view else []))
        for one in kb.relations(relation=[name])
    }
    return args in found


def after(kb: KnowledgeBase, change: Change, part: float = 1.0) -> KnowledgeBase:
    """Return the scene after a part of a change, grounded from the start."""
    return KnowledgeBase(moved(kb.scene, {change.thing: part * np.array(change.offset)}))


@pytest.mark.parametrize(
    ("goal", "distance", "way"),
    [
        ("on_top_of(sweater, heater)", 0.02, (0, 0, 1)),
        ("affixed_on(extinguisher1, wall)", 0.02, (0, -1, 0)),
        # Lifted off the floor it no longer leans: it hangs.
        ("leans_on(extinguisher2, wall)", 0.02, (0, 0, 1)),
        ("affixed_on(extinguisher2, wall)", 0.02, (0, 0, 1)),
        ("inside(sweater, heater)", 0.04, (0, 0, -1)),
        ("near(sweater, floor)", 0.4, (0, 0, 1)),
        ("left_of(extinguisher2, radiator, v0)", 0.0837, None),
        ("near(sign, extinguisher2)", None, None),
        # Over, along and up at once.
        ("on_top_of(sweater, radiator)", None, None),
        # Straight down is 58 cm, into the heater.
        ("on_top_of(sweater, floor)", None, None),
    ],
)
def test_what_changes_an_answer(
    hans: KnowledgeBase, goal: str, distance: float | None, way: tuple[float, ...] | None
) -> None:
    change = hans.change(goal)
    assert change is not None
    assert change.distance == pytest.approx(np.linalg.norm(change.offset))
    assert change.holds != holds(hans, goal)
    assert holds(after(hans, change), goal) == change.holds
    assert holds(after(hans, change, 0.9), goal) != change.holds
    if distance is not None:
        assert change.distance == pytest.approx(distance, abs=2e-4)
    if way is not None:
        assert np.allclose(np.array(change.offset) / change.distance, way, atol=1e-6)


def test_no_smaller_change_along_an_axis(root: Path) -> None:
    kb = KnowledgeBase.from_scene(root / "kb" / "scenes" / "kitchen.json")
    rng = np.random.default_rng(0)
    found = kb.relations()
    for at in rng.choice(len(found), 12, replace=False):
        one = found[at]
        goal = one.to_prolog()
        change = kb.change(goal)
        if change is None:
            continue
        assert change.distance <= FURTHEST + 1e-3
        for axis in np.concatenate([np.eye(3), -np.eye(3)]):
            offset = axis * (change.distance - 0.002)
            if change.distance > 0.004:
                other = KnowledgeBase(moved(kb.scene, {change.thing: offset}))
                assert stays(one, other) or new_company(kb, other, change.thing), (goal, change, offset)


def new_company(kb: KnowledgeBase, other: KnowledgeBase, thing: str) -> set[str]:
    """Return what a thing shares space with in another scene and does not in this one."""
    now, then = (
        {facts.ids[one] for one in facts.reference[overlaps(facts, thing)]}
        for facts in (kb.facts, other.facts)
    )
    return then - now


def overlaps(facts: Facts, thing: str) -> np.ndarray:
    figure = facts.figure == facts.ids.index(thing)
    return figure & (facts.separation < -facts.thresholds.penetration)


def stays(one: Relation, kb: KnowledgeBase) -> bool:
    return any(
        (one.figure, one.reference, one.view) == (other.figure, other.reference, other.view)
        for other in kb.relations(relation=[one.relation])
    )


def test_nothing_near_enough_changes_it() -> None:
    far = scene(box("a", (0, 0, 0), (0.1, 0.1, 0.1)), box("b", (50, 0, 0), (1, 1, 1)))
    assert KnowledgeBase(far).change("on_top_of(a, b)") is None


def test_rules_of_ones_own_can_be_asked_about(tmp_path: Path, hans: KnowledgeBase) -> None:
    mine = tmp_path / "mine.pl"
    mine.write_text("singed(A, B) :- distance(A, B, D), D =< 0.3, \\+ surface(A), \\+ surface(B).\n")
    kb = KnowledgeBase(hans.scene, rules=[mine])
    change = kb.change("singed(sweater, radiator)")
    assert change is not None
    assert change.holds
    now = after(kb, change).facts
    row = now.row("sweater", "radiator")
    assert row is not None
    assert 0.299 < now.distance[row] <= 0.3


def test_what_rules_name_is_not_said_to_change_nothing(tmp_path: Path) -> None:
    """Rules that say something of a thing by its name do not say it of its copies at other places."""
    mine = tmp_path / "mine.pl"
    mine.write_text(
        "frail(cup).\nrisk(A, B) :- near(A, B), frail(A).\n"
        "other(A, B) :- near(A, B), \\+ frail(A).\nbut(A, B) :- near(A, B), A \\== cup.\n"
        "called(A, B) :- label(A, cup, _), near(A, B).\n"
    )
    apart = scene(*(box(name, (x, 0, 0), (0.1, 0.1, 0.1)) for name, x in (("cup", 0), ("jug", 2))))
    kb = KnowledgeBase(apart, rules=[mine])
    for goal in ("risk(cup, jug)", "other(cup, jug)", "but(cup, jug)"):
        with pytest.raises(QueryError, match="nothing was found, but rules name 'cup'"):
            kb.change(goal)
    # A label of the same name is no matter.
    for goal in ("other(jug, cup)", "called(cup, jug)", "near(cup, jug)"):
        change = kb.change(goal)
        assert change is not None
        assert change.holds


def test_a_change_may_hang_on_what_other_things_are_to_one_another(tmp_path: Path) -> None:
    """The answer for a thing that moves is derived through things that stay where they are."""
    stack = scene(
        box("table", (0, 0, 0.5), (1, 1, 1)),
        box("tray", (0, 0, 1.02), (0.6, 0.6, 0.04)),
        box("cup", (0, 0, 1.09), (0.1, 0.1, 0.1)),
    )
    kb = KnowledgeBase(stack, rules=["support"])
    change = kb.change("supported_by(cup, table)")
    assert change is not None
    assert (change.holds, change.thing) == (False, "cup")
    assert change.distance == pytest.approx(0.02, abs=2e-4)
    lonely = tmp_path / "lonely.pl"
    lonely.write_text(
        "lonely(X) :- spatial_obj(X), \\+ touches(X, _).\ncalm(X, Y) :- near(X, Y), \\+ lonely(Y).\n"
    )
    calm = KnowledgeBase(stack, rules=[lonely]).change("calm(cup, tray)")
    assert calm is not None
    assert calm.distance > 0.1


def test_what_if(hans: KnowledgeBase) -> None:
    with hans.what_if({"sweater": (0.0, 0.0, 0.5), "sign": (0.0, -1.0, 0.0)}) as kb:
        assert kb.facts.views[0].view == "world"
        again = ground(kb.scene)
        assert np.array_equal(kb.facts.separation, again.separation)
        assert not holds(kb, "on_top_of(sweater, heater)")
        assert "not on top of" in kb.why("on_top_of(sweater, heater)").text
    assert holds(hans, "on_top_of(sweater, heater)")


def test_what_cannot_be_asked(hans: KnowledgeBase) -> None:
    for goal, said in (
        ("on_top_of(sweater, heeter)", "did you mean 'heater'"),
        ("on_top_off(sweater, heater)", "did you mean 'on_top_of'"),
        ("on_top_of(sweater)", "does not take 1 argument"),
        ("on_top_of(X, heater)", "is not one relation of named things"),
        ("on_top_of(sweater, heater), near(sweater, heater)", "is not one relation of named things"),
        (":- halt.", "is not one relation of named things"),
        ("above_r(floor, sweater)", "is a surface, which nobody moves"),
    ):
        with pytest.raises(QueryError, match=said):
            hans.change(goal)
    with pytest.raises(SceneError, match="has no object 'cap'"):
        hans.what_if({"cap": (0, 0, 1)})
    with pytest.raises(SceneError, match="is not x, y, z in metres"):
        hans.what_if({"sweater": (0, 1)})
    with pytest.raises(GeometryError, match="boxes only"):
        KnowledgeBase(hans.scene, region="mesh").change("on_top_of(sweater, heater)")


def test_ids_that_look_like_copies() -> None:
    things = [
        box("a", (0, 0, 0.05), (0.1, 0.1, 0.1)),
        box("a~0", (0, 0, -0.5), (1, 1, 1)),
        box("a~~1", (3, 0, 0), (1, 1, 1)),
    ]
    kb = KnowledgeBase(Scene.from_dict(scene(*things).to_dict()))
    change = kb.change("on_top_of(a, 'a~0')")
    assert change is not None
    assert change.offset == pytest.approx((0, 0, 0.02), abs=2e-4)


TABLE = box("table", (0, 0, 0.4), (1, 1, 0.8))
CUP = box("cup", (2, 0.2, 0.05), (0.1, 0.1, 0.1))


def test_moves_along_several_axes_are_about_as_short_as_can_be(hans: KnowledgeBase) -> None:
    for goal, most in (("on_top_of(sweater, radiator)", 1.14), ("on_top_of(sweater, floor)", 0.61)):
        change = hans.change(goal)
        assert change is not None
        assert (change.holds, change.collides) == (True, ())
        assert change.distance < most


def test_a_thing_is_put_on_another_by_the_shortest_way() -> None:
    """To where it stands on the table's edge by just enough, as a search of all such places finds too."""
    kb = KnowledgeBase(scene(TABLE, CUP))
    change = kb.change("on_top_of(cup, table)")
    assert change is not None
    assert (change.holds, change.collides) == (True, ())
    x, y, z = change.offset
    assert (abs(y), z) == (pytest.approx(0.0, abs=2e-2), pytest.approx(0.78, abs=0.03))
    assert -1.5 < x < -1.4
    rng = np.random.default_rng(0)
    for shift in rng.uniform([-2.5, -0.7, 0.6], [-1.0, 0.3, 0.9], (300, 3)):
        if np.linalg.norm(shift) < change.distance - 2e-3:
            assert not holds(KnowledgeBase(moved(kb.scene, {"cup": shift})), "on_top_of(cup, table)")


def test_a_place_that_is_free_is_better_than_one_that_is_nearer() -> None:
    vase = box("vase", (0.4, 0, 1.0), (0.3, 0.9, 0.4))
    kb = KnowledgeBase(scene(TABLE, CUP, vase))
    plain = KnowledgeBase(scene(TABLE, CUP)).change("on_top_of(cup, table)")
    change = kb.change("on_top_of(cup, table)")
    assert change is not None
    assert plain is not None
    assert change.collides == ()
    assert not new_company(kb, after(kb, change), "cup")
    assert change.distance > plain.distance + 0.01


def test_a_place_that_is_taken_is_said_to_be() -> None:
    piano = box("piano", (0, 0, 1.4), (1.4, 1.4, 1.2))
    kb = KnowledgeBase(scene(TABLE, CUP, piano))
    change = kb.change("on_top_of(cup, table)")
    assert change is not None
    assert change.collides == ("piano",)
    assert change.to_dict()["collides"] == ["piano"]
    assert new_company(kb, after(kb, change), "cup") == {"piano"}


def test_what_is_met_already_is_no_collision() -> None:
    kb = KnowledgeBase(
        scene(TABLE, box("cup", (0, 0, 0.75), (0.1, 0.1, 0.2)), box("far", (9, 9, 9), (1, 1, 1)))
    )
    change = kb.change("on_top_of(cup, table)")
    assert change is not None
    assert (change.holds, change.collides) == (True, ())
