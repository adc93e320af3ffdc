"""Names: a phrase that picks out one thing, as a person would, and in every sentence the same."""

from __future__ import annotations

import random
import time
from pathlib import Path
from typing import Any

import pytest

from deixis import KnowledgeBase, Scene
from deixis.errors import QueryError
from scenes import box, floor, scene, turned

SAMPLES = sorted((Path(__file__).resolve().parent.parent / "kb" / "scenes").glob("*.json"))
GOLDEN = sorted((Path(__file__).resolve().parent / "golden").glob("*.json"))

ONE_VIEW = ({"id": "v0", "label": "robot", "position": [-5.0, 0.0, 0.4], "heading": 0.0},)
TWO_VIEWS = (*ONE_VIEW, {"id": "v1", "label": "you", "position": [5.0, 0.0, 1.6], "heading": 3.14})


def names(*things: dict[str, Any], views: Any = ONE_VIEW, view: str | None = None) -> dict[str, str]:
    with KnowledgeBase(scene(*things, views=views)) as kb:
        return kb.names(view=view)


def cup(name: str, *center: float) -> dict[str, Any]:
    return box(name, center, (0.1, 0.1, 0.1), label="cup")


def unlabelled(thing: dict[str, Any]) -> dict[str, Any]:
    return {key: value for key, value in thing.items() if key != "label"}


TABLE = box("table", (0.0, 0.0, 0.35), (0.8, 1.6, 0.7))
SIDE_BY_SIDE = (cup("a", 0.0, 0.07, 1.05), cup("b", 0.0, -0.07, 1.05))


def test_a_label_of_one_thing_is_its_name() -> None:
    assert names(TABLE) == {"table": "the table"}
    assert names(unlabelled(TABLE)) == {"table": "table"}


def test_left_and_right_of_two() -> None:
    assert names(*SIDE_BY_SIDE, view="v0") == {"a": "the left cup", "b": "the right cup"}
    assert names(*SIDE_BY_SIDE) == {
        "a": "the left cup as seen from the robot",
        "b": "the right cup as seen from the robot",
    }


def test_sides_are_those_of_the_view_that_is_given() -> None:
    assert names(*SIDE_BY_SIDE, views=TWO_VIEWS, view="v0")["a"] == "the left cup"
    assert names(*SIDE_BY_SIDE, views=TWO_VIEWS, view="v1")["a"] == "the right cup"
    # Whoever looks, neither is the left one.
    assert names(*SIDE_BY_SIDE, views=TWO_VIEWS) == {"a": "the cup (a)", "b": "the cup (b)"}
    with pytest.raises(QueryError, match="v9"):
        names(*SIDE_BY_SIDE, view="v9")


def test_the_outermost_of_three() -> None:
    found = names(*SIDE_BY_SIDE, cup("c", 0.0, 0.0, 1.05), view="v0")
    assert found == {"a": "the leftmost cup", "b": "the rightmost cup", "c": "the cup (c)"}


def test_one_over_the_other() -> None:
    assert names(cup("a", 0, 0, 0.05), cup("b", 0, 0, 0.15)) == {"a": "the lower cup", "b": "the upper cup"}
    three = names(cup("a", 0, 0, 0.05), cup("b", 0, 0, 0.15), cup("c", 0, 0, 0.25))
    assert three == {"a": "the bottom cup", "b": "the cup (b)", "c": "the top cup"}


def test_the_only_one_in_a_place() -> None:
    found = names(floor(), TABLE, cup("a", 0.0, 0.0, 0.75), cup("b", 1.0, 0.0, 0.05), views=TWO_VIEWS)
    assert (found["a"], found["b"]) == ("the cup on the table", "the cup on the floor")


def test_a_place_that_two_are_in_tells_none() -> None:
    found = names(floor(), TABLE, cup("a", 0, 0.3, 0.75), cup("b", 0, -0.3, 0.75), views=TWO_VIEWS)
    assert (found["a"], found["b"]) == ("the cup (a)", "the cup (b)")


def test_a_landmark_has_a_name_of_its_own() -> None:
    tables = (box("t1", (0, 0, 0.35), (1, 1, 0.7), label="table"),
              box("t2", (3, 0, 0.35), (1, 1, 0.7), label="table"))  # fmt: skip
    found = names(*tables, cup("a", 0.0, 0.0, 0.75), cup("b", 3.0, 0.0, 0.75), views=TWO_VIEWS)
    assert (found["a"], found["b"]) == ("the cup (a)", "the cup (b)")


