"""One source of rules, three engines: SWI-Prolog, DuckDB and a triple store find the same."""

from __future__ import annotations

import math
import random
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from commands import call
from deixis.errors import GeometryError, QueryError, QueryTimeout, RuleError
from deixis.facts import Facts
from deixis.grounding import ground
from deixis.knowledge import KnowledgeBase, datalog_files, theory_files
from deixis.prolog import Atom, PrologEngine
from deixis.rdf import SparqlExecutor
from deixis.ruleset import RuleFile, Ruleset, assemble, load, read_file, read_text
from deixis.ruleset.base import BASE_FACTS
from deixis.scene import Scene
from deixis.sql import SqlExecutor
from deixis.vocabulary import BASE, RELATIONS
from naive import Naive, Table, base_rows
from programs import Program, program

HERE = Path(__file__).resolve().parent
GOLDEN = {path.stem: path for path in sorted((HERE / "golden").glob("*.json"))}
GOLDEN["figure_3"] = HERE.parent / "kb" / "scenes" / "hans.json"
PROGRAMS = 40
SMALL = ("cup_on_table", "jar_inside_cabinet", "two_views_two_lefts", "names_are_only_names")
SPOKEN = [(term.name, term.arity) for term in (*BASE, *RELATIONS)]
MEASURES = [("distance", 3), ("halfspace", 5), ("int_hs", 4), ("cont_hs", 4), ("intersection", 3)]

Rows = list[tuple[str | float, ...]]


@pytest.fixture(scope="module")
def files() -> list[RuleFile]:
    return [read_file(path)[0] for path in datalog_files()]


@pytest.fixture(scope="module")
def theory() -> Ruleset:
    return load(datalog_files())


@pytest.fixture(scope="module")
def sql(theory: Ruleset) -> Iterator[SqlExecutor]:
    with SqlExecutor(theory) as executor:
        yield executor


@pytest.fixture(scope="module")
def batch() -> Iterator[PrologEngine]:
    """Return a SWI-Prolog that takes many programs at once."""
    with PrologEngine([*theory_files(), HERE / "rules" / "batch.pl"]) as engine:
        yield engine


@pytest.fixture(scope="module")
def small() -> list[tuple[KnowledgeBase, dict[tuple[str, int], Table]]]:
    """Return small scenes with their base facts as rows."""
    found = []
    for name in SMALL:
        kb = KnowledgeBase.from_scene(GOLDEN[name])
        found.append((kb, {one: base_rows(kb.facts, one) for one in BASE_FACTS if one != ("view_label", 2)}))
    return found


def labels(kb: KnowledgeBase) -> list[tuple[str, str]]:
    return [(view.id, view.label) for view in kb.scene.views]


# The same rules, the same scenes


@pytest.mark.parametrize("name", GOLDEN)
def test_golden_scenes_by_all_engines_to_the_byte(name: str) -> None:
    options = [word for term in (*BASE, *RELATIONS) for word in ("--relation", term.name)]
    for form in ("table", "json", "pl"):
        told = {
            engine: call("relations", GOLDEN[name], *options, "--format", form, "--engine", engine)
            for engine in ("duckdb", "prolog", "sparql")
        }
        assert told["duckdb"] == told["prolog"] == told["sparql"]
        assert told["duckdb"].out


@pytest.mark.parametrize("name", [*GOLDEN, "kitchen"])
def test_margins_of_sql_are_those_of_the_proofs(name: str, sql: SqlExecutor, engine: PrologEngine) -> None:
    """SQL finds the widest margin set at a time, Prolog by one proof after the other: the same to 1 nm."""
    kb = KnowledgeBase.from_scene(GOLDEN.get(name, HERE.parent / "kb" / "scenes" / "kitchen.json"))
    engine.load(kb.facts_text(readable=False))
    predicates: list[Any] = [[Atom(name), arity] for name, arity in SPOKEN]
    told: Any = engine.call("margins", *predicates, timeout=60.0)
    proofs = {(name, *row): math.inf if margin is None else margin for name, *row, margin in told}
    found = {
        (predicate[0], *row): margin
        for predicate, table in sql.run(kb.facts, SPOKEN).items()
        for row, margin in table.named()
    }
    assert proofs.keys() == found.keys()
    worst = max((abs(proofs[one] - found[one]) for one in found if found[one] != proofs[one]), default=0.0)
    assert worst <= 1.0e-9


