"""The semantic map: what it was told it tells again, of any time, from either database, after any crash."""

from __future__ import annotations

import itertools
import json
import random
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any
from urllib.parse import quote

import duckdb
import psycopg
import pytest

from commands import Result, call
from deixis.errors import MapError, SceneError
from deixis.moments import moment, seconds
from deixis.scene import BoxRegion, Label, Scene, SpatialObject, View
from deixis.semantic_map import create_map, open_map
from postgis_server import PostgisUnavailable, postgis
from scenes import ROBOT, box, floor, scene

HERE = Path(__file__).resolve().parent
SCENES = sorted([*(HERE / "golden").glob("*.json"), *(HERE.parent / "kb" / "scenes").glob("*.json")])

Address = Callable[[], str]


@pytest.fixture(scope="module")
def server() -> Iterator[str]:
    try:
        with postgis() as address:
            yield address
    except PostgisUnavailable as error:
        pytest.skip(str(error))


@pytest.fixture(params=["duckdb", "postgresql"])
def address(request: pytest.FixtureRequest, tmp_path: Path) -> Address:
    """Return a function that gives the address of one more place without a map."""
    numbers = itertools.count()
    if request.param == "duckdb":
        return lambda: str(tmp_path / f"{next(numbers)}.duckdb")
    shown: str = request.getfixturevalue("server")

    def database() -> str:
        name = f"map_{time.monotonic_ns()}"
        with psycopg.connect(shown, autocommit=True) as admin:
            admin.execute(f"CREATE DATABASE {name}")
            where = admin.info
            return f"postgresql://{where.user}@/{name}?host={quote(where.host, safe='')}"

    return database


def room(*things: dict[str, Any], name: str = "room") -> Scene:
    return scene(*things, name=name)


CORNERS = list(itertools.product((0.0, 1.0), repeat=3))
CUP = box("cup", (0, 0, 1), (0.1, 0.1, 0.1))
TABLE = box("table", (0, 0, 0.5), (1, 1, 0.9))


def test_a_scene_comes_back_as_it_was(address: Address) -> None:
    for path in SCENES:
        given = Scene.load(path)
        with create_map(address(), given) as kept:
            frame = kept.add(given, stamp=5.0)
            assert (frame.source, frame.things) == (given.id, len(given.objects))
            assert kept.scene().to_dict() == given.to_dict()
            assert kept.scene(at=4.999).objects == kept.scene(at=4.999).views == ()


def test_what_was_told_last_counts(address: Address) -> None:
    place = address()
    with create_map(place, room()) as kept:
        kept.add(room(floor(), TABLE, CUP), stamp=10.0)
        kept.add(room(box("cup", (3, 0, 0.05), (0.1, 0.1, 0.1))), stamp=20.0)
        kept.add(room(), stamp=30.0, gone=["cup", "cup"])
        # It arrives late, and is put where it belongs.
        kept.add(room(box("cup", (0, 0, 1.5), (0.1, 0.1, 0.1)), box("pot", (1, 1, 1), (1, 1, 1))), stamp=15.0)
        kept.add(room(TABLE), stamp=40.0, whole=True)
    with open_map(place) as kept:
        heights = {
            at: {one.id: one.region.center[2] for one in kept.scene(at=at).objects if one.id == "cup"}
            for at in (9.9, 10, 14.9, 15, 20, 29, 30)
        }
        assert heights == {
            9.9: {}, 10: {"cup": 1.0}, 14.9: {"cup": 1.0}, 15: {"cup": 1.5}, 20: {"cup": 0.05},
            29: {"cup": 0.05}, 30: {},
        }  # fmt: skip
        assert {one.id for one in kept.scene(at=39).objects} == {"floor", "table", "pot"}
        assert [one.id for one in kept.scene().objects] == ["table"]
        assert kept.seen(at=39) == {"floor": 10.0, "table": 10.0, "pot": 15.0}
        assert [(one.stamp, one.gone) for one in kept.sightings("cup")] == [
            (10.0, False), (15.0, False), (20.0, False), (30.0, True),
        ]  # fmt: skip
        assert kept.sightings("nobody") == ()
        assert [(one.seq, one.stamp, one.whole, one.things, one.gone) for one in kept.frames()] == [
            (1, 10.0, False, 3, 0), (4, 15.0, False, 2, 0), (2, 20.0, False, 1, 0), (3, 30.0, False, 0, 1),
            (5, 40.0, True, 1, 0),
        ]  # fmt: skip


