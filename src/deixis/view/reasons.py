"""Reasons as tables: proofs share most of their steps and words, so each is written once."""

from __future__ import annotations

import json
from collections.abc import Iterable
from typing import Any, Final

from deixis.evidence import Evidence, Value, Witness
from deixis.proof import Proof, Rule

KINDS: Final = ("rule", "fact", "comparison", "negation", "conjunction")
"""Kinds of steps, in the order of their numbers."""

DECIMALS: Final = 4
"""Of what is drawn, metres: a tenth of a millimetre."""


class Reasons:
    """Proofs taken apart into tables of words, rules, sights and steps.

    A step is a row: kind, predicate, arguments, text, margin, axiom, rule, whether it is shown, the rows of
    its reasons, and of a leaf its evidence: values, thresholds, sight. Words, and arguments that are words,
    are positions in the table of words; numbers among the arguments stand in a list of their own, [number].
    A sight is what lights up for a leaf: things, two points, and a plane by point, normal and bound.

    Examples
    --------
    >>> leaf = Proof("fact", "gap", ("cup", 0.01), "the gap is 1 cm", 0.01, None, None, True, ())
    >>> table = Reasons()
    >>> table.add(leaf), table.add(leaf)
    (0, 0)
    >>> table.to_dict()["steps"]
    [[1, 0, [1, [0.01]], 2, 0.01, None, None, 1, []]]
    """

    def __init__(self) -> None:
        self._words: dict[str, int] = {}
        self._rules: dict[Rule, int] = {}
        self._sights: dict[str, int] = {}
        self._steps: dict[str, int] = {}
        self._rows: list[list[Any]] = []

    def add(self, proof: Proof) -> int:
        """Take in a proof; return the row of its conclusion."""
        below = [self.add(child) for child in proof.children]
        row: list[Any] = [
            KINDS.index(proof.kind),
            self._word(proof.predicate),
            [self._argument(one) for one in proof.args],
            self._word(proof.text),
            proof.margin,
            proof.axiom,
            None if proof.rule is None else self._rules.setdefault(proof.rule, len(self._rules)),
            int(proof.shown),
            below,
        ]
        if proof.evidence is not None:
            row += self._evidence(proof.evidence)
        key = json.dumps(row)
        if key not in self._steps:
            self._steps[key] = len(self._rows)
            self._rows.append(row)
        return self._steps[key]

    def to_dict(self) -> dict[str, Any]:
        """Return the tables, ready for JSON."""
        return {
            "words": list(self._words),
            "rules": [[rule.file, rule.line] for rule in self._rules],
            "sights": [json.loads(one) for one in self._sights],
            "steps": self._rows,
        }

    def _word(self, text: str) -> int:
        return self._words.setdefault(text, len(self._words))

    def _argument(self, one: str | float | None) -> int | list[float] | None:
        if one is None:
            return None
        return self._word(one) if isinstance(one, str) else [one]

    def _evidence(self, found: Evidence) -> list[Any]:
        """Return values, thresholds and sight."""
        return [self._values(found.values), self._values(found.thresholds), self._sight(found.witness)]

    def _values(self, values: Iterable[Value]) -> list[list[Any]]:
        return [[self._word(one.name), one.value, one.unit] for one in values]

    def _sight(self, witness: Witness | None) -> int | None:
        if witness is None or (witness.points is None and witness.plane is None):
            return None
        points = None if witness.points is None else [short(point) for point in witness.points]
        plane = witness.plane
        drawn = None if plane is None else [short(plane.point), short(plane.normal), plane.bound]
        sight = json.dumps([list(witness.things), points, drawn])
        return self._sights.setdefault(sight, len(self._sights))


def short(values: Iterable[float]) -> list[float]:
    """Return metres as they are drawn.

    >>> short([0.12345, -0.00001])
    [0.1235, 0.0]
    """
    return [round(float(value), DECIMALS) + 0.0 for value in values]
