"""Which words a person would accept of which things, by ``rules/prepositions.pl``."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from functools import cache
from typing import TYPE_CHECKING, Final
from weakref import WeakKeyDictionary

from deixis._files import datalog_files, rules_dir
from deixis.engines import AutoExecutor

if TYPE_CHECKING:
    from deixis.facts import Facts
    from deixis.inference import Inference
    from deixis.ruleset import Indicator, Ruleset

FITS: Final[tuple[Indicator, Indicator]] = (("fits", 3), ("fits", 4))

Pair = tuple[str, str]

_KNOWN: Final[WeakKeyDictionary[Inference, tuple[Facts, Accepted]]] = WeakKeyDictionary()
"""What was found of a knowledge base already: one question after the other asks for the same."""


@dataclass
class Accepted:
    """The words that fit: by word and view, with None for the view of a word that depends on none.

    Examples
    --------
    >>> from deixis._files import kb_dir
    >>> from deixis.knowledge import KnowledgeBase
    >>> with KnowledgeBase.from_scene(kb_dir() / "scenes" / "hans.json") as kb:
    ...     accepted(kb).fits("on", "sweater", "heater")
    True
    """

    pairs: dict[tuple[str, str | None], set[Pair]] = field(default_factory=lambda: defaultdict(set))

    def fits(self, word: str, figure: str, ground: str, view: str | None = None) -> bool:
        """Return whether a word fits a figure and a ground, seen from a view where that matters."""
        return (figure, ground) in self.pairs.get((word, view), ())

    def of(self, word: str, view: str | None = None) -> Iterator[Pair]:
        """Yield the figures and grounds that a word fits, sorted."""
        yield from sorted(self.pairs.get((word, view), ()))


def accepted(kb: Inference, timeout: float = 60.0) -> Accepted:
    """Return which words fit in a scene, whatever rules of one's own it was opened with.

    Raises
    ------
    QueryTimeout
        It took longer than ``timeout`` seconds.
    """
    facts = kb.facts
    known = _KNOWN.get(kb)
    if known is None or known[0] is not facts:
        with AutoExecutor(_rules()) as executor:
            tables = executor.run(facts, FITS, margins=False, timeout=timeout)
        known = facts, _gathered(row for table in tables.values() for row in table.rows())
        _KNOWN[kb] = known
    return known[1]


def _gathered(rows: Iterable[tuple[str | float, ...]]) -> Accepted:
    found = Accepted()
    for word, figure, ground, *view in rows:
        found.pairs[str(word), str(view[0]) if view else None].add((str(figure), str(ground)))
    return found


@cache
def _rules() -> Ruleset:
    from deixis.ruleset import load

    return load(datalog_files(), [rules_dir() / "prepositions.pl"])
