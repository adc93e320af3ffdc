"""Proofs checked without the engines: each step applied anew, each measured number found anew.

Rules are read by deixis.ruleset and followed top-down, in the plainest way; numbers come from the loop with
shapely that the geometry is compared with (tests/bench).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from bench import shapely_loop
from bench.job import frames, ordered, things
from deixis import KnowledgeBase
from deixis.explain import Proof
from deixis.ruleset import Indicator
from deixis.ruleset.base import BASE_FACTS
from deixis.ruleset.model import Atom, Comparison, Goal, Negation, Rule
from naive import COMPARE, Bound, Row, Value, _matched, _value, base_rows

LENGTH = 1.0e-9
"""Facts are rounded to a nanometre."""

AXES = ("X+", "X-", "Y+", "Y-")

VERTICAL = ("Z+", "Z-")


class Truth:
    """What holds in a scene, asked goal by goal."""

    def __init__(self, kb: KnowledgeBase) -> None:
        self.kb = kb
        self._rows: dict[Indicator, dict[tuple[int, Value] | None, list[Row]]] = {}

    def rows(self, atom: Atom, bound: Bound) -> list[Row]:
        """Return the base facts that may match, by the first argument that is known."""
        if atom.predicate not in self._rows:
            index: dict[tuple[int, Value] | None, list[Row]] = {None: []}
            for row in base_rows(self.kb.facts, atom.predicate):
                index[None].append(row)
                for at, cell in enumerate(row):
                    index.setdefault((at, cell), []).append(row)
            self._rows[atom.predicate] = index
        index = self._rows[atom.predicate]
        candidates = [index[None]]
        for at, value in enumerate(atom.args):
            cell = _known(value, bound)
            if cell is not None:
                candidates.append(index.get((at, cell), []))
        return min(candidates, key=len)

    def solve(self, goals: Sequence[Goal], bound: Bound) -> Iterator[Bound]:
        """Yield each way in which goals hold."""
        if not goals:
            yield bound
            return
        goal, *rest = goals
        for extended in self.step(goal, bound):
            yield from self.solve(rest, extended)

    def step(self, goal: Goal, bound: Bound) -> Iterator[Bound]:
        """Yield each way in which one goal holds."""
        if isinstance(goal, Comparison):
            if COMPARE[goal.operator](_value(goal.left, bound), _value(goal.right, bound)):
                yield bound
        elif isinstance(goal, Negation):
            if next(self.solve(goal.goals, bound), None) is None:
                yield bound
        elif goal.predicate in BASE_FACTS:
            for row in self.rows(goal, bound):
                extended = _matched(goal, row, bound)
                if extended is not None:
                    yield extended
        else:
            known = [_known(value, bound) for value in goal.args]
            for rule in self.kb.ruleset.by_head[goal.predicate]:
                inner = head_bound(rule, known)
                for solved in [] if inner is None else self.solve(rule.body, inner):
                    row = tuple(_value(one, solved) for one in rule.head.args)
                    extended = _matched(goal, row, bound)
                    if extended is not None:
                        yield extended

    def holds(self, name: str, args: Sequence[Value | None]) -> bool:
        """Return whether a predicate of the rules holds of these arguments; None stands for any."""
        for rule in self.kb.ruleset.by_head[name, len(args)]:
            bound = head_bound(rule, args)
            if bound is not None and next(self.solve(rule.body, bound), None) is not None:
                return True
        return False

    def rule_of(self, step: Proof) -> Rule:
        """Return the rule that a step says it was concluded by."""
        assert step.rule is not None
        (rule,) = (
            rule
            for rule in self.kb.ruleset.by_head[step.predicate, len(step.args)]
            if (rule.place.file.name, rule.place.line) == (step.rule.file, step.rule.line)
        )
        return rule

    def bindings(self, step: Proof) -> Bound:
        """Return what the variables of a step's rule stand for, by its conclusion and its reasons."""
        rule = self.rule_of(step)
        bound = head_bound(rule, step.args)
        assert bound is not None, step.text
        for goal, child in aligned(rule, step):
            if isinstance(goal, Atom):
                for value, cell in zip(goal.args, child.args, strict=True):
                    if cell is not None:
                        extended = _matched(Atom("_", (value,), goal.place), (cell,), bound)
                        assert extended is not None, child.text
                        bound = extended
        return bound

    def apply(self, step: Proof) -> None:
        """Check that a step follows from its reasons by its rule, and that each of them holds."""
        if step.kind == "rule":
            bound = self.bindings(step)
            rule = self.rule_of(step)
            assert len(rule.body) == len(step.children), step.text
            for goal, child in aligned(rule, step):
                assert next(self.step(goal, bound), None) is not None, child.text
                if isinstance(goal, Comparison):
                    assert child.kind == "comparison"
                    assert child.args == (_value(goal.left, bound), _value(goal.right, bound))
                elif isinstance(goal, Negation):
                    assert child.kind == "negation"
                else:
                    self.apply(child)
        else:
            assert step.kind == "fact", step.text


