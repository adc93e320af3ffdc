"""One source of rules, four engines: SWI-Prolog, DuckDB, arrays and a triple store find the same."""

from __future__ import annotations

import math
import os
import random
import re
import subprocess
import sys
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import duckdb
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from commands import call, run
from deixis._files import datalog_files, theory_files
from deixis.arrays import ArrayExecutor, TooMany
from deixis.engines import AutoExecutor
from deixis.errors import GeometryError, QueryError, QueryTimeout, RuleError
from deixis.facts import Facts
from deixis.knowledge import KnowledgeBase
from deixis.prolog import Atom, PrologEngine, facts_text
from deixis.prolog.quote import atom
from deixis.rdf import SparqlExecutor
from deixis.ruleset import RuleFile, Ruleset, assemble, load, read_file, read_text
from deixis.ruleset.base import BASE_FACTS
from deixis.sql import SqlExecutor
from deixis.vocabulary import BASE, RELATIONS
from naive import Naive, Table, base_rows
from programs import Program, random_program

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
            for engine in ("auto", "arrays", "duckdb", "prolog", "sparql")
        }
        assert len(set(told.values())) == 1
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
    # What is told for sentences alone is no business of rules.
    wanted = [one for one in theory.kinds if one[1] > 0 and one != ("box_volume", 2)]
    engine.load(kb.facts_text(readable=False))
    by_sql = {
        one: table.rows()
        for one, table in sql.run(kb.facts, wanted, view_labels=labels(kb), margins=False).items()
    }
    arrays = ArrayExecutor(theory).run(kb.facts, wanted, view_labels=labels(kb))
    by_sparql = SparqlExecutor(theory).run(kb.facts, wanted, view_labels=labels(kb))
    by_prolog = {
        (name, arity): sorted(
            tuple(float(cell) if isinstance(cell, (int, float)) else str(cell) for cell in row)
            for row in rows
        )
        for (name, arity), rows in zip(wanted, engine.relations(wanted).values(), strict=True)
    }
    assert by_sql == by_sparql == by_prolog == {one: table.rows() for one, table in arrays.items()}


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
        by_arrays = ArrayExecutor(ruleset).run(kb.facts, program.wanted, margins=margins)
        assert by_prolog == rows, program.text
        assert {one: table.rows() for one, table in by_arrays.items()} == rows, program.text
        assert {one: table.rows() for one, table in found.items()} == rows, program.text
        assert SparqlExecutor(ruleset).run(kb.facts, program.wanted) == rows, program.text
        if margins:
            widest = {one: dict(table.named()) for one, table in found.items()}
            assert widest == {one: expected.truth[one] for one in program.wanted}, program.text
            assert widest == {one: dict(table.named()) for one, table in by_arrays.items()}, program.text


@given(seed=st.integers(0, 2**63))
@settings(max_examples=25)
def test_random_programs(
    seed: int, files: list[RuleFile], sql: SqlExecutor, batch: PrologEngine, small: list[Any]
) -> None:
    """A thousand programs: SWI-Prolog = DuckDB = SPARQL = the naive fixpoint; margins too."""
    draw = random.Random(seed)  # noqa: S311 - no secret
    group = [random_program(draw) for _ in range(PROGRAMS)]
    differences(group, draw.choice(small), files, sql, batch, draw.random() < 0.5)


@pytest.mark.parametrize("seed", range(6))
def test_what_passes_the_check_loads_in_prolog(seed: int, files: list[RuleFile], tmp_path: Path) -> None:
    """SWI-Prolog complains of nothing that the check lets pass."""
    lines = random_program(random.Random(seed)).text.split("\n")  # noqa: S311 - no secret
    path = tmp_path / "random.pl"
    while True:
        file, _ = read_text("\n".join(lines), path)
        ruleset, problems = assemble(files, [file])
        if not problems:
            break
        place = problems[-1].place
        assert problems[-1].message.startswith("Singleton variable")
        line = lines[place.line - 1]
        lines[place.line - 1] = line[: place.column - 1] + re.sub(r"^\w+", "_", line[place.column - 1 :])
    path.write_text("\n".join(lines), encoding="utf-8")
    with PrologEngine([*theory_files(), path], tabled=sorted(ruleset.graph.recursive)) as engine:
        assert engine.ask("true")