@pytest.mark.parametrize("path", [*SAMPLES, *GOLDEN], ids=lambda path: path.stem)
def test_a_name_picks_out_one_thing(path: Path) -> None:
    with KnowledgeBase.from_scene(path) as kb:
        for view in (None, *(one.id for one in kb.scene.views)):
            found = kb.names(view=view)
            assert list(found) == list(kb.facts.ids)
            assert len(set(found.values())) == len(found)


WORDS = ("cup", "left", "the", "on", "the cup", "left cup", "cup on the table", "table", "(a)", "cup (a)",
         "a", "the left cup", "cup as seen from the robot", "the table", "<script>", "'). halt.", "%w ~w",
         "„", "“", "„cup“", "cup auf „table“", "cup links")  # fmt: skip


@pytest.mark.parametrize("seed", range(12))
def test_labels_that_look_like_names(seed: int) -> None:
    """Whatever things are called, no two have one name, and labels come out as they are."""
    pick = random.Random(seed)  # noqa: S311 - no secret
    ids = pick.sample([*WORDS, *(f"{one} (b)" for one in WORDS), *(f"{one}) (b" for one in WORDS)], 16)
    things = []
    for one in ids:
        center = [pick.choice((-0.4, -0.2, 0.0, 0.2, 0.4)) for _ in range(2)]
        thing = box(
            one, (*center, pick.choice((0.05, 0.15, 0.75))), (0.1, 0.1, 0.1), label=pick.choice(WORDS)
        )
        things.append(pick.choice((unlabelled(thing), thing, thing, {**thing, "label": "cup"})))
    # Labels are free text, but for a blank at their ends.
    with KnowledgeBase(scene(floor(), TABLE, *[one for one in things if one["id"] != "table"],
                             views=TWO_VIEWS)) as kb:  # fmt: skip
        for view in (None, "v0", "v1"):
            found = kb.names(view=view)
            assert len(set(found.values())) == len(found), found


def test_names_stay_when_the_world_is_turned() -> None:
    things = (TABLE, cup("a", 0.0, 0.3, 0.75), cup("b", 0.0, -0.3, 0.75), cup("c", 1.5, 0.0, 0.05))
    for angle in (0.3, 2.0, -1.1):
        far = [turned(one, angle, (3.0, -1.0, 0.0)) for one in things]
        views = [turned(dict(one), angle, (3.0, -1.0, 0.0)) for one in ONE_VIEW]
        assert names(*far, views=views, view="v0") == names(*things, view="v0")


def test_a_thousand_things_are_named_at_once() -> None:
    pick = random.Random(1)  # noqa: S311 - no secret
    things = [floor(half=10.0)]
    for number in range(999):
        size = [pick.uniform(0.05, 0.8) for _ in range(3)]
        center = (pick.uniform(-10, 10), pick.uniform(-10, 10), size[2] / 2)
        things.append(box(f"o{number}", center, size, label="cup" if number < 100 else f"thing {number}"))
    with KnowledgeBase(scene(*things)) as kb:
        assert kb.ask("true")
        start = time.perf_counter()
        found = kb.names(view="v0")
        took = time.perf_counter() - start
    assert len(set(found.values())) == 1000
    assert sum(name.startswith("the cup (") for name in found.values()) < 60
    assert took < 2.0


def test_scenes_are_named_as_they_are_loaded() -> None:
    """Names are kept in tables, which other facts must empty."""
    with KnowledgeBase(scene(*SIDE_BY_SIDE)) as kb:
        assert kb.names(view="v0")["a"] == "the left cup"
        with kb.what_if({"a": (0.0, -0.28, 0.0)}) as then:
            assert then.names(view="v0")["a"] == "the right cup"
        other = KnowledgeBase(Scene.from_dict({**kb.scene.to_dict(), "objects": [SIDE_BY_SIDE[0]]}))
        with other:
            kb.engine.load(other.facts_text(readable=False))
            assert kb.names() == {"a": "the cup"}


def test_sentences_use_the_names(figure_3: Scene) -> None:
    with KnowledgeBase(figure_3) as kb:
        called = kb.names()
        text = kb.why("leans_on(extinguisher2, wall)").text
        assert text == f"{called['extinguisher2']} leans on the wall"
        assert called["extinguisher2"] in kb.why_not("affixed_on(extinguisher2, wall)").sentence().lower()
    with KnowledgeBase(scene(*SIDE_BY_SIDE, TABLE)) as kb:
        # The sentence says whose view it is, once.
        assert kb.why_not("left_of(b, table, v0)").text == (
            "the right cup is not left of the table as seen from the robot"
        )
        assert kb.why("near(b, table)").text == "the right cup as seen from the robot is near the table"
