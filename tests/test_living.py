"""Living scenes: after every update what is kept is what a full run finds, for facts and for all rules."""

from __future__ import annotations

import json
import math
import random
import threading
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from bench.job import room
from commands import Result, run
from deixis._files import datalog_files
from deixis.errors import QueryTimeout, SceneError
from deixis.facts import Facts
from deixis.grounding import ground
from deixis.knowledge import KnowledgeBase
from deixis.relations import Relation
from deixis.ruleset import Ruleset, assemble, load, read_text
from deixis.ruleset.extent import extents
from deixis.scene import Scene
from deixis.updates import Changes, Update
from scenes import ROBOT, box, floor, scene, wall
from test_regrounding import same

HANS = Path(__file__).resolve().parent.parent / "kb" / "scenes" / "hans.json"

OWN = """
% looks along chains, whose length no rule bounds
rests(A, B) :- on_top_of(A, B).
rests(A, C) :- rests(A, B), on_top_of(B, C).
% what is far away decides
alone(A, V) :- spatial_obj(A), viewpoint(V), \\+ near(A, _).
same(A, B) :- label(A, L, _), label(B, L, _), A \\== B, \\+ touches(A, B).
% two steps away, one of them a denial
free(A, B) :- on_top_of(A, B), \\+ ( touches(C, A), C \\== B ).
bridge(A, C) :- touches(A, B), touches(B, C), A \\== C, \\+ ( near(A, D), near(D, C), D \\== B ).
seen(A, V) :- left_of(A, B, V), \\+ ( left_of(C, B, V), C \\== A ).
by_name(A, 'o1') :- near(A, 'o1').
% no surfaces, and surfaces as well
propped(A, B) :- touches(A, B), \\+ surface(A), touches(A, C), C \\== B, \\+ above(A, C).
loose(A, B) :- touches(A, B), \\+ ( surface(A), A \\== B, near(B, A) ).
% a fact that links what is far apart
pair_of(o1, o2).
pair_of(A, B) :- on_top_of(A, B).
linked(A, C) :- pair_of(A, B), touches(B, C).
"""


CALLED = ("a", "b", "sweater", "electric heater", "fire extinguisher", "fire extinguisher sign")


@pytest.fixture(scope="module")
def like(tmp_path_factory: pytest.TempPathFactory) -> Iterator[KnowledgeBase]:
    """Return a knowledge base with all rules: those above, and all that are shipped."""
    path = tmp_path_factory.mktemp("own") / "own.pl"
    path.write_text(OWN, encoding="utf-8")
    with KnowledgeBase.from_scene(HANS, rules=[path, "support", "safety"]) as kb:
        yield kb


def everything(kb: KnowledgeBase, *, by_arrays: bool = False) -> dict[Any, float | None]:
    """Return what a full run finds: by the database, which does nothing as arrays do, or faster by arrays."""
    labels = [(view.id, view.label) for view in kb.scene.views]
    executor: Any = kb._executor.arrays if by_arrays else kb._executor.sql
    tables = executor.run(ground(kb.scene, region=kb.region), kb._living.wanted, view_labels=labels)
    return told(((one, row), margin) for one, table in tables.items() for row, margin in table.named())


def kept(kb: KnowledgeBase) -> dict[Any, float | None]:
    return told(kb._living.holds.items())


def told(rows: Iterable[Any]) -> dict[Any, float | None]:
    return {
        (name, row[0], row[1], row[2] if arity == 3 else None): (
            round(margin, 9) + 0.0 if math.isfinite(margin) else None
        )
        for ((name, arity), row), margin in rows
    }


def named(relations: Iterable[Relation]) -> set[Any]:
    return {(one.relation, one.figure, one.reference, one.view) for one in relations}