@pytest.mark.long
@given(seed=st.integers(0, 2**63))
@settings(max_examples=2500)
def test_a_hundred_thousand_random_programs(
    seed: int, files: list[RuleFile], sql: SqlExecutor, small: list[Any]
) -> None:
    draw = random.Random(seed)  # noqa: S311 - no secret
    group = [random_program(draw) for _ in range(PROGRAMS)]
    # Programs stay in the process that they were loaded into: a new one for each group.
    with PrologEngine([*theory_files(), HERE / "rules" / "batch.pl"]) as batch:
        differences(group, draw.choice(small), files, sql, batch, draw.random() < 0.5)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        # left, right and mutual recursion
        ("t(X, Y) :- t(X, Z), e(Z, Y).\nt(X, Y) :- e(X, Y).", "ab ac ad bc bd cd"),
        ("t(X, Y) :- e(X, Y).\nt(X, Y) :- e(X, Z), t(Z, Y).", "ab ac ad bc bd cd"),
        ("t(X, Y) :- e(X, Y).\nt(X, Y) :- t(X, Z), t(Z, Y).", "ab ac ad bc bd cd"),
        (
            "t(X, Y) :- e(X, Y).\nt(X, Y) :- e(X, Z), odd(Z, Y).\nodd(X, Y) :- e(X, Z), t(Z, Y).",
            "ab ad bc cd",
        ),
        # a variable that stands only in a denial means any
        ("t(X, X) :- n(X, _), \\+ e(X, _).", "dd"),
        ("t(X, Y) :- e(X, Y), \\+ ( e(Z, Y), Z \\== X ).", "ab bc cd"),
        # duplicates are one row
        ("t(X, X) :- e(X, _).\nt(X, X) :- e(_, X).", "aa bb cc dd"),
        # 1 is 1.0, 0.1 + 0.2 is not 0.3, -0.0 is 0
        ("t(X, X) :- n(X, D), D =:= 1.0.", "aa"),
        ("t(X, X) :- n(X, D), D =:= 0.1 + 0.2.", "cc"),
        ("t(X, X) :- n(X, D), D =:= 0.3.", "bb"),
        ("t(X, X) :- n(X, D), D =:= -0.0.", "dd"),
        ("t(X, X) :- n(X, D), -D > -0.3, D =\\= 0.", ""),
        ("t(X, Y) :- n(X, D), n(Y, E), D < E - 0.5, X \\= Y.", "ba ca da"),
        # two minus signs are a comment in SQL
        ("t(X, X) :- near(X, Y), \\+ ( separation(X, Y, D), D =:= 0.3 ).", "cupcup tabletable"),
        # a name is not a number, quoted or not
        ("t(X, X) :- e(X, _), X == 'a'.", "aa"),
        # a predicate without clauses
        (":- dynamic wet/1.\nt(X, X) :- e(X, _), \\+ wet(X).", "aa bb cc"),
        # one more name for a name in two places
        ("t(X, X) :- e(X, Y), X = Y.", ""),
        ("t(c, Y) :- e(Y, c).", "cb"),
        ("same(X, X) :- n(X, _).\nt(X, Y) :- same(X, Y), e(X, _).", "aa bb cc"),
    ],
)
def test_semantic_traps(
    text: str, expected: str, files: list[RuleFile], sql: SqlExecutor, batch: PrologEngine, small: list[Any]
) -> None:
    whole = (
        "e(a, b).\ne(b, c).\ne(c, d).\nn(a, 1).\nn(b, 0.3).\nn(c, 0.30000000000000004).\nn(d, 0).\n" + text
    )
    differences([Program(whole, {"t": "nn"})], small[0], files, sql, batch, margins=True)
    file, _ = read_text(whole, Path("trap.pl"))
    ruleset, problems = assemble(files, [file])
    assert problems == []
    found = SqlExecutor(ruleset, beside=sql).run(small[0][0].facts, [("t", 2)])
    assert " ".join("".join(map(str, row)) for row in found["t", 2].rows()) == expected


