"""Maps in tiles: the union over tiles is the whole to the last bit, whatever spans them and is asked."""

from __future__ import annotations

import json
import random
import re
from collections import Counter
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import duckdb
import numpy as np
import psycopg
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from commands import call, run
from deixis._files import datalog_files
from deixis.broadphase import candidate_rows, plan_bounds, reach
from deixis.errors import GeometryError, QueryError, ReaderError, RuleError, SceneError
from deixis.grounding import ground
from deixis.knowledge import KnowledgeBase
from deixis.relations import rounded, rounded_all
from deixis.ruleset import assemble, load, locate, read_text
from deixis.ruleset.owning import ownerships
from deixis.scene import Scene
from deixis.tiles import OBJECTS, Summary, store
from deixis.tiles import run as run_tiles
from deixis.tiles.measure import box_facts
from deixis.vocabulary import BASE, RELATIONS
from postgis_server import PostgisUnavailable, postgis
from programs import random_program
from scenes import box, floor, scene, wall
from test_living import OWN
from test_regrounding import same

SPOKEN = [term.name for term in RELATIONS]
LIVING = ["rests", "alone", "same", "free", "bridge", "seen", "by_name", "pair_of", "linked"]
SIZES = (0.05, 0.3, 0.7, 1.0, 2.5, 9.0, 1000.0)

More = """
% by way of what is no surface, two links away
beyond(A, C) :- touches(A, B), \\+ surface(B), near(B, C), \\+ surface(A), A \\== C.
% the same, but what is between may be a floor
across(A, C) :- touches(A, B), touches(C, B), \\+ surface(A), \\+ surface(C), A \\== C.
% what stands on a chain of things, and has nothing on top of the other end
clear(A, B) :- tower(A, B), \\+ ( on_top_of(C, A), tower(C, B) ).
tower(A, B) :- on_top_of(A, B).
tower(A, C) :- on_top_of(A, B), tower(B, C).
% things with one label, one of which is near something
twin(A, B) :- label(A, L, _), label(B, L, _), A \\== B, \\+ near(A, B).
% which rows it has is written; of what is there and what is not
listed(o1, o2).
listed(o3, nowhere).
listed(A, B) :- inside(A, B).
kept(A, B) :- listed(A, B), \\+ near(A, B).
crowded(A, V) :- viewpoint(V), near(A, B), near(A, C), left_of(B, C, V), \\+ on_top_of(B, C).
lonely(A, here) :- surface(A), \\+ touches(A, _).
held(A, floor) :- on_top_of(A, floor).
"""


def whole(place: Path, names: list[str], rules: list[Path]) -> dict[Any, Any]:
    with KnowledgeBase(Scene.load(place), rules=rules) as kb:
        found = kb.relations(relation=names, timeout=300.0)
        labels = {thing.id: thing.label or None for thing in kb.scene.objects}
        noise = kb.scene.thresholds.pose_noise
    return {
        (one.relation, one.figure, one.reference, one.view): (
            one.margin,
            one.margin is not None and one.margin < noise,
            labels.get(one.figure),
            labels.get(one.reference),
        )
        for one in found
    }


def union(target: Path) -> dict[Any, Any]:
    """Return what is in all tiles; nothing may be in two of them."""
    columns = "relation, figure, reference, view, margin, uncertain, figure_label, reference_label"
    rows = duckdb.read_parquet(f"{target}/relations/*/*.parquet").project(columns).fetchall()
    found = {row[:4]: row[4:] for row in rows}
    assert len(found) == len(rows)
    return found


def check(
    whole_scene: Scene, size: float | None, names: list[str], rules: list[Path], **options: Any
) -> Summary:
    """Compare the union over tiles with a whole run."""
    with TemporaryDirectory(prefix="deixis-") as name:
        place, target = Path(name) / "map.json", Path(name) / "out"
        whole_scene.save(place)
        done = run_tiles(
            [place], target, size=size, relations=names, rules=rules, **{"workers": 1, **options}
        )
        found, wanted = union(target), whole(place, names, rules)
        assert found == wanted
        assert done.relations == len(found)
        assert done.things == len(whole_scene.objects)
        return done


