"""Print all tables, and write them to a file: ``make bench`` does, to ``kb/benchmarks.md``.

    python -m bench.run [FILE]

Every number is measured in this one run, on this one machine. Ratios are to Deixis.
"""

from __future__ import annotations

import os
import platform
import statistics
import subprocess
import sys
import textwrap
import time
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from importlib.metadata import version
from itertools import cycle
from pathlib import Path

import numpy as np

from bench import batch_bench, growth, prolog_bench, rules_bench, server_bench, shapely_loop, tiles_bench
from bench.job import Answers, room
from deixis.grounding import ground
from deixis.knowledge import KnowledgeBase
from deixis.parallel import WORKERS
from deixis.regrounding import reground
from deixis.scene import BoxRegion, Scene, SpatialObject, View
from deixis.updates import Update
from postgis_server import PostgisUnavailable, postgis

THROUGHPUT_AT = 100_000
"""Things in the scene whose candidate pairs are counted by the second."""


MESHES = Path(__file__).with_name("mesh_bench.py")
"""A benchmark of its own, which prints its own tables."""


def median(work: Callable[[], object], seconds: float = 1.0) -> float:
    """Return the median time of some work, warm: repeated for a second, three times at least."""
    work()
    taken: list[float] = []
    while len(taken) < 3 or sum(taken) < seconds:
        start = time.perf_counter()
        work()
        taken.append(time.perf_counter() - start)
    return statistics.median(taken)


def table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> Iterator[str]:
    """Yield the lines of a table, the first column to the left and the others to the right."""
    yield "| " + " | ".join(head) + " |"
    yield "|---|" + "--:|" * (len(head) - 1)
    for row in rows:
        yield "| " + " | ".join(row) + " |"


def number(value: float) -> str:
    """Return a number with three digits."""
    return f"{value:,.0f}" if value >= 1000.0 else f"{value:.3g}"


def machine() -> Iterator[str]:
    """Yield what this is measured on."""
    memory = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / 2**30
    packages = ", ".join(f"{name} {version(name)}" for name in ("deixis", "numpy", "scipy", "shapely"))
    load = os.getloadavg()[0]
    yield f"{_processor()}, {WORKERS} processors used, {memory:.0f} GiB of memory, {platform.system()}."
    yield f"Python {platform.python_version()}, {packages}. Load average at the start: {load:.1f}."


def _processor() -> str:
    """Return the processor's name, or its kind where it is not told."""
    told = Path("/proc/cpuinfo")
    lines = told.read_text(encoding="utf-8").splitlines() if told.exists() else []
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.machine()


def one_scene(count: int = 100) -> Iterator[str]:
    """Yield the comparison on a single scene."""
    scene = room(count)
    facts = ground(scene)
    wanted = Answers.of(facts)
    kernel = median(lambda: ground(scene))
    rows = [("Deixis", _seconds(kernel), "1", "")]

    def add(name: str, seconds: float, found: Answers) -> None:
        wrong = wanted.differences(found)
        said = "the same" if not wrong else f"{len(wrong)} differ: {wrong[0]}"
        rows.append((name, _seconds(seconds), number(seconds / kernel), said))

    add(
        "Python loop with shapely",
        median(lambda: shapely_loop.answers(scene), 0.0),
        shapely_loop.answers(scene),
    )
    why_not = ""
    try:
        _postgis(scene, add)
    except PostgisUnavailable as cause:
        why_not = f"PostGIS was not measured: {cause}."
    overlapping = int((facts.separation < 0.0).sum()) // 2
    yield (
        f"{count} things (a floor and two walls among them), {len(facts)} ordered pairs within reach, "
        f"{overlapping} overlaps, one view. From boxes in memory to answers; PostGIS has its rows in tables. "
        "The loop is asked for less: no margins, no strict halfspaces, no areas for PartIn. On a scene as "
        "small as this all run on one processor."
    )
    yield ""
    yield from table(("one scene", "time", "ratio", "answers"), rows)
    if why_not:
        yield from ("", why_not)