# Ids are data


def hostile(count: int) -> list[str]:
    """Return ids of anything that a text may hold, all different."""
    draw = random.Random(0)  # noqa: S311 - no secret
    pieces = [
        "'", '"', "\\", "\n", "\t", "`", ";", "--", "/*", "%", "$", "{", "}", "<", ">", "?-", "halt.", "NULL",
        " ", "\u202e", "\u2028", "\ufeff", "\U0001f600", "é", "e\u0301", "a0", "world", "X+", "_", "X", "[]",
        "%20", "\x1b",
        "), (", "SELECT", "urn:deixis:id:", "t0", "0'c", "~w", "-1", "\x7f", "\xa0",
    ]  # fmt: skip
    found = {"", *pieces}
    while len(found) < count:
        found.add("".join(draw.choices(pieces, k=draw.randint(1, 6))))
    return sorted(found)


def test_hostile_ids_come_back_from_all_engines(
    theory: Ruleset, sql: SqlExecutor, engine: PrologEngine
) -> None:
    """A hundred thousand ids, each an object, come back as they went in."""
    ids = hostile(100_000)
    empty = KnowledgeBase.from_scene(GOLDEN["cup_on_table"]).facts
    rows = len(ids)
    facts = Facts(
        scene="hostile",
        ids=tuple(ids),
        labels=((),) * rows,
        surface=np.ones(rows, dtype=bool),
        volume=np.ones(rows),
        thresholds=empty.thresholds,
        pairs=empty.pairs.at(np.zeros(0, dtype=np.int64)),
        views=(),
        region="box",
        models=("box",) * rows,
    )
    wanted = [("surface", 1)]
    expected = [(one,) for one in ids]
    assert sql.run(facts, wanted)["surface", 1].rows() == expected
    assert ArrayExecutor(theory).run(facts, wanted)["surface", 1].rows() == expected
    assert SparqlExecutor(theory).run(facts, wanted)["surface", 1] == expected
    engine.load(facts_text(facts))
    assert sorted((str(row[0]),) for row in engine.relations(wanted)["surface"]) == expected


def test_hostile_names_in_rules(files: list[RuleFile], sql: SqlExecutor, small: list[Any]) -> None:
    ids = hostile(300)
    lines = [f"p({atom(one)}, {atom(two)})." for one, two in zip(ids, reversed(ids), strict=True)]
    lines += [f"q(X) :- p(X, {atom(one)})." for one in ids]
    file, problems = read_text("\n".join(lines), Path("hostile.pl"))
    ruleset, more = assemble(files, [file])
    assert problems == more == []
    facts = small[0][0].facts
    found = SqlExecutor(ruleset, beside=sql).run(facts, wanted := [("p", 2), ("q", 1)])
    told = SparqlExecutor(ruleset).run(facts, wanted)
    assert found["p", 2].rows() == told["p", 2] == sorted(zip(ids, reversed(ids), strict=True))
    assert found["q", 1].rows() == told["q", 1] == [(one,) for one in ids]
    by_arrays = ArrayExecutor(ruleset).run(facts, wanted)
    assert [by_arrays[one].rows() for one in wanted] == [found[one].rows() for one in wanted]


def test_predicates_with_odd_names(files: list[RuleFile], sql: SqlExecutor, small: list[Any]) -> None:
    text = "'a b'(x).\n'a;b'(y).\n'a-b'(X) :- 'a b'(X).\n'A_b'(X) :- 'a;b'(X).\n'select'(X) :- 'A_b'(X).\n"
    file, problems = read_text(text, Path("odd.pl"))
    ruleset, more = assemble(files, [file])
    assert problems == more == []
    wanted = sorted(ruleset.user)
    found = SqlExecutor(ruleset, beside=sql).run(small[0][0].facts, wanted)
    told = SparqlExecutor(ruleset).run(small[0][0].facts, wanted)
    by_arrays = ArrayExecutor(ruleset).run(small[0][0].facts, wanted)
    assert {one: table.rows() for one, table in found.items()} == told
    assert {one: table.rows() for one, table in by_arrays.items()} == told
    assert told["select", 1] == [("y",)]


