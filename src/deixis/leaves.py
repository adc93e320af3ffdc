"""Leaves: to every leaf of a proof its evidence, in numbers and in geometry.

A proof says that a number was measured and compared. Here it is seen what the number is called, what it was
compared with, and between which points or against which plane it was measured. Nothing follows from it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Final, NamedTuple, TypeVar

import numpy as np

from deixis.bounds import planes
from deixis.boxes import align_with_world
from deixis.evidence import Evidence, Plane, Point, Value, Witness, measured, threshold
from deixis.explain import Answer, Contrast, Proof, Proofs, Refusal
from deixis.facts import Facts, SolidModel
from deixis.frames import AXES, HORIZONTAL, WORLD, Index
from deixis.grounding import frame
from deixis.inspection import Inspection
from deixis.scene import Scene
from deixis.witnesses import measured_segments

_SAME: Final = 1.0e-12
"""Numbers nearer than this are the same one: a rule may have turned its sign round."""


Explained = TypeVar("Explained", Proof, Proofs, Answer, Refusal, Contrast, Inspection)


class _Subject(NamedTuple):
    """What a number was measured of: the separation of two things, or a halfspace of the second."""

    figure: str
    reference: str
    axis: str | None = None
    view: str | None = None
    strict: bool = False


class Gathering:
    """Gathers the evidence of proofs over one scene.

    Parameters
    ----------
    scene : Scene
    facts : Facts
        Of the scene.
    """

    def __init__(self, scene: Scene, facts: Facts) -> None:
        self._scene, self._facts = scene, facts
        self._place = {name: position for position, name in enumerate(facts.ids)}
        self._views = {view.id: view for view in scene.views}

    def gather(self, proofs: Sequence[Proof]) -> list[Proof]:
        """Return the proofs with evidence on their leaves; what is to be seen is measured all at once.

        Examples
        --------
        >>> from deixis._files import kb_dir
        >>> from deixis.knowledge import KnowledgeBase
        >>> with KnowledgeBase.from_scene(kb_dir() / "scenes" / "hans.json") as kb:
        ...     found = kb.evidence(kb.why("near(sweater, heater)")).proof
        >>> leaf = found.children[-1].children[-1]
        >>> [(one.name, one.value) for one in (*leaf.evidence.values, *leaf.evidence.thresholds)]
        [('distance', 0.0), ('closeness', 1.0)]
        """
        wanted = {subject for proof in proofs for subject in self._subjects(proof)}
        seen = self._look(wanted)
        return [self._with(proof, None, (), seen) for proof in proofs]

    def _subjects(self, proof: Proof, parent: Proof | None = None) -> Iterator[_Subject]:
        found = self._subject(proof, parent)
        if found is not None:
            yield found
        for child in proof.children:
            yield from self._subjects(child, proof)

    def _subject(self, step: Proof, parent: Proof | None) -> _Subject | None:
        """Return what a step's numbers were measured of; None where it states none, or of nothing here."""
        args = step.args
        if step.kind not in ("rule", "fact") or not any(isinstance(one, int | float) for one in args):
            return None
        names = [one for one in args if isinstance(one, str)]
        if step.predicate == "aspect" and len(args) == 7:
            names = [*names[1:], names[0]]
        if len(names) < 2 or names[0] not in self._place or names[1] not in self._place:
            return None
        figure, reference, *rest = names
        if (step.predicate, len(args)) in (("halfspace", 5), ("strict", 5)):
            axis, view = rest
            return self._known(figure, reference, axis, view, step.predicate == "strict")
        if (step.predicate, len(args)) in (("pair", 9), ("aspect", 7)):
            if parent is not None and (parent.predicate, len(parent.args)) == ("halfspace", 5):
                return self._subject(parent, None)
            return _Subject(figure, reference)
        return _Subject(figure, reference) if step.children else None

    def _known(self, figure: str, reference: str, axis: str, view: str, strict: bool) -> _Subject | None:
        """Return a halfspace as a subject, if there are such an axis and view."""
        if axis not in AXES or (axis in HORIZONTAL and view != WORLD and view not in self._views):
            return None
        return _Subject(figure, reference, axis, view, strict)

    def _look(self, wanted: set[_Subject]) -> Mapping[_Subject, Witness]:
        """Return what there is to be seen of each subject."""
        found: dict[_Subject, Witness] = {}
        groups: dict[tuple[str | None, str | None, bool], list[_Subject]] = {}
        for one in sorted(wanted, key=str):
            groups.setdefault((one.axis, one.view, one.strict), []).append(one)
        for (axis, view, strict), subjects in groups.items():
            figure, reference = (
                np.array([self._place[one] for one in names], dtype=np.int64) for names in _columns(subjects)
            )
            rows = self._rows(figure, reference)
            known = rows >= 0
            some = [one for one, there in zip(subjects, known.tolist(), strict=True) if there]
            if not some:
                continue
            if axis is None or view is None:
                found.update(zip(some, self._segments(some, rows[known]), strict=True))
            else:
                found.update(zip(some, self._planes(some, rows[known], axis, view, strict), strict=True))
        return found

    def _rows(self, figure: Index, reference: Index) -> Index:
        """Return the rows of ordered pairs in the facts, which are in order; -1 where there is none."""
        first = np.searchsorted(self._facts.figure, figure)
        last = np.searchsorted(self._facts.figure, figure, side="right")
        rows = np.full(len(figure), -1, dtype=np.int64)
        for k, (start, end) in enumerate(zip(first.tolist(), last.tolist(), strict=True)):
            row = start + int(np.searchsorted(self._facts.reference[start:end], reference[k]))
            if row < end and self._facts.reference[row] == reference[k]:
                rows[k] = row
        return rows

    def _segments(self, subjects: Sequence[_Subject], rows: Index) -> Iterator[Witness]:
        points = measured_segments(self._scene, self._facts, rows)
        normals = self._facts.normal[rows].astype(np.float64)
        normals /= np.linalg.norm(normals, axis=1)[:, None]
        for one, (at, other), normal in zip(subjects, points.tolist(), normals.tolist(), strict=True):
            things = (one.figure, one.reference)
            yield Witness(
                things, (_point(at), _point(other)), _point(normal), measured_as=self._models(things)
            )

    def _planes(
        self, subjects: Sequence[_Subject], rows: Index, axis: str, view: str, strict: bool
    ) -> Iterator[Witness]:
        facts, boxes = self._facts, self._scene.boxes
        references = boxes.take(facts.reference[rows].astype(np.int64))
        if axis in HORIZONTAL:
            if view == WORLD:
                references, _ = align_with_world(references)
            else:
                references, _, _ = frame(references, self._views[view])
        figures = boxes.take(facts.figure[rows].astype(np.int64))
        found = planes(figures, references, facts.separation[rows], axis, facts.thresholds, strict=strict)
        separate = facts.normal[rows].astype(np.float64).tolist()
        for k, (one, at, below, normal, apart) in enumerate(
            zip(
                subjects,
                found.witness.tolist(),
                found.point.tolist(),
                found.normal.tolist(),
                separate,
                strict=True,
            )
        ):
            # The bounds are those of the boxes, whatever the margin was measured of.
            yield Witness(
                (one.figure, one.reference),
                (_point(at), _point(below)),
                _point(apart),
                Plane(_point(below), _point(normal), found.bound[k]),
                None if view == WORLD else view,
                {one.figure: "box", one.reference: "box"},
            )

    def _models(self, things: Sequence[str]) -> dict[str, SolidModel]:
        return {one: self._facts.models[self._place[one]] for one in things if one in self._place}

    def _with(
        self, step: Proof, parent: Proof | None, before: Sequence[Proof], seen: Mapping[_Subject, Witness]
    ) -> Proof:
        """Return a step with evidence on it and on all below it."""
        children = tuple(
            self._with(child, step, step.children[:number], seen)
            for number, child in enumerate(step.children)
        )
        return replace(step, children=children, evidence=self._evidence(step, parent, before, seen))

    def _evidence(
        self, step: Proof, parent: Proof | None, before: Sequence[Proof], seen: Mapping[_Subject, Witness]
    ) -> Evidence | None:
        if step.kind == "comparison":
            return self._compared(step, before, seen)
        if step.kind == "negation":
            return self._absent(step, seen)
        if step.kind == "conjunction":
            return None
        subject = self._subject(step, parent)
        values = measured(step.predicate, step.args)
        if subject is not None:
            return Evidence(values, (), step.margin, seen.get(subject))
        if step.children:
            return None
        if step.predicate == "figure_reference":
            values = tuple(
                Value(f"volume of {one}", float(self._facts.volume[self._place[one]]), "m3")
                for one in step.args
                if isinstance(one, str) and one in self._place
            )
        return Evidence(values, threshold(step.predicate, step.args), step.margin, self._bare(step))

    def _bare(self, step: Proof) -> Witness | None:
        """Return the things and the view that a step speaks of, without points; None where there are none."""
        names = [one for one in step.args if isinstance(one, str)]
        things = tuple(dict.fromkeys(one for one in names if one in self._place))
        view = next((one for one in names if one in self._views), None)
        if not things and view is None:
            return None
        return Witness(things, view=view, measured_as=self._models(things))

    def _compared(self, step: Proof, before: Sequence[Proof], seen: Mapping[_Subject, Witness]) -> Evidence:
        """Return what a comparison compares: of the steps before it those that state its numbers."""
        numbers = [abs(one) for one in step.args if isinstance(one, int | float)]
        values, limits, sources = [], [], []
        for one in before:
            if one.kind not in ("rule", "fact"):
                continue
            stated = [value for value in measured(one.predicate, one.args) if _among(value, numbers)]
            values += stated
            sources += [one] if stated else []
            limits += [value for value in threshold(one.predicate, one.args) if _among(value, numbers)]
        stated = [*values, *limits]
        limits += [
            Value("constant", float(one), "m")
            for one in step.args
            if isinstance(one, int | float) and not any(_among(value, [abs(one)]) for value in stated)
        ]
        subjects = (self._subject(one, None) for one in sources)
        witness = next((seen[one] for one in subjects if one is not None and one in seen), None)
        return Evidence(
            tuple(dict.fromkeys(values)),
            tuple(dict.fromkeys(limits)),
            step.margin,
            witness or self._bare(step),
        )

    def _absent(self, step: Proof, seen: Mapping[_Subject, Witness]) -> Evidence:
        """Return what keeps the nearest miss from holding."""
        for miss in step.children:
            found = self._weakest(miss, (), seen)
            if found is not None:
                return replace(found, margin=step.margin)
        return Evidence(margin=step.margin, witness=self._bare(step))

    def _weakest(
        self, step: Proof, before: Sequence[Proof], seen: Mapping[_Subject, Witness]
    ) -> Evidence | None:
        """Return the evidence of the comparison that gives a derivation its margin."""
        if step.kind == "comparison":
            return self._compared(step, before, seen)
        if step.kind == "negation":
            return self._absent(step, seen)
        for number, child in enumerate(step.children):
            if child.margin is not None and child.margin == step.margin:
                return self._weakest(child, step.children[:number], seen)
        return None


