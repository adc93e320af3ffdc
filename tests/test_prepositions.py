"""Prepositions: what people accept, by rules; and a lexicon that says what rules and vocabulary say."""

from __future__ import annotations

from pathlib import Path

import pyoxigraph as ox
import pytest
from hypothesis import given, settings

import lexicon as lexicon_file
import prepositions
from deixis._files import datalog_files, rules_dir
from deixis.errors import QueryError
from deixis.knowledge import KnowledgeBase
from deixis.ruleset import load
from deixis.ruleset.model import Constant
from deixis.scene import Scene
from deixis.vocabulary import BY_NAME, RELATIONS
from deixis.words import ENTRIES, NOT_GROUNDED, entry_of, predicates_in, words_for
from deixis.words.accepted import FITS
from scenes import box, floor, scene
from worlds import World, worlds

RULES = rules_dir() / "prepositions.pl"

# The spatial prepositions of English as Landau and Jackendoff (1993) list them, without those of time alone.
LANDAU_JACKENDOFF = (
    "about", "above", "across", "after", "against", "along", "alongside", "amid", "amidst", "among",
    "amongst", "around", "at", "atop", "before", "behind", "below", "beneath", "beside", "between",
    "betwixt", "beyond", "by", "down", "from", "in", "inside", "into", "near", "nearby", "off", "on",
    "onto", "opposite", "out", "outside", "over", "past", "through", "throughout", "to", "toward",
    "under", "underneath", "up", "upon", "via", "with", "within", "without", "apart", "away", "back",
    "backward", "downstairs", "downward", "east", "forward", "here", "homeward", "inward", "left",
    "north", "outward", "right", "sideways", "south", "there", "together", "upstairs", "upward", "west",
)  # fmt: skip
COMPOUND = (
    "far from", "in back of", "in between", "in front of", "in line with", "on top of", "to the left of",
    "to the right of", "to the side of",
)  # fmt: skip


@pytest.mark.skipif(
    not (prepositions.DATA / "prepositions").exists(),
    reason="the labelled scenes, ../shared/data/prepositions, are not here",
)
def test_the_words_agree_with_people_as_well_as_one_of_them_does() -> None:
    tables = prepositions.scores(prepositions.DATA, ("mesh",))["mesh"]
    short = {
        word: (round(tables[word].f1, 3), bar)
        for word, bar in prepositions.ONE_PERSON.items()
        if tables[word].f1 < bar
    }
    assert short == {}


def test_the_rules_name_no_scene_and_no_thing() -> None:
    """General rules: the only names in them are words, axes, the world and thresholds."""
    words = {entry.word for entry in ENTRIES}
    known = words | {"Z+", "world", "granularity"}
    rules = load(datalog_files(), [RULES])
    for rule in rules.rules:
        if rule.head.predicate not in rules.user:
            continue
        atoms = [rule.head, *(goal for goal in rule.body if hasattr(goal, "args"))]
        for atom in atoms:
            names = {one.value for one in atom.args if isinstance(one, Constant) and one.kind == "name"}
            assert names <= known, rule.head


def test_every_word_has_rules_and_every_rule_a_word() -> None:
    rules = load(datalog_files(), [RULES])
    ruled = {
        (str(rule.head.args[0].value), predicate == FITS[1])
        for predicate in FITS
        for rule in rules.by_head[predicate]
        if isinstance(rule.head.args[0], Constant)
    }
    assert ruled == {(entry.word, entry.view) for entry in ENTRIES}


def test_every_predicate_exists_and_every_relation_has_a_word() -> None:
    for entry in ENTRIES:
        for sense in entry.senses:
            assert sense.predicate in BY_NAME
            assert not BY_NAME[sense.predicate].view or entry.view
    assert [term.name for term in RELATIONS if not words_for(term.name)] == []


def test_on_has_three_senses_and_in_has_two() -> None:
    assert predicates_in("on") == ("on_top_of", "affixed_on", "leans_on")
    assert predicates_in("in") == ("inside", "part_in")


def test_the_list_of_landau_and_jackendoff_is_covered() -> None:
    forms = {form for entry in ENTRIES for form in entry.forms}
    assert [word for word in (*LANDAU_JACKENDOFF, *COMPOUND) if word not in forms | NOT_GROUNDED.keys()] == []
    assert forms & NOT_GROUNDED.keys() == set()
    assert len(forms) == sum(len(entry.forms) for entry in ENTRIES)


def test_words_of_the_data_sets_are_listed_once_for_spatial_sense() -> None:
    names = [name for entry in ENTRIES for name in entry.spatial_sense]
    assert sorted(names) == sorted(
        {
            "above",
            "behind",
            "in",
            "in front of",
            "next to",
            "on",
            "to the left of",
            "to the right of",
            "under",
        }
    )