# Rules of one's own


OWN = """
%!  over(?Figure, ?Reference) is nondet.
%   Figure rests on Reference, directly or by way of other things.
over(Figure, Reference) :-
    on_top_of(Figure, Reference).
over(Figure, Reference) :-
    over(Figure, Other),
    on_top_of(Other, Reference).

hidden(Figure, Reference, View) :-
    left_of(Figure, Reference, View),
    \\+ above(Figure, Reference).

gap(Figure, Distance) :-
    distance(Figure, wall, Distance),
    Distance < 0.5.
"""


@pytest.fixture
def own(tmp_path: Path) -> Path:
    path = tmp_path / "own.pl"
    path.write_text(OWN, encoding="utf-8")
    return path


def test_own_rules_by_all_engines(own: Path) -> None:
    told = {}
    for name in ("arrays", "duckdb", "prolog", "sparql"):
        options = ("--rules", own, "--relation", "over", "--relation", "hidden", "--format", "csv")
        told[name] = call("relations", GOLDEN["figure_3"], *options, "--engine", name)
    assert told["arrays"] == told["duckdb"] == told["prolog"] == told["sparql"]
    assert "over,sweater,floor,,0.02" in told["duckdb"].out
    assert "hidden," in told["duckdb"].out


def test_own_rules_are_asked_and_explained(own: Path) -> None:
    scene = GOLDEN["figure_3"]
    # Tables have no order.
    answers = call("ask", scene, "over(sweater, X)", "--rules", own).out.splitlines()
    assert sorted(answers) == ["X = floor", "X = heater"]
    assert call("why", scene, "over(sweater, floor)", "--rules", own).code == 0
    shell = run("shell", scene, "--rules", own, stdin="forall(over(sweater, X), (write(X), nl)).\n")
    assert {"floor", "heater"} <= set(shell.out.split())
    with KnowledgeBase.from_scene(scene, rules=[own]) as kb:
        assert ("sweater", "floor") in {
            (one.figure, one.reference) for one in kb.relations(relation=["over"])
        }
        with pytest.raises(QueryError, match="gap/2 is no relation of things"):
            kb.relations(relation=["gap"])
        with pytest.raises(QueryError, match="did you mean 'over'"):
            kb.relations(relation=["ovr"])


def test_own_rules_are_checked_before_any_engine_runs(tmp_path: Path) -> None:
    bad = tmp_path / "bad.pl"
    bad.write_text("p(X, Y) :- near(X, Y), shell(X).\nq(X, Y) :- nearr(X, Y).\n", encoding="utf-8")
    for engine in ("arrays", "duckdb", "prolog", "sparql"):
        told = call("relations", GOLDEN["figure_3"], "--rules", bad, "--engine", engine)
        assert (told.code, told.out) == (2, "")
        assert "'shell' is not in the subset" in told.err
        assert "did you mean near/2?" in told.err
    for command in (["ask", "true"], ["why", "near(sweater, heater)"], ["shell"]):
        assert call(command[0], GOLDEN["figure_3"], *command[1:], "--rules", bad).code == 2


# The database


def test_relations_need_no_prolog(root: Path) -> None:
    hidden = {
        **os.environ,
        "PATH": "/nonexistent",
        "LIBSWIPL_PATH": "/nonexistent",
        "SWI_HOME_DIR": "/nonexistent",
    }
    command = [sys.executable, "-m", "deixis", "relations", GOLDEN["figure_3"]]
    told = subprocess.run(command, env=hidden, capture_output=True, text=True, check=False, cwd=root)
    assert told.returncode == 0
    assert "leans_on" in told.stdout


