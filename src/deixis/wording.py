"""The small words that join sentences, in the language that is spoken."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final


@dataclass(frozen=True, slots=True)
class Words:
    """What stands between the sentences that the rules' templates make.

    Attributes
    ----------
    because, and_ : str
        As in "it is on the table, because it is above it and touches it".
    no, nor : str
        As in "No: ...", and in "Nor by commonsense.pl:40: ...".
    closest : str
        Before what comes closest to refuting a denial.
    margin, axiom : str
        Before their numbers.
    fails : str
        Of a step that does not hold.
    """

    because: str
    and_: str
    no: str
    nor: str
    closest: str
    margin: str
    axiom: str
    fails: str

    def listed(self, texts: list[str]) -> str:
        """Return texts one after the other.

        Examples
        --------
        >>> ENGLISH.listed(["the cup", "the mug", "the jar"])
        'the cup, the mug and the jar'
        """
        return f"{', '.join(texts[:-1])} {self.and_} {texts[-1]}" if len(texts) > 1 else "".join(texts)


ENGLISH: Final = Words("because", "and", "No", "Nor by", "what comes closest", "margin", "axiom", "fails")


def as_sentence(text: str) -> str:
    """Return a statement as a sentence: a capital first, a full stop last.

    Examples
    --------
    >>> as_sentence("the cup is on the table")
    'The cup is on the table.'
    """
    return f"{text[:1].upper()}{text[1:]}."