def test_views_are_those_of_the_last_frame_that_has_any(address: Address) -> None:
    far = {"id": "v1", "label": "you", "position": [9.0, 0.0, 1.7], "heading": 1.0, "stamp": 7.5}
    with create_map(address(), room()) as kept:
        kept.add(scene(TABLE, views=[ROBOT]), stamp=1.0)
        kept.add(scene(CUP, views=[far]))  # the stamp is that of the view
        kept.add(scene(CUP, views=[]), stamp=9.0)
        assert [view.id for view in kept.scene(at=7.4).views] == ["v0"]
        (view,) = kept.scene().views
        assert (view.id, view.label, view.heading, view.stamp) == ("v1", "you", 1.0, 7.5)
        assert kept.frames()[1].stamp == 7.5


def replayed(told: list[tuple[float, int, Scene, bool, list[str]]], at: float) -> dict[str, float]:
    """Return the height of each thing at a time, by telling it all again in order."""
    there: dict[str, float] = {}
    for stamp, _, shown, whole, gone in sorted(told, key=lambda one: one[:2]):
        if stamp <= at:
            there = {} if whole else {name: height for name, height in there.items() if name not in gone}
            there |= {one.id: float(shown.boxes.center[at, 2]) for at, one in enumerate(shown.objects)}
    return there


@pytest.mark.parametrize("seed", range(4))
def test_any_time_is_what_was_told_until_then(seed: int, address: Address) -> None:
    draw = random.Random(seed)  # noqa: S311 - a test
    names = [f"thing {at}" for at in range(6)]
    told: list[tuple[float, int, Scene, bool, list[str]]] = []
    known: set[str] = set()
    with create_map(address(), room()) as kept:
        for seq in range(1, 25):
            some = draw.sample(names, draw.randint(0, 4))
            shown = room(*(box(name, (0, 0, draw.random()), (1, 1, 1)) for name in some))
            known |= set(some)
            gone = [name for name in sorted(known) if name not in some and draw.random() < 0.3]
            stamp, whole = float(draw.randint(0, 12)), draw.random() < 0.15
            assert kept.add(shown, stamp=stamp, whole=whole, gone=gone).seq == seq
            told.append((stamp, seq, shown, whole, gone))
        for at in range(-1, 14):
            found = kept.scene(at=at)
            heights = dict(zip((one.id for one in found.objects), found.boxes.center[:, 2], strict=True))
            assert heights == replayed(told, at)


def test_ids_and_labels_are_data(address: Address) -> None:
    names = ["'; DROP TABLE thing;--", "$1", "%s", "\\", '"', "\\N", "a\u202fb", "☃", "null", ""]
    with create_map(address(), room(name="'); halt.")) as kept:
        given = scene(*(box(name, (0, 0, 1), (1, 1, 1), label=name or None) for name in names[:-1]))
        with pytest.raises(MapError, match="never told of"):
            kept.add(given, stamp=1.0, gone=["'; --"])
        kept.add(given, stamp=1.0)
        kept.add(room(), stamp=0.5, gone=names[:1])
        assert kept.scene().id == "'); halt."
        assert [(one.id, one.label) for one in kept.scene().objects] == [(name, name) for name in names[:-1]]
        # What no scene file may hold is refused at this door too, and the map stays readable.
        for bad in ("\x00", "\ud800", "a\nb"):
            odd = SpatialObject(bad, (Label("cup"),), "object", BoxRegion([0, 0, 0], [1, 1, 1]))
            with pytest.raises(SceneError):
                kept.add(Scene("odd", (odd,)), stamp=2.0)
        assert len(kept.frames()) == 2


def test_what_cannot_be_told_is_refused_and_leaves_nothing(address: Address) -> None:
    place = address()
    with create_map(place, room()) as kept:
        with pytest.raises(MapError, match="in the frame and said to be gone"):
            kept.add(room(CUP), gone=["cup"])
        with pytest.raises(MapError, match="stamp of scene 'room' is not finite"):
            kept.add(room(CUP), stamp=float("nan"))
        with pytest.raises(MapError, match="not a number"):
            kept.scene(at=float("nan"))
        with pytest.raises(MapError, match="other thresholds"):
            kept.add(scene(CUP, thresholds={"closeness": 0.7}))
        with pytest.raises(MapError, match="never told of 'cup'"):
            kept.add(room(), gone=["cup"])
        assert kept.frames() == ()
        kept.add(room(CUP), stamp=1.0)
        with pytest.raises(MapError, match="never told of 'cap': did you mean 'cup'"):
            kept.add(room(), gone=["cup", "cap"])
        assert len(kept.frames()) == 1
    with pytest.raises(MapError, match="already"):
        create_map(place, room())