def change(draw: random.Random, now: Scene, step: int) -> dict[str, Any]:
    """Return a random update of a small crowded room."""

    def place() -> list[float]:
        return [
            round(draw.uniform(-1.2, 1.2), 2),
            round(draw.uniform(-1.2, 1.2), 2),
            draw.choice([0.1, 0.3, 0.5]),
        ]

    movable = [one.id for one in now.objects if one.kind == "object"]
    told: dict[str, Any] = {"stamp": step}
    if movable and draw.random() < 0.6:
        told["moves"] = {
            name: [draw.uniform(-0.3, 0.3), draw.uniform(-0.3, 0.3), draw.choice([0.0, 0.2, -0.2])]
            for name in draw.sample(movable, min(len(movable), draw.choice([1, 1, 2])))
        }
    if draw.random() < 0.3 or not movable:
        size = [draw.choice([0.1, 0.2, 0.6]) for _ in range(3)]
        told["objects"] = [
            box(f"o{draw.randrange(12)}", place(), size, draw.uniform(-3, 3), draw.choice(CALLED))
        ]
    gone = [name for name in movable if name not in told.get("moves", {}) and draw.random() < 0.04]
    shown = {one["id"] for one in told.get("objects", [])}
    told["removed"] = [name for name in gone if name not in shown]
    told["moves"] = {name: way for name, way in told.get("moves", {}).items() if name not in shown}
    if draw.random() < 0.15:
        told["views"] = [{"id": f"v{draw.randrange(2)}", "position": place(), "heading": 0.0}]
    if len(now.views) > 1 and draw.random() < 0.1 and "views" not in told:
        told["removed_views"] = [now.views[0].id]
    if draw.random() < 0.03:
        told["removed"] += [one.id for one in now.objects if one.kind == "surface"][:1]
    return told


def follow(steps: int, draw: random.Random, like: KnowledgeBase, every: int) -> None:
    """Compare after each random update with a full run, by arrays or every so often by the database."""
    things = [
        box(f"o{at}", (draw.uniform(-1, 1), draw.uniform(-1, 1), 0.1), (0.2, 0.2, 0.2)) for at in range(8)
    ]
    kb = KnowledgeBase(scene(floor(), wall(), *things), rules=like._rules)
    # Rules are read and made ready once for all.
    kb.ruleset, kb._executor = like.ruleset, like._executor
    known = kept(kb)
    for step in range(steps):
        update = Update.from_dict(change(draw, kb.scene, step), kb.scene)
        changes = kb.update(update)
        now = kept(kb)
        assert named(changes.gained) == set(now) - set(known)
        assert named(changes.lost) == set(known) - set(now)
        known = now
        assert same(kb.facts, ground(kb.scene)), step
        assert now == everything(kb, by_arrays=(step + 1) % every > 0), step


@pytest.mark.parametrize("seed", range(2))
def test_kept_up_is_what_a_full_run_finds(seed: int, like: KnowledgeBase) -> None:
    follow(30, random.Random(seed), like, 6)  # noqa: S311 - a test


@pytest.mark.long
@settings(max_examples=200, suppress_health_check=list(HealthCheck))
@given(draw=st.randoms(use_true_random=False))
def test_kept_up_for_ten_thousand_steps(draw: random.Random, like: KnowledgeBase) -> None:
    follow(50, draw, like, 50)


@pytest.mark.long
@pytest.mark.parametrize("seed", range(100, 102))
def test_kept_up_for_long(seed: int, like: KnowledgeBase) -> None:
    follow(1000, random.Random(seed), like, 50)  # noqa: S311 - a test


def test_what_becomes_a_surface_or_ceases_to_be_one() -> None:
    block, cup = box("o1", (0, 0, 0.5), (1, 1, 1)), box("o2", (0, 0, 1.1), (0.2, 0.2, 0.2))
    kb = KnowledgeBase(scene(floor(), block, cup))
    for kind in ("surface", "object", "surface"):
        kb.update(Update.from_dict({"objects": [{**block, "kind": kind}]}, kb.scene))
        assert kept(kb) == everything(kb)
        assert any(one[:2] == ("on_top_of", "o1") for one in kept(kb)) == (kind == "object")


def test_rules_may_speak_of_what_is_not_there(tmp_path: Path) -> None:
    path = tmp_path / "ghost.pl"
    path.write_text(
        "known(ghost, floor).\nknown(A, 'floor') :- on_top_of(A, 'floor').\n"
        "marked(ghost, here).\nmarked(A, here) :- surface(A).\n",
        encoding="utf-8",
    )
    kb = KnowledgeBase(scene(floor(), box("o1", (0, 0, 0.1), (0.2, 0.2, 0.2))), rules=[path])
    updates: list[Any] = [
        {"moves": {"o1": [0, 0, 0.5]}},
        {"objects": [box("ghost", (0.5, 0, 0.1), (0.2, 0.2, 0.2))]},
        {"moves": {"ghost": [0, 0, 1]}},
        {"removed": ["ghost"]},
        {"removed": ["floor"]},
    ]
    for told in updates:
        kb.update(Update.from_dict(told, kb.scene))
        assert kept(kb) == everything(kb)
        assert ("marked", "ghost", "here", None) in kept(kb)


