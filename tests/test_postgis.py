"""Table 1(a) of the paper in PostGIS: the same facts as our own kernel's, and what is written of them."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from pathlib import Path
from urllib.parse import quote

import numpy as np
import psycopg
import pytest
from hypothesis import given, settings

from bench import coverage
from bench.coverage_cases import CASES
from bench.coverage_study import Study, random_clouds, random_room
from commands import call
from deixis.errors import GeometryError, MissingDependency, QueryError
from deixis.facts import Facts
from deixis.grounding import ground
from deixis.knowledge import KnowledgeBase
from deixis.polyhedra import hulls
from deixis.postgis import ground as postgis_ground
from deixis.postgis import grounding as tables
from deixis.postgis.functions import names
from deixis.scene import Scene
from deixis.semantic_map import create_map
from postgis_server import PostgisUnavailable, postgis
from scenes import box, floor, scene, wall
from worlds import World, worlds

HERE = Path(__file__).resolve().parent
SCENES = sorted([*(HERE / "golden").glob("*.json"), *(HERE.parent / "kb" / "scenes").glob("*.json")])
COVERAGE = HERE.parent / "kb" / "coverage.md"

NANOMETRES = 2.0e-9


@pytest.fixture(scope="module")
def server() -> Iterator[str]:
    try:
        with postgis() as address:
            yield address
    except PostgisUnavailable as reason:
        pytest.skip(str(reason))


@pytest.fixture(scope="module")
def connection(server: str) -> Iterator[psycopg.Connection]:
    with psycopg.connect(server, autocommit=True) as session:
        yield session


@pytest.fixture(scope="module")
def url(connection: psycopg.Connection) -> str:
    where = connection.info
    return f"postgresql://{where.user}@/{where.dbname}?host={quote(where.host, safe='')}"


def same(one: np.ndarray, other: np.ndarray) -> bool:
    return one.shape == other.shape and bool((np.abs(one.astype(float) - other) <= NANOMETRES).all())


def differences(mine: Facts, theirs: Facts) -> list[str]:
    """Return the columns in which facts differ, but for the two in which they may."""
    found = [
        name
        for name in ("separation", "intersection", "protrusion", "vertical", "vertical_strict", "ordered")
        if not same(getattr(mine, name), getattr(theirs, name))
    ]
    found += [
        name
        for name in ("ids", "labels", "models", "thresholds", "region")
        if getattr(mine, name) != getattr(theirs, name)
    ]
    if not same(mine.volume, theirs.volume):
        found.append("volume")
    for one, other in zip(mine.views, theirs.views, strict=True):
        if (
            one.view != other.view
            or one.withheld != other.withheld
            or not np.array_equal(one.rows, other.rows)
        ):
            found.append(f"{one.view}: what is spoken of")
            continue
        silent = {thing for thing, _ in one.withheld}
        if set(one.ambiguous) - silent != set(other.ambiguous) - silent:
            found.append(f"{one.view}: ties")
        for name in ("int_hs", "cont_hs"):
            ours, told = getattr(one, name), getattr(other, name)
            if not (np.array_equal(ours >= 0.0, told >= 0.0) and same(ours[ours >= 0.0], told[ours >= 0.0])):
                found.append(f"{one.view}: {name}")
    return found


def told(kb: KnowledgeBase) -> list[tuple[object, ...]]:
    found = kb.relations()
    return [
        (one.relation, one.figure, one.reference, one.view, one.margin and round(one.margin, 8))
        for one in found
    ]


@pytest.mark.parametrize("path", [one for one in SCENES if one.stem != "kitchen"], ids=lambda path: path.stem)
def test_the_rules_say_the_same(path: Path, connection: psycopg.Connection) -> None:
    """Walls without thickness, books side by side, jars in cabinets: each relation with the same margin."""
    given = Scene.load(path)
    facts = postgis_ground(connection, given)
    assert differences(ground(given), facts) == []
    with KnowledgeBase(given) as mine, KnowledgeBase(given, facts=facts) as theirs:
        assert told(mine) == told(theirs)
        assert mine.withheld == theirs.withheld


def upright_rod(world: World) -> bool:
    """Return whether a world has a thing whose plan is a point, which has a direction by its box alone."""
    return any(thing["box"]["size"][:2] == [0.0, 0.0] for thing in world.things if "box" in thing)


@given(world=worlds(most=4, views=1).filter(lambda world: not upright_rod(world)))
@settings(max_examples=12)
def test_facts_of_random_worlds_are_the_same(world: World, connection: psycopg.Connection) -> None:
    given = world.scene()
    assert differences(ground(given), postgis_ground(connection, given)) == []


@pytest.mark.long
@given(world=worlds(most=5, views=2).filter(lambda world: not upright_rod(world)))
@settings(max_examples=150)
def test_facts_of_many_random_worlds_are_the_same(world: World, connection: psycopg.Connection) -> None:
    given = world.scene()
    assert differences(ground(given), postgis_ground(connection, given)) == []


def test_differences_have_known_causes(connection: psycopg.Connection) -> None:
    """A small part of ``kb/coverage.md``; the whole, on a thousand boxes, in the long run."""
    study = Study(connection)
    study.look(random_room(14, 0))
    study.look_at_clouds(random_clouds(60))
    assert {
        key: causes["no known cause"] for key, causes in study.causes.items() if causes["no known cause"]
    } == {}
    assert {name for name, count in study.other.items() if count} <= coverage.WHY.keys()
    assert study.compared.keys() == coverage.TABLE_1A.keys()
    exact = ("box", "frame", "upright", "side", "volume", "order", "close", "inter", "horizontal")
    assert [study.agreed[key] for key in exact] == [study.compared[key] for key in exact]


def section(text: str, title: str) -> list[str]:
    """Return the lines of one section."""
    return text.partition(f"## {title}\n")[2].partition("\n## ")[0].strip().splitlines()


def test_what_is_written_of_the_coverage(connection: psycopg.Connection) -> None:
    written = COVERAGE.read_text(encoding="utf-8")
    rows = [
        line.split(" | ")[0].removeprefix("| ")
        for line in section(written, "The operators")
        if line.startswith("| ")
    ]
    assert rows[1:] == [line.name for line in coverage.TABLE_1A.values()]
    assert "no known cause" not in written
    if coverage.release(connection) not in written:
        pytest.skip(f"written of another release than {coverage.release(connection)}")
    assert section(written, "Where PostGIS cannot do what an axiom says") == list(coverage.cases(connection))
    assert len(CASES) == len({case.what for case in CASES})


@pytest.mark.long
def test_the_coverage_is_made_anew(connection: psycopg.Connection) -> None:
    written = COVERAGE.read_text(encoding="utf-8")
    if coverage.release(connection) not in written:
        pytest.skip(f"written of another release than {coverage.release(connection)}")
    anew = coverage.text(connection, coverage.ROOMS, coverage.THINGS, coverage.CLOUDS)
    assert coverage.without_times(anew) == coverage.without_times(written)


def test_only_milliseconds_are_left_out() -> None:
    written = COVERAGE.read_text(encoding="utf-8")
    left = coverage.without_times(written)
    assert re.findall(r"\| ([\d.e+]+) \| `\w+\.sql`", left) == []
    assert len(left.splitlines()) == len(written.splitlines())
    assert section(left, "The facts") == section(written, "The facts")


HOSTILE = ("'); DROP TABLE hull;--", "%(t)s", "%s", "{volume}", "\\N", "\\.", '"', "$1", "a\u202fb", "☃")


def test_ids_are_data_and_nothing_stays(connection: psycopg.Connection) -> None:
    given = scene(
        floor(),
        *(box(name, (0.4 * at, 0, 0.1), (0.2, 0.2, 0.2), label=name) for at, name in enumerate(HOSTILE)),
        views=[{"id": "'; --", "label": "%s", "position": [-3, 0, 1], "heading": 0}],
    )  # fmt: skip
    left = "SELECT count(*) FROM pg_class, pg_proc WHERE relname = 'hull' OR proname = 'raised'"
    # What users call their own tables does not matter.
    connection.execute("CREATE TABLE hull (mine text); CREATE TABLE threshold (mine text)")
    try:
        before = connection.execute(left).fetchone()
        assert differences(ground(given), postgis_ground(connection, given)) == []
        assert connection.execute(left).fetchone() == before
        assert connection.execute("SHOW search_path").fetchone() == ('"$user", public',)
    finally:
        connection.execute("DROP TABLE hull, threshold")


def test_within_a_transaction_of_the_callers_own(connection: psycopg.Connection) -> None:
    given = scene(floor(), box("cup", (0, 0, 0.05), (0.1, 0.1, 0.1)))
    with connection.transaction():
        connection.execute("CREATE TABLE kept (mine int)")
        one, other = (postgis_ground(connection, given) for _ in range(2))
    assert differences(one, other) == []
    connection.execute("DROP TABLE kept")


def test_a_scene_with_nothing_in_it(connection: psycopg.Connection) -> None:
    assert differences(ground(scene()), postgis_ground(connection, scene())) == []


def test_functions_by_their_newer_names(connection: psycopg.Connection) -> None:
    """As in PostGIS 3.5: here they are made, under their new names, of the old ones."""
    assert {name.as_string() for name in names(connection).values()} == {
        '"st_extrude"', '"st_makesolid"', '"st_volume"', '"st_3dintersection"',
    }  # fmt: skip
    made = {
        "cg_extrude(g geometry, x float8, y float8, z float8)": ("geometry", "ST_Extrude(g, x, y, z)"),
        "cg_makesolid(g geometry)": ("geometry", "ST_MakeSolid(g)"),
        "cg_volume(g geometry)": ("float8", "ST_Volume(g)"),
        "cg_3dintersection(g geometry, h geometry)": ("geometry", "ST_3DIntersection(g, h)"),
    }
    given = scene(box("a", (0, 0, 0), (1, 1, 1)), box("b", (0.1, 0, 0.2), (1, 0.5, 1), 0.3))
    with connection.transaction(force_rollback=True):
        for head, (kind, body) in made.items():
            connection.execute(f"CREATE FUNCTION {head} RETURNS {kind} LANGUAGE sql AS 'SELECT {body}'")
        assert all(name.as_string().startswith('"cg_') for name in names(connection).values())
        assert differences(ground(given), postgis_ground(connection, given)) == []


def test_what_is_missing_is_named(connection: psycopg.Connection, url: str, tmp_path: Path) -> None:
    connection.execute("CREATE DATABASE bare")
    bare = url.replace("/postgres?", "/bare?")
    with pytest.raises(
        MissingDependency, match="no postgis and no postgis_sfcgal: CREATE EXTENSION postgis_sfcgal"
    ):
        postgis_ground(bare, scene())
    with psycopg.connect(bare, autocommit=True) as admin:
        admin.execute("CREATE EXTENSION postgis")
    with pytest.raises(MissingDependency, match="has no postgis_sfcgal"):
        postgis_ground(bare, scene())
    with pytest.raises(GeometryError, match="PostGIS cannot ground the scene"):
        postgis_ground(f"postgresql:///none?host={quote(str(tmp_path), safe='')}", scene())


def test_facts_of_another_scene_are_refused() -> None:
    one, other = scene(box("a", (0, 0, 0), (1, 1, 1))), scene(box("b", (0, 0, 0), (1, 1, 1)))
    with pytest.raises(QueryError, match="not those of scene 'test'"):
        KnowledgeBase(other, facts=ground(one))
    with pytest.raises(QueryError, match="not those of scene"):
        KnowledgeBase(scene(box("a", (0, 0, 0), (1, 1, 1)), views=()), facts=ground(one))


def test_from_the_command_line(url: str, tmp_path: Path) -> None:
    path = tmp_path / "room.json"
    given = scene(
        floor(),
        wall(),
        box("board", (1.93, 0, 0.5), (0.1, 0.4, 1.0)),
        box("cup", (0, 0, 0.05), (0.1, 0.1, 0.1)),
    )
    given.save(path)
    ours = call("relations", path, "--format", "csv")
    told = call("relations", path, "--format", "csv", "--grounding", "postgis", "--db", url)
    assert (told.code, told.out, told.err) == (0, ours.out, ours.err)
    assert "leans_on,board,wall" in told.out
    for options, reason in (
        ((), "none is given: use --db postgresql://"),
        (("--db", "map.duckdb"), "--db names none: use --db postgresql://"),
        (("--db", url, "--region", "hull"), "--region hull asks for more: use --grounding kernel"),
    ):
        wrong = call("relations", path, "--grounding", "postgis", *options)
        assert (wrong.code, wrong.out) == (2, "")
        assert reason in wrong.err
    with create_map(url, given) as kept:
        kept.add(given, stamp=1.0)
    assert call("map", "relations", "--db", url, "--grounding", "postgis", "--format", "csv").out == ours.out


@pytest.mark.parametrize(
    ("points", "kind"),
    [
        ([[0.3, 0.1, 0.2]], "ST_Point"),
        ([[0.3, 0.1, 0.2]] * 5, "ST_Point"),
        ([[0.0, 0.0, 0.0], [0.2, 0.0, 0.1], [0.4, 0.0, 0.2]], "ST_LineString"),
        ([[0.0, 0.0, 0.0], [0.2, 0.0, 0.1], [0.4, 0.3, 0.2]], "ST_Polygon"),
        ([[x, y, 0.5 * x] for x in (0.0, 0.2, 0.5) for y in (0.0, 0.1, 0.3)], "ST_Polygon"),
        ([[x, y, z] for x in (0.0, 0.2) for y in (0.0, 0.1) for z in (0.0, 0.4)], "ST_PolyhedralSurface"),
    ],
)
def test_hulls_of_few_and_flat_points(points: object, kind: str, connection: psycopg.Connection) -> None:
    given = scene({"id": "heap", "label": "heap", "points": points})
    (text,) = hulls(given, np.zeros(3))
    asked = (
        "SELECT ST_GeometryType(g), ST_XMax(g), ST_YMax(g), ST_ZMax(g) FROM (SELECT %s::geometry AS g) AS one"
    )
    most = np.max(points, axis=0).tolist()
    assert connection.execute(asked, [text]).fetchone() == (kind, *most)


@pytest.mark.parametrize("turn", [0.0, 0.7, math.pi / 4])
def test_minimum_boxes_of_clouds_where_there_is_but_one(turn: float, connection: psycopg.Connection) -> None:
    """A cloud in the shape of a box, a wall seen as points, a line of points."""
    cos, sin = math.cos(turn), math.sin(turn)
    corners = [(x, y, z) for x in (0.0, 0.4) for y in (0.0, 0.2) for z in (0.0, 0.3)]
    points = [[cos * x - sin * y, sin * x + cos * y, z] for x, y, z in corners]
    seen = [[cos * 3 - sin * y, sin * 3 + cos * y, z] for y in (-1.0, 0.0, 1.5) for z in (0.0, 1.0, 2.0)]
    rod = [[cos * x, sin * x, 0.6] for x in (-0.2, -0.1, 0.1)]
    given = scene(
        {"id": "crate", "label": "crate", "points": points}, {"id": "rod", "label": "rod", "points": rod},
        {"id": "wall", "kind": "surface", "label": "wall", "points": seen},
    )  # fmt: skip
    assert differences(ground(given), postgis_ground(connection, given)) == []


def test_all_rows_of_the_table_are_shipped() -> None:
    folder = Path(tables.__file__).parent / "sql"
    assert {path.stem for path in folder.glob("*.sql")} == {"tables", *tables.ROWS}
    for row in tables.ROWS:
        assert tables.text(row).startswith("-- Table 1(a), row ")
