"""Derivations as quads: of every relation its axiom, its margin, and the step that concluded it.

A premise that is a relation itself is the derivation of that relation, so that one can follow a proof through
the graph; any other is a step of its own, down to what was measured.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping
from typing import Final

from deixis.rdf.evidence import write_evidence
from deixis.rdf.knowledge import Holds
from deixis.rdf.layout import TERM, term
from deixis.rdf.names import SceneNames
from deixis.rdf.quads import GraphWriter
from deixis.rdf.relations import arguments, graph_of, relation_iri
from deixis.steps import Step
from deixis.vocabulary import BY_NAME

STEPS: Final = {
    "rule": "Conclusion",
    "fact": "Measurement",
    "comparison": "Comparison",
    "negation": "Absence",
    "conjunction": "Conjunction",
}
"""Kind of a proof's step to its class."""

Key = tuple[str, ...]
"""A relation's name and its arguments."""


def write_derivations(
    to: GraphWriter, found: Iterable[Holds], names: SceneNames, proofs: Mapping[Key, Step] | None = None
) -> None:
    """Write what each relation is, in which graph it stands, its axiom, its margin and its last step."""
    holds = {(one.relation, *arguments(one)): one for one in found}
    for key, one in holds.items():
        iri = _derivation(key, names)
        to.typed(iri, TERM + "Derivation")
        to.link(iri, TERM + "relation", relation_iri(one))
        to.link(iri, TERM + "figure", names.named(one.figure))
        to.link(iri, TERM + "reference", names.named(one.reference))
        to.link(iri, TERM + "inGraph", graph_of(one, names))
        if one.margin is not None:
            to.number(iri, TERM + "margin", one.margin)
        known = BY_NAME.get(one.relation)
        if known is not None:
            to.whole(iri, TERM + "axiom", known.axiom)
        if proofs is not None:
            step = proofs[key]
            if step.rule is not None:
                to.text(iri, TERM + "ruleFile", step.rule.file)
                to.whole(iri, TERM + "ruleLine", step.rule.line)
            _step(to, iri, step, holds.keys(), names)


def _derivation(key: Key, names: SceneNames) -> str:
    name, *args = key
    return names.derivation(term((name, len(args))).removeprefix(TERM), *args)


def _step(to: GraphWriter, iri: str, step: Step, holds: Collection[Key], names: SceneNames) -> None:
    """Write what a step says, what it rests on, and its premises."""
    to.text(iri, TERM + "says", step.text)
    if step.evidence is not None:
        write_evidence(to, iri, step.evidence, names)
    for number, (reason, by) in enumerate(_reasons(step, holds), 1):
        if _is_relation(reason, holds):
            to.link(iri, TERM + "premise", _derivation(_key(reason), names))
            continue
        premise = f"{iri}:premise:{number}"
        to.link(iri, TERM + "premise", premise)
        to.typed(premise, TERM + STEPS[reason.kind])
        if reason.margin is not None:
            to.number(premise, TERM + "margin", reason.margin)
        _by(to, premise, by if reason.rule is None else reason)
        _step(to, premise, reason, holds, names)


def _by(to: GraphWriter, iri: str, step: Step) -> None:
    """Write the rule that concludes a step or, of what no rule concludes, the one that asks for it."""
    if step.rule is not None:
        to.text(iri, TERM + "ruleFile", step.rule.file)
        to.whole(iri, TERM + "ruleLine", step.rule.line)
    if step.axiom is not None:
        to.whole(iri, TERM + "axiom", step.axiom)


def _reasons(step: Step, holds: Collection[Key]) -> Iterator[tuple[Step, Step]]:
    """Yield the nearest reasons that are relations or that a person needs, each with the step it is asked by.

    What is absent says its own.
    """
    if step.kind == "negation":
        return
    for child in step.children:
        if child.shown or _is_relation(child, holds):
            yield child, step
        else:
            yield from _reasons(child, holds)


def _is_relation(step: Step, holds: Collection[Key]) -> bool:
    return step.kind == "rule" and _key(step) in holds


def _key(step: Step) -> Key:
    return (step.predicate, *map(str, step.args))
