"""Proof trees: each step with its sentence, margin and reasons, told to people at three lengths."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

from deixis.evidence import Evidence
from deixis.render import Shown
from deixis.render.html import Part
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
    words : Words
        What joins its sentences, in their language.
    clause : str or None
        Of a first reason what it says after the conclusion, in one sentence with it: a pronoun stands for
        what both are about. None where that is the text.
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
    words: Words = field(default=ENGLISH, repr=False, compare=False)
    clause: str | None = field(default=None, compare=False)

    @classmethod
    def from_dict(cls, node: Mapping[str, Any], words: Words = ENGLISH) -> Proof:
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
            children=tuple(cls.from_dict(child, words) for child in node["children"]),
            evidence=None if evidence is None else Evidence.from_dict(evidence),
            words=words,
            clause=node.get("clause"),
        )

    def to_dict(self) -> dict[str, Any]:
        """Return the proof as nested dicts, ready for JSON."""
        return {
            "kind": self.kind,
            "predicate": self.predicate,
            "args": list(self.args),
            "text": self.text,
            "clause": self.clause,
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
        # A step that is not shown is no conclusion: the clauses below it go on after one further up.
        texts = [child.clause if self.shown and child.clause else child.text for child in reasons]
        listed = self.words.listed(texts)
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
class Proofs(Shown):
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

    def told(self, length: Length = "normal") -> str:
        """Return them for people, at one of three lengths, an empty line between two."""
        return "\n\n".join(one.told(length) for one in self.proofs)

    def parts(self) -> list[Part]:
        """Return each conclusion in a sentence, with its proof below it."""
        return [part for one in self.proofs for part in one.parts()]

    def to_dict(self) -> dict[str, Any]:
        """Return the proofs as nested dicts, ready for JSON."""
        return {
            "holds": bool(self),
            "proofs": [one.to_dict() for one in self.proofs],
            "truncated": self.truncated,
        }
