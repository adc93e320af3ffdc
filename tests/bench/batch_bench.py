"""Relations of many scenes: `deixis batch` on 1,500 rooms of 30 things, and where the time of a scene goes.

    python -m bench.batch_bench [ROOMS]

prints the section, or rooms per second measured in this run.
"""

from __future__ import annotations

import json
import math
import resource
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import pyarrow as pa
import pyarrow.parquet as pq

from datasets import as_lines, rooms
from deixis import Scene
from deixis._files import datalog_files
from deixis.batch import Relate
from deixis.batch.columns import Columns
from deixis.batch.run import run
from deixis.engines import AutoExecutor
from deixis.errors import SceneError
from deixis.grounding import ground
from deixis.parallel import WORKERS, work_alone
from deixis.ruleset import load
from deixis.strict_json import parse
from deixis.vocabulary import RELATIONS

ROOMS, THINGS = 1_500, 30


class Run(NamedTuple):
    """What a data set took: seconds, seconds of processors, and what came out."""

    seconds: float
    processors: float
    relations: int
    bytes: int


def end_to_end(count: int = ROOMS) -> Run:
    """Measure a data set from JSON lines to Parquet, the start of the processes among it."""
    with tempfile.TemporaryDirectory() as folder:
        place = as_lines(Path(folder) / "rooms.jsonl", rooms(count, THINGS))
        start, used = time.perf_counter(), _processors()
        done = run([place], Path(folder) / "out", Relate())
        seconds, used = time.perf_counter() - start, _processors() - used
        assert (done.scenes, done.refused) == (count, 0)
        written = sum(one.stat().st_size for one in Path(folder, "out").glob("*.parquet"))
        return Run(seconds, used, done.relations, written)


def _processors() -> float:
    """Return the seconds of processors that this process and those it has ended have used."""
    both = (resource.getrusage(whose) for whose in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    return sum(one.ru_utime + one.ru_stime for one in both)


def stages(count: int = 64, repeat: int = 7) -> dict[str, float]:
    """Return the milliseconds of each stage of a room on one processor: of each room the least."""
    work_alone()
    texts = [json.dumps(one).encode() for one in rooms(count, THINGS)]
    wanted = [(term.name, term.arity) for term in RELATIONS]
    executor = AutoExecutor(load(datalog_files()))
    labels = [("robot", "robot")]
    least: dict[str, list[float]] = {}

    def each(name: str, work: Callable[[Any], Any], given: Sequence[Any]) -> list[Any]:
        best, found = least.setdefault(name, [math.inf] * len(given)), []
        for at, one in enumerate(given):
            start = time.process_time()
            found.append(work(one))
            best[at] = min(best[at], (time.process_time() - start) * 1000.0 / count)
        return found

    for _ in range(repeat):
        data = each("JSON, read strictly", lambda text: parse(text, SceneError, "a room"), texts)
        scenes = each("checked, boxes made", Scene.from_dict, data)
        facts = each("measured", ground, scenes)
        tables = each("rules", lambda one: executor.run(one, wanted, view_labels=labels), facts)
        (table,) = each("columns of Arrow", _columns, [(scenes, tables)])
        each("Parquet", lambda one: pq.write_table(one, pa.BufferOutputStream(), compression="zstd"), [table])
    return {name: sum(times) for name, times in least.items()}


def _columns(given: tuple[Sequence[Scene], Sequence[Any]]) -> pa.Table:
    columns = Columns({(term.name, term.arity): term.name for term in RELATIONS})
    for scene, found in zip(*given, strict=True):
        columns.add("", scene.id, found, {one.id: one.label for one in scene.objects}, 0.05, None)
    return pa.Table.from_batches([columns.batch()])


def section() -> Iterator[str]:
    """Yield the lines of the section."""
    whole = end_to_end()
    yield (
        f"{ROOMS:,} rooms of {THINGS} things as JSON lines to {whole.relations:,} relations in Parquet, from "
        f"the call to the last file, {WORKERS} processes started on the way: {whole.seconds:.1f} s, "
        f"{ROOMS / whole.seconds:,.0f} rooms a second. The processors were busy with it for "
        f"{whole.processors:.1f} s, {ROOMS / whole.processors:,.0f} rooms a second of each. "
        f"{whole.bytes / ROOMS:,.0f} bytes a room are written."
    )
    yield ""
    yield "| one room, one processor | ms |"
    yield "|---|--:|"
    found = stages()
    for name, milliseconds in found.items():
        yield f"| {name} | {milliseconds:.2f} |"
    yield f"| all | {sum(found.values()):.2f} |"


if __name__ == "__main__":
    if len(sys.argv) > 1:
        count = int(sys.argv[1])
        measured = end_to_end(count)
        print(
            f"{count / measured.seconds:,.0f} rooms a second, {count / measured.processors:,.0f} a processor"
        )
    else:
        print("\n".join(section()))
