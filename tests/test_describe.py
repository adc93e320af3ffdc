"""Scenes in a few sentences: as people speak, each resting on relations that hold."""

from __future__ import annotations

import json
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from commands import call
from deixis.errors import QueryError
from deixis.knowledge import KnowledgeBase
from deixis.readers import read
from deixis.scene import Label, Scene
from deixis.words import Description
from prepositions import DATA
from scenes import ROBOT, box, floor, scene, wall
from worlds import World, moved, worlds, yaws

TABLE = box("table", (0, 0, 0.36), (1.6, 0.8, 0.72))
HOSTILE = (
    "<script>alert(1)</script>",
    "'); halt.",
    "two\nlines",
    "x" * 10_000,
    "\x1b[31mred",
    '"',
    "the",
    "{0} ~w",
)


def on_table(name: str, x: float, label: str | None = None, size: float = 0.1) -> dict[str, Any]:
    return box(name, (x, 0.0, 0.72 + size / 2), (size, size, size), label=label)


def described(given: Scene | Path | str, **options: Any) -> Description:
    region = options.pop("region", "box")
    with KnowledgeBase.from_scene(given, region=region) as kb:
        found = kb.describe(**options)
        check(kb, found)
        return found


def check(kb: KnowledgeBase, found: Description) -> None:
    """Every fact holds, no pair is said twice or both ways round, and what is left out is counted."""
    holds = {(one.relation, one.figure, one.reference, one.view) for one in kb.relations()}
    facts = [one.relation for sentence in found.sentences for one in sentence.facts]
    assert {(one.relation, one.figure, one.reference, one.view) for one in facts} <= holds
    pairs = [frozenset((one.figure, one.reference)) for one in facts]
    assert len(pairs) == len(set(pairs))
    surfaces = {thing.id for thing in kb.scene.objects if thing.kind == "surface"}
    said = {thing for pair in pairs for thing in pair} | surfaces
    assert found.left_out == len({thing.id for thing in kb.scene.objects} - said)
    assert all(sentence.text.endswith(".") and "\n" not in sentence.text for sentence in found.sentences)
    assert not any(one.figure in surfaces for one in facts)


def called(label: str) -> Scene:
    """Return a scene in which a thing on a table has any label, also one that no file may have."""
    given = scene(TABLE, on_table("a", 0.1))
    things = tuple(replace(one, labels=(Label(label),)) if one.id == "a" else one for one in given.objects)
    return replace(given, objects=things)


def texts(found: Description) -> list[str]:
    return [one.text for one in found.sentences]


def test_figure_3(figure_3: Scene) -> None:
    assert texts(described(figure_3)) == [
        "On the wall are the radiator, a fire extinguisher and the fire extinguisher sign.",
        (
            "The fire extinguisher on the floor leans against the wall, "
            "left of the radiator as seen from the robot."
        ),
        "The sweater is on the electric heater.",
    ]


def test_figure_3_from_where_you_stand(figure_3: Scene) -> None:
    assert "left of" not in described(figure_3, view="v1").text()


def test_the_study_by_its_meshes(root: Path) -> None:
    assert texts(described(root / "kb" / "scenes" / "study.json", region="mesh")) == [
        "On the desk are the lamp and the mug.",
        "The pencil is in the mug.",
        "Under the desk are the chair and the carton.",
    ]


def test_the_kitchen_is_told_in_six_sentences_and_says_how_much_is_left(root: Path) -> None:
    found = described(root / "kb" / "scenes" / "kitchen.json")
    assert len(found.sentences) == 6
    assert found.text().endswith(f"And {found.left_out} more things.")
    assert max(map(len, texts(found))) < 200


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("cup_on_table", "The cup is on the table."),
        ("jar_inside_cabinet", "The jar is in the cabinet."),
        ("towel_partly_in_cabinet", "The towel is in the cabinet."),
        ("clock_affixed_on_wall", "The clock is on the wall."),
        ("ladder_leans_on_wall", "The ladder leans against the wall."),
        ("lamp_hangs_from_ceiling", "The lamp is on the ceiling."),
    ],
)
def test_golden_scenes(root: Path, name: str, text: str) -> None:
    assert text in texts(described(root / "tests" / "golden" / f"{name}.json"))


def test_all_golden_scenes_are_told_truly(root: Path) -> None:
    for path in sorted((root / "tests" / "golden").glob("*.json")):
        described(path)


def test_things_of_one_place_are_told_together() -> None:
    books = [on_table(f"b{at}", -0.6 + 0.2 * at, "book") for at in range(2)]
    found = described(scene(TABLE, *books, on_table("cup", 0.1), on_table("plate", 0.4, size=0.2)))
    assert texts(found) == ["On the table are the plate, two books and the cup."]
    assert found.left_out == 0
    assert found.rest == ""


def test_above_is_said_only_without_contact() -> None:
    shelf = box("shelf", (0, 0, 1.5), (0.8, 0.3, 0.03))
    found = described(scene(TABLE, shelf, on_table("cup", 0.5)))
    assert "The cup is on the table." in texts(found)
    assert "The shelf is above the table." in texts(found)


def test_a_table_is_not_below_its_cup() -> None:
    found = described(scene(TABLE, on_table("cup", 0.1)), about="table")
    assert found.text() == "The cup is on the table."


def test_near_is_not_said_where_on_is() -> None:
    found = described(scene(floor(), TABLE, on_table("cup", 0.1)), about="cup")
    assert found.text() == "The cup is on the table."


def test_a_floor_is_mentioned_only_where_nothing_else_tells() -> None:
    alone = described(scene(floor(), TABLE))
    assert alone.text() == "The table is on the floor."
    with_cup = described(scene(floor(), TABLE, on_table("cup", 0.1)))
    assert with_cup.text() == "The cup is on the table."