def random_scene(draw: random.Random) -> Scene:
    """Return a small crowded map: things in stacks, long ones, walls and floors of all kinds, odd names."""
    names = [
        "o1",
        "o2",
        "o3",
        "a",
        "b",
        "c",
        "d",
        "X y",
        "world",
        "it's",
        "floor",
        "X+",
        "\u00e9\U0001f600",
        "box",
    ]
    count = draw.randint(0, 14)
    things: list[dict[str, Any]] = []
    spread = draw.choice([0.5, 2.0, 6.0, 30.0])
    for name in draw.sample(names, min(count, len(names))):
        at = [round(draw.uniform(-spread, spread), draw.choice([0, 1, 3])) for _ in range(2)]
        size = [draw.choice([0.0, 0.1, 0.4, 1.0]) for _ in range(3)]
        if draw.random() < 0.15:
            size[draw.randrange(2)] = draw.choice([4.0, 15.0])
        below = draw.choice([0.0, 0.0, 0.02, -0.03])
        if things and draw.random() < 0.4:
            under = draw.choice(things)["box"]
            at = [under["center"][0], under["center"][1]]
            below += under["center"][2] + under["size"][2] / 2
        center = [*at, below + size[2] / 2]
        things.append(box(name, center, size, draw.choice([0.0, 0.0, 0.5, -2.9]), draw.choice("ab")))
    if draw.random() < 0.5:
        things.append(floor("ground", draw.choice([0.3, 3.0, 20.0])))
    if draw.random() < 0.5:
        things.append(wall("wall", draw.choice([0.0, 1.5]), draw.choice([0.4, 12.0])))
    if draw.random() < 0.3:
        slab = box("slab", [0.3, 0.0, 1.0], [draw.choice([0.5, 25.0]), 0.1, 2.0], 0.3)
        things.append({**slab, "kind": "surface"})
    views = [
        {"id": f"v{at}", "label": "robot", "position": [draw.uniform(-9, 9), 1.0, 1.0], "heading": 0.0}
        for at in range(draw.randint(0, 2))
    ]  # fmt: skip
    return scene(*things, views=views, thresholds={"closeness": draw.choice([0.3, 1.0])})


def without_singletons(line: str) -> str:
    """Return a rule with _ for variables that it names once, as a file must have it."""
    once = [name for name, count in Counter(re.findall(r"\b[A-Z]\d+\b", line)).items() if count == 1]
    return re.sub(r"\b[A-Z]\d+\b", lambda found: "_" if found[0] in once else found[0], line)


def random_case(seed: int) -> None:
    draw = random.Random(seed)  # noqa: S311 - a test
    there = random_scene(draw)
    size = draw.choice(SIZES)
    with TemporaryDirectory(prefix="deixis-") as name:
        own = Path(name) / "own.pl"
        choice = draw.randrange(4)
        names = [*SPOKEN, *draw.sample([term.name for term in BASE], 4)]
        if choice == 0:
            program = random_program(draw)
            lines = [without_singletons(line) for line in program.text.splitlines()]
            own.write_text("\n".join(lines) + "\n", encoding="utf-8")
            names = ["near", *(one for one, shape in program.shapes.items() if shape in ("nn", "nnn"))]
        elif choice == 1:
            own.write_text(OWN, encoding="utf-8")
            names += LIVING
        else:
            own.write_text(More, encoding="utf-8")
            names += [
                "beyond",
                "across",
                "clear",
                "tower",
                "twin",
                "listed",
                "kept",
                "crowded",
                "lonely",
                "held",
            ]
        check(there, size, names, [own])


@settings(max_examples=25, suppress_health_check=list(HealthCheck))
@given(st.integers(0, 1 << 40))
def test_the_union_over_tiles_is_the_whole(seed: int) -> None:
    random_case(seed)


