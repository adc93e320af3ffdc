"""Rows that meet wanted values: the same as by looking at every pair."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from deixis.arrays.rows import Rows, TooMany

NAMES = st.integers(-3, 6)
NUMBERS = st.sampled_from([-1.5, -0.0, 0.0, 0.25, 3.0])
MANY = 1000


def columns(told: list[tuple[float, ...]], kinds: tuple[type, ...]) -> list[np.ndarray]:
    return [np.array([row[at] for row in told], dtype=kind) for at, kind in enumerate(kinds)]


@given(st.data(), st.lists(st.sampled_from([np.int64, np.float64]), min_size=1, max_size=3))
def test_rows_meet_what_is_equal_in_all_columns(data: st.DataObject, kinds: list[type]) -> None:
    cells = [NAMES if kind is np.int64 else NUMBERS for kind in kinds]
    rows = data.draw(st.lists(st.tuples(*cells), max_size=12))
    wanted = data.draw(st.lists(st.tuples(*cells), max_size=12))
    places = data.draw(st.permutations(range(len(kinds))))
    held = Rows(columns(rows, tuple(kinds)))
    asked = columns(wanted, tuple(kinds))
    found = held.matches(places, [asked[place] for place in places], MANY)
    pairs = sorted(zip(found[0].tolist(), found[1].tolist(), strict=True))
    assert pairs == [(a, b) for a, one in enumerate(wanted) for b, row in enumerate(rows) if one == row]


def test_values_beyond_all_rows_meet_none() -> None:
    """Packed into one number with others they must not look like a row."""
    held = Rows(columns([(1, 0), (2, 0)], (np.int64, np.int64)))
    grid = [(a, b) for a in range(-2, 6) for b in range(-6, 7)]
    found = held.matches([0, 1], columns(grid, (np.int64, np.int64)), MANY)
    assert [grid[at] for at in found[0]] == [(1, 0), (2, 0)]


def test_more_meetings_than_fit_are_refused() -> None:
    same = Rows([np.zeros(50, dtype=np.int64)])
    with pytest.raises(TooMany):
        same.matches([0], [np.zeros(50, dtype=np.int64)], 2499)
    assert len(same.matches([0], [np.zeros(50, dtype=np.int64)], 2500)[0]) == 2500
