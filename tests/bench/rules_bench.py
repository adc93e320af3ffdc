"""All rules over a large map: DuckDB and arrays beside SWI-Prolog, clingo and Nemo, end to end.

    python -m bench.rules_bench [ENGINE COUNT]

prints the table, or one measurement as JSON. End to end is from facts in memory to arrays or tuples of
answers in memory: starting the engine, loading, rules, answers. Everyone derives the same predicates without
margins, and counts must be the same. clingo knows whole numbers of 32 bits only and gets nanometres, cut off
beyond two metres, where nothing is compared, and ranks instead of cardinalities; Nemo gets the same as CSV.
"""

from __future__ import annotations

import json
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from bench.job import room, scattered
from deixis._files import datalog_files, theory_files
from deixis.arrays import ArrayExecutor
from deixis.engines import AutoExecutor
from deixis.facts import Facts
from deixis.grounding import ground
from deixis.ruleset import Indicator, Ruleset, load
from deixis.ruleset.base import BASE_FACTS
from deixis.ruleset.columns import Symbols, base_columns
from deixis.ruleset.model import (
    Arithmetic,
    Atom,
    Comparison,
    Constant,
    Expression,
    Goal,
    Negation,
    Rule,
    Variable,
)
from deixis.sql import SqlExecutor
from deixis.vocabulary import BASE, RELATIONS

WANTED: list[Indicator] = [(term.name, term.arity) for term in (*BASE, *RELATIONS)]
ENGINES = ("duckdb", "arrays", "prolog", "clingo", "nemo")
SHOWN = {"duckdb": "DuckDB", "arrays": "arrays", "prolog": "SWI-Prolog", "clingo": "clingo", "nemo": "Nemo"}
CUT = 2_140_000_000
"""Nanometres: what clingo can count, a little less than its 2**31."""


class Measured(NamedTuple):
    """Seconds and peak memory of one engine, and how many rows it found of each predicate."""

    seconds: float
    bytes: int
    rows: dict[str, int]


def duckdb(facts: Facts) -> dict[str, int]:
    with SqlExecutor(load(datalog_files())) as executor:
        found = executor.run(facts, WANTED, margins=False)
    return {name: len(table) for (name, _), table in found.items()}


def arrays(facts: Facts) -> dict[str, int]:
    found = ArrayExecutor(load(datalog_files())).run(facts, WANTED, margins=False)
    return {name: len(table) for (name, _), table in found.items()}


def prolog(facts: Facts) -> dict[str, int]:
    from deixis.prolog import PrologEngine, facts_text

    with PrologEngine(theory_files(), memory_bytes=24 << 30) as engine:
        engine.load(facts_text(facts))
        return {name: len(rows) for name, rows in engine.relations(WANTED, timeout=3600.0).items()}


def clingo(facts: Facts) -> dict[str, int]:
    import clingo as engine

    ruleset = load(datalog_files())
    symbols = Symbols(facts.ids, ())
    control = engine.Control(["--warn=none"])
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "facts.lp"
        with path.open("w", encoding="utf-8") as file:
            for predicate, rows in _rows(ruleset, facts, symbols):
                row = f"{predicate[0]}({','.join(['%d'] * rows.shape[1])})."
                file.writelines(row % tuple(one) + "\n" for one in rows.tolist())
        control.load(str(path))
    control.add("base", [], "\n".join(_clauses(ruleset, symbols, "{}.", ":-", "not ", "!=")))
    control.ground([("base", [])])
    atoms = control.symbolic_atoms
    return {
        name: len([[one.number for one in atom.symbol.arguments] for atom in atoms.by_signature(name, arity)])
        for name, arity in WANTED
    }


def nemo(facts: Facts) -> dict[str, int]:
    import nmo_python as engine

    ruleset = load(datalog_files())
    symbols = Symbols(facts.ids, ())
    with tempfile.TemporaryDirectory() as folder:
        lines = []
        for predicate, rows in _rows(ruleset, facts, symbols):
            path = Path(folder) / f"{predicate[0]}.csv"
            np.savetxt(path, rows, fmt="%d", delimiter=",")
            form = ", ".join(["int"] * rows.shape[1])
            lines.append(f'@import {predicate[0]} :- csv{{resource="{path}", format=({form})}} .')
        lines += _clauses(ruleset, symbols, "{} .", ":-", "~", "!=", variable="?")
        lines += [f"@output {name} ." for name, _ in WANTED]
        running = engine.NemoEngine(engine.load_string("\n".join(lines)))
        running.reason()
        return {name: len(list(running.result(name))) for name, _ in WANTED}


def _rows(ruleset: Ruleset, facts: Facts, symbols: Symbols) -> Iterator[tuple[Indicator, np.ndarray]]:
    """Yield the base facts that the rules need as whole numbers."""
    for predicate in sorted(ruleset.graph.needed(WANTED) & BASE_FACTS.keys()):
        columns = base_columns(predicate, facts, (), symbols)
        whole = []
        for at, kind in enumerate(BASE_FACTS[predicate]):
            column = columns[f"a{at}"]
            if kind == "number":
                column = np.unique(column, return_inverse=True)[1]
            elif kind == "length":
                column = np.clip(np.rint(column * 1.0e9), -CUT, CUT)
            whole.append(column.astype(np.int64))
        yield (
            predicate,
            np.column_stack(whole) if len(whole[0]) else np.empty((0, len(whole)), dtype=np.int64),
        )


