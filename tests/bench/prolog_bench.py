"""A million facts in SWI-Prolog: through the bridge, and at the prompt of the shell.

    python -m bench.prolog_bench

prints the table. The facts are those of boxes, one per square metre, with one view.
"""

from __future__ import annotations

import statistics
import subprocess
import time
from collections.abc import Iterator
from typing import NamedTuple

from bench.job import scattered
from deixis._files import theory_files
from deixis.facts import Facts
from deixis.grounding import ground
from deixis.prolog import PrologEngine
from deixis.prolog.shell import shell_command
from deixis.prolog.text import facts_parts

THINGS = 17_500
"""As many as have a million facts."""

ASKED = 1_000
"""Bound questions, of which the median counts."""


class Measured(NamedTuple):
    """Seconds; of questions, for one."""

    facts: int
    text: float
    load: float
    question: float
    prompt: float
    at_the_prompt: float


def through_the_bridge(facts: Facts) -> tuple[int, float, float, float]:
    """Return how many facts there are, and seconds to write them, to load them, and for a bound question."""
    start = time.perf_counter()
    text = facts_parts(facts)
    written = time.perf_counter()
    with PrologEngine(theory_files(), memory_bytes=8 << 30) as engine:
        engine.ask("true")
        begin = time.perf_counter()
        count = engine.load(text)
        loaded = time.perf_counter()
        engine.ask("touches(o0, X)")
        taken = []
        for number in range(ASKED):
            asked = time.perf_counter()
            engine.ask(f"touches(o{number}, X)")
            taken.append(time.perf_counter() - asked)
    return count, written - start, loaded - begin, statistics.median(taken)


def at_the_prompt(facts: Facts) -> tuple[float, float]:
    """Return seconds from the start of swipl to its first answer, and for a bound question."""
    command = shell_command(theory_files(), [(facts, [])])
    start = time.perf_counter()
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as shell:
        assert shell.stdin is not None
        assert shell.stdout is not None
        shell.stdin.write("write(ready), nl.\n")
        shell.stdin.flush()
        while "ready" not in shell.stdout.readline():
            pass
        ready = time.perf_counter() - start
        # The first question waits for the index of pairs.
        shell.stdin.write(
            "touches(o0, _), ! ; true.\n"
            f"call_time(forall(between(1, {ASKED}, N), (atom_concat(o, N, T), forall(touches(T, _), true))),"
            " Took), format('took ~w~n', [Took.wall]).\nhalt.\n"
        )
        shell.stdin.flush()
        told, _ = shell.communicate(timeout=120)
    (took,) = (line.split()[1] for line in told.splitlines() if line.startswith("took "))
    return ready, float(took) / ASKED


def measure() -> Measured:
    """Return all of it."""
    facts = ground(scattered(THINGS))
    return Measured(*through_the_bridge(facts), *at_the_prompt(facts))


def section() -> Iterator[str]:
    """Yield the table for ``kb/benchmarks.md``."""
    one = measure()
    yield f"{THINGS:,} things, {one.facts:,} facts. Text is written by Python and read by SWI-Prolog."
    yield ""
    yield "| step | time |"
    yield "|---|--:|"
    yield f"| facts written as text | {one.text:.2f} s |"
    yield f"| loaded through the bridge | {one.load:.2f} s |"
    yield f"| a bound question from Python | {1000.0 * one.question:.2g} ms |"
    yield f"| from the start of the shell to its prompt | {one.prompt:.2f} s |"
    yield f"| a bound question at the prompt | {1000.0 * one.at_the_prompt:.2g} ms |"


if __name__ == "__main__":
    print("\n".join(section()))