class Measured:
    """What a scene of boxes measures, by shapely and by the scene itself, one pair at a time.

    Gaps and overlaps are those of the things as they are; for halfspaces no thing is thinner than D (decision
    0009), which the loop leaves to whoever calls it.
    """

    def __init__(self, kb: KnowledgeBase) -> None:
        self.kb = kb
        self.ids = kb.facts.ids
        self.least = 0.5 * kb.scene.thresholds.granularity
        self.things = things(kb.scene)
        self.solids = [shapely_loop._solid(one) for one in self.things]
        self.thick = [shapely_loop._solid(self._thick(one)) for one in self.things]
        for view, index, frame in frames(kb.scene):
            self.thick[index].frames[view] = self._thick(frame)

    def _thick(self, thing: Any) -> Any:
        halves = {name: max(getattr(thing, name), self.least) for name in ("hx", "hy", "hz")
                  if hasattr(thing, name)}  # fmt: skip
        return thing._replace(**halves)

    def separation(self, i: int, j: int) -> float:
        """Return the signed separation of two things."""
        a, b, limits = self.solids[i], self.solids[j], self.kb.scene.thresholds
        return shapely_loop._separation(a, b, shapely_loop._distance(a, b), limits)[0]

    def vertical(self, i: int, j: int) -> list[bool]:
        """Return whether a thing is above another, and whether it is below."""
        a, b, limits = self.solids[i], self.solids[j], self.kb.scene.thresholds
        apart, _, up, down = shapely_loop._separation(a, b, shapely_loop._distance(a, b), limits)
        one, other = self.thick[i], self.thick[j]
        lateral = shapely_loop._separation(one, other, 0.0, limits)[1]
        return shapely_loop._vertical(one, other, round(apart, 9), lateral, up, down, limits)

    def sides(self, i: int, j: int, view: str) -> list[bool]:
        """Return which halfspaces of a reference, as seen from a view, a figure meets."""
        one, other, limits = self.thick[i], self.thick[j], self.kb.scene.thresholds
        apart = round(self.separation(i, j), 9)
        return shapely_loop._sides(one, other, other.frames[view], apart, limits)

    def leaf(self, leaf: Proof) -> None:
        """Check a measured fact."""
        args = leaf.args
        match leaf.predicate:
            case "pair":
                self._pair(*args)  # type: ignore[arg-type]
            case "aspect":
                view, figure, reference, *margins = args
                found = self.sides(*self._at(figure, reference), str(view))
                assert [float(one or 0.0) >= 0.0 for one in margins] == found, leaf.text
            case "strict":
                figure, reference, axis, view, _ = args
                i, j = self._at(figure, reference)
                if str(axis) in VERTICAL:
                    assert self.vertical(i, j)[VERTICAL.index(str(axis))], leaf.text
                else:
                    assert self.sides(i, j, str(view))[AXES.index(str(axis))], leaf.text
            case "threshold":
                assert dict(self.kb.scene.thresholds.items())[str(args[0])] == args[1]
            case "viewpoint":
                assert args[0] in {one.id for one in self.kb.scene.views}
            case "figure_reference":
                i, j = (self.ids.index(str(one)) for one in args)
                assert ordered(self.things[i], self.things[j])
            case "surface":
                assert self.things[self.ids.index(str(args[0]))].surface
            case other:
                raise AssertionError(f"{other} is no measured fact")

    def _at(self, figure: object, reference: object) -> tuple[int, int]:
        return self.ids.index(str(figure)), self.ids.index(str(reference))

    def _pair(self, figure: str, reference: str, *numbers: float) -> None:
        distance, separation, protrusion, volume, frontier, up, down = numbers
        i, j = self._at(figure, reference)
        a, b = self.solids[i], self.solids[j]
        apart = self.separation(i, j)
        assert abs(separation - apart) <= LENGTH, (figure, reference, separation, apart)
        assert abs(distance - max(apart, 0.0)) <= LENGTH
        assert abs(protrusion - shapely_loop._sticks_out(a, b)) <= LENGTH
        height = min(a.top, b.top) - max(a.bottom, b.bottom)
        shared = a.plan.intersection(b.plan).area * height if round(apart, 9) < 0.0 else 0.0
        assert abs(volume - shared) <= LENGTH
        assert frontier >= 0.0
        for margin, holds in zip((up, down), self.vertical(i, j), strict=True):
            # Of two things without thickness the one may stand just at the other's bound.
            assert margin == 0.0 or (margin > 0.0) == holds, (figure, reference, up, down)