def test_thresholds_are_those_of_the_map(address: Address) -> None:
    like = scene(CUP, thresholds={"closeness": 0.7})
    with create_map(address(), like) as kept:
        kept.add(like, stamp=1.0)
        kept.add(room(TABLE), stamp=2.0)
        assert kept.scene().thresholds.closeness == 0.7
        with pytest.raises(MapError, match="other thresholds"):
            kept.add(scene(CUP, thresholds={"closeness": 0.8}))


def test_what_a_map_could_not_read_again_does_not_get_into_it(address: Address) -> None:
    """A scene without thresholds of its own is read with the map's, strays and all."""
    piece = [[0.01 * x, 0.01 * y, 0.01 * z] for x in range(4) for y in range(4) for z in range(4)]
    cloud = {"id": "cloud", "label": "cloud", "points": [*piece, [3.0, 3.0, 3.0]]}
    like = Scene.from_dict({"deixis": 1, "id": "strict", "strays": "refuse"})
    with create_map(address(), like) as kept:
        with pytest.raises(SceneError, match="'cloud': its 65 points are in 2 pieces"):
            kept.add(scene(cloud), stamp=1.0)
        assert kept.frames() == ()
        kept.add(scene({**cloud, "points": piece}), stamp=2.0)
        assert [thing.id for thing in kept.scene().objects] == ["cloud"]
    with create_map(address(), scene(thresholds={"piece_gap": 9.0})) as kept:
        kept.add(scene(cloud), stamp=1.0)
        (sighting,) = kept.sightings("cloud")
        assert sighting.center == tuple(kept.scene().boxes.center[0].tolist())


def test_a_place_without_a_map(tmp_path: Path) -> None:
    with pytest.raises(MapError, match="is no file"):
        open_map(tmp_path / "none.duckdb")
    for content in (b"", b"not a database", b"\x00" * 4096):
        (tmp_path / "odd").write_bytes(content)
        with pytest.raises(MapError):
            open_map(tmp_path / "odd")
    with pytest.raises(MapError, match=r"cannot be opened|is no map"):
        create_map(tmp_path / "no" / "such" / "folder.duckdb", room())
    with pytest.raises(MapError, match="cannot be read or written"):
        open_map(f"postgresql:///none?host={quote(str(tmp_path), safe='')}")


def test_an_init_that_was_cut_off_can_be_done_again(tmp_path: Path) -> None:
    for number, statements in enumerate(([], ["CREATE TABLE migration (number integer PRIMARY KEY)"])):
        place = tmp_path / f"{number}.duckdb"
        with duckdb.connect(str(place)) as connection:
            for statement in statements:
                connection.execute(statement)
        create_map(place, room()).close()
        with open_map(place) as kept:
            assert kept.frames() == ()
    foreign = tmp_path / "foreign.duckdb"
    with duckdb.connect(str(foreign)) as connection:
        connection.execute("CREATE TABLE theirs (x integer)")
    with pytest.raises(MapError, match="holds other tables"):
        open_map(foreign)
    with pytest.raises(MapError, match="holds other tables"):
        create_map(foreign, room())


@pytest.mark.parametrize(
    "told", ["u:secret pw@[::1/x", "u:sec%zzret@localhost/x", "u:p@secretpw@127.0.0.1:1/x"]
)
def test_no_message_holds_a_password(told: str) -> None:
    with pytest.raises(MapError, match="not well formed") as caught:
        open_map(f"postgresql://{told}")
    assert "sec" not in str(caught.value)


def test_another_process_waits_for_its_turn(tmp_path: Path) -> None:
    place = tmp_path / "map.duckdb"
    kept = create_map(place, room())
    other = subprocess.Popen(
        [sys.executable, "-m", "deixis", "map", "list", "--db", place], stderr=subprocess.PIPE, text=True
    )
    time.sleep(1.0)
    assert other.poll() is None
    kept.close()
    assert other.wait(timeout=20) == 1  # nothing is in it, which is no error
    assert other.stderr is not None
    assert other.stderr.read() == ""
    other.stderr.close()


@pytest.mark.parametrize("address", ["postgresql"], indirect=True)
def test_two_writers_lose_nothing(address: Address) -> None:
    """A thousand frames each, at the same time, into the shared map."""
    place = address()
    create_map(place, room()).close()

    def write(writer: int) -> list[int]:
        with open_map(place) as kept:
            return [
                kept.add(room(box(f"{writer}/{at}", (0, 0, at), (1, 1, 1))), stamp=float(at)).seq
                for at in range(1000)
            ]

    with ThreadPoolExecutor(2) as pool:
        numbers = list(pool.map(write, range(2)))
    assert len({*numbers[0], *numbers[1]}) == 2000
    with open_map(place) as kept:
        assert len(kept.frames()) == len(kept.scene().objects) == 2000


