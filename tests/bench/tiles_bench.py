"""Maps in tiles: seconds and memory of ever larger ones, each in a process of its own.

    python -m bench.tiles_bench 100000 1000000

prints a line of JSON for each size. Things are strewn about at indoor density, one per square metre, T = 1 m,
one view, and no walls and floors, as in :mod:`bench.growth`; all spoken relations are written.
"""

from __future__ import annotations

import json
import math
import os
import shutil
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from deixis.scene import Scene, View
from deixis.tiles import OBJECTS, run

SIZES = (100_000, 1_000_000, 10_000_000)

_ROWS = 250_000
_PERIOD = 0.1
"""Seconds between two looks at the memory."""


class Measured(NamedTuple):
    """One size: things, tiles, relations; seconds to cut the map into tiles and to do them; bytes.

    ``peak_bytes`` is the most memory that all processes had together, ``largest_bytes`` the most of one; what
    they share counts in each. ``disk_bytes`` is what was written.
    """

    things: int
    tiles: int
    relations: int
    cutting: float
    seconds: float
    peak_bytes: int
    largest_bytes: int
    disk_bytes: int


def scattered(count: int, place: Path, seed: int = 0) -> None:
    """Write things strewn about, part by part, without holding them all."""
    rng = np.random.default_rng(seed)
    side = math.sqrt(count)
    kinds = np.array(["cup", "chair", "table", "book", "lamp", "box", "plant", "bottle"])
    names = ("id", "label", "x", "y", "z", "size_x", "size_y", "size_z", "yaw")
    schema = pa.schema([OBJECTS.field(name) for name in names])
    with pq.ParquetWriter(place, schema) as writer:
        for first in range(0, count, _ROWS):
            some = min(_ROWS, count - first)
            low = rng.uniform([0.0, 0.0, 0.0], [side, side, 1.6], (some, 3))
            low[rng.random(some) < 0.5, 2] = 0.0
            size = rng.uniform(0.08, 0.9, (some, 3))
            low[:, 2] += 0.5 * size[:, 2]
            columns = [
                pa.array([f"o{first + at}" for at in range(some)]),
                pa.array(kinds[rng.integers(0, len(kinds), some)]),
                *(pa.array(column) for column in (*low.T, *size.T, rng.uniform(-math.pi, math.pi, some))),
            ]
            writer.write_batch(pa.RecordBatch.from_arrays(columns, schema=schema))


class _Watch:
    """Looks at the memory of this process and its children now and then."""

    def __init__(self) -> None:
        self.peak = self.largest = 0
        self._done = threading.Event()
        self._thread = threading.Thread(target=self._look, daemon=True)

    def __enter__(self) -> _Watch:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._done.set()
        self._thread.join()

    def _look(self) -> None:
        while not self._done.wait(_PERIOD):
            each = [_resident(one) for one in _family(os.getpid())]
            self.peak = max(self.peak, sum(each))
            self.largest = max(self.largest, *each)


def _family(process: int) -> Iterator[int]:
    yield process
    for thread in Path(f"/proc/{process}/task").glob("*/children"):
        try:
            children = thread.read_text().split()
        except OSError:
            continue  # it has ended
        for child in children:
            yield from _family(int(child))


def _resident(process: int) -> int:
    try:
        pages = int(Path(f"/proc/{process}/statm").read_text().split()[1])
    except OSError:
        return 0
    return pages * os.sysconf("SC_PAGE_SIZE")


def measure(count: int, workers: int | None = None) -> Measured:
    """Return the measurement for one size, in this process and those it starts."""
    with tempfile.TemporaryDirectory(prefix="deixis-tiles-") as folder:
        place, target = Path(folder) / "things.parquet", Path(folder) / "out"
        scattered(count, place)
        views = Path(folder) / "views.json"
        Scene("map", (), (View("robot", "robot", np.array([-2.0, 0.4 * math.sqrt(count), 0.5])),)).save(views)
        cut: list[float] = []

        def progress(_: object) -> None:
            cut.append(time.perf_counter())

        with _Watch() as watch:
            start = time.perf_counter()
            found = run([place, views], target, workers=workers, progress=progress)
            seconds = time.perf_counter() - start
        noted = json.loads((target / "manifest.json").read_text())
        disk = sum(one.stat().st_size for one in target.rglob("*.parquet"))
        shutil.rmtree(target)
        return Measured(
            count, found.tiles, found.relations, noted["seconds"], seconds, watch.peak, watch.largest, disk
        )


def measure_apart(count: int) -> Measured:
    """Return the measurement for one size, in a fresh process."""
    command = [sys.executable, "-m", "bench.tiles_bench", str(count)]
    tests = Path(__file__).resolve().parent.parent
    result = subprocess.run(command, cwd=tests, capture_output=True, text=True, check=True)
    return Measured(**json.loads(result.stdout))


if __name__ == "__main__":
    for size in map(int, sys.argv[1:]):
        print(json.dumps(measure(size)._asdict()), flush=True)
