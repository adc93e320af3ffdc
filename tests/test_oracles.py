"""The kernel against others that know nothing of its closed forms: point sets, shapely, PostGIS."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from dataclasses import replace
from itertools import islice
from pathlib import Path
from typing import NoReturn

import numpy as np
import psycopg
import pytest
from psycopg.sql import SQL

import oracles
import postgis_server
from bench import growth, run, shapely_loop
from bench.job import RELATIVE, Answers, Frame, Thing, frames, room, scattered, things
from deixis import measures
from deixis.boxes import NO_NORMAL, Boxes
from deixis.facts import Facts
from deixis.grounding import ground
from deixis.postgis import ground as postgis_ground
from deixis.postgis.functions import names
from oracles import Seen
from postgis_server import PostgisUnavailable, postgis
from scenes import box, scene

# One server for all that need it.
with_postgis = pytest.mark.xdist_group("postgis")


@pytest.fixture(scope="module")
def connection() -> Iterator[psycopg.Connection]:
    """Return a session with a server of our own, or skip what needs it and say why there is none."""
    with ExitStack() as stack:
        try:
            address = stack.enter_context(postgis())
        except PostgisUnavailable as reason:
            pytest.skip(str(reason))
        yield stack.enter_context(psycopg.connect(address, autocommit=True))


class Comparison:
    """Facts beside what point sets say: what was compared, what was too near a bound to be, what differs."""

    def __init__(self, facts: Facts) -> None:
        self.facts = facts
        both = zip(facts.figure.tolist(), facts.reference.tolist(), strict=True)
        self.row = {pair: row for row, pair in enumerate(both)}
        self.view_row = {view.view: {row: at for at, row in enumerate(view.rows)} for view in facts.views}
        self.compared: Counter[str] = Counter()
        self.skipped: Counter[str] = Counter()
        self.wrong: list[str] = []

    def truth(self, what: str, margin: float, tolerance: float, seen: bool) -> None:
        """Compare a truth value that is a margin's sign, unless the margin is within the tolerance."""
        if abs(margin) <= tolerance:
            self.skipped[what] += 1
        else:
            self.compared[what] += 1
            self.same(what, margin, (margin >= 0.0) == seen)

    def same(self, what: str, fact: object, agreed: bool) -> None:
        if not agreed:
            self.wrong.append(f"{what}: the kernel says {fact}")

    def pair(self, figure: int, a: Thing, b: Thing, seen: Seen) -> None:
        """Compare a figure and the thing after it in the scene, its reference."""
        facts, name = self.facts, self.facts.ids[figure]
        row, back = self.row[figure, figure + 1], self.row[figure + 1, figure]
        apart = float(facts.separation[row])
        near = oracles.DISTANCE_TOLERANCE if apart > 0.0 else oracles.DEPTH_TOLERANCE
        self.compared["distance" if apart > 0.0 else "depth"] += 1
        self.same(f"{name} separation {seen.separation}", apart, abs(seen.separation - apart) <= near)
        limits = facts.thresholds
        if min(abs(apart + limits.penetration), abs(apart - limits.granularity)) <= near:
            self.skipped["contact"] += 1
            return
        self.compared["contact"] += 1
        deep = seen.separation < -limits.penetration
        contact = not deep and seen.separation <= limits.granularity
        self.same(f"{name} intersects", facts.intersects[row], bool(facts.intersects[row]) == deep)
        self.same(f"{name} touches", facts.touches[row], bool(facts.touches[row]) == contact)
        self.same(f"{name} contained", facts.compl_cont[row], bool(facts.compl_cont[row]) == seen.contained)
        self.compared["contained"] += seen.contained
        if deep:
            self.inter(f"{name} inter", row, back, a, b, seen)
        for side, holds in enumerate(seen.vertical):
            margin = float(facts.vertical[row, side])
            self.truth(f"{name[0]} vertical", margin, oracles.DEPTH_TOLERANCE, holds)
        for view in facts.views:
            if row in self.view_row[view.view]:
                margins = view.int_hs[self.view_row[view.view][row]]
                for margin, holds in zip(margins, seen.sides[view.view], strict=True):
                    self.truth(f"{name[0]} horizontal", float(margin), oracles.SIDE_TOLERANCE, holds)

    def inter(self, name: str, row: int, back: int, a: Thing, b: Thing, seen: Seen) -> None:
        """Compare the volume of inter, and which of the two has fewer points adjacent to it (axiom 40)."""
        surface = min(8.0 * (one.hx * one.hy + one.hy * one.hz + one.hx * one.hz) for one in (a, b))
        volume = float(self.facts.intersection[row])
        self.compared["volume"] += 1
        self.same(name, volume, abs(volume - seen.volume) <= 0.5 * oracles.PITCH * surface)
        of_figure, of_reference = seen.frontier
        thick = min(a.hx, a.hy, a.hz, b.hx, b.hy, b.hz) >= self.facts.thresholds.granularity
        if not thick or abs(of_figure - of_reference) <= oracles.PART * max(of_figure, of_reference):
            self.skipped["adjacent"] += 1
            return
        self.compared["adjacent"] += 1
        fact = (float(self.facts.frontier[row]), float(self.facts.frontier[back]))
        self.same(f"{name} adjacent {seen.frontier}", fact, (fact[0] < fact[1]) == (of_figure < of_reference))


