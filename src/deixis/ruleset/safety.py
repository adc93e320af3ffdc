"""Checks of one rule by itself: every variable is bound before it is used, and used more than once."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator

from deixis.ruleset.model import (
    Atom,
    Comparison,
    Constant,
    Negation,
    Problem,
    Rule,
    Variable,
    variables,
)


def unsafe(rule: Rule) -> Iterator[Problem]:
    r"""Yield what is wrong with the variables of a rule.

    Prolog evaluates from left to right, and a denial or comparison of what is not bound yet is silently
    wrong there; so order matters, though the other engines do not mind.

    Examples
    --------
    >>> from pathlib import Path
    >>> from deixis.ruleset.reading import read_text
    >>> file, _ = read_text("lone(X) :- \\+ touches(_, X), surface(X).", Path("x.pl"))
    >>> print(*unsafe(file.rules[0]))
    x.pl:1:26: X is denied before it is bound (put the goal that binds it in front of the denial)
    """
    positive = {one.name for goal in rule.body if isinstance(goal, Atom) for one in variables(goal)}
    bound: set[str] = set()
    for goal in rule.body:
        match goal:
            case Atom():
                bound |= {one.name for one in variables(goal)}
            case Comparison():
                yield from _loose(goal, bound, positive)
            case Negation():
                yield from _denial(goal, bound, positive)
    for value in rule.head.args:
        if isinstance(value, Constant) or value.name in bound:
            continue
        if not rule.body:
            yield Problem(value.place, f"{_name(value)} in a fact", "a fact is about names and numbers")
        elif value.anonymous:
            yield Problem(value.place, "_ in the head of a rule", "name it, and bind it in the body")
        else:
            yield Problem(
                value.place, f"{value.name} is bound by no goal", "a goal that is not denied must bind it"
            )
    yield from _shared(rule, bound)
    yield from _singletons(rule)


def _name(value: Variable) -> str:
    return "_" if value.anonymous else value.name


def _denial(goal: Negation, bound: set[str], positive: set[str]) -> Iterator[Problem]:
    inner = set(bound)
    for one in goal.goals:
        if isinstance(one, Comparison):
            yield from _loose(one, inner, positive)
            continue
        for value in _early(variables(one), inner, positive):
            yield Problem(
                value.place,
                f"{value.name} is denied before it is bound",
                "put the goal that binds it in front of the denial",
            )
        inner |= {value.name for value in variables(one)}


def _early(values: Iterable[Variable], bound: set[str], positive: set[str]) -> Iterator[Variable]:
    seen = set()
    for value in values:
        if value.name not in bound and value.name in positive and value.name not in seen:
            seen.add(value.name)
            yield value


def _loose(goal: Comparison, bound: set[str], positive: set[str]) -> Iterator[Problem]:
    seen = set()
    for value in variables(goal):
        if value.name in bound or value.name in seen:
            continue
        seen.add(value.name)
        if value.anonymous:
            yield Problem(value.place, "_ is compared", "name it, and bind it before")
        elif value.name in positive:
            hint = "put the goal that binds it in front of the comparison"
            yield Problem(value.place, f"{value.name} is compared before it is bound", hint)
        else:
            yield Problem(
                value.place, f"{value.name} is compared and never bound", "a goal before must bind it"
            )


def _singletons(rule: Rule) -> Iterator[Problem]:
    everywhere = [*variables(rule.head), *(one for goal in rule.body for one in variables(goal))]
    times = Counter(one.name for one in everywhere)
    in_head = {one.name for one in variables(rule.head)}
    for one in everywhere:
        if times[one.name] == 1 and not one.name.startswith("_") and one.name not in in_head:
            yield Problem(one.place, f"Singleton variable {one.name}", "write _ if any will do", warning=True)
    told: set[str] = set()
    for one in everywhere:
        if times[one.name] > 1 and _marked(one.name) and one.name not in told:
            told.add(one.name)
            hint = "a variable that begins with _ stands once"
            yield Problem(one.place, f"{one.name} stands more than once", hint, warning=True)


def _marked(name: str) -> bool:
    return name[:1] == "_" and name[1:2].isupper()


def _shared(rule: Rule, bound: set[str]) -> Iterator[Problem]:
    """Yield the variables that stand in two denials and nowhere else."""
    seen: set[str] = set()
    for goal in rule.body:
        if not isinstance(goal, Negation):
            continue
        inner = {one.name: one for one in reversed(list(variables(goal))) if one.name not in bound}
        for name, one in inner.items():
            if name in seen:
                hint = "it means any in each: name it anew"
                yield Problem(one.place, f"{name} stands in two denials", hint, warning=True)
        seen |= inner.keys()
