"""Explanations: proof trees with margins, and how they are shown to people and programs."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

from deixis.facts import SolidModel
from deixis.thresholds import SNAP_DECIMALS
from deixis.wording import ENGLISH, Words, as_sentence

Kind = Literal["rule", "fact", "comparison", "negation", "conjunction"]

Length = Literal["brief", "normal", "full"]
"""How much of a proof is told: what decides it; an outline; every step with its evidence."""


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
class Proof:
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
    words : Words
        What joins its sentences, in their language.
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
    words: Words = field(default=ENGLISH, repr=False, compare=False)

    @classmethod
    def from_dict(cls, node: Mapping[str, Any], words: Words = ENGLISH) -> Proof:
        """Return the proof that the rules' meta-interpreter gave as a dict."""
        rule = node["rule"]
        return cls(
            kind=node["kind"],
            predicate=node["predicate"],
            args=tuple(node["args"]),
            text=node["text"],
            margin=None if node["margin"] is None else round(node["margin"], SNAP_DECIMALS),
            axiom=node["axiom"],
            rule=Rule(rule["file"], rule["line"]) if rule else None,
            shown=node["shown"],
            children=tuple(cls.from_dict(child, words) for child in node["children"]),
            words=words,
        )

    def to_dict(self) -> dict[str, Any]:
        """Return the proof as nested dicts, ready for JSON."""
        return {
            "kind": self.kind,
            "predicate": self.predicate,
            "args": self.args,
            "text": self.text,
            "margin": self.margin,
            "axiom": self.axiom,
            "rule": None if self.rule is None else {"file": self.rule.file, "line": self.rule.line},
            "shown": self.shown,
            "children": tuple(child.to_dict() for child in self.children),
        }

    def rule_place(self) -> str:
        """Return file and line of the rule, or the predicate where there is no rule."""
        return self.predicate if self.rule is None else f"{self.rule.file}:{self.rule.line}"

    def told(self, length: Length = "normal") -> str:
        """Return the proof for people, at one of three lengths."""
        return {"brief": self.brief, "normal": self.outline, "full": self.full}[length]()

    def outline(self) -> str:
        """Return the proof as indented lines, one sentence each, for people."""
        return "\n".join(self._lines(0))

    def full(self) -> str:
        """Return every step as indented lines, with its evidence: exact values, margin, axiom, file and line.

        Below a denial stands what came closest to refuting it.

        Examples
        --------
        >>> leaf = Proof("fact", "gap", ("cup", 0.01), "the gap is 1 cm", None, None, None, True, ())
        >>> rule = Rule("topology.pl", 44)
        >>> print(Proof("rule", "touches", ("cup",), "it touches", 0.01, 16, rule, True, (leaf,)).full())
        it touches  [axiom 16, topology.pl:44, margin 0.01 m]
          the gap is 1 cm  [gap(cup, 0.01)]
        """
        return "\n".join(self._full_lines(0))

    def brief(self) -> str:
        """Return the conclusion and the reason that decides it: the one that least would have to change.

        Examples
        --------
        >>> over = Proof("rule", "above", (), "it is above it", 0.4, 28, None, True, ())
        >>> near = Proof("rule", "touches", (), "it touches it", 0.01, 16, None, True, ())
        >>> Proof("rule", "on", (), "it is on it", 0.01, 36, None, True, (over, near)).brief()
        'It is on it, because it touches it.'
        """
        reasons = self._reasons()
        measured = [child for child in reasons if child.margin is not None]
        decisive = min(measured, key=lambda child: child.margin or 0.0, default=None)
        return self._because([decisive] if decisive is not None else reasons)

    def sentence(self) -> str:
        """Return the conclusion and its first reasons in one sentence.

        Examples
        --------
        >>> leaf = Proof("fact", "gap", (), "the gap is 1 cm", 0.01, None, None, True, ())
        >>> Proof("rule", "touches", (), "they touch", 0.01, 16, None, True, (leaf,)).sentence()
        'They touch, because the gap is 1 cm.'
        """
        return self._because(self._reasons())

    def _reasons(self) -> list[Proof]:
        return [child for child in self._shown_children() if child.predicate != "figure_reference"]

    def _because(self, reasons: list[Proof]) -> str:
        if not reasons:
            return as_sentence(self.text)
        listed = self.words.listed([child.text for child in reasons])
        return as_sentence(f"{self.text}, {self.words.because} {listed}")

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
        axiom = (
            f"  [{self.words.axiom} {self.axiom}]" if self.kind == "rule" and self.axiom is not None else ""
        )
        yield "  " * depth + self.text + axiom
        for child in self._shown_children():
            yield from child._lines(depth + 1)

    def _full_lines(self, depth: int) -> Iterator[str]:
        evidence = ", ".join(self._evidence())
        yield "  " * depth + self.text + (f"  [{evidence}]" if evidence else "")
        if self.kind == "negation" and self.children:
            depth += 1
            yield "  " * depth + self.words.closest + ":"
        for child in self.children:
            yield from child._full_lines(depth + 1)

    def _evidence(self) -> Iterator[str]:
        """Yield what a step rests on, exactly."""
        values = ["_" if one is None else f"{one:.9g}" if isinstance(one, float) else str(one)
                  for one in self.args]  # fmt: skip
        if self.kind == "comparison":
            yield f" {self.predicate} ".join(values)
        elif self.kind == "fact":
            yield f"{self.predicate}({', '.join(values)})"
        if self.kind == "rule" and self.axiom is not None:
            yield f"{self.words.axiom} {self.axiom}"
        if self.rule is not None:
            yield self.rule_place()
        if self.margin is not None:
            yield f"{self.words.margin} {self.margin:.9g} m"
            if self.margin < 0.0:
                yield self.words.fails


