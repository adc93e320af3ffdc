"""Explanations: why, why not, and why rather; proof trees are in :mod:`deixis.proof`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from deixis.facts import SolidModel
from deixis.proof import Length, Proof, Proofs, Rule
from deixis.render import Shown
from deixis.render.html import Part
from deixis.wording import ENGLISH, Words, as_sentence

__all__ = ["Answer", "Contrast", "Miss", "Proof", "Proofs", "Refusal", "Rule", "as_sentence"]


@dataclass(frozen=True, slots=True)
class Answer(Shown):
    """The answer to a question for reasons.

    Attributes
    ----------
    proof : Proof or None
        Why it holds; None where it does not.
    nearest : Proof or None
        Where it does not hold, the derivation that comes closest; None where nothing within reach does.
    text : str
        The answer in one sentence.
    measured_as : mapping of str to str
        What each thing that the answer speaks of was measured as: its box, hull, mesh or outline.
    """

    proof: Proof | None
    nearest: Proof | None
    text: str
    measured_as: Mapping[str, SolidModel] = field(default_factory=dict)
    words: Words = field(default=ENGLISH, repr=False, compare=False)

    @classmethod
    def from_dict(cls, reply: Mapping[str, Any], words: Words = ENGLISH) -> Answer:
        """Return the answer that the rules' meta-interpreter gave as a dict.

        Its ``measured_as`` may tell of more things than the answer speaks of.
        """
        proof, nearest = (
            None if reply[name] is None else Proof.from_dict(reply[name], words)
            for name in ("proof", "nearest")
        )
        named = {name for one in (proof, nearest) if one is not None for name in one.things()}
        measured = {name: model for name, model in reply["measured_as"].items() if name in named}
        return cls(proof, nearest, reply["text"], measured, words)

    def __bool__(self) -> bool:
        return self.proof is not None

    def parts(self) -> list[Part]:
        """Return the answer in a sentence, with the proof or what comes closest below it."""
        if self.proof is not None:
            return self.proof.parts()
        return [(f"{self.words.no}: {self.text}.", [] if self.nearest is None else [self.nearest])]

    def told(self, length: Length = "normal") -> str:
        """Return the proof at one of three lengths; of what does not hold, by how much it does not."""
        if self.proof is not None:
            return self.proof.told(length)
        told = f"{self.words.no}: {self.text}."
        if length == "full" and self.nearest is not None:
            told += f"\n{as_sentence(self.words.closest)[:-1]}:\n{self.nearest.full()}"
        return told

    def to_dict(self) -> dict[str, Any]:
        """Return the answer as nested dicts, ready for JSON."""
        return {
            "holds": self.proof is not None,
            "text": self.text,
            "proof": None if self.proof is None else self.proof.to_dict(),
            "nearest": None if self.nearest is None else self.nearest.to_dict(),
            "measured_as": dict(self.measured_as),
        }


@dataclass(frozen=True, slots=True)
class Miss:
    """A rule that could have concluded something, and what keeps it from that.

    Attributes
    ----------
    derivation : Proof
        The derivation by this rule that comes closest; what fails has a negative margin.
    obstacles : tuple of str
        What fails, each in a sentence.
    """

    derivation: Proof
    obstacles: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Refusal(Shown):
    """Why something does not hold.

    Attributes
    ----------
    holds : bool
        True where it does hold after all; then there is nothing to refuse.
    text : str
        What holds or does not, in one sentence.
    misses : tuple of Miss
        One for each rule whose facts are there, nearest first.
    hindrance : str or None
        What keeps it from being stated whatever was measured: the order of the two, or a view.
    because : tuple of str
        What keeps it from holding, as clauses that go on after ``text``: the hindrance, or what fails by the
        rule that comes closest.
    """

    holds: bool
    text: str
    misses: tuple[Miss, ...]
    hindrance: str | None
    because: tuple[str, ...] = ()
    words: Words = field(default=ENGLISH, repr=False, compare=False)

    @classmethod
    def from_dict(cls, reply: Mapping[str, Any], words: Words = ENGLISH) -> Refusal:
        """Return the refusal that the rules' meta-interpreter gave as a dict."""
        misses = tuple(
            Miss(Proof.from_dict(one["derivation"], words), tuple(one["obstacles"]))
            for one in reply["misses"]
        )
        return cls(reply["holds"], reply["text"], misses, reply["hindrance"], tuple(reply["because"]), words)

    def to_dict(self) -> dict[str, Any]:
        """Return the refusal as nested dicts, ready for JSON."""
        return {
            "holds": self.holds,
            "text": self.text,
            "hindrance": self.hindrance,
            "because": list(self.because),
            "misses": [
                {"derivation": one.derivation.to_dict(), "obstacles": list(one.obstacles)}
                for one in self.misses
            ],
        }

    def parts(self) -> list[Part]:
        """Return that it does not hold, and why, with what comes closest by each rule below it."""
        misses: list[Part] = [
            (f"By {miss.derivation.rule_place()}: {' and '.join(miss.obstacles)}.", [miss.derivation])
            for miss in self.misses
        ]
        return [(self.sentence(), []), *misses]

    def reason(self) -> str:
        """Return what keeps it from holding, after its text; empty where that is not known."""
        return self.words.listed(list(self.because))

    def sentence(self) -> str:
        """Return that it does not hold, and why, in one sentence.

        Examples
        --------
        >>> Refusal(False, "the cup is not on the table", (), None, ("it is apart from it",)).sentence()
        'The cup is not on the table, because it is apart from it.'
        """
        reason = self.reason()
        told = f"{self.text}, {self.words.because} {reason}" if reason and not self.holds else self.text
        return as_sentence(told)

    def others(self) -> list[str]:
        """Return for each rule but the one that comes closest what keeps it from concluding."""
        return [
            f"{self.words.nor} {miss.derivation.rule_place()}: {self.words.listed(list(miss.obstacles))}."
            for miss in self.misses[1:]
        ]


@dataclass(frozen=True, slots=True)
class Contrast:
    """Why one thing holds rather than another.

    Attributes
    ----------
    fact : Answer
    other : Refusal
    text : str
        Both in one statement.
    """

    fact: Answer
    other: Refusal
    text: str

    def __bool__(self) -> bool:
        return bool(self.fact) and not self.other.holds

    def sentence(self) -> str:
        """Return it in one sentence."""
        return as_sentence(self.text)

    def to_dict(self) -> dict[str, Any]:
        """Return the contrast as nested dicts, ready for JSON."""
        return {"text": self.text, "fact": self.fact.to_dict(), "other": self.other.to_dict()}