def test_a_larger_room_is_kept_up() -> None:
    """Things among many: most conclusions are not looked at again."""
    kb = KnowledgeBase(room(150))
    draw = random.Random(0)  # noqa: S311 - a test
    for step in range(12):
        name = f"o{draw.randrange(140)}"
        way = [draw.uniform(-0.5, 0.5), draw.uniform(-0.5, 0.5), draw.uniform(0.0, 0.3)]
        kb.update(Update.from_dict({"moves": {name: way}}, kb.scene))
        if step % 4 == 3:
            assert kept(kb) == everything(kb)


def test_only_what_is_near_is_derived_again(monkeypatch: pytest.MonkeyPatch) -> None:
    from deixis.engines import AutoExecutor

    kb = KnowledgeBase(room(300))
    _ = kb._living
    asked: list[int] = []
    original = AutoExecutor.run

    def counted(self: AutoExecutor, facts: Facts, *args: Any, **options: Any) -> Any:
        asked.append(len(facts))
        return original(self, facts, *args, **options)

    monkeypatch.setattr(AutoExecutor, "run", counted)
    kb.update(Update.from_dict({"moves": {"o7": [0.05, 0.0, 0.0]}}, kb.scene))
    assert 0 < max(asked) < len(kb.facts) / 3


def rules(text: str) -> Ruleset:
    file, problems = read_text(text, Path("own.pl"))
    ruleset, more = assemble(list(load(datalog_files()).files), [file])
    assert problems == more == []
    return ruleset


def test_how_far_rules_look() -> None:
    found = extents(rules(OWN))
    bounded = {
        name: found[name, arity].bounded for (name, arity) in found if (name, arity) in rules(OWN).user
    }
    assert bounded == {
        "rests": False, "alone": True, "same": False, "free": True, "bridge": True, "seen": True,
        "by_name": True, "propped": True, "loose": True, "pair_of": False, "linked": False,
    }  # fmt: skip
    assert sorted(found["bridge", 2].looks) == [(0, 2), (1, 1), (2, 0)]
    assert found["free", 2].figures == found["propped", 2].figures == {0}
    assert found["loose", 2].figures == frozenset()


def test_subscribers_and_reasons() -> None:
    with KnowledgeBase.from_scene(HANS) as kb:
        heard: list[Changes] = []
        stop = kb.subscribe(heard.append)
        changes = kb.update(Update.from_dict({"moves": {"sweater": [0, 0, 0.1]}, "stamp": 4}, kb.scene))
        assert heard == [changes]
        assert [one.to_prolog() for one in changes.lost] == ["on_top_of('sweater','heater')"]
        assert (changes.stamp, bool(changes)) == (4.0, True)
        # Prolog is told of the scene as it is now.
        assert not kb.why("on_top_of(sweater, heater)")
        stop()
        back = kb.update(Update.from_dict({"moves": {"sweater": [0, 0, -0.1]}}, kb.scene))
        assert [one.to_prolog() for one in back.gained] == ["on_top_of('sweater','heater')"]
        assert kb.why("on_top_of(sweater, heater)")
        assert len(heard) == 1
        assert not kb.update(Update())


