"""A changed scene: what is measured again, and that the answer is that of a full run."""

from __future__ import annotations

import copy
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from deixis import grounding
from deixis.errors import SceneError
from deixis.facts import Facts
from deixis.regrounding import reground
from deixis.scene import Scene
from scenes import box, floor, scene, wall

millimetres = st.integers(-900, 900).map(lambda value: value / 1000)
points = st.tuples(millimetres, millimetres, millimetres)
boxes = st.tuples(points, st.tuples(*[st.integers(0, 600).map(lambda v: v / 1000)] * 3), st.floats(-3, 3))


def same(one: Facts, other: Facts) -> bool:
    """Return whether two tables are equal to the last bit."""
    equal = one.ids == other.ids and len(one.views) == len(other.views)
    for name in one.pairs.__slots__:
        equal = equal and np.array_equal(getattr(one.pairs, name), getattr(other.pairs, name))
    for a, b in zip(one.views, other.views, strict=True):
        equal = equal and a.view == b.view and a.withheld == b.withheld and a.ambiguous == b.ambiguous
        equal = equal and all(
            np.array_equal(getattr(a, n), getattr(b, n)) for n in ("rows", "int_hs", "cont_hs")
        )
    return equal


def made(things: list[Any], positions: list[Any]) -> dict[str, Any]:
    listed = [box(f"o{i}", *thing) for i, thing in enumerate(things)]
    views = [{"id": f"v{i}", "position": list(at)} for i, at in enumerate(positions)]
    return {"deixis": 1, "id": "s", "objects": [floor(), wall(), *listed], "views": views}


@given(
    st.lists(boxes, min_size=6, max_size=12),
    st.lists(points, min_size=1, max_size=3),
    st.lists(st.tuples(st.integers(0, 13), points), max_size=3),
    st.lists(st.tuples(st.integers(0, 2), points), max_size=2),
    st.lists(boxes, max_size=2),
    st.lists(st.integers(0, 13), max_size=2),
    st.randoms(),
)
def test_equals_a_full_run(
    things: Any, positions: Any, moves: Any, looks: Any, more: Any, gone: Any, draw: Any
) -> None:
    data = made(things, positions)
    before = Scene.from_dict(data)
    changed = copy.deepcopy(data)
    for index, point in moves:
        if 2 <= index < len(changed["objects"]):
            changed["objects"][index]["box"]["center"] = list(point)
    for index, point in looks:
        if index < len(changed["views"]):
            changed["views"][index]["position"] = list(point)
    changed["objects"] = [one for at, one in enumerate(changed["objects"]) if at not in gone]
    changed["objects"] += [box(f"n{at}", *thing) for at, thing in enumerate(more)]
    if draw.random() < 0.3:
        draw.shuffle(changed["objects"])
    after = Scene.from_dict(changed)
    assert same(reground(before, grounding.ground(before), after), grounding.ground(after))


def test_a_changed_scene_is_the_scene_that_says_so() -> None:
    before = scene(floor(), box("a", (0, 0, 0), (1, 1, 1)), box("b", (1, 0, 0), (1, 1, 1)))
    other = scene(box("c", (0, 0, 2), (1, 1, 1)), box("a", (0, 0, 1), (1, 2, 1), 0.3))
    after = before.changed(objects=other.objects, removed=["b"], views=other.views[:0])
    assert [thing.id for thing in after.objects] == ["floor", "a", "c"]
    assert not after.boxes.differs(Scene.from_dict(after.to_dict()).boxes).any()
    assert after.views == ()
    assert before.changed().to_dict() == before.to_dict()
    for wrong, said in (
        ({"removed": ["d"]}, "has no object 'd'"),
        ({"removed": ["a"], "objects": other.objects}, "both given and removed"),
        ({"objects": other.objects * 2}, "more than once"),
    ):
        with pytest.raises(SceneError, match=said):
            before.changed(**wrong)


def test_other_things_or_thresholds_are_grounded_from_the_start() -> None:
    one = scene(box("a", (0, 0, 0), (1, 1, 1)), box("b", (1, 0, 0), (1, 1, 1)))
    for other in (
        scene(box("a", (0, 0, 0), (1, 1, 1))),
        scene(box("a", (0, 0, 0), (1, 1, 1)), box("b", (1, 0, 0), (1, 1, 1)), thresholds={"closeness": 3.0}),
        scene(box("a", (0, 0, 0), (1, 1, 1)), box("b", (1, 0, 0), (1, 1, 1)), views=[]),
    ):
        assert same(reground(one, grounding.ground(one), other), grounding.ground(other))


def test_only_the_pairs_of_what_moved_are_measured(monkeypatch: pytest.MonkeyPatch) -> None:
    things = [box(f"o{i}", (i * 0.5, 0, 0), (0.2, 0.2, 0.2)) for i in range(40)]
    before = scene(*things)
    facts = grounding.ground(before)
    things[7] = box("o7", (3.5, 0.1, 0), (0.2, 0.2, 0.2))
    measured = []
    original = grounding.measure_pairs

    def count(*args: Any) -> Any:
        measured.append(len(args[1]))
        return original(*args)

    monkeypatch.setattr(grounding, "measure_pairs", count)
    again = reground(before, facts, scene(*things))
    assert len(measured) == 1
    assert measured[0] < len(facts) / 5
    assert same(again, grounding.ground(scene(*things)))