@pytest.mark.long
@settings(max_examples=3000, suppress_health_check=list(HealthCheck))
@given(st.integers(0, 1 << 40))
def test_the_union_over_tiles_is_the_whole_many_times(seed: int) -> None:
    random_case(seed)


def test_a_tower_that_recursion_goes_up_through_tiles() -> None:
    leaning = [box(f"b{at}", [0.3 * at, 0.0, 0.2 + 0.4 * at], [0.6, 0.6, 0.4]) for at in range(12)]
    done = check(scene(floor(), *leaning), 0.5, ["supported_by", "supports", "near"], [Path("support")])
    assert done.tiles > 6


def test_a_long_thing_touches_what_is_tiles_away() -> None:
    """Axiom 38 denies that anything else touches the figure, however far from its middle."""
    beam = box("beam", [0.0, 0.0, 1.0], [30.0, 0.1, 0.1])
    shelf = box("shelf", [14.5, 0.4, 1.0], [0.6, 0.7, 3.0])
    peg = box("peg", [-14.8, 0.06, 1.0], [0.02, 0.02, 0.02])
    for things in ([beam, shelf], [beam, shelf, peg], [beam, wall("wall", 15.0, 9.0), peg]):
        check(scene(*things), 1.0, [*SPOKEN, "touches"], [])


def test_a_floor_joins_what_stands_on_it_however_far_apart(tmp_path: Path) -> None:
    own = tmp_path / "own.pl"
    own.write_text(More, encoding="utf-8")
    cups = [box(f"cup{at}", [6.0 * at, 0.0, 0.1], [0.2, 0.2, 0.2]) for at in range(-3, 4)]
    check(scene(floor("ground", 20.0), *cups), 2.0, ["across", "beyond", "lonely", "held"], [own])


def test_the_theory_needs_only_what_is_one_link_away() -> None:
    found = ownerships(load(datalog_files(), locate(["support"], datalog_files())))
    assert {found[term.name, term.arity].links for term in (*RELATIONS, *BASE)} == {1}
    assert ("held_by", 2) in found
    assert ("supported_by", 2) not in found


def test_who_owns_what() -> None:
    file, _ = read_text(More, Path("own.pl"))
    ruleset, problems = assemble(list(load(datalog_files()).files), [file])
    assert problems == []
    found = ownerships(ruleset)
    owned = {name: found[name, arity].links for name, arity in ruleset.user if (name, arity) in found}
    assert owned == {"beyond": 2, "held": 1, "crowded": 1}


def test_boxes_have_the_facts_of_their_scene() -> None:
    draw = random.Random(7)  # noqa: S311 - a test
    for _ in range(10):
        there = random_scene(draw)
        names = [thing.id for thing in there.objects]
        labels = tuple(tuple((one.name, one.score) for one in thing.labels) for thing in there.objects)
        assert same(box_facts(there, names, labels, there.boxes), ground(there))
        # What is around a tile is found by these.
        low, high = plan_bounds(there.boxes, there.thresholds)
        far = reach(there.boxes, there.thresholds)
        for one, two in zip(*candidate_rows(there.boxes, there.thresholds), strict=True):
            gap = max(0.0, *(low[one] - high[two]), *(low[two] - high[one]))
            assert gap <= max(far[one], far[two])


@given(st.lists(st.floats(allow_nan=False), min_size=1))
def test_margins_are_rounded_as_one_by_one(values: list[float]) -> None:
    near = [round(one, 9) + 0.5e-9 for one in values if abs(one) < 1e5]
    every = np.array([*values, *near, 0.5e-9, 1.5e-9, 2.5e-9])
    wanted = [one if np.isinf(one) else rounded(float(one)) for one in every.tolist()]
    assert rounded_all(every).tolist() == wanted


# Tables