@pytest.mark.parametrize("engine", ["auto", "arrays", "duckdb"])
def test_only_what_is_needed_is_imported_for_relations(engine: str) -> None:
    code = (
        "import sys; from deixis.knowledge import KnowledgeBase; "
        f"KnowledgeBase.from_scene({str(GOLDEN['figure_3'])!r}).relations(engine={engine!r}); "
        "print(sorted({'duckdb', 'pyswip', 'pyoxigraph', 'pandas', 'pyarrow'} & set(sys.modules)))"
    )
    told = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert told.stdout == ("['duckdb']\n" if engine == "duckdb" else "[]\n")


def test_without_a_triple_store_the_remedy_is_named() -> None:
    code = (
        "import sys; sys.modules['pyoxigraph'] = None; from deixis.cli import main; "
        f"sys.argv = ['deixis', 'relations', {str(GOLDEN['figure_3'])!r}, '--engine', 'sparql']; "
        "sys.exit(main())"
    )
    told = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert (told.returncode, told.stdout) == (2, "")
    assert told.stderr == "deixis: RDF needs pyoxigraph: pip install 'deixis[rdf]'\n"


CONNECTIONS = """
import sys
from pathlib import Path
import duckdb
from deixis._files import datalog_files
from deixis.ruleset import load
from deixis.scene import Scene
from deixis.semantic_map import create_map
from deixis.sql import SqlExecutor
from deixis.tiles.database import database

folder = Path(sys.argv[1])
asked = "SELECT current_setting('enable_progress_bar')"
with (
    duckdb.connect() as plain,
    SqlExecutor(load(datalog_files())) as sql,
    create_map(folder / "map.duckdb", Scene("map")) as kept,
    database(folder, 1 << 28, "") as small,
    database(folder, 1 << 28, "", folder / "after.duckdb") as large,
):
    for one in (plain, sql._connection, kept._connection, small, large):
        print(*one.execute(asked).fetchone())
"""


def test_no_database_draws_a_progress_bar(tmp_path: Path) -> None:
    # DuckDB draws one where Python runs no file, as in a shell: here too.
    command = [sys.executable, "-c", CONNECTIONS, tmp_path]
    told = subprocess.run(command, capture_output=True, text=True, check=True)
    assert told.stdout.split() == ["True"] + ["False"] * 4


def test_the_database_is_closed_to_the_world(sql: SqlExecutor, tmp_path: Path) -> None:
    (tmp_path / "x.csv").write_text("a\n1\n", encoding="utf-8")
    for statement in (
        f"FROM '{tmp_path / 'x.csv'}'",
        f"COPY (SELECT 1) TO '{tmp_path / 'y.csv'}'",
        f"ATTACH '{tmp_path / 'z.db'}'",
        "SET enable_external_access = true",
        "INSTALL httpfs",
        "LOAD httpfs",
    ):
        with pytest.raises(duckdb.Error):
            sql._connection.execute(statement)


def test_numbers_must_be_finite(sql: SqlExecutor, theory: Ruleset) -> None:
    facts = KnowledgeBase.from_scene(GOLDEN["cup_on_table"]).facts
    facts.pairs.separation[0] = math.nan
    with pytest.raises(GeometryError, match="not a finite number"):
        sql.run(facts, [("touches", 2)])
    with pytest.raises(GeometryError, match="not a finite number"):
        ArrayExecutor(theory).run(facts, [("touches", 2)])


def test_a_question_that_takes_too_long_is_stopped(files: list[RuleFile], sql: SqlExecutor) -> None:
    text = "".join(f"n({at}).\n".replace("(", "(n") for at in range(400))
    text += "p(A, B) :- n(A), n(B).\nq(A) :- p(A, B), p(C, D), p(E, F), \\+ p(B, E), A \\== C, D \\== F."
    file, _ = read_text(text, Path("slow.pl"))
    ruleset, problems = assemble(files, [file])
    assert problems == []
    facts = KnowledgeBase.from_scene(GOLDEN["cup_on_table"]).facts
    with pytest.raises(QueryTimeout, match=r"0\.2 s"):
        SqlExecutor(ruleset, beside=sql).run(facts, [("q", 1)], timeout=0.2)
    assert sql.run(facts, [("near", 2)])["near", 2].rows()
    with pytest.raises(QueryTimeout):
        SparqlExecutor(ruleset).run(facts, [("q", 1)], timeout=0.0)
    with pytest.raises(QueryTimeout, match="within 0 s"):
        ArrayExecutor(ruleset).run(facts, [("q", 1)], timeout=0.0)