def aligned(rule: Rule, step: Proof) -> Iterator[tuple[Goal, Proof]]:
    """Yield each reason of a step with the goal of the rule that it is for; goals may be left out."""
    goals = iter(rule.body)
    for child in step.children:
        kind = {"negation": Negation, "comparison": Comparison}.get(child.kind, Atom)
        for goal in goals:
            if isinstance(goal, kind) and getattr(goal, "name", child.predicate) == child.predicate:
                yield goal, child
                break
        else:
            raise AssertionError(f"{child.text}: no goal of {rule.place}")


def head_bound(rule: Rule, args: Sequence[Value | None]) -> Bound | None:
    """Return what the head's variables stand for when it is these arguments; None where it is not."""
    bound: Bound = {}
    for value, cell in zip(rule.head.args, args, strict=True):
        if cell is None:
            continue
        extended = _matched(Atom("_", (value,), rule.place), (cell,), bound)
        if extended is None:
            return None
        bound = extended
    return bound


def _known(value: object, bound: Bound) -> Value | None:
    name = getattr(value, "name", None)
    if name is not None:
        return bound.get(name)
    constant: Value = value.value  # type: ignore[attr-defined]
    return constant


def leaves(proof: Proof) -> Iterator[Proof]:
    """Yield all measured facts of a proof, those below denials too."""
    if proof.kind == "fact":
        yield proof
    for child in proof.children:
        yield from leaves(child)


def random_goals(kb: KnowledgeBase, count: int, seed: int) -> list[tuple[str, tuple[str, ...]]]:
    """Return relations of random things, most of them within reach of each other."""
    from deixis.vocabulary import BASE, RELATIONS

    pick = np.random.default_rng(seed)
    terms, ids, facts = [*RELATIONS, *BASE], kb.facts.ids, kb.facts
    views = [one.id for one in kb.scene.views]
    found = []
    while len(found) < count:
        term = terms[int(pick.integers(len(terms)))]
        if term.view and not views:
            continue
        if len(facts) and pick.random() < 0.85:
            row = int(pick.integers(len(facts)))
            one, other = facts.figure[row], facts.reference[row]
        else:
            one, other = pick.choice(len(ids), 2, replace=len(ids) < 2)
        view = (views[int(pick.integers(len(views)))],) if term.view else ()
        found.append((term.name, (ids[one], ids[other], *view)))
    return found