def test_what_stands_on_the_floor_is_placed_by_something_larger_beside_it() -> None:
    stool = box("stool", (0.0, 1.0, 0.25), (0.4, 0.4, 0.5))
    found = described(scene(floor(), TABLE, stool))
    assert texts(found) == ["The stool is left of the table as seen from the robot."]
    no_views = described(scene(floor(), TABLE, stool, views=()))
    assert texts(no_views) == ["The stool is near the table."]


def test_plurals_agree() -> None:
    assert described(scene(TABLE, on_table("a", 0.1, "scissors"))).text() == "The scissors are on the table."


def test_a_hundred_things_are_told_shortly() -> None:
    things = [on_table(f"t{at:03}", -0.75 + 0.015 * at, f"thing {at}", 0.01) for at in range(100)]
    found = described(scene(TABLE, *things, floor()))
    assert len(found.sentences) == 1
    assert "and 94 more things" in found.text()


def test_more_sentences_can_be_asked_for(root: Path) -> None:
    kitchen = root / "kb" / "scenes" / "kitchen.json"
    few, many = described(kitchen, most=2), described(kitchen, most=50)
    assert texts(many)[:2] == texts(few)
    assert many.left_out < few.left_out


def test_an_empty_scene_has_nothing_to_tell() -> None:
    found = described(scene())
    assert (found.text(), found.left_out) == ("There is nothing to describe here.", 0)


@pytest.mark.parametrize("label", HOSTILE)
def test_labels_are_only_words(label: str) -> None:
    found = described(called(label))
    (sentence,) = found.sentences
    assert len(sentence.text) < 120
    assert sentence.facts[0].relation.figure == "a"
    if len(label) < 30:
        assert " ".join(label.split()) in sentence.text


@pytest.mark.skipif(
    not (DATA / "ithor").exists(), reason="the AI2-THOR rooms, ../shared/data/ithor, are not here"
)
def test_rooms_of_a_simulator() -> None:
    for room in list(read("ithor", DATA / "ithor" / "scenes.jsonl"))[:3]:
        found = described(room)
        assert 1 <= len(found.sentences) <= 6
        assert found.left_out > 0


@settings(max_examples=15)
@given(world=worlds())
def test_whatever_is_told_holds(world: World) -> None:
    with KnowledgeBase(world.scene()) as kb:
        check(kb, kb.describe(most=20))
        for name in world.names[:2]:
            check_about(kb, kb.describe(about=name), name)


def check_about(kb: KnowledgeBase, found: Description, name: str) -> None:
    holds = {(one.relation, one.figure, one.reference, one.view) for one in kb.relations()}
    facts = [one.relation for sentence in found.sentences for one in sentence.facts]
    assert {(one.relation, one.figure, one.reference, one.view) for one in facts} <= holds
    assert all(name in (one.figure, one.reference) for one in facts)
    pairs = [frozenset((one.figure, one.reference)) for one in facts]
    assert len(pairs) == len(set(pairs))


@settings(max_examples=10)
@given(world=worlds(), angle=yaws(), shift=st.tuples(*[st.integers(-3, 3)] * 3))
def test_turning_all_and_the_views_changes_nothing(
    world: World, angle: float, shift: tuple[float, float, float]
) -> None:
    told = []
    for one in (world, moved(world, angle, shift)):
        with KnowledgeBase(one.scene()) as kb:
            told.append(
                {(fact.word, *pair(fact)) for said in kb.describe(most=50).sentences for fact in said.facts}
            )
    assert told[0] == told[1]


def pair(fact: Any) -> tuple[str, str]:
    return fact.relation.figure, fact.relation.reference


def test_unknown_things_and_views_are_named(figure_3: Scene) -> None:
    with KnowledgeBase(figure_3) as kb:
        with pytest.raises(QueryError, match=r"nothing is called 'sweatr'.*did you mean 'sweater'"):
            kb.describe(about="sweatr")
        with pytest.raises(QueryError, match="no view 'v9'"):
            kb.describe(view="v9")


def test_the_command(root: Path) -> None:
    hans = root / "kb" / "scenes" / "hans.json"
    found = call("describe", hans)
    assert found.code == 0
    assert found.out.splitlines()[-1] == "The sweater is on the electric heater."
    data = json.loads(call("describe", hans, "--object", "sweater", "--format", "json").out)
    assert data["sentences"][0]["facts"][0]["relation"] == "on_top_of"
    assert data["text"] == "The sweater is on the electric heater."


def test_the_command_prints_a_hostile_label_as_text(tmp_path: Path) -> None:
    path = tmp_path / "odd.json"
    scene(TABLE, on_table("a", 0.1, "'); halt. <script>")).save(path)
    assert call("describe", path).out == "The '); halt. <script> is on the table.\n"


def test_larger_things_come_first() -> None:
    things = [on_table(f"t{at}", -0.6 + 0.3 * at, f"cube {at}", 0.05 + 0.02 * at) for at in range(4)]
    (text,) = texts(described(scene(TABLE, *things)))
    places = [text.index(f"cube {at}") for at in (3, 2, 1, 0)]
    assert all(one < other for one, other in pairwise(places))


def test_a_board_and_a_picture_at_a_wall() -> None:
    board = box("board", (1.93, 0.5, 0.5), (0.1, 0.6, 1.0))
    picture = box("picture", (1.98, -1.0, 1.5), (0.04, 0.5, 0.4))
    found = described(scene(floor(), wall(), board, picture, views=(ROBOT,)))
    assert "The board leans against the wall." in texts(found)
    assert any(text.startswith("The picture is on the wall") for text in texts(found))