@pytest.mark.parametrize(
    ("count", "seed"),
    [
        *((500, seed) for seed in range(4)),
        *(pytest.param(2_500, s, marks=pytest.mark.long) for s in range(4, 8)),
    ],
)
def test_point_sets_agree(count: int, seed: int) -> None:
    compared: Counter[str] = Counter()
    skipped: Counter[str] = Counter()
    wrong = []
    for world in oracles.scenes(count, seed):
        listed = things(world)
        framed: dict[int, dict[str, Frame]] = {}
        for view, index, frame in frames(world):
            framed.setdefault(index, {})[view] = frame
        comparison = Comparison(ground(world))
        for at in range(0, len(listed), 2):
            a, b = listed[at], listed[at + 1]
            comparison.pair(at, a, b, oracles.look(a, b, framed[at + 1], world.thresholds))
        compared += comparison.compared
        skipped += comparison.skipped
        wrong += comparison.wrong
    assert wrong == []
    # Of everything there was enough, and little of it was too close to call.
    assert compared["distance"] + compared["depth"] == count
    assert min(compared["distance"], compared["depth"], compared["volume"]) > 0.2 * count
    assert min(compared["contained"], compared["adjacent"]) > 0.05 * count
    assert compared["a horizontal"] > 6 * count
    assert skipped["a horizontal"] < 0.1 * compared["a horizontal"]
    assert skipped["a vertical"] < 0.02 * compared["a vertical"]
    assert skipped["contact"] < 0.1 * count


@pytest.mark.parametrize("seed", range(3))
def test_shapely_agrees_on_a_room(seed: int) -> None:
    one = room(100, seed)
    assert Answers.of(ground(one)).differences(shapely_loop.answers(one)) == []


@with_postgis
@pytest.mark.parametrize("count", [24, pytest.param(100, marks=pytest.mark.long)])
def test_postgis_agrees_on_a_room(count: int, connection: psycopg.Connection) -> None:
    one = room(count, seed=3)
    assert Answers.of(ground(one)).differences(Answers.of(postgis_ground(connection, one))) == []


def test_a_single_other_answer_is_noticed() -> None:
    answers = Answers.of(ground(room(30)))
    assert answers.differences(answers) == []
    for column in ("separation", "volume"):
        moved = getattr(answers, column).copy()
        moved[7] += 2.0e-9
        assert len(answers.differences(replace(answers, **{column: moved}))) == 1
    for column in ("touches", "contained", "vertical"):
        flipped = getattr(answers, column).copy()
        flipped.flat[7] ^= True
        assert len(answers.differences(replace(answers, **{column: flipped}))) == 1
    other = {view: ~sides for view, sides in answers.sides.items()}
    assert len(answers.differences(replace(answers, sides=other))) == 8 * len(answers.pairs)
    assert len(answers.differences(replace(answers, pairs=answers.pairs[::-1]))) == 1


def test_the_competitors_refuse_thin_things() -> None:
    with pytest.raises(ValueError, match="thinner than D"):
        shapely_loop.answers(scene(box("sheet", (0, 0, 0), (1, 1, 0.001))))


SOLIDS = """
WITH made AS MATERIALIZED (
    SELECT pair, {makesolid}({extrude}(ST_Translate(ST_Rotate(ST_Force3D(
        ST_MakeEnvelope(-hx, -hy, hx, hy)), yaw), x, y, z - hz), 0, 0, 2 * hz)) AS shape, first
    FROM boxes)
SELECT ST_3DDistance(a.shape, b.shape),
       CASE WHEN ST_3DIntersects(a.shape, b.shape)
            THEN {volume}({intersection}(a.shape, b.shape)) ELSE 0 END
FROM made AS a JOIN made AS b USING (pair) WHERE a.first AND NOT b.first ORDER BY pair
"""


