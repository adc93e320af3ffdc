"""History: the intervals a map keeps are those that full runs at each stamp give, however frames arrive."""

from __future__ import annotations

import json
import random
import re
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from itertools import count
from pathlib import Path
from typing import Any

import pyoxigraph as ox
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from commands import Result, call
from deixis import KnowledgeBase
from deixis.errors import DeixisError, MapError, QueryError, QueryTimeout
from deixis.rdf.namespaces import PREFIXES
from deixis.readers import read_one
from deixis.semantic_map import Interval, SemanticMap, create_map, open_map
from deixis.vocabulary import RELATIONS
from deixis.words import Lasting, predicates_in
from deixis.words.lasting import PHRASES
from endpoint import serving
from scenes import ROBOT, box, floor, scene, wall
from test_living import OWN
from test_semantic_map import Address, address, server  # noqa: F401 - fixtures

TABLE = box("table", (0, 0, 0.4), (1, 1, 0.8))
CUP = box("cup", (0, 0, 0.85), (0.1, 0.1, 0.1))
FALLEN = box("cup", (2, 0, 0.05), (0.1, 0.1, 0.1))

Key = tuple[str, str, str, str | None]


def brute(kept: SemanticMap, names: Iterable[str] | None = None, **how: Any) -> set[Interval]:
    """Return all intervals, by a full run at each stamp."""
    found: set[Interval] = set()
    before: dict[Key, float] = {}
    for stamp in sorted({frame.stamp for frame in kept.frames()}):
        with KnowledgeBase(kept.scene(at=stamp), **how) as kb:
            holds = kb.relations(relation=names)
        now = {(one.relation, one.figure, one.reference, one.view) for one in holds}
        found |= {Interval(*key, since, stamp) for key, since in before.items() if key not in now}
        before = {key: before.get(key, stamp) for key in now}
    return found | {Interval(*key, since, None) for key, since in before.items()}


def frames(draw: random.Random, most: int) -> Iterator[dict[str, Any]]:
    """Yield random frames: a few things that come, move and go, told in any order of their stamps."""
    names = [f"o{at}" for at in range(5)]
    known: set[str] = set()
    for _ in range(most):
        some = draw.sample(names, draw.randint(0, 3))
        things = [
            box(
                name,
                (draw.choice([0, 0.1, 0.5]), draw.choice([0, 0.3]), draw.choice([0.1, 0.3, 0.35])),
                [draw.choice([0.1, 0.2, 0.6]) for _ in range(3)],
                draw.choice([0.0, 0.3]),
                draw.choice("ab"),
            )
            for name in some
        ]
        things += [floor()] if draw.random() < 0.5 else []
        things += [wall(x=0.6)] if draw.random() < 0.2 else []
        views = []
        if draw.random() < 0.5:
            position = [draw.choice([-3.0, 3.0]), draw.choice([0.0, 1.0]), 0.5]
            views = [{**ROBOT, "id": draw.choice(["v0", "v1"]), "position": position}]
            for thing in things[: draw.randint(0, 2)]:
                thing["seen_in"] = [views[0]["id"]]
        gone = [name for name in sorted(known) if name not in some and draw.random() < 0.15]
        known |= set(some)
        yield {
            "scene": scene(*things, views=views),
            "stamp": float(draw.choice([draw.randint(0, 12), draw.randint(0, 3)])),
            "whole": draw.random() < 0.15,
            "gone": gone,
        }


def told(kept: SemanticMap, seed: int, most: int, batch: int) -> None:
    """Tell a map random frames, and ask it in between; each time all intervals are those of full runs."""
    draw = random.Random(seed)  # noqa: S311 - a test
    kept._batch = batch
    for frame in frames(draw, most):
        kept.add(frame.pop("scene"), **frame)
        if draw.random() < 0.3:
            assert set(kept.intervals()) == brute(kept)
    found = kept.intervals()
    assert len(found) == len(set(found))
    assert set(found) == brute(kept)
    # No two of one relation meet or overlap.
    last: dict[Key, float | None] = {}
    for one in found:
        before = last.get(one.key, -1.0)
        assert before is not None
        assert before < one.since
        last[one.key] = one.until


NUMBERS = count()
ANY_SEED = {"seed": st.integers(0, 10**9), "batch": st.sampled_from([1, 2, 256])}


