"""One rule made ready for arrays: which table is read when, by what, and what of it is needed afterwards.

All of that is a property of the rule and not of a scene, so it is found once.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

from deixis.ruleset.flags import flag, stands_beside
from deixis.ruleset.kinds import rule_lengths
from deixis.ruleset.model import (
    ORDER,
    Atom,
    Comparison,
    Constant,
    Goal,
    Indicator,
    Negation,
    Rule,
    Variable,
    variables,
)
from deixis.ruleset.plan import Mode

ROW = ""
"""Which way of the outer conjunction a way of a denied one belongs to; no variable is called so."""


@dataclass(frozen=True, slots=True)
class Join:
    """An atom, read from its table.

    Attributes
    ----------
    predicate : Indicator
    flags : tuple of str
        Columns beside the arguments that have to be true.
    constants : tuple of (int, Constant)
        Arguments that are written in the rule, with their places.
    repeated : tuple of (int, int)
        Places of arguments that are the same as another argument of this atom.
    scalars, keys : tuple of (int, str)
        Places of arguments known already: one for all rows, or a value a row.
    fresh : tuple of (int, str)
        Places of arguments that are known from here on, and needed.
    kept : frozenset of str
        What of all that was known before is needed from here on.
    """

    predicate: Indicator
    flags: tuple[str, ...]
    constants: tuple[tuple[int, Constant], ...]
    repeated: tuple[tuple[int, int], ...]
    scalars: tuple[tuple[int, str], ...]
    keys: tuple[tuple[int, str], ...]
    fresh: tuple[tuple[int, str], ...]
    kept: frozenset[str]


@dataclass(frozen=True, slots=True)
class Check:
    """A comparison; ``soft`` where both sides are lengths, so that it has a margin."""

    goal: Comparison
    soft: bool
    kept: frozenset[str]


@dataclass(frozen=True, slots=True)
class Denial:
    """What is denied: how it may hold, and how near it comes.

    Attributes
    ----------
    held : frozenset of str
        What it is told of.
    truth, near : Conjunction or None
        None where it is not asked for.
    kept : frozenset of str
        What of all that is known is needed from here on.
    """

    held: frozenset[str]
    truth: Conjunction | None
    near: Conjunction | None
    kept: frozenset[str]


@dataclass(frozen=True, slots=True)
class Conjunction:
    """Goals in the order in which they are looked at.

    Attributes
    ----------
    mode : {"truth", "near"}
    limits : tuple of (str, str)
        Variables that stand for a threshold, and which.
    steps : tuple of Join, Check or Denial
    """

    mode: Mode
    limits: tuple[tuple[str, str], ...]
    steps: tuple[Join | Check | Denial, ...]


@dataclass(frozen=True, slots=True)
class Program:
    """A rule, ready."""

    head: Atom
    body: Conjunction


def program(
    rule: Rule,
    mode: Mode,
    *,
    lengths: Mapping[Indicator, Sequence[bool]],
    limits: Collection[str],
    margins: bool,
) -> Program:
    """Return a rule made ready.

    Parameters
    ----------
    rule : Rule
    mode : {"truth", "near"}
    lengths : mapping
        For each argument of each predicate whether it is a length.
    limits : collection of str
        Names of the thresholds.
    margins : bool
        Whether margins are wanted.

    Examples
    --------
    >>> from deixis._files import datalog_files
    >>> from deixis.ruleset import load
    >>> rules = load(datalog_files())
    >>> found = program(rules.by_head["is_close", 2][0], "truth", lengths=rules.lengths,
    ...                 limits=["closeness"], margins=True)
    >>> [type(step).__name__ for step in found.body.steps], found.body.limits
    (['Join', 'Check'], (('T', 'closeness'),))
    """
    return Program(rule.head, _Writer(mode, lengths, limits, margins=margins).rule(rule))


class _Writer:
    """Puts the goals of rules in an order; parameters as of :func:`program`."""

    def __init__(
        self,
        mode: Mode,
        lengths: Mapping[Indicator, Sequence[bool]],
        limits: Collection[str],
        *,
        margins: bool,
    ) -> None:
        self._mode, self._lengths, self._limits, self._margins = mode, lengths, limits, margins

    def rule(self, rule: Rule) -> Conjunction:
        """Return the body of a rule."""
        known = rule_lengths([goal for goal in rule.body if isinstance(goal, Atom)], self._lengths)
        return self._ordered(rule.body, self._mode, {}, {one.name for one in variables(rule.head)}, known)

    def _ordered(
        self,
        goals: Sequence[Goal],
        mode: Mode,
        held: dict[str, bool],
        needed: Collection[str],
        lengths: Mapping[str, bool],
    ) -> Conjunction:
        """Return goals in an order.

        Parameters
        ----------
        goals : sequence of Goal
        mode : {"truth", "near"}
        held : dict
            What is known, and whether it is a value a row.
        needed : collection of str
            What is needed afterwards.
        lengths : mapping
            For each variable whether it is a length.
        """
        atoms = [goal for goal in goals if isinstance(goal, Atom)]
        checks = [goal for goal in goals if isinstance(goal, Comparison)]
        denials = [goal for goal in goals if isinstance(goal, Negation)]
        every = {one.name for goal in atoms for one in variables(goal)}
        thresholds: list[tuple[str, str]] = []
        for atom in list(atoms):
            told = _threshold(atom, held, self._limits)
            if told is not None:
                thresholds.append(told)
                held[told[0]] = False
                atoms.remove(atom)
        beside = [flag(goal, goals) for goal in atoms]
        read = [goal for goal, found in zip(atoms, beside, strict=True) if found is None]
        flagged = [(goal, *found) for goal, found in zip(atoms, beside, strict=True) if found is not None]
        order: list[tuple[Goal, tuple[str, ...], dict[str, bool]]] = []
        while True:
            # What leaves fewer rows comes first, what may make more of them last.
            for check in [one for one in checks if _named(one) <= held.keys()]:
                checks.remove(check)
                order.append((check, (), dict(held)))
            for denial in [one for one in denials if _named(one) & every <= held.keys()]:
                denials.remove(denial)
                order.append((denial, (), dict(held)))
            if not read:
                break
            # What shares something with what is known comes next.
            atom = next((one for one in read if _linked(one, held)), read[0])
            read.remove(atom)
            columns = tuple(name for one, of, at, name in flagged if stands_beside(one, atom, of, at))
            flagged = [one for one in flagged if not stands_beside(one[0], atom, one[1], one[2])]
            order.append((atom, columns, dict(held)))
            held |= dict.fromkeys(_named(atom) - held.keys(), True)
        steps: list[Join | Check | Denial] = []
        after = set(needed)
        goal: Goal
        for goal, columns, before in reversed(order):
            kept = frozenset(after)
            match goal:
                case Comparison():
                    soft = goal.operator in ORDER and all(lengths.get(name, True) for name in _named(goal))
                    steps.append(Check(goal, soft, kept))
                case Negation():
                    steps.append(self._denial(goal, before, lengths, kept))
                case Atom():
                    steps.append(_join(goal, columns, before, kept))
            after |= _named(goal)
        return Conjunction(mode, tuple(thresholds), tuple(reversed(steps)))

    def _denial(
        self, goal: Negation, before: Mapping[str, bool], lengths: Mapping[str, bool], kept: frozenset[str]
    ) -> Denial:
        inside = {**rule_lengths(goal.goals, self._lengths), **lengths}
        held = frozenset(_named(goal) & before.keys())

        def conjunction(mode: Mode) -> Conjunction:
            given = {ROW: True, **{name: before[name] for name in held}}
            return self._ordered(goal.goals, mode, given, {ROW}, inside)

        return Denial(
            held,
            conjunction("truth") if self._mode == "truth" else None,
            conjunction("near") if self._margins else None,
            kept,
        )


def _named(goal: Goal) -> set[str]:
    return {one.name for one in variables(goal)}


def _linked(goal: Atom, held: Mapping[str, bool]) -> bool:
    return any(isinstance(value, Constant) or held.get(value.name, False) for value in goal.args)


def _threshold(goal: Atom, held: Mapping[str, bool], limits: Collection[str]) -> tuple[str, str] | None:
    """Return the variable and the threshold, where an atom does nothing but name a threshold's value."""
    if goal.predicate != ("threshold", 2):
        return None
    name, value = goal.args
    if not isinstance(name, Constant) or name.value not in limits:
        return None
    if not isinstance(value, Variable) or value.name in held:
        return None
    return value.name, str(name.value)


def _join(goal: Atom, flags: tuple[str, ...], held: Mapping[str, bool], kept: frozenset[str]) -> Join:
    constants: list[tuple[int, Constant]] = []
    repeated: list[tuple[int, int]] = []
    scalars: list[tuple[int, str]] = []
    keys: list[tuple[int, str]] = []
    fresh: dict[str, int] = {}
    for place, value in enumerate(goal.args):
        if isinstance(value, Constant):
            constants.append((place, value))
        elif value.name in fresh:
            repeated.append((place, fresh[value.name]))
        elif value.name not in held:
            fresh[value.name] = place
        elif held[value.name]:
            keys.append((place, value.name))
        else:
            scalars.append((place, value.name))
    return Join(
        goal.predicate, flags, tuple(constants), tuple(repeated), tuple(scalars), tuple(keys),
        tuple((place, name) for name, place in fresh.items() if name in kept), kept,
    )  # fmt: skip
