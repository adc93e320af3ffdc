"""Plain questions: what can be asked, what is answered, and what is refused with what can be asked."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from commands import call
from deixis.errors import QueryError
from deixis.knowledge import KnowledgeBase
from deixis.scene import Label, Scene
from deixis.words import ENTRIES
from deixis.words.phrases import plural, singulars
from deixis.words.questions import PATTERNS, read
from scenes import box, floor, scene

TABLE = box("table", (0, 0, 0.36), (1.6, 0.8, 0.72))


def on_table(name: str, x: float, label: str | None = None, y: float = 0.0) -> dict[str, Any]:
    return box(name, (x, y, 0.77), (0.1, 0.1, 0.1), label=label)


@pytest.fixture(scope="module")
def hans(root: Path) -> Iterator[KnowledgeBase]:
    with KnowledgeBase.from_scene(root / "kb" / "scenes" / "hans.json") as kb:
        yield kb


@pytest.fixture(scope="module")
def room() -> Iterator[KnowledgeBase]:
    given = scene(
        floor(),
        TABLE,
        on_table("cup", -0.6),
        on_table("red", 0.0, "book"),
        on_table("blue", 0.5, "book"),
        on_table("torn", 0.3, "book", y=0.3),
        box("bin", (0.0, -2.0, 0.2), (0.3, 0.3, 0.4), label="waste bin"),
    )
    with KnowledgeBase(given) as kb:
        yield kb


@pytest.mark.parametrize(
    ("question", "text"),
    [
        ("what is on the heater?", "The sweater is on the electric heater."),
        ("What's on the electric heater", "The sweater is on the electric heater."),
        ("what is the sweater on?", "The sweater is on the electric heater."),
        ("where is the sweater?", "The sweater is on the electric heater."),
        ("is the sweater on the heater?", "Yes, the sweater is on the electric heater."),
        ("does the sweater lie on the heater?", "Yes, the sweater is on the electric heater."),
        ("is the sweater under the heater?", "No, the sweater is not under the electric heater."),
        ("which things lean on the wall?", "The fire extinguisher on the floor is leaning on the wall."),
        ("what leans against the wall?", "The fire extinguisher on the floor is leaning on the wall."),
        ("how many fire extinguishers are on the wall?", "One is on the wall: a fire extinguisher."),
        ("how many radiators are in the heater?", "None is in the electric heater."),
        ("what is in the radiator?", "Nothing is in the radiator."),
        (
            "what is left of the radiator?",
            "The fire extinguisher on the floor is left of the radiator as seen from the robot.",
        ),
        (
            "what is to the left of the radiator from the robot?",
            "The fire extinguisher on the floor is left of the radiator as seen from the robot.",
        ),
        (
            "what is left of the radiator from where you stand?",
            "Nothing is left of the radiator from where you stand.",
        ),
        (
            "why is the sweater on the heater?",
            (
                "The sweater is on top of the electric heater, because it is above the electric heater "
                "and it touches the electric heater."
            ),
        ),
        ("why is the sweater in the heater?", "But the sweater is not in the electric heater."),
        ("why isn't the sweater on the heater?", "But the sweater is on the electric heater."),
    ],
)
def test_figure_3(hans: KnowledgeBase, question: str, text: str) -> None:
    assert hans.say(question).text == text


def test_why_extinguisher_2_is_not_on_the_wall_names_the_floor(hans: KnowledgeBase) -> None:
    found = hans.say("why is extinguisher2 not on the wall?")
    assert found.holds
    assert "affixed on the wall, because the floor touches" in found.text


def test_what_fits_is_named_with_the_answer(hans: KnowledgeBase) -> None:
    found = hans.say("what is on the wall?")
    assert found.things == ("extinguisher1", "radiator", "sign")
    assert found.facts[0].to_dict() == {
        "word": "on",
        "figure": "extinguisher1",
        "ground": "wall",
        "view": None,
    }


def test_a_noun_of_several_things_asks_back(room: KnowledgeBase) -> None:
    found = room.say("is the book on the table?")
    assert not found.holds
    assert found.choices == ("red", "blue", "torn")
    assert found.text.startswith("Which book do you mean: the ")
    assert found.text.endswith("?")
    for choice in found.choices:
        assert room.say(f"is {choice} on the table?").holds


def test_the_names_of_a_choice_can_be_used_in_the_next_question(room: KnowledgeBase) -> None:
    for name in room.names().values():
        found = room.say(f"where is '{name.removeprefix('the ')}'?")
        assert found.choices == ()


def test_plurals_and_indefinite_nouns_mean_any(room: KnowledgeBase) -> None:
    assert room.say("which books are on the table?").things == ("blue", "red", "torn")
    assert room.say("is a book on the table?").holds
    assert room.say("are any books on the floor?").text.startswith("No, ")
    assert room.say("how many books are on the table?").text.startswith("Three are on the table: ")
    assert room.say("how many things are on the table?").text.startswith("Four are on the table: ")


def test_the_last_word_of_a_label_will_do(room: KnowledgeBase) -> None:
    assert room.say("where is the bin?").holds
    assert room.say("what is the waste bin on?").text == "The waste bin is on the floor."


@pytest.mark.parametrize(
    "form", [form for entry in ENTRIES if not entry.word.endswith(" of") for form in entry.forms]
)
def test_every_form_is_read_as_its_word(form: str) -> None:
    (entry,) = (one for one in ENTRIES if form in one.forms)
    assert read(f"what is {form} the table?").word == entry.word


@pytest.mark.parametrize("pattern", PATTERNS)
def test_every_pattern_can_be_read(pattern: str) -> None:
    assert read(pattern).asks
    assert read(pattern.upper()).asks == read(pattern).asks


@pytest.mark.parametrize(
    ("question", "message"),
    [
        ("what is onn the table?", "character 9: 'onn' is no preposition I know: did you mean 'on'"),
        ("what is between the books?", "character 9: 'between' needs a ground of several things"),
        ("what is on the tabel?", "character 16: nothing here is called 'tabel': did you mean 'table'"),
        ("tell me a joke", "character 1: 'tell' is not expected here; I can answer"),
        ("what is on", "character 11: the question ends too early"),
        ("", "character 1: the question ends too early"),
        ("what is left of the table from the robt?", "no view is called 'the robt': did you mean 'robot'"),
        (
            "what is on the xyzzy?",
            "nothing here is called 'xyzzy': there are book, cup, floor, table, waste bin",
        ),
        ("where is " + "x" * 2000, "a question has at most 1000 characters"),
    ],
)
def test_what_cannot_be_answered_says_so(room: KnowledgeBase, question: str, message: str) -> None:
    with pytest.raises(QueryError, match=message.replace("(", r"\(").replace("?", r"\?")):
        room.say(question)


def test_sides_need_a_view() -> None:
    with KnowledgeBase(scene(TABLE, on_table("cup", 0.0), views=())) as kb:
        assert kb.say("what is on the table?").holds
        with pytest.raises(QueryError, match="has no view, so nothing is left of anything"):
            kb.say("what is left of the table?")


@pytest.mark.parametrize(
    "label", ["<script>", "'); halt.", "on", "what is", "the", "x" * 10_000, "a\nb", '"', "?"]
)
def test_labels_are_only_words(label: str) -> None:
    given = scene(TABLE, on_table("thing", 0.0), on_table("a'); halt.", 0.4))
    things = tuple(
        replace(one, labels=(Label(label),)) if one.id == "thing" else one for one in given.objects
    )
    with KnowledgeBase(replace(given, objects=things)) as kb:
        assert kb.say("is thing on the table?").holds
        found = kb.say("what is on the table?")
        assert found.things == ("a'); halt.", "thing")
        assert len(found.text) < 200
        assert kb.say("why is thing on the table?").holds
        assert kb.say("""is "a'); halt." on the table?""").holds
        if label in ("<script>", "on", "what is", "the"):
            assert kb.say(f'is "{label}" on the table?').holds


ANY_WORDS = """
    what is are the a on in front of left book books not why where how many which table isn't from robot ' " ?
    lean things does xyz