def test_words_that_are_not_grounded_say_why() -> None:
    with pytest.raises(QueryError, match="'between' needs a ground of several things"):
        entry_of("between")
    with pytest.raises(QueryError, match="'benaeth' is no preposition I know: did you mean 'beneath'"):
        entry_of("benaeth")


def test_the_file_is_the_table(root: Path) -> None:
    written = lexicon_file.LEXICON.read_text(encoding="utf-8")
    assert written == lexicon_file.lexicon(), "write it anew: python tests/lexicon.py"
    graph = list(ox.parse(written, format=ox.RdfFormat.TURTLE))
    reference = ox.NamedNode("http://www.w3.org/ns/lemon/ontolex#reference")
    meant = {one.object for one in graph if one.predicate == reference}
    defined = {one.subject for one in ox.parse(path=root / "kb" / "ontology.ttl", format=ox.RdfFormat.TURTLE)}
    assert meant
    assert meant <= defined
    used = {one.predicate for one in graph if one.predicate.value.startswith("urn:deixis:word:")}
    assert used == {
        ox.NamedNode(f"urn:deixis:word:{name}") for name in ("visualGenome", "spatialSense", "notGrounded")
    }


def fits(given: Scene, engine: str) -> set[tuple[str, ...]]:
    with KnowledgeBase(given, rules=[RULES]) as kb:
        found = kb._derive(engine, FITS, 60.0)  # type: ignore[arg-type]
        return {row for _, row, _ in found}


@pytest.mark.parametrize("name", ["hans", "study", "inspection"])
def test_three_engines_accept_the_same_words(root: Path, name: str) -> None:
    given = Scene.load(root / "kb" / "scenes" / f"{name}.json")
    found = fits(given, "duckdb")
    assert found
    assert found == fits(given, "prolog") == fits(given, "sparql")


@settings(max_examples=15)
@given(world=worlds())
def test_words_never_contradict_each_other(world: World) -> None:
    found = fits(world.scene(), "arrays")
    by_word: dict[str, set[tuple[str, ...]]] = {}
    for word, *pair in found:
        by_word.setdefault(word, set()).add(tuple(pair[:2]))
    got = {entry.word: by_word.get(entry.word, set()) for entry in ENTRIES}
    surfaces = {thing.id for thing in world.scene().objects if thing.kind == "surface"}
    assert got["on top of"] <= got["on"] <= got["touching"]
    assert got["inside"] <= got["in"]
    assert got["over"] == got["above"]
    assert got["under"] == got["below"]
    assert got["above"] & got["on"] == set()
    assert got["near"] & got["touching"] == set()
    for word in ("beside", "left of", "behind", "near"):
        assert got[word] & (got["in"] | got["inside"]) == set()
    assert {pair[0] for pairs in got.values() for pair in pairs} & surfaces == set()


def cup(z: float, x: float = 0.0) -> dict[str, object]:
    return box("cup", (x, 0.0, z), (0.08, 0.08, 0.1))


TABLE = box("table", (0, 0, 0.36), (1.2, 0.8, 0.72))
PLATE = box("plate", (0, 0, 0.727), (0.25, 0.25, 0.014))
CASES = (
    ("a cup on a table", (TABLE, cup(0.77)), {"on", "on top of"}, {"above", "over", "near", "against", "in"}),
    ("a cup over a table", (TABLE, cup(0.95)), {"above", "over", "near"}, {"on", "on top of", "touching"}),
    ("a cup at a table's side", (TABLE, floor(), cup(0.05, 0.64)), {"against"}, {"on", "under", "above"}),
    ("a cup in a table's box", (TABLE, cup(0.3)), {"in", "inside"}, {"on", "under", "above", "near"}),
)  # fmt: skip


@pytest.mark.parametrize(("name", "things", "yes", "no"), CASES, ids=[case[0] for case in CASES])
def test_words_of_a_cup(
    name: str, things: tuple[dict[str, object], ...], yes: set[str], no: set[str]
) -> None:
    found = {row[0] for row in fits(scene(*things), "arrays") if row[1:3] == ("cup", "table")}
    assert yes <= found, name
    assert no & found == set(), name


def test_an_apple_on_a_thin_plate_is_on_the_plate() -> None:
    apple = box("apple", (0, 0, 0.734 + 0.04), (0.08, 0.08, 0.08))
    found = fits(scene(TABLE, PLATE, apple), "arrays")
    assert ("on", "apple", "plate") in found


def test_fruit_on_the_fruit_in_a_bowl_is_in_the_bowl() -> None:
    bowl = box("bowl", (0, 0, 0.77), (0.3, 0.3, 0.1))
    low = box("low", (0, 0, 0.8), (0.09, 0.09, 0.09))
    high = box("high", (0.1, 0, 0.8601), (0.09, 0.09, 0.08))
    found = fits(scene(TABLE, bowl, low, high), "arrays")
    assert ("in", "low", "bowl") in found
    assert ("in", "high", "bowl") in found
    assert ("inside", "high", "bowl") not in found
