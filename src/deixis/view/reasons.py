"""Reasons as tables: proofs share most of their steps and words, so each is written once."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, Final

from deixis.explain import Proof, Rule
from deixis.frames import AXES

KINDS: Final = ("rule", "fact", "comparison", "negation", "conjunction")
"""Kinds of steps, in the order of their numbers."""


class Reasons:
    """Proofs taken apart into a table of words, one of rules, and one of steps.

    A step is a row: kind, predicate, arguments, text, margin, axiom, rule, whether it is shown, and the rows
    of its reasons. Words and arguments that are words are positions in the table of words; numbers among the
    arguments stand in a list of their own, [number].

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
        self._steps: dict[str, int] = {}
        self._rows: list[list[Any]] = []
        self._pairs: dict[tuple[str, str], None] = {}
        self._spaces: dict[tuple[str, str, str, str], None] = {}

    def add(self, proof: Proof) -> int:
        """Take in a proof; return the row of its conclusion."""
        below = [self.add(child) for child in proof.children]
        names = [one for one in proof.args if isinstance(one, str)]
        if len(names) > 1:
            self._pairs[names[0], names[1]] = None
        if len(names) > 3 and names[2] in AXES:
            self._spaces[names[0], names[1], names[2], names[3]] = None
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
        key = repr(row)
        if key not in self._steps:
            self._steps[key] = len(self._rows)
            self._rows.append(row)
        return self._steps[key]

    def pairs(self) -> Iterable[tuple[str, str]]:
        """Return the first two names of each step, in order of appearance."""
        return self._pairs

    def spaces(self) -> Iterable[tuple[str, str, str, str]]:
        """Return what halfspaces are spoken of: figure, reference, axis and view."""
        return self._spaces

    def to_dict(self) -> dict[str, Any]:
        """Return the tables, ready for JSON."""
        return {
            "words": list(self._words),
            "rules": [[rule.file, rule.line] for rule in self._rules],
            "steps": self._rows,
        }

    def _word(self, text: str) -> int:
        return self._words.setdefault(text, len(self._words))

    def _argument(self, one: str | float | None) -> int | list[float] | None:
        if one is None:
            return None
        return self._word(one) if isinstance(one, str) else [one]