def table(count: int = 300, **columns: Any) -> pa.Table:
    rng = np.random.default_rng(3)
    told: dict[str, Any] = {
        "id": [f"o{at}" for at in range(count)],
        "label": ["cup" if at % 3 else None for at in range(count)],
        "x": rng.uniform(-8, 8, count), "y": rng.uniform(-8, 8, count), "z": rng.uniform(0, 1, count),
        "size_x": rng.uniform(0, 1, count), "size_y": rng.uniform(0, 1, count),
        "size_z": rng.uniform(0, 1, count),
        "yaw": rng.uniform(-3, 3, count),
    }  # fmt: skip
    return pa.table({**told, **columns})


def as_scene(rows: pa.Table) -> Scene:
    things = []
    for row in rows.to_pylist():
        thing = box(
            row["id"],
            [row["x"], row["y"], row["z"]],
            [row["size_x"], row["size_y"], row["size_z"]],
            row["yaw"],
        )
        del thing["label"]
        if row.get("labels"):
            thing["labels"] = row["labels"]
        elif row.get("label"):
            thing["label"] = row["label"]
        things.append({**thing, "kind": row.get("kind") or "object"})
    return scene(*things, name="views")


def views(folder: Path) -> Path:
    place = folder / "views.json"
    scene(name="views").save(place)
    return place


def test_parquet_arrow_lines_and_scenes_give_the_same(tmp_path: Path) -> None:
    labels = [
        [{"name": "cup", "score": 0.2}, {"name": "mug", "score": 0.7}] if at % 2 else None
        for at in range(300)
    ]
    kinds = ["surface" if at in (5, 6) else ("object" if at % 2 else None) for at in range(300)]
    rows = table(labels=labels, kind=kinds, label=[None if at % 2 else "tin" for at in range(300)])
    there = as_scene(rows)
    pq.write_table(rows, tmp_path / "map.parquet", row_group_size=70)
    with pa.OSFile(str(tmp_path / "map.arrow"), "wb") as sink, pa.ipc.new_file(sink, rows.schema) as writer:
        writer.write_table(rows, max_chunksize=64)
    lines = "\n".join(json.dumps(one) for one in there.to_dict()["objects"])
    (tmp_path / "map.jsonl").write_text(lines + "\n\n", encoding="utf-8")
    there.save(tmp_path / "map.json")
    wanted = whole(tmp_path / "map.json", SPOKEN, [])
    for kind in ("parquet", "arrow", "jsonl"):
        target = tmp_path / kind
        run_tiles([tmp_path / f"map.{kind}", views(tmp_path)], target, size=3.0, workers=1)
        assert union(target) == wanted, kind
    # What comes out can go in again.
    run_tiles([tmp_path / "parquet" / "things", views(tmp_path)], tmp_path / "again", size=4.0, workers=1)
    assert {key: value[0] for key, value in union(tmp_path / "again").items()} == {
        key: value[0] for key, value in wanted.items()
    }


def test_rows_say_what_they_are_and_where_they_are_stated(tmp_path: Path) -> None:
    pq.write_table(table(), tmp_path / "map.parquet")
    run_tiles([tmp_path / "map.parquet"], tmp_path / "out", workers=1)
    (one,) = duckdb.sql(
        f"FROM read_parquet('{tmp_path}/out/relations/*/*.parquet', hive_partitioning = true) "
        "WHERE relation = 'on_top_of' ORDER BY figure LIMIT 1"
    ).fetchall()
    assert (one[0], one[1], one[2], one[5]) == ("map.parquet", "map", "on_top_of", None)
    assert one[10].startswith("commonsense.pl:")
    noted = json.loads((tmp_path / "out" / "manifest.json").read_text(encoding="utf-8"))
    assert noted["done"]
    assert noted["things"] == 300
    assert not (tmp_path / "out" / ".deixis-work").exists()