@given(**ANY_SEED)
@settings(max_examples=8, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_intervals_are_those_of_full_runs(seed: int, batch: int, tmp_path: Path) -> None:
    with create_map(tmp_path / f"{next(NUMBERS)}.duckdb", scene()) as kept:
        told(kept, seed, 10, batch)


@pytest.mark.long
@given(**ANY_SEED)
@settings(max_examples=150, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_intervals_are_those_of_full_runs_of_many_frames(seed: int, batch: int, tmp_path: Path) -> None:
    with create_map(tmp_path / f"{next(NUMBERS)}.duckdb", scene()) as kept:
        told(kept, seed, 40, batch)


@pytest.mark.parametrize("seed", range(2))
def test_both_databases_keep_the_same(seed: int, address: Address) -> None:  # noqa: F811 - a fixture
    with create_map(address(), scene()) as kept:
        told(kept, seed, 12, 2)


def test_a_map_is_followed_over_several_openings(address: Address) -> None:  # noqa: F811 - a fixture
    place = address()
    create_map(place, scene()).close()
    draw = random.Random(7)  # noqa: S311 - a test
    for frame in frames(draw, 8):
        with open_map(place) as kept:
            kept.add(frame.pop("scene"), **frame)
            assert set(kept.intervals()) == brute(kept)


@pytest.mark.parametrize("address", ["postgresql"], indirect=True)
def test_writers_and_askers_at_the_same_time(address: Address) -> None:  # noqa: F811 - a fixture
    place = address()
    create_map(place, scene()).close()

    def work(at: int) -> None:
        draw = random.Random(at)  # noqa: S311 - a test
        with open_map(place) as kept:
            kept._batch = 2
            for frame in frames(draw, 10):
                kept.add(frame.pop("scene"), **frame)
                kept.intervals()

    with ThreadPoolExecutor(3) as pool:
        list(pool.map(work, range(3)))
    with open_map(place) as kept:
        assert len(kept.frames()) == 30
        assert set(kept.intervals()) == brute(kept)


def test_a_map_of_before_there_was_history(address: Address) -> None:  # noqa: F811 - a fixture
    place = address()
    with kitchen(place) as kept, kept._transaction():
        kept._run("DROP VIEW lasting")
        for table in ("held", "holding", "accounted", "derivation"):
            kept._run(f"DROP TABLE {table}")
        kept._run("DELETE FROM migration WHERE number = 3")
    with open_map(place) as kept:
        assert set(kept.intervals()) == brute(kept) != set()


def test_other_relations_rules_and_regions_are_derived_on_demand(tmp_path: Path) -> None:
    own = tmp_path / "own.pl"
    own.write_text(OWN, encoding="utf-8")
    mesh = {
        "id": "ramp",
        "mesh": {
            "vertices": [[0, 0, 0], [0.4, 0, 0], [0, 0.4, 0], [0, 0, 0.4]],
            "faces": [[0, 1, 3], [0, 2, 1], [0, 3, 2], [1, 2, 3]],
        },
    }
    with create_map(tmp_path / "map.duckdb", scene()) as kept:
        draw = random.Random(3)  # noqa: S311 - a test
        kept.add(scene(mesh, floor()), stamp=0.0)
        for frame in frames(draw, 10):
            kept.add(frame.pop("scene"), **frame)
        base = ["touches", "near"]
        assert set(kept.intervals(base)) == brute(kept, base)
        names = ["rests", "seen", "by_name", "pair_of", "on_top_of"]
        assert set(kept.intervals(names, rules=[own])) == brute(kept, names, rules=[own])
        assert set(kept.intervals(region="mesh")) == brute(kept, region="mesh")
        # Nothing of it is kept, nor in the way of what is.
        assert set(kept.intervals()) == brute(kept)
        kept._batch = 1
        with pytest.raises(QueryTimeout, match="are not kept"):
            kept.intervals(base, timeout=0.0)


def test_what_was_derived_in_time_is_kept(tmp_path: Path) -> None:
    with create_map(tmp_path / "map.duckdb", scene()) as kept:
        for at in range(4):
            kept.add(scene(floor(), box("cup", (at, 0, 0.05), (0.1, 0.1, 0.1))), stamp=float(at))
        said = []
        for _ in range(3):
            with pytest.raises(QueryTimeout, match="what was derived is kept") as caught:
                kept.catch_up(timeout=0.0)
            said.append(str(caught.value).partition(" UTC")[0])
        assert said == [f"what held from 1970-01-01 00:00:0{at}" for at in (1, 2, 3)]
        kept.catch_up(timeout=0.0)
        assert set(kept.intervals()) == brute(kept)


def test_what_other_rules_derived_is_derived_again(tmp_path: Path) -> None:
    with create_map(tmp_path / "map.duckdb", scene()) as kept:
        kept.add(scene(floor(), TABLE, CUP), stamp=1.0)
        found = kept.intervals()
        with kept._transaction():
            kept._run("UPDATE derivation SET rules = 'of another time'")
            kept._run("UPDATE holding SET since = 77")
        assert kept.intervals() == found


def kitchen(place: str | Path) -> SemanticMap:
    """Return a map in which a cup falls off a table, is put back, and is taken away."""
    kept = create_map(place, scene(name="kitchen"))
    kept.add(scene(floor(), TABLE, CUP), stamp=100.0)
    kept.add(scene(FALLEN, views=[]), stamp=160.0)
    kept.add(scene(CUP, views=[]), stamp=220.0)
    kept.add(scene(views=[]), stamp=280.0, gone=["cup"])
    kept.add(scene(box("pot", (0.3, 0, 0.9), (0.2, 0.2, 0.2)), views=[]), stamp=280.0)
    return kept


@pytest.mark.parametrize("again", [False, True])
def test_a_frame_of_the_stamp_that_was_derived_last(again: bool, tmp_path: Path) -> None:
    """Two of one stamp are one change: what only the first made hold held at no time."""
    place = tmp_path / "map.duckdb"
    kept = create_map(place, scene())
    kept.add(scene(floor(), TABLE), stamp=1.0)
    kept.add(scene(CUP, views=[]), stamp=2.0)
    assert kept.since("on_top_of", "cup", "table") is not None
    if again:
        kept.close()
        kept = open_map(place)
    with kept:
        kept.add(scene(FALLEN, views=[]), stamp=2.0)
        assert set(kept.intervals()) == brute(kept)
        assert [one.reference for one in kept.intervals("on_top_of", figure="cup")] == ["floor"]


def test_since_when(address: Address) -> None:  # noqa: F811 - a fixture
    with kitchen(address()) as kept:
        on = ("on_top_of", "cup", "table")
        for at, expected in [
            (100.0, (100.0, 160.0)), (159.9, (100.0, 160.0)), (160.0, None), (220.0, (220.0, 280.0)),
            (279.0, (220.0, 280.0)), (280.0, None), (1e9, None),
        ]:  # fmt: skip
            found = kept.since(*on, at=at)
            assert (None if found is None else (found.since, found.until)) == expected
        pot = Interval("on_top_of", "pot", "table", None, 280.0, None)
        assert kept.since(*pot.key[:3]) == pot
        (cup,) = kept.relations(at=270.0, relation=["on_top_of"], reference="table")
        assert cup.figure == "cup"
        left = kept.intervals(["right_of", "left_of"], view="v0")
        assert {one.view for one in left} <= {"v0"}
        assert [one.since for one in kept.intervals(["on_top_of"], figure="cup", start=160.0, end=220.0)] == [
            160.0, 220.0,
        ]  # fmt: skip
        assert kept.intervals(end=99.0) == ()
        assert (kept.span(), kept.views()) == ((100.0, 280.0), {"v0": "robot"})
        assert kept.labels() == {"floor": "floor", "table": "table", "cup": "cup", "pot": "pot"}


def test_what_changed_between(address: Address) -> None:  # noqa: F811 - a fixture
    def named(some: Iterable[Interval]) -> list[tuple[str, str]]:
        return [(one.figure, one.reference) for one in some]

    with kitchen(address()) as kept:
        found = kept.changes(130.0, 300.0, relation="on_top_of")
        assert named(found.gained) == [("pot", "table")]
        assert [(one.figure, one.since, one.until) for one in found.lost] == [("cup", 100.0, 160.0)]
        # Put back and taken away: it was there at the start, and what came back is no news of its own.
        assert named(found.passing) == [("cup", "floor")]
        assert not kept.changes(100.0, 130.0)
        assert not kept.changes(100.0, 230.0, relation=["on_top_of"]).gained
        assert named(kept.changes(100.0, 160.0, relation=["on_top_of"]).gained) == [("cup", "floor")]
        assert {one.view for one in kept.changes(100.0, 280.0).lost} == {None}
        assert {one.view for one in kept.changes(100.0, 280.0, view="v0").lost} <= {None, "v0"}


@pytest.mark.parametrize(
    ("ask", "error", "said"),
    [
        (lambda kept: kept.since("on_top_of", "cup", "table", at=99.0), MapError, "the first frame is of"),
        (lambda kept: kept.since("on_top_of", "cap", "table"), MapError, "did you mean 'cup'"),
        (lambda kept: kept.since("on_top", "cup", "table"), QueryError, "did you mean 'on_top_of'"),
        (lambda kept: kept.since("left_of", "cup", "table"), QueryError, "name a view: known are v0"),
        (lambda kept: kept.since("left_of", "cup", "table", "v9"), QueryError, "a view 'v9': known are v0"),
        (lambda kept: kept.since("on_top_of", "cup", "table", "v0"), QueryError, "depends on no view"),
        (lambda kept: kept.since("on_top_of", "cup", "table", at=float("nan")), MapError, "not a number"),
        (lambda kept: kept.changes(200.0, 150.0), MapError, "runs backwards"),
        (lambda kept: kept.changes(1.0, 150.0), MapError, "the first frame is of"),
        (lambda kept: kept.intervals(region="sphere"), DeixisError, "sphere"),
        (lambda kept: kept.intervals(rules=["none.pl"]), DeixisError, "none.pl"),
    ],
)
def test_wrong_questions(
    ask: Callable[[SemanticMap], object], error: type[DeixisError], said: str, tmp_path: Path
) -> None:
    with kitchen(tmp_path / "map.duckdb") as kept, pytest.raises(error, match=said):
        ask(kept)


def test_a_map_without_frames(tmp_path: Path) -> None:
    with create_map(tmp_path / "map.duckdb", scene()) as kept:
        assert kept.intervals() == ()
        for ask in (kept.span, kept.relations, lambda: kept.changes(0.0, 1.0)):
            with pytest.raises(MapError, match="no frames yet"):
                ask()


def test_ids_are_data(address: Address) -> None:  # noqa: F811 - a fixture
    names = ["'; DROP TABLE held;--", "$1", "%s", "\\N", '"', "a\u202fb", "null", "<x>", "{cup}"]
    things = [box(name, (at / 2 - 2, 0, 0.5), (0.4, 0.5, 1.0), label=name) for at, name in enumerate(names)]
    with create_map(address(), scene(name="'); halt.")) as kept:
        kept.add(scene(floor(), *things), stamp=1.0)
        assert set(kept.intervals()) == brute(kept)
        for name in names:
            assert kept.since("on_top_of", name, "floor") is not None
        kept.add(scene(), stamp=2.0, gone=names)
        assert set(kept.intervals()) == brute(kept)


# In words


def test_every_relation_has_a_phrase() -> None:
    assert list(PHRASES) == [term.name for term in RELATIONS]
    for name, phrase in PHRASES.items():
        if phrase != "partly in":
            assert name in predicates_in(phrase)


def test_sentences() -> None:
    lasting = Lasting({"a": "cup", "b": "cup", "c": "scissors", "d": ""}, {"v": "robot"})
    day = 1795344125.0
    on = Interval("on_top_of", "a", "d", None, day, None)
    assert lasting.holds(on, day) == "The cup (a) has been on d since 2026-11-22 10:42:05 UTC."
    assert lasting.holds(on, day + 1080).endswith("since 2026-11-22 10:42:05 UTC (18 minutes).")
    assert lasting.was(Interval("left_of", "c", "a", "v", day, None)) == (
        "The scissors have been left of the cup (a) as seen from the robot since 2026-11-22 10:42:05 UTC."
    )
    assert lasting.was(Interval("rests", "a", "d", None, day, day + 60)) == (
        "It was so that rests(a, d) from 2026-11-22 10:42:05 UTC to 2026-11-22 10:43:05 UTC (1 minute)."
    )
    assert lasting.not_so(on, None, None) == "The cup (a) is not on d, and was not before."


# The command line


@pytest.fixture
def on_map(tmp_path: Path) -> Callable[..., Result]:
    place = tmp_path / "map.duckdb"
    with create_map(place, scene(name="kitchen")) as kept:
        kept.add(scene(floor(), TABLE, CUP), stamp=1795341600.0)
        kept.add(scene(FALLEN, views=[]), stamp=1795344120.0)
    return lambda *typed: call("map", *typed, "--db", place)


def test_since_on_the_command_line(on_map: Callable[..., Result]) -> None:
    done = on_map("since", "on_top_of(table, floor)")
    assert done == Result(
        0, "The table has been on the floor since 2026-11-22 10:00:00 UTC (42 minutes).\n", ""
    )
    done = on_map("since", "on_top_of(cup, table)", "--why")
    assert (done.code, done.err) == (1, "")
    first, why = done.out.split("\n", 1)
    assert first == (
        "The cup is not on the table; it last was from 2026-11-22 10:00:00 UTC to 2026-11-22 10:42:00 UTC."
    )
    assert why.startswith("No: the cup is not on top of the table (short by ")
    for time in ("10:30", "11:30:00+01:00", "2026-11-22T10:30:00", "1795343400"):
        done = on_map("since", "on_top_of(cup, table)", "--at", time)
        said = "At 2026-11-22 10:30:00 UTC the cup was on the table, since 2026-11-22 10:00:00 UTC, until "
        assert (done.code, done.out) == (0, f"{said}2026-11-22 10:42:00 UTC.\n")
    done = on_map("since", "on_top_of(cup, table)", "--at", "10:30", "--why", "--format", "json")
    found = json.loads(done.out)
    assert (found["holds"], found["interval"]["until"]) == (True, "2026-11-22T10:42:00.000Z")
    assert found["why"]["holds"] is True


def test_of_what_is_gone_the_reason_is_that_it_is(on_map: Callable[..., Result], tmp_path: Path) -> None:
    with open_map(tmp_path / "map.duckdb") as kept:
        kept.add(scene(views=[]), stamp=1795344180.0, gone=["cup"])
    done = on_map("since", "on_top_of(cup, table)", "--why")
    assert (done.code, done.err) == (1, "")
    assert done.out.endswith("to 2026-11-22 10:42:00 UTC.\nNo: at that time there is no cup.\n")
    done = on_map("since", "on_top_of(cup, table)", "--at", "10:43", "--why", "--format", "json")
    assert json.loads(done.out)["why"]["text"] == "at that time there is no cup"


def test_a_time_that_is_told_can_be_asked_for(on_map: Callable[..., Result], tmp_path: Path) -> None:
    """Not cut short to one before it, nor rounded to another, in the calendar or beyond it."""
    for stamp in (1795344180.0005, 1795344180001.0):
        with open_map(tmp_path / "map.duckdb") as kept:
            kept.add(scene(CUP, views=[]), stamp=stamp - 0.25, gone=["table"])
            kept.add(scene(TABLE, views=[]), stamp=stamp)
        (*_, found) = json.loads(on_map("history", "--figure", "cup", "--format", "json").out)
        done = on_map("since", "near(cup, table)", "--at", found["since"], "--format", "json")
        assert (done.code, json.loads(done.out)["interval"]["since"]) == (0, found["since"])


@pytest.mark.parametrize(
    ("typed", "said"),
    [
        (("since", "on_top_of(cap, table)"), "did you mean 'cup'"),
        (("since", "on_top_of(cup, table)", "--at", "09:00"), "the first frame is of 2026-11-22 10:00:00"),
        (("since", "on_top_of(cup, table)", "--at", "25:00"), "is no time"),
        (("since", "on_top_of(X, table)"), "is not one relation of named things"),
        (("since", "left_of(cup, table)"), "does not take 2 arguments"),
        (("since", "left_of(cup, table, v7)"), "nothing is called 'v7'"),
        (("history", "--at", "10:30", "--from", "10:00"), "--at is one time"),
        (("history", "--figure", "cap"), "did you mean 'cup'"),
        (("changes", "10:42", "10:00"), "runs backwards"),
        (("changes", "10:42", "today"), "is no time"),
    ],
)
def test_wrong_commands(typed: tuple[str, ...], said: str, on_map: Callable[..., Result]) -> None:
    done = on_map(*typed)
    assert (done.code, done.out) == (2, "")
    assert said in done.err


def test_history_on_the_command_line(on_map: Callable[..., Result]) -> None:
    done = on_map("history", "--relation", "on_top_of", "--figure", "cup")
    assert done.out == (
        "The cup was on the table from 2026-11-22 10:00:00 UTC to 2026-11-22 10:42:00 UTC (42 minutes).\n"
        "The cup has been on the floor since 2026-11-22 10:42:00 UTC.\n"
    )
    rows = json.loads(on_map("history", "--figure", "cup", "--at", "10:41:59", "--format", "json").out)
    assert {row["reference"] for row in rows if row["relation"] == "on_top_of"} == {"table"}
    csv = on_map("history", "--figure", "cup", "--to", "10:00", "--format", "csv").out.split("\n")
    assert csv[0] == "relation,figure,reference,view,since,until"
    assert on_map("history", "--relation", "inside").code == 1
    assert on_map("list", "--at", "10:41").code == on_map("relations", "--at", "10:41").code == 0


def test_changes_on_the_command_line(on_map: Callable[..., Result]) -> None:
    done = on_map("changes", "10:00", "10:42", "--relation", "on_top_of", "--why")
    lines = [re.split(r" since | from |, | \(", line)[0] for line in done.out.splitlines()]
    assert lines == [
        "+ The cup has been on the floor",
        "  The cup is on top of the floor",
        "- The cup was on the table",
        "  The cup is not on top of the table",
    ]
    found = json.loads(on_map("changes", "10:00", "10:42", "--format", "json").out)
    assert ("on_top_of", "floor") in [(one["relation"], one["reference"]) for one in found["gained"]]
    assert on_map("changes", "10:00", "10:41").code == 1


# SPARQL

SINCE_WHEN = """
SELECT ?what ?since {
  ?held a :Holding ; :relation :onTopOf ; :figure/rdfs:label ?what ; :reference/rdfs:label "table" ;
        time:hasBeginning/time:inXSDDateTimeStamp ?since
  FILTER NOT EXISTS { ?held time:hasEnd ?end }
} ORDER BY ?what"""
AT_A_TIME = """
SELECT ?what {
  ?held a :Holding ; :relation :onTopOf ; :figure/dcterms:identifier ?what ; :reference/rdfs:label "table" ;
        time:hasBeginning/time:inXSDDateTimeStamp ?since
  OPTIONAL { ?held time:hasEnd/time:inXSDDateTimeStamp ?until }
  FILTER (?since <= ?at && (!BOUND(?until) || ?at < ?until))
  BIND ("1970-01-01T00:02:30Z"^^xsd:dateTime AS ?at)
} ORDER BY ?what"""
BETWEEN = """
SELECT ?change ?relation ?what ?by ?when {
  { ?held time:hasBeginning ?moment BIND ("gained" AS ?change) } UNION
  { ?held time:hasEnd ?moment BIND ("lost" AS ?change) }
  ?held :relation ?relation ; :figure/dcterms:identifier ?what ; :reference/dcterms:identifier ?by .
  ?moment time:inXSDDateTimeStamp ?when
  FILTER ("1970-01-01T00:02:00Z"^^xsd:dateTime < ?when && ?when <= "1970-01-01T00:03:00Z"^^xsd:dateTime)
  FILTER (?relation = :onTopOf)
} ORDER BY ?when ?change"""

ANSWERS = {
    SINCE_WHEN: [("pot", "1970-01-01T00:04:40Z")],
    AT_A_TIME: [("cup",)],
    BETWEEN: [
        ("gained", "urn:deixis:term:onTopOf", "cup", "floor", "1970-01-01T00:02:40Z"),
        ("lost", "urn:deixis:term:onTopOf", "cup", "table", "1970-01-01T00:02:40Z"),
    ],
}


@pytest.mark.parametrize("form", ["trig", "nq", "jsonld", "nt"])
def test_an_export_answers_the_three_questions(form: str, tmp_path: Path) -> None:
    kitchen(tmp_path / "map.duckdb").close()
    done = call("map", "export", "--db", tmp_path / "map.duckdb", "-o", tmp_path / f"x.{form}", "--no-proofs")
    assert done.code == 0, done.err
    store = ox.Store()
    store.load(path=tmp_path / f"x.{form}")
    for query, answers in ANSWERS.items():
        found = store.query(query, prefixes=PREFIXES, use_default_graph_as_union=True)
        assert [tuple(one.value for one in row) for row in found] == answers
    # The scene is read back as it is now; what went is no thing of it.
    with open_map(tmp_path / "map.duckdb") as kept:
        back = read_one("rdf", str(tmp_path / f"x.{form}"))
        assert back.to_dict() == kept.scene().to_dict()


def test_a_served_map_answers_the_three_questions(tmp_path: Path) -> None:
    kitchen(tmp_path / "map.duckdb").close()
    with serving(tmp_path / "map.duckdb") as running:
        prefixes = "".join(f"PREFIX {name}: <{iri}>\n" for name, iri in PREFIXES.items())
        for query, answers in ANSWERS.items():
            rows = running.query(prefixes + query).json["results"]["bindings"]
            assert [tuple(one["value"] for one in row.values()) for row in rows] == answers
        graphs = running.query("SELECT DISTINCT ?g { GRAPH ?g { ?s ?p ?o } }").body.decode()
        assert "urn:deixis:scene:kitchen:history" in graphs
