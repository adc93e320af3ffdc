"""Facts that stand in a column of another table too, so that they need not be looked up."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Final

from deixis.ruleset.model import Atom, Goal, Indicator

FLAGS: Final[Mapping[Indicator, tuple[tuple[Indicator, tuple[int, ...], str], ...]]] = {
    ("figure_reference", 2): (
        (("pair", 9), (0, 1), "ordered"),
        (("aspect", 7), (1, 2), "ordered"),
    ),
    ("viewpoint", 1): ((("aspect", 7), (0,), "viewed"),),
}
"""Facts that stand in a column of another table too: the table, its places of their arguments, the column."""


def flag(goal: Atom, goals: Sequence[Goal]) -> tuple[Indicator, tuple[int, ...], str] | None:
    """Return where a fact is a column of a table that is read anyway, with the same arguments."""
    for predicate, places, column in FLAGS.get(goal.predicate, ()):
        if any(isinstance(one, Atom) and stands_beside(goal, one, predicate, places) for one in goals):
            return predicate, places, column
    return None


def stands_beside(goal: Atom, one: Atom, predicate: Indicator, places: Sequence[int]) -> bool:
    """Return whether an atom has the same arguments, at some places, as a goal."""
    return one.predicate == predicate and tuple(one.args[place] for place in places) == goal.args
