"""How grounding grows: seconds and memory for ever larger scenes, each in a process of its own.

    python -m bench.growth 1000000

prints one measurement as JSON.
"""

from __future__ import annotations

import json
import resource
import subprocess
import sys
import time
from pathlib import Path
from typing import NamedTuple

import numpy as np

from bench.job import scattered
from deixis.broadphase import candidate_rows
from deixis.grounding import ground

SIZES = (1_000, 3_000, 10_000, 30_000, 100_000, 300_000, 1_000_000)

REPEATED_UP_TO = 100_000
"""Larger scenes are grounded once: the second time would count in the peak memory too."""


class Growth(NamedTuple):
    """One size: things, ordered pairs kept, seconds to make the boxes and to ground them, bytes.

    ``candidates`` are the ordered pairs that were looked at, 0 where they were not counted apart.
    """

    things: int
    candidates: int
    pairs: int
    boxes_seconds: float
    seconds: float
    scene_bytes: int
    peak_bytes: int


def peak() -> int:
    """Return the most memory this process has had, bytes."""
    unit = 1 if sys.platform == "darwin" else 1024
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit


def measure(count: int) -> Growth:
    """Return the measurement for one size, in this process."""
    ground(scattered(1_000))
    scene = scattered(count)
    start = time.perf_counter()
    boxes = scene.boxes
    boxes_seconds = time.perf_counter() - start
    candidates = len(candidate_rows(boxes, scene.thresholds)[0]) if count <= REPEATED_UP_TO else 0
    before = peak()
    seconds = []
    for _ in range(5 if count <= REPEATED_UP_TO else 1):
        start = time.perf_counter()
        pairs = len(ground(scene))
        seconds.append(time.perf_counter() - start)
    return Growth(count, candidates, pairs, boxes_seconds, float(np.median(seconds)), before, peak())


def measure_apart(count: int) -> Growth:
    """Return the measurement for one size, in a fresh process."""
    command = [sys.executable, "-m", "bench.growth", str(count)]
    tests = Path(__file__).resolve().parent.parent
    result = subprocess.run(command, cwd=tests, capture_output=True, text=True, check=True)
    return Growth(**json.loads(result.stdout))


def exponent(measured: list[Growth]) -> float:
    """Return k of the seconds' growth as n ** k, by least squares of the logarithms."""
    count = np.log([one.things for one in measured])
    return float(np.polyfit(count, np.log([one.seconds for one in measured]), 1)[0])


if __name__ == "__main__":
    print(json.dumps(measure(int(sys.argv[1]))._asdict()))
