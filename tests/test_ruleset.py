"""Rule files: what is read, what is refused and where, and in what order rules are derived."""

from __future__ import annotations

import json
import re
import subprocess
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from commands import call
from deixis._files import datalog_files, theory_files
from deixis.errors import RuleError
from deixis.ruleset import Ruleset, assemble, examine, load, read_file, read_text, shown
from deixis.ruleset.base import BASE_FACTS
from deixis.ruleset.clauses import LONGEST_CLAUSE, MOST_CHARACTERS
from deixis.ruleset.model import Atom, Comparison, Constant, Negation, Variable, variables
from deixis.ruleset.reserved import PROLOG_ONLY, reserved
from deixis.ruleset.syntax import parser_tables, unquoted
from deixis.ruleset.unfold import unfolded
from deixis.vocabulary import TERMS

BAD = sorted((Path(__file__).resolve().parent / "rules_bad").glob("*.pl"))
MINE = Path("mine.pl")


@pytest.fixture(scope="module")
def theory() -> Ruleset:
    return load(datalog_files())


def problems(text: str) -> list[str]:
    """Return what is wrong with a user's rules, as line:column: message."""
    files = [read_file(path)[0] for path in datalog_files()]
    file, found = read_text(text, MINE)
    _, more = assemble(files, [file], partial=bool(found))
    return [str(one).removeprefix("mine.pl:") for one in (*found, *more)]


# What is read


def test_the_theory_is_in_the_subset(theory: Ruleset) -> None:
    assert {predicate for predicate in theory.kinds if predicate in BASE_FACTS} == set(BASE_FACTS)
    derived = {(term.name, term.arity) for term in TERMS} - {("spatial_obj", 1)}
    assert derived <= theory.by_head.keys()
    assert all(theory.by_head[one] for one in derived)


def test_base_facts_are_those_of_facts_pl() -> None:
    (facts, *_) = datalog_files()
    file, found = read_file(facts)
    assert found == []
    # Sentences alone need the last.
    assert [one for one, _ in file.declared] == [*BASE_FACTS, ("box_volume", 2)]
    assert file.exports == tuple(BASE_FACTS)
    assert {len(columns) == arity for (_, arity), columns in BASE_FACTS.items()} == {True}


def test_all_of_the_theory_is_read_or_reserved() -> None:
    stems = {path.stem for path in theory_files()}
    assert stems == {path.stem for path in datalog_files()} | set(PROLOG_ONLY)
    assert reserved(("proof", 2)) == "the theory, in explain.pl"


def test_a_rule_keeps_its_parts_and_places() -> None:
    text = (
        "%!  lone(?X)\n%   Nothing else touches X.\n\n"
        "lone('a b', X) :-\n    near(X, _),\n    \\+ ( touches(Y, X), Y \\== X ).\n"
    )
    file, found = read_text(text, MINE)
    assert found == []
    (rule,) = file.rules
    assert rule.doc == "lone(?X)\n\nNothing else touches X."
    assert (rule.place.line, rule.place.column) == (4, 1)
    assert isinstance(rule.head.args[0], Constant)
    assert rule.head.args[0].value == "a b"
    near, denial = rule.body
    assert isinstance(near, Atom)
    assert isinstance(near.args[1], Variable)
    assert near.args[1].anonymous
    assert isinstance(denial, Negation)
    assert (denial.place.line, denial.place.column) == (6, 5)
    assert isinstance(denial.goals[1], Comparison)
    assert [one.name for one in variables(denial)] == ["Y", "X", "Y", "X"]


def test_comments_become_documentation(theory: Ruleset) -> None:
    assert theory.docs["on_top_of", 2].endswith(
        "Axiom 36. Figure is on top of Reference iff it is above it and touches it."
    )
    assert set(theory.docs) >= {(term.name, term.arity) for term in TERMS} - {("spatial_obj", 1)}


@pytest.mark.parametrize(
    ("written", "meant"),
    [
        (r"'it''s'", "it's"),
        (r"'a\nb\t\\\'\x41\\x41'", "a\nb\t\\'AA"),
        (r"'\u00e9\U0001F600\101\'", "é\U0001f600A"),
        ("'a\\\nb'", "ab"),
        (r"'\e\s\\'", "\x1b \\"),
    ],
)
def test_quoted_names_are_read_as_prolog_does(written: str, meant: str) -> None:
    assert unquoted(written) == meant
    told = subprocess.run(
        ["swipl", "-q", "-g", f"X = {written}, atom_codes(X, C), print(C), nl", "-t", "halt"],
        capture_output=True,
        text=True,
        check=True,
    )
    assert told.stdout.strip() == str([ord(character) for character in meant]).replace(" ", "")