def test_what_is_declared_and_never_stated_holds_of_nothing(files: list[RuleFile], sql: SqlExecutor) -> None:
    ruleset, problems = assemble(files, [read_text(":- dynamic extra/2.", Path("own.pl"))[0]])
    assert problems == []
    facts = KnowledgeBase.from_scene(GOLDEN["cup_on_table"]).facts
    executors = SqlExecutor(ruleset, beside=sql), ArrayExecutor(ruleset), SparqlExecutor(ruleset)
    assert [len(one.run(facts, [("extra", 2)])["extra", 2]) for one in executors] == [0, 0, 0]


def test_a_triple_store_is_stopped_in_the_midst_of_a_rule(files: list[RuleFile]) -> None:
    text = "".join(f"n(n{at}).\n" for at in range(1500)) + "wide(A, B) :- n(A), n(B)."
    file, _ = read_text(text, Path("wide.pl"))
    facts = KnowledgeBase.from_scene(GOLDEN["cup_on_table"]).facts
    with pytest.raises(QueryTimeout, match=r"0\.3 s"):
        SparqlExecutor(assemble(files, [file])[0]).run(facts, [("wide", 2)], timeout=0.3)


def test_what_is_too_much_for_arrays_is_left_to_duckdb(files: list[RuleFile]) -> None:
    text = "".join(f"n(n{at}).\n" for at in range(300))
    text += "q(A, B) :- n(A), n(B), n(C), A \\== B, B == C."
    file, _ = read_text(text, Path("wide.pl"))
    ruleset, problems = assemble(files, [file])
    assert problems == []
    facts = KnowledgeBase.from_scene(GOLDEN["cup_on_table"]).facts
    with pytest.raises(TooMany, match="26,910,000 rows at once"):
        ArrayExecutor(ruleset).run(facts, [("q", 2)])
    with AutoExecutor(ruleset) as executor:
        assert len(executor.run(facts, [("q", 2)])["q", 2]) == 300 * 299


def test_long_chains_of_rules(files: list[RuleFile], sql: SqlExecutor) -> None:
    text = "".join(f"p{at}(X) :- p{at + 1}(X).\n" for at in range(400)) + "p400(X) :- surface(X).\n"
    file, _ = read_text(text, Path("chain.pl"))
    ruleset, problems = assemble(files, [file])
    assert problems == []
    facts = KnowledgeBase.from_scene(GOLDEN["cup_on_table"]).facts
    found = SqlExecutor(ruleset, beside=sql).run(facts, [("p0", 1), ("p399", 1)])
    assert found["p0", 1].rows() == found["p399", 1].rows() == [("floor",)]
    by_arrays = ArrayExecutor(ruleset).run(facts, [("p0", 1), ("p399", 1)])
    assert by_arrays["p0", 1].rows() == by_arrays["p399", 1].rows() == [("floor",)]


def test_an_executor_serves_many_threads(sql: SqlExecutor) -> None:
    facts = [KnowledgeBase.from_scene(GOLDEN[name]).facts for name in SMALL]
    alone = [sql.run(one, SPOKEN)["near", 2].rows() for one in facts]
    with ThreadPoolExecutor(4) as pool:
        together = list(pool.map(lambda one: sql.run(one, SPOKEN)["near", 2].rows(), facts * 5))
    assert together == alone * 5


def test_rules_must_be_there() -> None:
    with pytest.raises(RuleError, match="no rule file"):
        KnowledgeBase.from_scene(GOLDEN["figure_3"], rules=["none.pl"]).relations()