@pytest.mark.parametrize("address", ["postgresql"], indirect=True)
def test_makers_at_the_same_time(address: Address) -> None:
    """Of those who make a map in one database at once one does; all find the same tables."""
    place = address()

    def make(_: int) -> bool:
        try:
            create_map(place, room()).close()
        except MapError:
            return False
        return True

    with ThreadPoolExecutor(4) as pool:
        assert sum(pool.map(make, range(4))) == 1


WRITER = """
import sys
from deixis.scene import BoxRegion, Label, Scene, SpatialObject
from deixis.semantic_map import open_map
with open_map(sys.argv[1]) as kept:
    print("ready", flush=True)
    for at in range(int(sys.argv[2]), 1_000_000):
        things = tuple(
            SpatialObject(f"{at}/{one}", (Label("cup"),), "object", BoxRegion([one, 0, 0], [1, 1, 1]))
            for one in range(at % 7 + 1)
        )
        kept.add(Scene("s", things), stamp=float(at))
        print(at, flush=True)
"""


def crash(place: Path, times: int, seed: int) -> None:
    """Write frames and kill the writer at any moment; see that what it acknowledged is there and whole."""
    draw = random.Random(seed)  # noqa: S311 - a test
    create_map(place, room()).close()
    told: set[int] = set()
    for _ in range(times):
        start = max(told, default=-1) + 2
        writer = subprocess.Popen(
            [sys.executable, "-c", WRITER, str(place), str(start)], stdout=subprocess.PIPE, text=True
        )
        assert writer.stdout is not None
        assert writer.stdout.readline() == "ready\n"
        time.sleep(draw.uniform(0.0, 0.15))
        writer.send_signal(signal.SIGKILL)
        writer.wait()
        lines = writer.stdout.read().split("\n")
        writer.stdout.close()
        told |= {int(line) for line in lines[:-1]}
        with open_map(place) as kept:
            frames = kept.frames()
            found = {int(one.stamp): one.things for one in frames}
            assert len(found) == len(frames)
            assert told <= set(found)
            # One more may be there whose acknowledgement was never read; it too is whole.
            assert len(set(found) - told) <= 1
            assert all(things == at % 7 + 1 for at, things in found.items())
            assert len(kept.scene().objects) == sum(found.values())
            told = set(found)


def test_frames_outlive_kill_9(tmp_path: Path) -> None:
    crash(tmp_path / "map.duckdb", 5, 1)


@pytest.mark.long
def test_frames_outlive_kill_9_many_times(tmp_path: Path) -> None:
    crash(tmp_path / "map.duckdb", 200, 2)


@pytest.mark.parametrize("address", ["postgresql"], indirect=True)
def test_shapes_are_kept_where_there_is_postgis(address: Address) -> None:
    """It may come after the map; things told of before have no shape, and the map works on either way."""
    place = address()
    cloud = {"id": "heap", "label": "heap", "points": [[x, y, z] for x, y, z in CORNERS] + [[0.5, 0.5, 1.5]]}
    with create_map(place, room()) as kept:
        kept.add(room(CUP), stamp=1.0)
    with psycopg.connect(place, autocommit=True) as admin:
        admin.execute("CREATE EXTENSION postgis_sfcgal CASCADE")
        with open_map(place) as kept:
            kept.add(room(TABLE, cloud, floor()), stamp=2.0, gone=["cup"])
            assert {one.id for one in kept.scene().objects} == {"table", "heap", "floor"}
        shapes = """
            SELECT id, ST_GeometryType(hull), ST_GeometryType(box),
                   round(CASE WHEN kind = 'object' THEN ST_Volume(ST_MakeSolid(hull)) ELSE 0 END::numeric, 9),
                   round(CASE WHEN kind = 'object' THEN ST_Volume(ST_MakeSolid(box)) ELSE 0 END::numeric, 9)
            FROM deixis.shape JOIN deixis.thing USING (frame, position) ORDER BY id
        """
        solid, flat = "ST_PolyhedralSurface", "ST_Polygon"
        assert [(*row[:3], *map(float, row[3:])) for row in admin.execute(shapes)] == [
            ("floor", flat, flat, 0.0, 0.0),
            ("heap", solid, solid, 1.166666667, 1.5),
            ("table", solid, solid, 0.9, 0.9),
        ]
        (by,) = admin.execute("""
            SELECT string_agg(indexdef, ' ') FROM pg_indexes
            WHERE tablename = 'shape' AND indexdef LIKE '%gist%'
        """).fetchone() or ("",)
        assert by.count("gist_geometry_ops_nd") == 2
        near = "SELECT count(*) FROM deixis.shape WHERE hull &&& ST_MakePoint(0, 0, 0.5)"
        assert admin.execute(near).fetchone() == (2,)