def test_no_tile_has_more_things_than_wanted(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(store, "TARGET", 60)
    pq.write_table(table(1500, size_x=np.full(1500, 0.1)), tmp_path / "map.parquet")
    done = run_tiles([tmp_path / "map.parquet"], tmp_path / "out", workers=1, relations="near")
    assert done.tiles > 1
    with KnowledgeBase(as_scene(table(1500, size_x=np.full(1500, 0.1)))) as kb:
        assert done.relations == len(kb.relations(relation=["near"]))


def test_a_stopped_run_goes_on_where_it_was(tmp_path: Path) -> None:
    pq.write_table(table(), tmp_path / "map.parquet")

    class Stop(Exception):
        pass

    def stop(now: Summary) -> None:
        if now.done == 4:
            raise Stop

    options: dict[str, Any] = {
        "size": 3.0,
        "workers": 1,
        "rules": [Path("support")],
        "relations": ["near", "supports"],
    }
    with pytest.raises(Stop):
        run_tiles([tmp_path / "map.parquet"], tmp_path / "out", progress=stop, **options)
    parts = sorted((tmp_path / "out" / "relations").rglob("*.parquet"))
    stamps = [one.stat().st_mtime_ns for one in parts]
    done = run_tiles([tmp_path / "map.parquet"], tmp_path / "out", **options)
    assert (len(parts), done.before, done.done) == (4, 4, done.tiles - 4)
    assert [one.stat().st_mtime_ns for one in parts] == stamps
    run_tiles([tmp_path / "map.parquet"], tmp_path / "other", **options)
    assert union(tmp_path / "out") == union(tmp_path / "other")
    again = run_tiles([tmp_path / "map.parquet"], tmp_path / "out", **options)
    assert (again.done, again.relations, again.things) == (0, done.relations, 300)
    with pytest.raises(ReaderError, match="another map or other options"):
        run_tiles([tmp_path / "map.parquet"], tmp_path / "out", **{**options, "size": 4.0})


def test_what_was_written_is_not_read_again(tmp_path: Path) -> None:
    """A run goes on in a folder that lies among its maps."""
    pq.write_table(table(), tmp_path / "map.parquet")
    done = run_tiles([tmp_path], tmp_path / "out", size=9.0, relations=["near"], workers=1)
    (tmp_path / "out" / ".deixis-work").mkdir()  # as of a run that was stopped before it had tidied up
    again = run_tiles([tmp_path], tmp_path / "out", size=9.0, relations=["near"], workers=1)
    assert (again.before, again.relations) == (done.tiles, done.relations)
    assert not (tmp_path / "out" / ".deixis-work").exists()


def test_processes_share_the_tiles(tmp_path: Path) -> None:
    pq.write_table(table(), tmp_path / "map.parquet")
    for name, workers in (("one", 1), ("two", 2)):
        run_tiles([tmp_path / "map.parquet"], tmp_path / name, size=5.0, workers=workers)
    assert union(tmp_path / "one") == union(tmp_path / "two")


@pytest.mark.filterwarnings("ignore::DeprecationWarning:ray.*")  # Ray's own, from within
@pytest.mark.usefixtures("cluster")
def test_ray_shares_the_tiles(tmp_path: Path) -> None:
    pq.write_table(table(), tmp_path / "map.parquet")
    for name in ("local", "ray"):
        run_tiles([tmp_path / "map.parquet"], tmp_path / name, size=5.0, workers=2, engine=name)
    assert union(tmp_path / "local") == union(tmp_path / "ray")


def test_a_map_of_nothing(tmp_path: Path) -> None:
    place = tmp_path / "empty.json"
    scene().save(place)
    done = run_tiles(
        [place], tmp_path / "out", workers=1, rules=[Path("support")], relations=["near", "supports"]
    )
    assert (done.things, done.relations) == (0, 0)
    assert union(tmp_path / "out") == {}


def test_duckdb_and_postgis_read_what_comes_out(tmp_path: Path) -> None:
    """As the README says: through a table of text that DuckDB writes and COPY reads."""
    there = scene(floor(), *(box(f"o{at}", [at, 0.0, 0.25], [0.4, 0.4, 0.5], 0.3) for at in range(-4, 5)))
    there.save(tmp_path / "map.json")
    run_tiles([tmp_path / "map.json"], tmp_path / "out", size=2.5, workers=1)
    with duckdb.connect() as base:
        base.read_parquet(f"{tmp_path}/out/things/*/*.parquet").create_view("things")
        base.read_parquet(f"{tmp_path}/out/relations/*/*.parquet").create_view("relations")
        on_top = base.sql(
            "SELECT figure FROM relations WHERE relation = 'on_top_of' ORDER BY figure"
        ).fetchall()
        plan = "SELECT id, label, kind, hex(ST_AsWKB(geometry)) FROM things"
        base.sql(plan).write_csv(f"{tmp_path}/things.csv")
        base.sql("SELECT relation, figure, reference, view, margin FROM relations").write_csv(
            f"{tmp_path}/relations.csv"
        )
    try:
        with postgis() as address, psycopg.connect(address, autocommit=True) as connection:
            connection.execute(
                "CREATE TABLE things (id text PRIMARY KEY, label text, kind text, geometry geometry)"
            )
            connection.execute(
                "CREATE TABLE relations (relation text, figure text, reference text, view text, margin float)"
            )
            for name in ("things", "relations"):
                with connection.cursor().copy(f"COPY {name} FROM STDIN CSV HEADER") as copy:
                    copy.write((tmp_path / f"{name}.csv").read_bytes())
            found = connection.execute(
                "SELECT figure FROM relations JOIN things ON figure = id "
                "WHERE relation = 'on_top_of' ORDER BY figure"
            ).fetchall()
            assert found == on_top
            assert len(found) == 9
            areas = connection.execute(
                "SELECT id, ST_Area(geometry), ST_X(ST_Centroid(geometry)) FROM things"
            ).fetchall()
            assert {name: round(area, 9) for name, area, _ in areas if name != "floor"} == {
                f"o{at}": 0.16 for at in range(-4, 5)
            }
            assert {round(x, 9) for _, _, x in areas} == set(range(-4, 5))
    except PostgisUnavailable as reason:
        pytest.skip(str(reason))


# What is refused


@pytest.mark.parametrize(
    ("columns", "said"),
    [
        ({"x": [float("nan"), 0.0, 0.0]}, "'o0': x is nan"),
        ({"y": [0.0, float("inf"), 0.0]}, "'o1': y is inf"),
        ({"z": [0.0, 0.0, 1.0e300]}, "'o2': z is"),
        ({"z": [0.0, None, 0.0]}, "'o1': z is None"),
        ({"size_x": [0.0, -1.0, 0.0]}, "'o1': size_x is -1.0"),
        ({"id": ["a", "", "c"]}, "row 2: id is ''"),
        ({"id": ["a", None, "c"]}, "row 2: id is None"),
        ({"id": ["a", "b\n", "c"]}, "row 2: id is"),
        ({"id": ["a", "b\u202e", "c"]}, "row 2: id is"),
        ({"id": ["a", "b" * 300, "c"]}, "row 2: id is"),
        ({"id": ["a", "b", "a"]}, "'a' is given more than once"),
        ({"kind": ["object", "wall", None]}, "'o1': kind is 'wall'"),
        ({"label": ["", "b", None]}, "'o0': label is ''"),
        ({"label": [None] * 3, "labels": [[{"name": "a", "score": 2.0}], None, None]}, "'o0': labels is"),
        ({"label": [None] * 3, "labels": [None, [{"name": None, "score": 1.0}], None]}, "'o1': labels is"),
        ({"labels": [[{"name": "a", "score": 1.0}]] * 3}, "keep one"),
    ],
)
def test_a_row_that_is_not_well_formed(tmp_path: Path, columns: dict[str, Any], said: str) -> None:
    rows = {**table(3, label=["a", "b", "c"]).to_pydict(), **columns}
    schema = pa.schema([OBJECTS.field(name).with_nullable(True) for name in OBJECTS.names if name in rows])
    pq.write_table(pa.table(rows, schema=schema), tmp_path / "map.parquet")
    with pytest.raises(SceneError) as error:
        run_tiles([tmp_path / "map.parquet"], tmp_path / "out", workers=1)
    assert said in str(error.value)


def test_files_that_are_no_maps(tmp_path: Path) -> None:
    whole_file = tmp_path / "map.parquet"
    pq.write_table(table(), whole_file)
    cut = tmp_path / "cut.parquet"
    cut.write_bytes(whole_file.read_bytes()[:2000])
    (tmp_path / "garbage.arrow").write_bytes(b"\x00" * 99)
    (tmp_path / "map.txt").write_text("x", encoding="utf-8")
    pq.write_table(pa.table({"id": ["a"], "x": [1.0]}), tmp_path / "few.parquet")
    pq.write_table(table(3, x=["a", "b", "c"]), tmp_path / "text.parquet")
    (tmp_path / "bad.jsonl").write_text(
        '{"id": "a", "box": {"center": [0, 0, 0], "size": [1, 1, 1]}}\n{', "utf-8"
    )
    (tmp_path / "empty").mkdir()
    refused: list[tuple[str, type[Exception], str]] = [
        ("cut.parquet", ReaderError, "is no Parquet file"),
        ("garbage.arrow", ReaderError, "is no Arrow file"),
        ("map.txt", ReaderError, "of no known kind"),
        ("nowhere.parquet", ReaderError, "does not exist"),
        ("empty", ReaderError, "holds no map"),
        ("few.parquet", ReaderError, "has no column y, z"),
        ("text.parquet", ReaderError, "column x is not what it should be"),
        ("bad.jsonl", SceneError, "line 2: not JSON"),
    ]
    for at, (name, kind, said) in enumerate(refused):
        with pytest.raises(kind, match=said):
            run_tiles([tmp_path / name], tmp_path / f"out{at}", workers=1)


def test_options_that_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pq.write_table(table(), tmp_path / "map.parquet")

    def go(**options: Any) -> None:
        run_tiles([tmp_path / "map.parquet"], tmp_path / "out", **{"workers": 1, **options})

    for size in (0.0, -1.0, float("nan"), 1e9):
        with pytest.raises(ReaderError, match="give its side in metres"):
            go(size=size)
    with pytest.raises(QueryError, match="no relation 'nearr'"):
        go(relations=["nearr"])
    with pytest.raises(RuleError, match="there is no rule file"):
        go(rules=[tmp_path / "none.pl"])
    monkeypatch.setattr(store, "MOST", 50)
    with pytest.raises(GeometryError, match=r"tile .*choose smaller tiles"):
        go(size=8.0)


def test_thresholds_that_do_not_agree(tmp_path: Path) -> None:
    for name, closeness in (("a", 1.0), ("b", 2.0)):
        scene(name=name, thresholds={"closeness": closeness}).save(tmp_path / f"{name}.json")
    with pytest.raises(SceneError, match="other thresholds"):
        run_tiles([tmp_path], tmp_path / "out", workers=1)


# The command line


def test_the_command(tmp_path: Path) -> None:
    pq.write_table(table(), tmp_path / "map.parquet")
    done = call("tiles", tmp_path / "map.parquet", "-o", tmp_path / "out", "--size", "6", "--workers", "1")
    assert (done.code, done.out) == (0, "")
    assert "300 things" in done.err
    again = call("tiles", tmp_path / "map.parquet", "-o", tmp_path / "out", "--size", "6", "--workers", "1")
    assert "of them done before" in again.err
    refused = call("tiles", tmp_path / "map.parquet", "-o", tmp_path / "out", "--size", "7")
    assert (refused.code, refused.err[:7]) == (2, "deixis:")
    alone = run("tiles", str(tmp_path / "map.parquet"), "-o", str(tmp_path / "two"), "--size", "6")
    assert (alone.code, alone.err.partition(": ")[2]) == (0, done.err.partition(": ")[2])
