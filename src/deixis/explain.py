"""Explanations: proof trees with margins, and how they are shown to people and programs."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

from deixis.evidence import Evidence
from deixis.facts import SolidModel
from deixis.render import Shown
from deixis.render.html import Part
from deixis.thresholds import SNAP_DECIMALS

Kind = Literal["rule", "fact", "comparison", "negation", "conjunction"]


@dataclass(frozen=True, slots=True)
class Rule:
    """Where the rule of a proof step stands.

    Attributes
    ----------
    file : str
        Name of the rule file.
    line : int
        First line of the clause.
    """

    file: str
    line: int


@dataclass(frozen=True, slots=True)
class Proof(Shown):
    """One step of a proof and the reasons it rests on.

    Attributes
    ----------
    kind : {"rule", "fact", "comparison", "negation", "conjunction"}
        A conclusion by a rule, a measured or given fact, a comparison of numbers, the absence of a proof,
        or several things at once.
    predicate : str
        Name of the predicate, or the comparison's operator.
    args : tuple
        Its arguments: ids and numbers; None where a variable stands.
    text : str
        The step in one sentence.
    margin : float or None
        Metres by which a length would have to change for the step to change its answer.
    axiom : int or None
        Number in the paper.
    rule : Rule or None
    shown : bool
        Whether a person needs this step; the outline leaves out the others.
    children : tuple of Proof
        The reasons; of a negation, what came closest to refuting it.
    evidence : Evidence or None
        What a leaf rests on, once :meth:`deixis.knowledge.KnowledgeBase.evidence` has gathered it.
    """

    kind: Kind
    predicate: str
    args: tuple[str | float | None, ...]
    text: str
    margin: float | None
    axiom: int | None
    rule: Rule | None
    shown: bool
    children: tuple[Proof, ...]
    evidence: Evidence | None = None

    @classmethod
    def from_dict(cls, node: Mapping[str, Any]) -> Proof:
        """Return the proof that the rules' meta-interpreter, or :meth:`to_dict`, gave as a dict."""
        rule, evidence = node["rule"], node.get("evidence")
        return cls(
            kind=node["kind"],
            predicate=node["predicate"],
            args=tuple(node["args"]),
            text=node["text"],
            margin=None if node["margin"] is None else round(node["margin"], SNAP_DECIMALS),
            axiom=node["axiom"],
            rule=Rule(rule["file"], rule["line"]) if rule else None,
            shown=node["shown"],
            children=tuple(cls.from_dict(child) for child in node["children"]),
            evidence=None if evidence is None else Evidence.from_dict(evidence),
        )

    def to_dict(self) -> dict[str, Any]:
        """Return the proof as nested dicts, ready for JSON."""
        return {
            "kind": self.kind,
            "predicate": self.predicate,
            "args": list(self.args),
            "text": self.text,
            "margin": self.margin,
            "axiom": self.axiom,
            "rule": None if self.rule is None else {"file": self.rule.file, "line": self.rule.line},
            "shown": self.shown,
            "evidence": None if self.evidence is None else self.evidence.to_dict(),
            "children": [child.to_dict() for child in self.children],
        }

    def parts(self) -> list[Part]:
        """Return the conclusion in a sentence, with the proof below it."""
        return [(self.sentence(), [self])]

    def rule_place(self) -> str:
        """Return file and line of the rule, or the predicate where there is no rule."""
        return self.predicate if self.rule is None else f"{self.rule.file}:{self.rule.line}"

    def outline(self) -> str:
        """Return the proof as indented lines, one sentence each, for people."""
        return "\n".join(self._lines(0))

    def sentence(self) -> str:
        """Return the conclusion and its first reasons in one sentence.

        Examples
        --------
        >>> leaf = Proof("fact", "gap", (), "the gap is 1 cm", 0.01, None, None, True, ())
        >>> Proof("rule", "touches", (), "they touch", 0.01, 16, None, True, (leaf,)).sentence()
        'They touch, because the gap is 1 cm.'
        """
        reasons = [child.text for child in self._shown_children() if child.predicate != "figure_reference"]
        if not reasons:
            return as_sentence(self.text)
        listed = ", ".join(reasons[:-1]) + " and " + reasons[-1] if len(reasons) > 1 else reasons[0]
        return as_sentence(f"{self.text}, because {listed}")

    def things(self) -> Iterator[str]:
        """Yield all names that the proof speaks of, ids and others, as often as they occur."""
        yield from (argument for argument in self.args if isinstance(argument, str))
        for child in self.children:
            yield from child.things()

    def _shown_children(self) -> Iterator[Proof]:
        """Yield the nearest shown reasons below this step."""
        if self.kind == "negation":
            return
        for child in self.children:
            if child.shown:
                yield child
            else:
                yield from child._shown_children()

    def _lines(self, depth: int) -> Iterator[str]:
        axiom = f"  [axiom {self.axiom}]" if self.kind == "rule" and self.axiom is not None else ""
        yield "  " * depth + self.text + axiom
        for child in self._shown_children():
            yield from child._lines(depth + 1)


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

    @classmethod
    def from_dict(cls, reply: Mapping[str, Any]) -> Answer:
        """Return the answer that the rules' meta-interpreter gave as a dict.

        Its ``measured_as`` may tell of more things than the answer speaks of.
        """
        proof, nearest = (
            None if reply[name] is None else Proof.from_dict(reply[name]) for name in ("proof", "nearest")
        )
        named = {name for one in (proof, nearest) if one is not None for name in one.things()}
        measured = {name: model for name, model in reply["measured_as"].items() if name in named}
        return cls(proof, nearest, reply["text"], measured)

    def __bool__(self) -> bool:
        return self.proof is not None

    def parts(self) -> list[Part]:
        """Return the answer in a sentence, with the proof or what comes closest below it."""
        if self.proof is not None:
            return self.proof.parts()
        return [(f"No: {self.text}.", [] if self.nearest is None else [self.nearest])]

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
    """

    holds: bool
    text: str
    misses: tuple[Miss, ...]
    hindrance: str | None

    @classmethod
    def from_dict(cls, reply: Mapping[str, Any]) -> Refusal:
        """Return the refusal that the rules' meta-interpreter gave as a dict."""
        misses = tuple(
            Miss(Proof.from_dict(one["derivation"]), tuple(one["obstacles"])) for one in reply["misses"]
        )
        return cls(reply["holds"], reply["text"], misses, reply["hindrance"])

    def to_dict(self) -> dict[str, Any]:
        """Return the refusal as nested dicts, ready for JSON."""
        return {
            "holds": self.holds,
            "text": self.text,
            "hindrance": self.hindrance,
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
        """Return what keeps it from holding, for the rule that comes closest; empty where that is not known.

        Examples
        --------
        >>> Refusal(False, "the cup is not on top of the table", (), "they are apart").sentence()
        'The cup is not on top of the table, because they are apart.'
        """
        if self.hindrance is not None:
            return self.hindrance
        return " and ".join(self.misses[0].obstacles) if self.misses else ""

    def sentence(self) -> str:
        """Return that it does not hold, and why, in one sentence."""
        reason = self.reason()
        return as_sentence(f"{self.text}, because {reason}" if reason and not self.holds else self.text)


def contrast(fact: Answer, other: Refusal) -> str:
    """Return in one sentence why a fact holds rather than another."""
    if fact.proof is None:
        return as_sentence(f"{fact.text}: there is nothing to contrast")
    if other.holds:
        return as_sentence(f"both hold: {fact.text}, and {other.text}")
    reason = other.reason()
    head = f"{fact.text}, but {other.text}"
    return as_sentence(f"{head}, because {reason}" if reason else head)


def as_sentence(text: str) -> str:
    """Return a statement as a sentence: a capital first, a full stop last.

    Examples
    --------
    >>> as_sentence("the cup is on the table")
    'The cup is on the table.'
    """
    return f"{text[:1].upper()}{text[1:]}."