@pytest.mark.parametrize(
    ("told", "said"),
    [
        ([], "is a JSON object"),
        ({"object": []}, "no key 'object'"),
        ({"removed": "sweater"}, "not a list of ids"),
        ({"removed": ["sweter"]}, "did you mean 'sweater'"),
        ({"moves": {"sweater": [1, 2]}}, "three numbers"),
        ({"moves": {"sweater": "abc"}}, "three numbers"),
        ({"moves": {"sweater": [[1], [2, 3], 0]}}, "three numbers"),
        ({"moves": {"sweater": {"a": 1}}}, "three numbers"),
        ({"moves": {"sweater": ["1", 0, 0]}}, "three numbers"),
        ({"moves": {"sweater": [10**400, 0, 0]}}, "three numbers"),
        ({"moves": {"swater": [1, 2, 3]}}, "has no object"),
        ({"moves": [1]}, "no JSON object"),
        ({"moves": {"sweater": [0, 0, 1]}, "removed": ["sweater"]}, "both given and removed"),
        ({"removed_views": ["v7"]}, "no view 'v7'"),
        ({"views": [ROBOT], "removed_views": [ROBOT["id"]]}, "both given and removed"),
        ({"views": [{"id": "world", "position": [0, 0, 0]}]}, "the name is taken"),
        ({"stamp": "now"}, "not a finite number"),
        ({"stamp": True}, "not a finite number"),
        ({"objects": [{"id": "x"}]}, "x"),
        ({"objects": [{"id": "x", "points": "/etc/passwd"}]}, "x"),
    ],
)
def test_what_is_refused_leaves_everything_as_it_was(told: Any, said: str) -> None:
    kb = KnowledgeBase.from_scene(HANS)
    before, facts, holds = kb.scene, kb.facts, dict(kb._living.holds)
    with pytest.raises(SceneError, match=said):
        kb.update(Update.from_dict(told, kb.scene))
    assert (kb.scene, kb.facts, kb._living.holds) == (before, facts, holds)


def test_updates_of_many_threads_are_all_made() -> None:
    kb = KnowledgeBase(scene(floor(), *(box(f"o{at}", (at, 0, 0.1), (0.2, 0.2, 0.2)) for at in range(8))))
    _ = kb._living

    def work(at: int) -> None:
        for _ in range(5):
            kb.update(Update.from_dict({"moves": {f"o{at}": [0.0, 0.1, 0.0]}}, kb.scene))

    threads = [threading.Thread(target=work, args=(at,)) for at in range(4)]
    for one in threads:
        one.start()
    for one in threads:
        one.join()
    assert kept(kb) == everything(kb)


# The command line


def live(*lines: str, options: tuple[str, ...] = ()) -> tuple[Result, list[Any]]:
    done = run("live", str(HANS), *options, stdin="\n".join(lines))
    return done, [json.loads(line) for line in done.out.splitlines()]


def test_updates_in_changes_out() -> None:
    done, told = live(
        '{"stamp": 1.5, "moves": {"sweater": [0, 0, 0.1]}}',
        "",
        '{"views": [' + json.dumps(ROBOT) + "]}",
        '{"removed": ["heater"]}',
    )
    assert (done.code, done.err) == (0, "")
    assert [one["update"] for one in told] == [1, 2, 3]
    (lost,) = told[0]["lost"]
    assert (told[0]["stamp"], lost["relation"], lost["figure"]) == (1.5, "on_top_of", "sweater")
    assert lost["because"].startswith("The sweater is not on top of the electric heater")
    assert any("gone" in one["because"] for one in told[2]["lost"])


def test_a_bad_line_changes_nothing_and_says_so() -> None:
    done, told = live("{", '{"removed": ["x"]}', '{"moves": {"sweater": [0, 0, 0.1]}}', options=("--brief",))
    assert done.code == 2
    assert ["error" in one for one in told] == [True, True, False]
    assert set(told[2]["lost"][0]) == {"relation", "figure", "reference", "view", "margin"}


def test_a_derivation_that_takes_too_long_changes_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "wide.pl"
    path.write_text(
        "trio(A, B, C) :- spatial_obj(A), spatial_obj(B), spatial_obj(C).\n"
        "wide(A, F) :- trio(A, B, C), trio(D, E, F), A \\== B, C \\== D, E \\== F.\n",
        encoding="utf-8",
    )
    things = [box(f"o{at}", (at, 0, 0.1), (0.2, 0.2, 0.2)) for at in range(60)]
    kb = KnowledgeBase(scene(floor(), *things[:3]), rules=[path])
    before, holds = kb.scene, dict(kb._living.holds)
    monkeypatch.setattr(kb._living, "_timeout", 0.5)
    crowd = scene(*things[3:])
    with pytest.raises(QueryTimeout, match=r"within 0\.5 s"):
        kb.update(Update(objects=crowd.objects))
    assert (kb.scene, kb._living.holds) == (before, holds)
    monkeypatch.setattr(kb._living, "_timeout", 60.0)
    assert kb.update(Update.from_dict({"moves": {"o1": [0, 0, 1]}}, kb.scene))
    assert kept(kb) == everything(kb)