@dataclass(frozen=True, slots=True)
class Answer:
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
class Proofs:
    """All proofs of something, or the first of them.

    Attributes
    ----------
    proofs : tuple of Proof
        The best first: the shortest, and among those the one with the widest margin.
    truncated : bool
        Whether there are more.
    """

    proofs: tuple[Proof, ...]
    truncated: bool

    @classmethod
    def from_dict(cls, reply: Mapping[str, Any], words: Words = ENGLISH) -> Proofs:
        """Return the proofs that the rules' meta-interpreter gave as dicts."""
        return cls(tuple(Proof.from_dict(one, words) for one in reply["proofs"]), reply["truncated"])

    def __bool__(self) -> bool:
        return bool(self.proofs)

    def to_dict(self) -> dict[str, Any]:
        """Return the proofs as nested dicts, ready for JSON."""
        return {
            "holds": bool(self),
            "proofs": [one.to_dict() for one in self.proofs],
            "truncated": self.truncated,
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
class Refusal:
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
    words: Words = field(default=ENGLISH, repr=False, compare=False)

    @classmethod
    def from_dict(cls, reply: Mapping[str, Any], words: Words = ENGLISH) -> Refusal:
        """Return the refusal that the rules' meta-interpreter gave as a dict."""
        misses = tuple(
            Miss(Proof.from_dict(one["derivation"], words), tuple(one["obstacles"]))
            for one in reply["misses"]
        )
        return cls(reply["holds"], reply["text"], misses, reply["hindrance"], words)

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

    def reason(self) -> str:
        """Return what keeps it from holding, for the rule that comes closest; empty where that is not known.

        Examples
        --------
        >>> Refusal(False, "the cup is not on top of the table", (), "they are apart").sentence()
        'The cup is not on top of the table, because they are apart.'
        """
        if self.hindrance is not None:
            return self.hindrance
        return self.words.listed(list(self.misses[0].obstacles)) if self.misses else ""

    def sentence(self) -> str:
        """Return that it does not hold, and why, in one sentence."""
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
