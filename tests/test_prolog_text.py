"""Values and facts as Prolog text: what goes into SWI-Prolog comes back the same."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from deixis.errors import GeometryError, QueryError
from deixis.facts import Facts, PairColumns, ViewFacts
from deixis.prolog import Atom, Compound, PrologEngine, Term, Variable, facts_text
from deixis.prolog.quote import atom, number, string, term
from deixis.prolog.terms import decode
from deixis.thresholds import Thresholds

ECHO = """
:- module(echo, []).
:- multifile bridge:operation/3.
bridge:operation(echo, [Term], term(Term)).
"""

HOSTILE = (
    "?- halt.",
    "'). halt. %",
    'x"))),shell("id"),assertz((obj("y',
    "')),halt,(('",
    "\\", "\\'", "\\x27\\", "'", '"', "`", "''", "\n", "\r\n", "\t", "\0", "a\0", "\0b", "\x7f", "\x85",
    "/*", "*/", "%", "0'a", "~w", "%p", "{0}", "a:-b", "[]", "{}", "_", "X", "-1", "1e400", "nan", "null",
    "true", "", " ", "\u202e", "\u2028", "\u2029", "\ufeff", "\u200b", "e\u0301", "\u00e9", "\U0001f600",
    "\U0010ffff", "\uffff", "\U000d8000", "\U000dffff", "\u0430", "end_of_file", ".", ".\n", "a.\nb.",
)  # fmt: skip

hostile_text = st.one_of(
    st.sampled_from(HOSTILE),
    st.lists(st.sampled_from(HOSTILE), min_size=2, max_size=4).map("".join),
    st.text(max_size=30),
    st.text(alphabet="'\"\\`\0\n\x1b%*/.x41\\ ", max_size=20),
)
numbers = st.one_of(
    st.integers(),
    st.integers(min_value=-(10**30), max_value=10**30),
    st.floats(allow_nan=False, allow_infinity=False),
    st.fractions().filter(lambda value: value.denominator > 1),
)
terms = st.recursive(
    st.one_of(hostile_text.map(Atom), hostile_text, numbers),
    lambda inner: st.one_of(
        st.lists(inner, max_size=4),
        st.builds(Compound, hostile_text, st.lists(inner, max_size=3).map(tuple)),
    ),
    max_leaves=8,
)


@pytest.fixture(scope="module")
def prolog(tmp_path_factory: pytest.TempPathFactory) -> Iterator[PrologEngine]:
    file = tmp_path_factory.mktemp("rules") / "echo.pl"
    file.write_text(ECHO)
    with PrologEngine([file]) as engine:
        yield engine


def same(one: Term, other: Term) -> bool:
    """Return whether two terms are of the same classes and values all the way down."""
    if type(one) is not type(other):
        return False
    if isinstance(one, list) and isinstance(other, list):
        return len(one) == len(other) and all(map(same, one, other))
    if isinstance(one, Compound) and isinstance(other, Compound):
        return one.functor == other.functor and same(list(one.args), list(other.args))
    if isinstance(one, float) and isinstance(other, float):
        return one.hex() == other.hex()  # tells -0.0 from 0.0
    return one == other


@given(st.lists(hostile_text, min_size=60, max_size=80))
def test_hostile_texts_come_back(prolog: PrologEngine, texts: list[str]) -> None:
    sent: list[Term] = [*map(Atom, texts), *texts]
    back = decode(prolog.call("echo", sent))
    assert same(back, sent)


@given(st.lists(terms, min_size=1, max_size=10))
def test_terms_come_back(prolog: PrologEngine, sent: list[Term]) -> None:
    back = decode(prolog.call("echo", sent))
    assert same(back, sent)


def test_every_character_comes_back(prolog: PrologEngine) -> None:
    characters = [
        chr(code) for code in (*range(0x3000), *range(0xFE00, 0x10100)) if not 0xD800 <= code < 0xE000
    ]
    sent: list[Term] = [Atom("".join(characters)), "".join(characters), *map(Atom, characters)]
    assert same(decode(prolog.call("echo", sent)), sent)


def test_numbers_come_back(prolog: PrologEngine) -> None:
    sent: list[Term] = [
        1e-05,
        1e22,
        5e-324,
        1.7976931348623157e308,
        -0.0,
        0,
        -1,
        7**8000,
        -(2**60),
        Fraction(1, 3),
    ]
    assert same(decode(prolog.call("echo", sent)), sent)


def test_what_python_has_no_literal_for(prolog: PrologEngine) -> None:
    (row,) = prolog.ask("X is inf, Y is -inf, Z is nan").bindings
    assert (row["X"], row["Y"]) == (math.inf, -math.inf)
    assert isinstance(row["Z"], float)
    assert math.isnan(row["Z"])


def test_variables_are_shared_by_name(prolog: PrologEngine) -> None:
    sent: list[Term] = [Variable("X"), Variable("it's"), Variable("X")]
    first, second, third = prolog.call("echo", sent)[1:]
    assert first == third != second


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf, True, None, "1"])
def test_only_finite_numbers_are_numbers(value: float) -> None:
    with pytest.raises(QueryError, match="number"):
        number(value)


def test_half_a_surrogate_pair_is_refused() -> None:
    for quote in (atom, string):
        with pytest.raises(QueryError, match="surrogate"):
            quote("cup\ud800")


def test_what_stands_for_no_term_is_refused() -> None:
    with pytest.raises(QueryError, match="stands for no Prolog term"):
        term([b"bytes"])  # type: ignore[list-item]


# ------------------------------------------------------------------------------------------------- facts


def some_facts(ids: tuple[str, ...] = ("cup", "it's a table"), view: str = "v 100%s") -> Facts:
    """Return two things, each measured against the other, seen from one view."""
    row = np.array([0])
    across = np.array([[0.5, -0.5, 0.25, -1.0]])
    world = ViewFacts("world", row, across, np.array([[-0.1, 0.0, 0.125, 0.0]]))
    seen = ViewFacts(view, row, np.full((1, 4), -2.0), np.full((1, 4), -3.0), ((1, "inside it's box"),))
    pairs = PairColumns(
        figure=np.array([0, 1]),
        reference=np.array([1, 0]),
        separation=np.array([-0.005, 0.123456789]),
        normal=np.array([[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]], dtype=np.float32),
        intersection=np.array([1e-9, 0.0]),
        protrusion=np.array([0.1, 0.7]),
        frontier=np.array([0.0, 1.0 / 3.0]),
        vertical=np.array([[0.4, -0.3], [-0.3, 0.0]]),
        vertical_strict=np.array([[0.2, -0.4], [-0.4, -0.001]]),
        ordered=np.array([True, False]),
    )
    return Facts(
        scene="s",
        ids=ids,
        labels=((("cup", 0.75), ("mug", 0.25)), (("table", 1.0),)),
        surface=np.array([False, True]),
        volume=np.array([0.001, 0.5]),
        thresholds=Thresholds(),
        pairs=pairs,
        views=(world, seen),
        region="mesh",
        models=("mesh", "box"),
    )


@pytest.fixture(scope="module")
def base(root: Path) -> Iterator[PrologEngine]:
    with PrologEngine([root / "rules" / "facts.pl"]) as engine:
        yield engine


@pytest.mark.parametrize("readable", [False, True])
def test_facts_as_rules_see_them(base: PrologEngine, readable: bool) -> None:
    text = facts_text(some_facts(), [("v 100%s", 'the "robot"')], readable=readable)
    if readable:
        assert text.endswith(".\n")
        clauses = [line.removesuffix(".") for line in text.splitlines()]
        predicates = [clause.partition("(")[0] for clause in clauses]
        assert predicates == sorted(predicates), "those of a predicate stand together"
        text = f"[{','.join(clauses)}]"
    base.load(text)
    contract = {
        "spatial_obj": 1, "surface": 1, "label": 3, "measured_as": 2, "viewpoint": 1, "view_label": 2,
        "threshold": 2, "figure_reference": 2, "pair": 9, "aspect": 7, "strict": 5, "withheld": 3,
    }  # fmt: skip
    cup, table, view = "cup", "it's a table", "v 100%s"
    assert base.relations(list(contract.items())) == {
        "spatial_obj": [(cup,), (table,)],
        "surface": [(table,)],
        "label": [(cup, "cup", 0.75), (cup, "mug", 0.25), (table, "table", 1.0)],
        "measured_as": [(cup, "mesh"), (table, "box")],
        "viewpoint": [(view,)],
        "view_label": [(view, 'the "robot"')],
        "threshold": sorted(Thresholds().items()),
        "figure_reference": [(cup, table)],
        "pair": [
            (cup, table, 0.0, -0.005, 0.1, 1e-9, 0.0, 0.4, -0.3),
            (table, cup, 0.123456789, 0.123456789, 0.7, 0.0, 1.0 / 3.0, -0.3, 0.0),
        ],
        "aspect": [(view, cup, table, -2.0, -2.0, -2.0, -2.0), ("world", cup, table, 0.5, -0.5, 0.25, -1.0)],
        "strict": [
            (cup, table, "X+", "world", -0.1),
            (cup, table, "Y+", "world", 0.125),
            (cup, table, "Z+", "world", 0.2),
            (table, cup, "Z-", "world", -0.001),
        ],
        "withheld": [(table, view, "inside it's box")],
    }


@given(st.lists(st.floats(-1e7, 1e7), min_size=12, max_size=12), st.booleans())
def test_measured_numbers_come_back(base: PrologEngine, values: list[float], rounded: bool) -> None:
    columns = np.array(values).reshape(6, 2)
    if rounded:
        columns = np.round(columns, 9)
    names = ("separation", "protrusion", "intersection", "frontier")
    facts = some_facts()
    pairs = replace(facts.pairs, **dict(zip(names, columns, strict=False)), vertical=columns[4:].T.copy())
    base.load(facts_text(replace(facts, pairs=pairs)))
    rows = base.relations([("pair", 9)])["pair"]
    expected = zip(np.maximum(columns[0], 0.0).tolist(), *columns.tolist(), strict=True)
    assert [row[2:] for row in rows] == list(expected)


@given(st.lists(hostile_text, min_size=2, max_size=2, unique=True), hostile_text)
def test_hostile_ids_are_only_ids(base: PrologEngine, ids: list[str], view: str) -> None:
    count = base.load(facts_text(some_facts((ids[0], ids[1]), view), [(view, ids[0])]))
    found = base.relations([("figure_reference", 2), ("view_label", 2), ("spatial_obj", 1)])
    assert found["figure_reference"] == [tuple(ids)]
    assert found["view_label"] == [(view, ids[0])]
    assert {row[0] for row in found["spatial_obj"]} == set(ids)
    assert count == 2 + 1 + 3 + 2 + 2 + (view != "world") + 1 + len(Thresholds().items()) + 1 + 2 + 2 + 4 + 1


@pytest.mark.parametrize("value", [math.nan, math.inf])
@pytest.mark.parametrize("column", ["separation", "vertical", "vertical_strict"])
def test_numbers_that_would_match_anything_are_refused(column: str, value: float) -> None:
    facts = some_facts()
    wrong = getattr(facts, column).copy()
    wrong[1] = value
    with pytest.raises(GeometryError, match=r"\"it's a table\" against 'cup'"):
        facts_text(replace(facts, pairs=replace(facts.pairs, **{column: wrong})))


def test_a_scene_without_pairs(base: PrologEngine) -> None:
    some = some_facts()
    world = ViewFacts("world", np.zeros(0, dtype=np.int64), np.zeros((0, 4)), np.zeros((0, 4)))
    nothing = some.pairs.at(np.zeros(0, dtype=np.int64))
    nobody = some.volume[:0]
    facts = replace(
        some,
        ids=(),
        labels=(),
        models=(),
        surface=some.surface[:0],
        volume=nobody,
        pairs=nothing,
        views=(world,),
    )
    assert base.load(facts_text(facts)) == len(Thresholds().items())