@given(st.text(st.characters(exclude_categories=["Cs"], exclude_characters="\0"), max_size=12))
def test_any_name_is_read_back(text: str) -> None:
    from deixis.prolog.quote import atom, string

    file, found = read_text(f"p({atom(text)}, {string(text)}).", MINE)
    assert found == []
    assert [one.value for one in file.rules[0].head.args if isinstance(one, Constant)] == [text, text]


def test_numbers() -> None:
    file, found = read_text("p(3, -4, 0.5, -1.5e-3, 1e3, -0.0).", MINE)
    assert found == []
    values = [one.value for one in file.rules[0].head.args if isinstance(one, Constant)]
    assert values == [3.0, -4.0, 0.5, -0.0015, 1000.0, 0.0]
    assert str(values[-1]) == "0.0"


def test_the_parser_s_tables_are_made_of_the_grammar(root: Path) -> None:
    """Otherwise: python -m deixis.ruleset.syntax"""
    here = root / "src" / "deixis" / "ruleset"
    fresh = json.loads(parser_tables((here / "grammar.lark").read_text(encoding="utf-8")))
    kept = json.loads((here / "grammar.json").read_text(encoding="utf-8"))
    assert kept["made_of"] == fresh["made_of"]
    # How states are numbered is another matter each time.
    assert kept.keys() == fresh.keys()


# What is refused


@pytest.mark.parametrize("path", BAD, ids=lambda path: path.stem)
def test_a_bad_file_has_one_problem_with_its_place(path: Path) -> None:
    """The first line of each file says: % expect: LINE:COLUMN: message."""
    expected = re.match("% expect: (.*)", path.read_text(encoding="utf-8"))
    assert expected is not None
    _, found = examine(datalog_files(), [path])
    (only,) = found
    assert f"{only.place.line}:{only.place.column}: {only.message}" == expected[1]


def test_there_are_bad_files_of_every_kind() -> None:
    assert len(BAD) >= 70


def test_all_problems_are_told_in_order() -> None:
    text = "p(X) :- nearr(X, _).\nq(X :- surface(X).\nr(X, Y) :- surface(X), !.\ns(Z) :- surface(floor).\n"
    assert [one.partition(" (")[0] for one in problems(text)] == [
        "2:5: ':-' is not expected here",
        "3:24: the cut ! is not in the subset",
        "1:9: nearr/2 is not defined",
        "4:3: Z is bound by no goal",
    ]


def test_a_problem_says_what_to_do() -> None:
    assert problems("p(X) :- on_topp_of(X, _).") == [
        "1:9: on_topp_of/2 is not defined (did you mean on_top_of/2?)"
    ]
    assert problems("p(X) :- beside(X, _).") == ["1:9: beside/2 is not defined (beside has 3 arguments)"]


@pytest.mark.parametrize(
    "text",
    [
        "p(X) :- surface(X), \\+ touches(_, X).",
        "p(X) :- spatial_obj(X), \\+ ( touches(Y, X), Y \\== X ).",
        "p(X, Y) :- separation(X, Y, D), threshold(penetration, P), D >= -P + 0.01 - 2.",
        "p(X, Y) :- near(X, Y).\np(X, Y) :- near(X, Z), p(Z, Y).",
        ":- dynamic wet/1.\np(X) :- surface(X), \\+ wet(X).",
        "weight(cup, 0.3).\nheavy(X) :- weight(X, W), W > 1.",
        'p(X, "a text") :- surface(X).\nq(X, T) :- p(X, T), T \\== "other".',
        ":- module(mine, [p/1]).\n:- use_module(facts).\n:- use_module(library(lists)).\np(X) :- surface(X).",
        "p(X) :- label(X, _Name, _Score).",
        "p(X) :- near(X, Y), X == Y.\np(X) :- near(X, Y), X \\= Y, X = X, cup \\== X.",
    ],
)
def test_good_rules(text: str) -> None:
    assert problems(text) == []


def test_two_files_of_ones_own_do_not_share_a_predicate(tmp_path: Path) -> None:
    for name in ("one", "two"):
        (tmp_path / f"{name}.pl").write_text("p(X) :- surface(X).\n", encoding="utf-8")
    _, found = examine(datalog_files(), [tmp_path / "one.pl", tmp_path / "two.pl"])
    assert [(one.place.file.name, one.place.line) for one in found] == [("two.pl", 1)]