@pytest.mark.parametrize("name", GOLDEN)
def test_every_predicate_of_the_theory_by_all_engines(
    name: str, sql: SqlExecutor, engine: PrologEngine, theory: Ruleset
) -> None:
    kb = KnowledgeBase.from_scene(GOLDEN[name])
    wanted = [one for one in theory.kinds if one[1] > 0]
    engine.load(kb.facts_text(readable=False))
    by_sql = {
        one: table.rows()
        for one, table in sql.run(kb.facts, wanted, view_labels=labels(kb), margins=False).items()
    }
    by_sparql = SparqlExecutor(theory).run(kb.facts, wanted, view_labels=labels(kb))
    by_prolog = {
        (name, arity): sorted(
            tuple(float(cell) if isinstance(cell, (int, float)) else str(cell) for cell in row)
            for row in rows
        )
        for (name, arity), rows in zip(wanted, engine.relations(wanted).values(), strict=True)
    }
    assert by_sql == by_sparql == by_prolog


# Random rules


def differences(
    group: Sequence[Program],
    world: tuple[KnowledgeBase, dict[tuple[str, int], Table]],
    files: list[RuleFile],
    sql: SqlExecutor,
    batch: PrologEngine,
    margins: bool,
) -> None:
    """Compare what all engines, and the naive evaluation, find by each of some programs."""
    kb, base = world
    batch.load(kb.facts_text(readable=False))
    rulesets = []
    for program in group:
        file, problems = read_text(program.text, Path("random.pl"))
        assert problems == []
        ruleset, found = assemble(files, [file])
        assert [one for one in found if not one.warning] == [], program.text
        rulesets.append(ruleset)
    requests: list[Any] = [
        [
            program.text,
            [[Atom(name), arity] for name, arity in sorted(ruleset.user)],
            [[Atom(name), arity] for name, arity in sorted(ruleset.graph.recursive)],
            [[Atom(name), arity] for name, arity in program.wanted],
        ]
        for program, ruleset in zip(group, rulesets, strict=True)
    ]
    told: Any = batch.call("programs", *requests, timeout=300.0)
    for program, ruleset, tables in zip(group, rulesets, told, strict=True):
        expected = Naive(ruleset, program.wanted, base)
        rows = {one: sorted(expected.truth[one]) for one in program.wanted}
        by_prolog = {
            one: sorted({tuple(float(c) + 0.0 if isinstance(c, float) else c for c in row) for row in table})
            for one, table in zip(program.wanted, tables, strict=True)
        }
        found = SqlExecutor(ruleset, beside=sql).run(kb.facts, program.wanted, margins=margins)
        assert by_prolog == rows, program.text
        assert {one: table.rows() for one, table in found.items()} == rows, program.text
        assert SparqlExecutor(ruleset).run(kb.facts, program.wanted) == rows, program.text
        if margins:
            widest = {one: dict(table.named()) for one, table in found.items()}
            assert widest == {one: expected.truth[one] for one in program.wanted}, program.text


@given(seed=st.integers(0, 2**63))
@settings(max_examples=25)
def test_random_programs(
    seed: int, files: list[RuleFile], sql: SqlExecutor, batch: PrologEngine, small: list[Any]
) -> None:
    """A thousand programs: SWI-Prolog = DuckDB = SPARQL = the naive fixpoint; margins too."""
    draw = random.Random(seed)
    group = [program(draw) for _ in range(PROGRAMS)]
    differences(group, draw.choice(small), files, sql, batch, draw.random() < 0.5)
