"""What would be otherwise if things stood elsewhere: relations gained and lost, each with its reason."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

from deixis.explain import Answer
from deixis.relations import Relation
from deixis.wording import as_sentence


@dataclass(frozen=True, slots=True)
class Consequence:
    """A relation that would begin or cease to hold.

    Attributes
    ----------
    relation : Relation
    because : str
        Why it would hold, or not, in a sentence.
    """

    relation: Relation
    because: str

    def to_dict(self) -> dict[str, Any]:
        """Return it as a dict, ready for JSON."""
        return {**self.relation.to_dict(), "because": self.because}


@dataclass(frozen=True, slots=True)
class Consequences:
    """What would be otherwise.

    Attributes
    ----------
    gained, lost : tuple of Consequence
        In the order of the vocabulary, then by ids.
    truncated : bool
        Whether there are more than were asked for.
    """

    gained: tuple[Consequence, ...]
    lost: tuple[Consequence, ...]
    truncated: bool = False

    def __bool__(self) -> bool:
        return bool(self.gained or self.lost)

    def to_dict(self) -> dict[str, Any]:
        """Return them as dicts, ready for JSON."""
        return {
            "gained": [one.to_dict() for one in self.gained],
            "lost": [one.to_dict() for one in self.lost],
            "truncated": self.truncated,
        }


def compared(
    before: Iterable[Relation],
    after: Iterable[Relation],
    why: Callable[[str], Answer],
    limit: int | None = None,
) -> Consequences:
    """Return what holds after and not before, and the other way round.

    Parameters
    ----------
    before, after : iterable of Relation
    why : callable
        What gives the reason for a goal in the world of after.
    limit : int or None
        At most this many, those that are gained first.
    """
    old = {(one.relation, one.figure, one.reference, one.view): one for one in before}
    new = {(one.relation, one.figure, one.reference, one.view): one for one in after}
    gained = [one for key, one in new.items() if key not in old]
    lost = [one for key, one in old.items() if key not in new]
    most = len(gained) + len(lost) if limit is None else limit
    told = [Consequence(one, because(why(one.to_prolog()))) for one in (gained + lost)[:most]]
    cut = len(gained) + len(lost) > most
    return Consequences(tuple(told[: len(gained)]), tuple(told[len(gained) :]), cut)


def because(answer: Answer) -> str:
    """Return the reason of what holds, or by how much it does not, in a sentence."""
    return as_sentence(answer.text) if answer.proof is None else answer.proof.sentence()