def _postgis(scene: Scene, add: Callable[[str, float, Answers], None]) -> None:
    """Measure the SQL, once: it takes long enough."""
    with postgis() as address:
        import psycopg

        from deixis.postgis import grounding as tables

        with psycopg.connect(address, autocommit=True) as connection:
            (said,) = connection.execute("SELECT postgis_full_version()").fetchone() or ("",)
            release = said.partition('POSTGIS="')[2].split(" ")[0]
            with tables.session(connection) as session:
                tables.load(session, scene)
                start = time.perf_counter()
                for row in tables.ROWS:
                    tables.run(session, row)
                seconds = time.perf_counter() - start
                found = Answers.of(tables.facts(session, scene))
            add(f"PostGIS {release} + SFCGAL, Table 1(a) of the paper", seconds, found)


def _seconds(value: float) -> str:
    return f"{value:.3g} s" if value >= 1.0 else f"{1000.0 * value:.3g} ms"


def updates(count: int = 1_000) -> Iterator[str]:
    """Yield the cost of a change, against that of a full run."""
    scene = room(count)
    facts = ground(scene)
    full = median(lambda: ground(scene))
    rows = [("full run", _seconds(full), "1")]
    step = View("robot", "robot", scene.views[0].position + np.array([0.3, 0.1, 0.0]))
    changes = {"the robot moved": Scene(scene.id, scene.objects, (step,), scene.thresholds)}
    for moved in (1, 10, 100):
        changes[f"{moved} thing{'s' if moved > 1 else ''} moved"] = _moved(scene, moved)
    for name, after in changes.items():
        seconds = median(partial(reground, scene, facts, after))
        rows.append((name, _seconds(seconds), number(seconds / full)))
    for name, seconds in _followed(scene):
        rows.append((name, _seconds(seconds), number(seconds / full)))
    yield (
        f"{count:,} things, {len(facts):,} ordered pairs within reach, one view. First the facts alone, then "
        "`KnowledgeBase.update`: from what is told to the relations gained and lost, with the margins of all."
    )
    yield ""
    yield from table(("update", "time", "part of a full run"), rows)


def _followed(scene: Scene) -> Iterator[tuple[str, float]]:
    """Yield what a change costs from what is told to what holds; things go to and fro."""
    steps = cycle([0.1, -0.1])
    names = [thing.id for thing in scene.objects[3:]]
    at = scene.views[0].position
    with KnowledgeBase(scene) as kb:

        def moved(some: Sequence[str]) -> object:
            step = next(steps)
            return kb.update(Update.from_dict({"moves": {name: [step, 0.0, 0.0] for name in some}}, kb.scene))

        def seen() -> object:
            return kb.update(Update(views=(View("robot", "robot", at + np.array([next(steps), 0.0, 0.0])),)))

        chosen = cycle(names[:200])
        yield "relations: the robot moved", median(seen)
        yield "relations: 1 thing moved", median(lambda: (moved([one := next(chosen)]), moved([one]))) / 2.0
        yield "relations: 10 things moved", median(lambda: (moved(names[:10]), moved(names[:10]))) / 2.0


def _moved(scene: Scene, count: int) -> Scene:
    """Return the scene with some of its things shifted by ten centimetres."""
    chosen = np.random.default_rng(1).choice(np.arange(3, len(scene.objects)), count, replace=False)
    objects = list(scene.objects)
    for index in chosen:
        thing = objects[index]
        old = thing.region
        region = BoxRegion(old.center + np.array([0.1, 0.0, 0.0]), old.size, old.yaw)
        objects[index] = SpatialObject(thing.id, thing.labels, thing.kind, region)
    after = Scene(scene.id, tuple(objects), scene.views, scene.thresholds)
    # A tracker has the boxes of what it moved: making them is not part of the update.
    assert after.boxes is not None
    return after