def _clauses(
    ruleset: Ruleset, symbols: Symbols, end: str, arrow: str, denied: str, unequal: str, variable: str = ""
) -> Iterator[str]:
    """Yield the rules in another Datalog; a denied conjunction gets a predicate of its own."""
    needed = ruleset.graph.needed(WANTED)
    helpers = 0

    def value(one: Expression) -> str:
        match one:
            case Variable():
                if one.anonymous:
                    return "_"
                return (variable or "V") + one.name.replace("_#", "any")
            case Constant(kind="number"):
                return str(round(float(one.value) * 1.0e9))
            case Constant():
                return str(symbols.code(str(one.value)))
            case Arithmetic(operator, (only,)):
                return f"({operator} {value(only)})" if not variable else f"(0 {operator} {value(only)})"
            case Arithmetic(operator, (left, right)):
                return f"({value(left)} {operator} {value(right)})"
        raise AssertionError(one)

    def atom(one: Atom) -> str:
        return f"{one.name}({', '.join(map(value, one.args))})"

    def plain(one: Goal) -> str:
        if isinstance(one, Atom):
            return atom(one)
        assert isinstance(one, Comparison)
        operator = {"=<": "<=", "\\==": unequal, "=\\=": unequal, "==": "=", "=:=": "="}.get(
            one.operator, one.operator
        )
        return f"{value(one.left)} {operator} {value(one.right)}"

    def clause(rule: Rule) -> Iterator[str]:
        nonlocal helpers
        goals = []
        for goal in rule.body:
            if not isinstance(goal, Negation):
                goals.append(plain(goal))
            elif len(goal.goals) == 1 and isinstance(goal.goals[0], Atom):
                goals.append(denied + atom(goal.goals[0]))
            else:
                helpers += 1
                # Axiom 38: for all who touch Figure, which others do; the outer variables are its arguments.
                outer = f"figure_reference({value(rule.head.args[0])}, {value(rule.head.args[1])})"
                head = f"helper{helpers}({', '.join(map(value, rule.head.args))})"
                yield end.format(f"{head} {arrow} {', '.join([outer, *map(plain, goal.goals)])}")
                goals.append(denied + head)
        yield end.format(f"{atom(rule.head)} {arrow} {', '.join(goals)}")

    for rule in ruleset.rules:
        if rule.head.predicate in needed:
            yield from clause(rule)


def measure(name: str, count: int) -> Measured:
    """Return the measurement of one engine, in this process."""
    work: dict[str, Callable[[Facts], dict[str, int]]] = {
        "duckdb": duckdb,
        "arrays": arrays,
        "prolog": prolog,
        "clingo": clingo,
        "nemo": nemo,
    }
    facts = ground(scattered(count))
    seconds = []
    rows: dict[str, int] = {}
    for _ in range(3 if name in ("duckdb", "arrays") else 1):
        start = time.perf_counter()
        rows = work[name](facts)
        seconds.append(time.perf_counter() - start)
    peak = max(resource.getrusage(who).ru_maxrss for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    return Measured(min(seconds), peak * 1024, rows)


def measure_apart(name: str, count: int) -> Measured | str:
    """Return the measurement of one engine in a fresh process, or why there is none."""
    command = [sys.executable, "-m", "bench.rules_bench", name, str(count)]
    tests = Path(__file__).resolve().parent.parent
    result = subprocess.run(command, cwd=tests, capture_output=True, text=True, check=False)
    if result.returncode:
        return (result.stderr.strip().splitlines() or ["killed"])[-1]
    return Measured(**json.loads(result.stdout))


def small() -> tuple[int, float, float]:
    """Return how many pairs a scene of 100 things has, and its seconds warm, with and without margins."""
    facts = ground(room(100))
    wanted: list[Indicator] = [(term.name, term.arity) for term in RELATIONS]
    best = []
    with AutoExecutor(load(datalog_files())) as executor:
        for margins in (True, False):
            taken: list[float] = []
            for _ in range(50):
                start = time.perf_counter()
                executor.run(facts, wanted, margins=margins)
                taken.append(time.perf_counter() - start)
            best.append(min(taken))
    return len(facts), best[0], best[1]


def section(count: int = 100_000) -> Iterator[str]:
    """Yield the table for ``kb/benchmarks.md``."""
    measured: dict[str, Any] = {name: measure_apart(name, count) for name in ENGINES}
    ours = measured["duckdb"]
    pairs = len(ground(scattered(count)))
    yield (
        f"{count:,} things, {pairs:,} ordered pairs within reach; all {len(WANTED)} relations of the rules, "
        "from facts in memory to answers in memory: starting the engine, loading, deriving, reading back. "
        "Without margins. Least of three runs for DuckDB and arrays, one run for the others, each in its own "
        "process."
    )
    yield ""
    yield "| engine | seconds | ratio | peak, GiB | answers |"
    yield "|---|--:|--:|--:|--:|"
    for name, one in measured.items():
        if isinstance(one, str):
            yield f"| {SHOWN[name]} | | | | not measured: {one[:80]} |"
            continue
        same = "the same" if one.rows == ours.rows else "they differ"
        answers = f"{sum(one.rows.values()):,}" if name == "duckdb" else same
        yield (
            f"| {SHOWN[name]} | {one.seconds:.3g} | {one.seconds / ours.seconds:.3g} "
            f"| {one.bytes / 2**30:.2f} | {answers} |"
        )
    pairs, with_margins, without = small()
    yield ""
    yield (
        f"A scene of 100 things ({pairs:,} pairs) warm: all spoken relations with their margins in "
        f"{1000 * with_margins:.1f} ms, without margins in {1000 * without:.1f} ms."
    )


if __name__ == "__main__":
    if len(sys.argv) == 3:
        print(json.dumps(measure(sys.argv[1], int(sys.argv[2]))._asdict()))
    else:
        print("\n".join(section()))