def with_evidence(gathering: Gathering, found: Explained) -> Explained:
    """Return what was explained with evidence on the leaves of all its proofs."""
    if isinstance(found, Proof):
        return gathering.gather([found])[0]
    if isinstance(found, Proofs):
        return replace(found, proofs=tuple(gathering.gather(found.proofs)))
    if isinstance(found, Answer):
        held = [one for one in (found.proof, found.nearest) if one is not None]
        told = iter(gathering.gather(held))
        proof = None if found.proof is None else next(told)
        return replace(found, proof=proof, nearest=None if found.nearest is None else next(told))
    if isinstance(found, Contrast):
        fact, other = with_evidence(gathering, found.fact), with_evidence(gathering, found.other)
        return replace(found, fact=fact, other=other)
    if isinstance(found, Inspection):
        told = iter(gathering.gather([one.proof for one in found.violations if one.proof is not None]))
        violations = (
            one if one.proof is None else replace(one, proof=next(told)) for one in found.violations
        )
        return replace(found, violations=tuple(violations))
    derivations = gathering.gather([miss.derivation for miss in found.misses])
    misses = zip(found.misses, derivations, strict=True)
    return replace(found, misses=tuple(replace(miss, derivation=one) for miss, one in misses))


def _columns(subjects: Sequence[_Subject]) -> tuple[list[str], list[str]]:
    return [one.figure for one in subjects], [one.reference for one in subjects]


def _among(value: Value, numbers: Sequence[float]) -> bool:
    return any(abs(abs(value.value) - one) <= _SAME for one in numbers)


def _point(values: Sequence[float]) -> Point:
    x, y, z = (round(one, 9) + 0.0 for one in values)
    return x, y, z