@with_postgis
@pytest.mark.parametrize("spread", [1.3, pytest.param(0.3, marks=pytest.mark.long)])
def test_postgis_measures_the_same(spread: float, connection: psycopg.Connection) -> None:
    """On a thousand pairs. A volume takes PostGIS a quarter of a second: in the long run most overlap."""
    count = 1_000
    rng = np.random.default_rng(11)
    a, b = (
        Boxes(
            rng.uniform(-spread, spread, (count, 3)),
            rng.uniform(0.05, 0.5, (count, 3)),
            rng.uniform(-np.pi, np.pi, count),
            np.full(count, NO_NORMAL),
            np.zeros(count, dtype=bool),
        )
        for _ in range(2)
    )
    connection.execute("DROP TABLE IF EXISTS boxes")
    connection.execute(
        "CREATE TEMPORARY TABLE boxes (pair int, first bool, x float8, y float8, z float8, "
        "hx float8, hy float8, hz float8, yaw float8)"
    )
    with connection.cursor() as cursor, cursor.copy("COPY boxes FROM STDIN") as copy:
        for first, boxes in ((True, a), (False, b)):
            for pair, row in enumerate(np.column_stack([boxes.center, boxes.half, boxes.yaw]).tolist()):
                copy.write_row((pair, first, *row))
    rows = connection.execute(SQL(SOLIDS).format(**names(connection))).fetchall()
    distance, volume = np.array(rows, dtype=np.float64).T
    place = measures.place(a, b)
    no = np.zeros(count, dtype=bool)
    up, down = measures.vertical_escapes(place, a.half, b.half, no, no, 0.02)
    apart, _ = measures.separation(place, a.half, b.half, up, down)
    inter = measures.intersection_volume(place, a.half, b.half)
    np.testing.assert_allclose(np.maximum(apart, 0.0), distance, rtol=RELATIVE, atol=0.0)
    np.testing.assert_allclose(np.where(apart < 0.0, inter, 0.0), volume, rtol=RELATIVE, atol=0.0)
    assert (volume > 0.0).sum() > (50 if spread > 1.0 else 800)


@with_postgis
def test_the_server_leaves_nothing_behind_and_listens_on_no_port(connection: psycopg.Connection) -> None:
    assert connection.execute("SHOW listen_addresses").fetchone() == ("",)
    with postgis() as address:
        home = Path(address.split()[0].removeprefix("host="))
        assert home.stat().st_mode & 0o777 == 0o700
    assert not home.exists()


def test_without_programs_the_reason_and_the_remedy_are_given(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(postgis_server, "DEBIAN", Path("nowhere"))
    monkeypatch.setenv("PATH", "nowhere")
    with (
        pytest.raises(PostgisUnavailable, match=r"was not found; .*apt install postgresql-postgis"),
        postgis(),
    ):
        pass


def test_growth_is_measured_and_fitted() -> None:
    one = growth.measure(200)
    assert one.things == 200
    assert one.candidates >= one.pairs > 200
    assert one.peak_bytes >= one.scene_bytes > 1_000_000
    exact = [one._replace(things=n, seconds=1.0e-6 * n**1.5) for n in (10, 100, 1_000)]
    assert growth.exponent(exact) == pytest.approx(1.5)


def test_the_tables_are_made(monkeypatch: pytest.MonkeyPatch) -> None:
    """All but the meshes and the sizes; what they say of this machine is nobody's promise."""

    def none() -> NoReturn:
        raise PostgisUnavailable("no server today")

    def once(work: Callable[[], object], *_: float) -> float:
        work()
        return 0.001

    monkeypatch.setattr(run, "postgis", none)
    monkeypatch.setattr(run, "median", once)
    monkeypatch.setattr(run, "THROUGHPUT_AT", 200)
    monkeypatch.setattr(growth, "SIZES", (100, 200))
    printed = {title: "\n".join(lines) for title, lines in islice(run.sections(), 4)}
    assert "Python" in printed["Machine"]
    one, updates, large = list(printed.values())[1:]
    assert "| Python loop with shapely | 1 ms | 1 | the same |" in one
    assert "PostGIS was not measured: no server today." in one
    assert updates.count("| 1 ms | 1 |") == 6
    # To and fro is two updates.
    assert updates.count("| 0.5 ms | 0.5 |") == 2
    assert "| 200 |" in large
    assert "million ordered candidates a second" in large


def test_scenes_are_the_same_each_time_and_of_indoor_density() -> None:
    boxes = scattered(400).boxes
    assert not boxes.differs(scattered(400).boxes).any()
    assert boxes.center[:, :2].max() < 20.5
    assert len(room(50).objects) == 50