# The command line


def test_a_map_from_the_command_line(address: Address, tmp_path: Path) -> None:
    place = address()
    early, late = tmp_path / "early.json", tmp_path / "late.json"
    room(floor(), TABLE, CUP).save(early)
    room(box("cup", (3, 0, 0.05), (0.1, 0.1, 0.1))).save(late)

    def on_map(*arguments: str | Path) -> Result:
        return call("map", *arguments, "--db", place)

    assert on_map("list").code == 2
    assert on_map("init", "--like", early, "--id", "kitchen").code == 0
    assert (on_map("list").code, on_map("relations").code) == (1, 1)
    assert on_map("add", early, "--stamp", "2026-11-22T10:00:00Z").code == 0
    assert on_map("add", late, "--stamp", "2026-11-22T11:00:00+00:00").out.startswith("2\t2026-11-22T11:00")
    then = on_map("relations", "--at", "2026-11-22T10:30:00", "--relation", "on_top_of", "--format", "pl")
    now = on_map("relations", "--relation", "on_top_of", "--format", "pl")
    assert "on_top_of('cup','table')." in then.out.split("\n")
    assert "on_top_of('cup','floor')." in now.out.split("\n")
    rows = json.loads(on_map("list", "--thing", "cup", "--format", "json").out)
    assert [(row["stamp"], row["x"]) for row in rows] == [
        ("2026-11-22T10:00:00.000Z", 0.0), ("2026-11-22T11:00:00.000Z", 3.0),
    ]  # fmt: skip
    assert [row["seq"] for row in json.loads(on_map("list", "--frames", "--format", "json").out)] == [1, 2]
    listed = on_map("list", "--format", "csv").out.split("\n")
    assert listed[0] == "id,label,kind,x,y,z,seen"
    assert on_map("add", late, "--gone", "table", "--stamp", "1").code == 0
    out = tmp_path / "out.json"
    assert on_map("scene", "-o", out, "--at", "2026-11-22T10:30:00Z").code == 0
    assert {one.id for one in Scene.load(out).objects} == {"floor", "table", "cup"}
    assert on_map("init").code == 2
    wrong = on_map("list", "--at", "yesterday")
    assert (wrong.code, "is no time" in wrong.err) == (2, True)


def test_times_as_people_write_them() -> None:
    assert seconds("1e3") == 1000.0
    assert seconds("2026-11-22T10:42:00+01:00") == seconds("2026-11-22 09:42") == 1795340520.0
    assert moment(1e300) == "1e+300"
    assert moment(seconds("2026-11-22T10:42:00.250Z")) == "2026-11-22T10:42:00.250Z"
    late = seconds("2026-11-22T23:30:00Z")
    assert seconds("10:42", day=late) == seconds("2026-11-22T10:42Z")
    # In that zone it is the next day.
    assert seconds("10:42:05+01:00", day=late) == seconds("2026-11-23T10:42:05+01:00")
    for wrong in ("yesterday", "10:60", "nan", "inf", "1e999", ""):
        with pytest.raises(MapError, match="is no time"):
            seconds(wrong, day=late)
    for nowhere in (None, 1e300):
        with pytest.raises(MapError, match="of no certain day"):
            seconds("10:42", day=nowhere)


def test_a_view_made_in_python_keeps_its_stamp(address: Address) -> None:
    with create_map(address(), room()) as kept:
        kept.add(Scene("s", (), (View("v", "", [0, 0, 1], 0.5, 12.25),)))
        assert kept.scene().views[0].stamp == kept.frames()[0].stamp == 12.25


def test_maps_are_used_by_several_threads_each_with_its_own(address: Address) -> None:
    place = address()
    create_map(place, room()).close()

    def write(writer: int) -> int:
        with open_map(place) as kept:
            kept.add(room(box(f"{writer}", (0, 0, 1), (1, 1, 1))), stamp=float(writer))
            return len(kept.frames())

    with ThreadPoolExecutor(4) as pool:
        assert max(pool.map(write, range(12))) == 12
    with open_map(place) as kept:
        assert len(kept.scene().objects) == 12