@pytest.mark.parametrize(
    "text",
    [
        "p(X) :- surface(X)." + " " * MOST_CHARACTERS,
        "p(" + "a, " * LONGEST_CLAUSE + "a).",
        "p(X) :- " + "(" * 30_000,
        "p(X) :- X < " + "-" * 30_000 + "1.",
        "p(X) :- " + "\\+ " * 20_000 + "surface(X).",
        "p(X) :- " + "surface(X), " * 5_000 + "surface(X).\nq(X) :- r(X).",
        "p(X) :- " + "surface(X) ; " * 5_000 + "surface(X).",
        "p(X) :- D < " + "1 + " * 15_000 + "1, distance(X, _, D).",
        "'" * 65_000,
        "\0\x01 :- \ud7ff.",
    ],
    ids=range(10),
)
def test_large_and_deep_files_are_refused_quickly(text: str) -> None:
    assert problems(text)


def test_many_rules_are_read() -> None:
    text = "".join(f"p{at}(X) :- p{at + 1}(X).\n" for at in range(3_000)) + "p3000(X) :- surface(X).\n"
    assert problems(text) == []


@given(st.text(st.sampled_from("pqXY_(),.:-\\+=<>!;|[]{}'\"% \n0123abc/*~"), max_size=60))
def test_no_text_crashes_the_reader(text: str) -> None:
    problems(text)


def test_a_file_must_be_there_and_text(tmp_path: Path) -> None:
    with pytest.raises(RuleError, match="no rule file"):
        load(datalog_files(), [tmp_path / "none.pl"])
    (tmp_path / "latin.pl").write_bytes(b"p('\xe9').")
    with pytest.raises(RuleError, match="no UTF-8"):
        load(datalog_files(), [tmp_path / "latin.pl"])


# Order and kinds


def test_strata(theory: Ruleset) -> None:
    strata = theory.graph.strata()
    assert {one for one, level in strata.items() if level == 1} == {("leans_on", 2), ("affixed_on", 2)}
    order = {one: at for at, component in enumerate(theory.graph.components) for one in component}
    assert all(order[edge.on] < order[edge.head] for edge in theory.graph.edges)
    assert theory.graph.recursive == frozenset()


def test_kinds_and_lengths(theory: Ruleset) -> None:
    assert theory.kinds["halfspace", 5] == ("name", "name", "name", "name", "number")
    assert theory.lengths["halfspace", 5][4]
    assert theory.lengths["distance", 3][2]
    assert not theory.lengths["intersection", 3][2]
    assert not theory.lengths["adj_sr_card", 3][2]


def test_what_is_written_out_reads_pairs_once(theory: Ruleset) -> None:
    written = unfolded(theory)
    (rule,) = written.rules["on_top_of", 2]
    assert sorted(goal.name for goal in rule.body if isinstance(goal, Atom)) == [
        "figure_reference",
        "pair",
        "threshold",
        "threshold",
    ]
    assert ("on_top_of", 2) in written.once
    assert ("leans_on", 2) not in written.once


# On the command line


def test_rules_check(tmp_path: Path) -> None:
    good, bad = tmp_path / "good.pl", tmp_path / "bad.pl"
    good.write_text("p(X) :- near(X, _).\n", encoding="utf-8")
    bad.write_text("p(X) :- neer(X, _).\nq(X) :- near(Y, _).\n", encoding="utf-8")
    assert call("rules", "check", good) == call("rules", "check", *datalog_files())
    assert (call("rules", "check", good).code, call("rules", "check", good).out) == (0, "")
    told = call("rules", "check", bad)
    assert (told.code, told.err) == (1, "")
    assert [line.split(":", 1)[1].partition(" (")[0] for line in told.out.splitlines()] == [
        "1:9: neer/2 is not defined",
        "2:3: X is bound by no goal",
        "2:14: warning: Singleton variable Y",
    ]
    assert call("rules", "check", tmp_path / "none.pl").code == 2


def test_rules_graph(tmp_path: Path) -> None:
    own = tmp_path / "own.pl"
    own.write_text("'odd \"name\"'(X) :- surface(X), \\+ leans_on(_, X).\n", encoding="utf-8")
    told = call("rules", "graph", own)
    assert told.code == 0
    assert 'stratum 2\n  odd "name"/1: surface/1, \\+ leans_on/2\n' in told.out
    drawn = call("rules", "graph", own, "--format", "dot")
    assert '  "odd \\"name\\"/1" -> "leans_on/2" [style = dashed];' in drawn.out


@pytest.mark.parametrize("language", ["sql", "sparql"])
def test_rules_compile(tmp_path: Path, language: str) -> None:
    own = tmp_path / "own.pl"
    own.write_text(
        "over(X, Y) :- on_top_of(X, Y).\nover(X, Y) :- on_top_of(X, Z), over(Z, Y).\n", encoding="utf-8"
    )
    told = call("rules", "compile", "--to", language, own)
    assert (told.code, told.err) == (0, "")
    assert "over" in told.out
    assert told.out.count("Repeat") == 1
    assert shown(("on_top_of", 2)) in told.out
