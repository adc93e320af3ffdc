"""Rules written out: what an atom stands for put in its place, and facts with one key looked up once.

Executors that derive whole relations at a time gain from it. What follows stays the same, margins too.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from itertools import count
from typing import Final

from deixis.ruleset.base import BASE_FACTS
from deixis.ruleset.checking import Ruleset
from deixis.ruleset.model import (
    Arithmetic,
    Atom,
    Comparison,
    Constant,
    Expression,
    Goal,
    Indicator,
    Kind,
    Negation,
    Rule,
    Value,
    Variable,
    variables,
)

KEYS: Final[dict[Indicator, int]] = {
    ("spatial_obj", 1): 1,
    ("surface", 1): 1,
    ("viewpoint", 1): 1,
    ("threshold", 2): 1,
    ("figure_reference", 2): 2,
    ("pair", 9): 2,
    ("aspect", 7): 3,
    ("strict", 5): 4,
}
"""Base facts of which there is at most one with given first arguments; so many are the key."""

LONGEST: Final = 24
"""Goals of a rule written out."""

Binding = dict[str, Value]


@dataclass(frozen=True, slots=True)
class Unfolded:
    """Rules written out.

    Attributes
    ----------
    rules : dict
        Of each derived predicate.
    once : frozenset of Indicator
        The predicates whose one rule finds each conclusion once.
    """

    rules: dict[Indicator, tuple[Rule, ...]]
    once: frozenset[Indicator]


def unfolded(ruleset: Ruleset, whole: Collection[Indicator] = ()) -> Unfolded:
    """Return the rules of each derived predicate, written out as far as that duplicates nothing.

    They are written out once for a ruleset and what is left whole.

    Parameters
    ----------
    ruleset : Ruleset
    whole : collection of Indicator
        Predicates that nothing is put in the place of.

    Examples
    --------
    >>> from deixis._files import rules_dir
    >>> from deixis.ruleset.checking import load
    >>> rules = load([rules_dir() / f"{name}.pl" for name in ("facts", "topology", "direction")])
    >>> [goal.name for goal in unfolded(rules).rules["above", 2][0].body if isinstance(goal, Atom)]
    ['figure_reference', 'pair']
    """
    key = Unfolded, frozenset(whole)
    known: Unfolded | None = ruleset.plans.get(key)
    if known is None:
        known = ruleset.plans[key] = _unfolded(ruleset, frozenset(whole))
    return known


def _unfolded(ruleset: Ruleset, whole: frozenset[Indicator]) -> Unfolded:
    recursive = ruleset.graph.recursive
    done: dict[Indicator, tuple[Rule, ...]] = {}
    keys = dict(KEYS)
    fresh = count()
    for component in ruleset.graph.components:
        for predicate in sorted(component):
            if predicate in BASE_FACTS:
                continue
            rules = ruleset.by_head.get(predicate, ())
            plain = {one: done[one] for one in done if one not in recursive and one not in whole}
            writer = _Writer(plain, keys, fresh)
            written = (writer.rule(rule) for rule in rules)
            done[predicate] = tuple(one for one in written if one is not None)
            key = _key(ruleset.kinds[predicate], rules, keys)
            if predicate not in recursive and key is not None:
                keys[predicate] = key
    once = {
        one
        for one, rules in done.items()
        if len(rules) == 1 and one not in recursive and rules[0].body and _found_once(rules[0], keys)
    }
    return Unfolded(done, frozenset(once))


def _found_once(rule: Rule, keys: Mapping[Indicator, int]) -> bool:
    # Nothing says that a label is given once.
    loose = any(
        isinstance(goal, Atom) and goal.predicate in BASE_FACTS and goal.predicate not in KEYS
        for goal in rule.body
    )
    head = {one.name for one in rule.head.args if isinstance(one, Variable)}
    return not loose and _determined(rule, head, keys)


class _Writer:
    """Writes rules out, given what others stand for and which arguments are keys."""

    def __init__(
        self, known: Mapping[Indicator, Sequence[Rule]], keys: Mapping[Indicator, int], fresh: count[int]
    ) -> None:
        self.known, self.keys, self.fresh = known, keys, fresh

    def rule(self, rule: Rule) -> Rule | None:
        """Return a rule with atoms replaced where one rule can stand for them; None where none can hold."""
        at = 0
        # What is the same as something else by another name is read from there.
        copies = len(rule.body) == 1 and not any(
            isinstance(one, Constant) for goal in rule.body if isinstance(goal, Atom) for one in goal.args
        )
        while at < len(rule.body):
            goal = rule.body[at]
            changed: Rule | None = rule
            if isinstance(goal, Atom) and goal.predicate in self.known and not copies:
                changed = self._replace(rule, at, goal)
            elif isinstance(goal, Negation):
                inner = self._inner(goal)
                changed = Rule(rule.head, (*rule.body[:at], inner, *rule.body[at + 1 :]), rule.doc)
                at += 1
            else:
                at += 1
            if changed is None:
                return None
            if changed is rule and isinstance(goal, Atom):
                at += goal.predicate in self.known
            rule = changed
        return _once(rule)

    def _replace(self, rule: Rule, at: int, atom: Atom) -> Rule | None:
        candidates = _candidates(atom, self.known[atom.predicate])
        if not candidates:
            return None
        (first, *more) = candidates
        if more or not _opens(first, self.keys) or len(rule.body) + len(first.body) > LONGEST:
            return rule
        suffix = f"~{next(self.fresh)}"
        binding: Binding = {}
        outer: Binding = {}
        for have, want in zip(first.head.args, atom.args, strict=True):
            if isinstance(have, Variable):
                binding[have.name] = want
            elif isinstance(want, Variable) and outer.setdefault(want.name, have) != have:
                return None
        body = tuple(_put(goal, binding, suffix) for goal in first.body)
        whole = Rule(rule.head, (*rule.body[:at], *body, *rule.body[at + 1 :]), rule.doc)
        if not outer:
            return whole
        return Rule(
            _put_atom(whole.head, outer, ""), tuple(_put(goal, outer, "") for goal in whole.body), rule.doc
        )

    def _inner(self, goal: Negation) -> Negation:
        """Return a denial with atoms written out where one rule without a denial can stand for them."""
        done: list[Atom | Comparison] = []
        todo = list(goal.goals)
        while todo:
            one = todo.pop(0)
            if not isinstance(one, Atom) or one.predicate not in self.known:
                done.append(one)
                continue
            candidates = _candidates(one, self.known[one.predicate])
            body = self._plain_body(one, candidates) if len(candidates) == 1 else None
            if body is None or len(done) + len(todo) + len(body) > LONGEST:
                done.append(one)
            else:
                todo[:0] = body
        return Negation(tuple(done), goal.place)

    def _plain_body(self, atom: Atom, candidates: Sequence[Rule]) -> list[Atom | Comparison] | None:
        (rule,) = candidates
        if (
            not rule.body
            or not _opens(rule, self.keys)
            or any(isinstance(goal, Negation) for goal in rule.body)
        ):
            return None
        suffix = f"~{next(self.fresh)}"
        binding: Binding = {}
        for have, want in zip(rule.head.args, atom.args, strict=True):
            if isinstance(have, Variable):
                binding[have.name] = want
            elif isinstance(want, Variable):
                return None  # it would have to be compared with the constant
        written = [_put(goal, binding, suffix) for goal in rule.body]
        return [goal for goal in written if not isinstance(goal, Negation)]


def _candidates(atom: Atom, rules: Sequence[Rule]) -> list[Rule]:
    """Return the rules whose head can be this atom, by its constants."""
    return [rule for rule in rules if _may_agree(rule.head, atom)]


def _opens(rule: Rule, keys: Mapping[Indicator, int]) -> bool:
    """Return whether a rule finds each of its conclusions once, with distinct variables in its head."""
    head = [one.name for one in rule.head.args if isinstance(one, Variable)]
    return len(set(head)) == len(head) and len(rule.body) <= LONGEST and _determined(rule, set(head), keys)


def _determined(rule: Rule, found: set[str], keys: Mapping[Indicator, int]) -> bool:
    """Return whether the known variables leave at most one way for all goals to hold."""
    for goal in rule.body:
        if not isinstance(goal, Atom):
            continue
        key = goal.args[: keys.get(goal.predicate, len(goal.args))]
        if any(isinstance(one, Variable) and one.name not in found for one in key):
            return False
        found |= {one.name for one in goal.args if isinstance(one, Variable)}
    return True


def _key(kinds: Sequence[Kind], rules: Sequence[Rule], keys: Mapping[Indicator, int]) -> int | None:
    """Return how many first arguments determine the others: all but the numbers, where that is so."""
    key = sum(kind != "number" for kind in kinds)
    if "number" in kinds[:key]:
        return None
    heads = [Atom(rule.head.name, rule.head.args[:key], rule.place) for rule in rules]
    for at, (rule, head) in enumerate(zip(rules, heads, strict=True)):
        if not _determined(rule, {one.name for one in head.args if isinstance(one, Variable)}, keys):
            return None
        if any(_may_agree(head, other) for other in heads[:at]):
            return None
    return key


def _may_agree(one: Atom, other: Atom) -> bool:
    return not any(
        isinstance(mine, Constant) and isinstance(theirs, Constant) and mine != theirs
        for mine, theirs in zip(one.args, other.args, strict=True)
    )


def _once(rule: Rule) -> Rule | None:
    """Return a rule that looks up each base fact by its key once, in its denials too."""
    body = list(rule.body)
    head = rule.head
    at = 0
    while at < len(body):
        goal = body[at]
        if not isinstance(goal, Atom) or goal.predicate not in KEYS:
            at += 1
            continue
        twin = next((one for one in body[:at] if isinstance(one, Atom) and _same_key(one, goal)), None)
        if twin is None:
            at += 1
            continue
        binding = _merge(goal, twin)
        if binding is None:
            at += 1
            continue
        body = [_put(one, binding, "") for place, one in enumerate(body) if place != at]
        head = _put_atom(head, binding, "")
    outside = [goal for goal in body if isinstance(goal, Atom)]
    used = {one.name for goal in body if not isinstance(goal, Negation) for one in variables(goal)}
    body = [_denied_once(goal, outside, used) if isinstance(goal, Negation) else goal for goal in body]
    return Rule(head, tuple(body), rule.doc)


def _denied_once(goal: Negation, outside: Sequence[Atom], used: set[str]) -> Negation:
    inner = list(goal.goals)
    at = 0
    while at < len(inner):
        one = inner[at]
        at += 1
        if not isinstance(one, Atom) or one.predicate not in KEYS:
            continue
        before = [other for other in inner[: at - 1] if isinstance(other, Atom)]
        twin = next((other for other in (*outside, *before) if _same_key(other, one)), None)
        if twin is None:
            continue
        binding = _merge(one, twin)
        if binding is None or binding.keys() & used:
            continue
        kept = [_put(other, binding, "") for place, other in enumerate(inner) if place != at - 1]
        inner = [other for other in kept if not isinstance(other, Negation)]
        at -= 1
    return Negation(tuple(inner), goal.place)


def _same_key(one: Atom, other: Atom) -> bool:
    key = KEYS.get(one.predicate)
    return key is not None and one.predicate == other.predicate and one.args[:key] == other.args[:key]


def _merge(atom: Atom, twin: Atom) -> Binding | None:
    """Return what the variables of an atom are in its twin; None where a constant stands beside the key."""
    binding: Binding = {}
    for mine, other in zip(atom.args, twin.args, strict=True):
        if mine == other:
            continue
        if not isinstance(mine, Variable) or mine.name in binding:
            return None
        binding[mine.name] = other
    return binding


def _put(goal: Goal, binding: Mapping[str, Value], suffix: str) -> Goal:
    """Return a goal with its variables replaced; those without a value get a suffix to their names."""
    match goal:
        case Atom():
            return _put_atom(goal, binding, suffix)
        case Comparison():
            return _put_comparison(goal, binding, suffix)
        case Negation():
            inner = (
                _put_atom(one, binding, suffix)
                if isinstance(one, Atom)
                else _put_comparison(one, binding, suffix)
                for one in goal.goals
            )
            return Negation(tuple(inner), goal.place)


def _put_atom(atom: Atom, binding: Mapping[str, Value], suffix: str) -> Atom:
    return Atom(atom.name, tuple(_put_value(one, binding, suffix) for one in atom.args), atom.place)


def _put_comparison(goal: Comparison, binding: Mapping[str, Value], suffix: str) -> Comparison:
    left, right = (_put_expression(one, binding, suffix) for one in (goal.left, goal.right))
    return Comparison(goal.operator, left, right, goal.place)


def _put_value(value: Value, binding: Mapping[str, Value], suffix: str) -> Value:
    if isinstance(value, Constant):
        return value
    return binding.get(value.name, Variable(value.name + suffix, value.place) if suffix else value)


def _put_expression(value: Expression, binding: Mapping[str, Value], suffix: str) -> Expression:
    if isinstance(value, Arithmetic):
        operands = tuple(_put_expression(one, binding, suffix) for one in value.operands)
        return Arithmetic(value.operator, operands, value.place)
    return _put_value(value, binding, suffix)