""".split()  # noqa: SIM905 - a list of words is read more easily so


@settings(max_examples=200)
@given(words=st.lists(st.sampled_from(ANY_WORDS), max_size=9))
def test_any_words_are_answered_or_refused(room: KnowledgeBase, words: list[str]) -> None:
    try:
        found = room.say(" ".join(words))
    except QueryError:
        return
    assert found.text
    assert not (found.holds and found.choices)


@settings(max_examples=100)
@given(text=st.text(max_size=40))
def test_any_text_is_refused_politely(room: KnowledgeBase, text: str) -> None:
    try:
        found = room.say(text)
    except QueryError:
        return
    assert found.text


@pytest.mark.parametrize(
    "noun", ["cup", "box", "berry", "shelf", "knife", "dish", "fire extinguisher", "person"]
)
def test_plurals_are_read_back(noun: str) -> None:
    assert noun in singulars(plural(noun))


def test_the_command(root: Path) -> None:
    hans = root / "kb" / "scenes" / "hans.json"
    yes = call("say", hans, "what is on the heater?")
    assert (yes.code, yes.out) == (0, "The sweater is on the electric heater.\n")
    assert call("say", hans, "is the radiator on the heater?").code == 1
    which = call("say", hans, "where is the fire extinguisher?")
    assert (which.code, which.out.split(":")[0]) == (2, "Which fire extinguisher do you mean")
    refused = call("say", hans, "sing!")
    assert refused.code == 2
    assert "what is on the table?" in refused.err
    data = json.loads(call("say", hans, "what is on the heater?", "--format", "json").out)
    assert data["things"] == ["sweater"]


def test_the_lexicon_command() -> None:
    assert call("lexicon", "on").out.splitlines()[1] == "  on_top_of: the ground holds it up from below"
    assert call("lexicon", "leans_on").out == "on, leaning on, against\n"
    assert len(call("lexicon").out.splitlines()) > len(ENTRIES)
    missing = call("lexicon", "through")
    assert (missing.code, missing.err) == (
        2,
        "deixis: 'through' says a way, not a place: nothing here moves\n",
    )


def test_meshes_make_a_pencil_be_in_the_mug(root: Path) -> None:
    with KnowledgeBase.from_scene(root / "kb" / "scenes" / "study.json", region="mesh") as kb:
        assert kb.say("what is in the mug?").text == "The pencil is in the mug."
        assert kb.say("what is under the desk?").things == ("carton", "chair")
        assert kb.say("what is in the desk?").text == "Nothing is in the desk."


def test_the_scene_is_as_it_was(room: KnowledgeBase) -> None:
    before: Scene = room.scene
    room.say("where are the books?")
    assert room.scene is before