def large() -> Iterator[str]:
    """Yield the growth from a thousand to a million things."""
    measured = [growth.measure_apart(count) for count in growth.SIZES]
    rows = [
        (
            f"{one.things:,}",
            f"{one.pairs:,}",
            f"{one.boxes_seconds:.3g}",
            f"{one.seconds:.3g}",
            f"{one.scene_bytes / 2**30:.2f}",
            f"{one.peak_bytes / 2**30:.2f}",
        )
        for one in measured
    ]
    yield (
        "One thing per square metre, T = 2 m, one view and the cardinal directions; each size in a process "
        "of its own. No walls and floors: all that faces them is within their reach."
    )
    yield ""
    yield from table(("things", "pairs", "boxes, s", "facts, s", "scene, GiB", "peak, GiB"), rows)
    yield ""
    yield f"Seconds for facts grow as the number of things to the power {growth.exponent(measured):.3f}."
    (one,) = (one for one in measured if one.things == THROUGHPUT_AT)
    yield (
        f"With {one.things:,} things, {one.candidates / one.seconds / 1e6:.2f} million ordered candidates "
        f"a second are found, measured, and looked at from the view, on {WORKERS} processors."
    )


def tiled() -> Iterator[str]:
    """Yield the growth to ten million things by tiles."""
    measured = [tiles_bench.measure_apart(count) for count in tiles_bench.SIZES]
    rows = [
        (
            f"{one.things:,}",
            f"{one.tiles:,}",
            f"{one.relations:,}",
            _seconds(one.cutting),
            _seconds(one.seconds),
            _seconds((one.seconds - one.cutting) / one.things * 1000.0),
            f"{one.peak_bytes / 2**30:.2f}",
            f"{one.largest_bytes / 2**30:.2f}",
            f"{one.disk_bytes / 2**30:.2f}",
        )
        for one in measured
    ]
    yield (
        "One thing per square metre, T = 1 m, one view, no walls and floors; from a Parquet file to Parquet "
        f"files by tile, all spoken relations with their margins, {WORKERS} processes. Memory is that of all "
        "processes together at its highest, and of the largest of them."
    )
    yield ""
    head = (
        "things",
        "tiles",
        "relations",
        "cutting",
        "all",
        "a thousand things",
        "peak, GiB",
        "largest, GiB",
        "disk, GiB",
    )
    yield from table(head, rows)


def meshes() -> Iterator[str]:
    """Yield what the benchmark of meshes prints, in a fresh process."""
    result = subprocess.run([sys.executable, MESHES], capture_output=True, text=True, check=True)
    yield from (f"    {line}".rstrip() for line in result.stdout.splitlines())


def sections() -> Iterator[tuple[str, Iterator[str]]]:
    """Yield the tables with their titles."""
    yield "Machine", machine()
    yield "Beside other ways to do the same", one_scene()
    yield "What a change costs", updates()
    yield "Growth", large()
    yield "Maps in tiles", tiled()
    yield "Rules", rules_bench.section()
    yield "A million facts in SWI-Prolog", prolog_bench.section()
    yield "Data sets", batch_bench.section()
    if MESHES.exists():
        yield "Meshes", meshes()
    yield "SPARQL over HTTP", server_bench.lines()


def wrapped(lines: Iterator[str]) -> Iterator[str]:
    """Yield lines with the prose broken to the width of a page; tables and indented lines stay."""
    for line in lines:
        yield from [line] if line.startswith(("|", " ")) or not line else textwrap.wrap(line, 120)


def main(target: Path | None) -> None:
    """Print the tables as they are made; then write them."""
    lines = ["# Benchmarks", "", "Measured and written by `make bench`, all in one run. Warm, median times."]
    print("\n".join(lines))
    for title, content in sections():
        part = ["", f"## {title}", "", *wrapped(content)]
        print("\n".join(part), flush=True)
        lines += part
    if target:
        target.write_text("\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else None)
