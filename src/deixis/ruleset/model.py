"""What a rule file says, as values: facts, rules and what they are made of, each with its place."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final, Literal

Kind = Literal["name", "number", "string"]
"""Of a value: an atom (every id is one), a double, or text in double quotes."""

Indicator = tuple[str, int]
"""A predicate: its name and how many arguments it has."""

ORDER: Final = frozenset({"<", "=<", ">", ">=", "=:=", "=\\="})
"""Comparisons of numbers."""

SAME: Final = frozenset({"==", "\\==", "=", "\\="})
r"""Comparisons of names or strings, all of them bound: so ``=`` is ``==`` and ``\=`` is ``\==``."""

VIOLATIONS: Final = frozenset({("violation", 2), ("violation", 3)})
"""Predicates that several files of the user's may define together: what breaks which rule (decision 0020)."""

SAYS: Final = ("says", 3)
"""What several files may state too: how their predicates are put in words (decision 0034)."""


@dataclass(frozen=True, slots=True)
class Place:
    """Where something stands: a file, and line and column counted from 1."""

    file: Path
    line: int
    column: int

    def __str__(self) -> str:
        return f"{self.file}:{self.line}:{self.column}"


@dataclass(frozen=True, slots=True)
class Variable:
    """A variable of one rule; each ``_`` has a name of its own that begins with ``_#``."""

    name: str
    place: Place = field(compare=False)

    @property
    def anonymous(self) -> bool:
        """Return whether it is written ``_``."""
        return self.name.startswith("_#")


@dataclass(frozen=True, slots=True)
class Constant:
    """A name, a number or a string that is written in a rule."""

    kind: Kind
    value: str | float
    place: Place = field(compare=False)


Value = Variable | Constant


@dataclass(frozen=True, slots=True)
class Arithmetic:
    """A sum, a difference, or the opposite of a number (one operand)."""

    operator: Literal["+", "-"]
    operands: tuple[Expression, ...]
    place: Place = field(compare=False)


Expression = Variable | Constant | Arithmetic


@dataclass(frozen=True, slots=True)
class Atom:
    """A predicate with its arguments: ``touches(A, B)``."""

    name: str
    args: tuple[Value, ...]
    place: Place = field(compare=False)

    @property
    def predicate(self) -> Indicator:
        """Return the name and the number of arguments."""
        return self.name, len(self.args)


@dataclass(frozen=True, slots=True)
class Comparison:
    """Two values and how they must compare."""

    operator: str
    left: Expression
    right: Expression
    place: Place = field(compare=False)


@dataclass(frozen=True, slots=True)
class Negation:
    r"""``\+ goal`` or ``\+ ( goal, ... )``: variables that stand only here mean "any"."""

    goals: tuple[Atom | Comparison, ...]
    place: Place = field(compare=False)


Goal = Atom | Comparison | Negation


@dataclass(frozen=True, slots=True)
class Rule:
    """A head and the goals it follows from; a fact has none."""

    head: Atom
    body: tuple[Goal, ...]
    doc: str = field(default="", compare=False)

    @property
    def place(self) -> Place:
        """Return where it begins."""
        return self.head.place


@dataclass(frozen=True, slots=True)
class RuleFile:
    """One file.

    Attributes
    ----------
    path : Path
    module : str or None
        Name of the module it declares; without one all it defines is seen by every question.
    exports : tuple of Indicator
        What the module offers.
    imports : tuple of (str, Place)
        The files named by ``use_module``, without libraries.
    declared : tuple of (Indicator, Place)
        Predicates declared dynamic: they may have no clause.
    rules : tuple of Rule
        In the order of the file.
    docs : dict
        The comment in front of each predicate, by indicator.
    """

    path: Path
    module: str | None
    exports: tuple[Indicator, ...]
    imports: tuple[tuple[str, Place], ...]
    declared: tuple[tuple[Indicator, Place], ...]
    rules: tuple[Rule, ...]
    docs: dict[Indicator, str]


@dataclass(frozen=True, slots=True)
class Problem:
    """What is wrong with a rule file, where, and what to do about it."""

    place: Place
    message: str
    hint: str = ""
    warning: bool = False

    def __str__(self) -> str:
        kind = "warning: " if self.warning else ""
        return f"{self.place}: {kind}{self.message}" + (f" ({self.hint})" if self.hint else "")


def variables(part: Goal | Expression) -> Iterator[Variable]:
    """Yield the variables of a goal or expression from left to right, repetitions included."""
    match part:
        case Variable():
            yield part
        case Atom():
            for value in part.args:
                yield from variables(value)
        case Arithmetic():
            for operand in part.operands:
                yield from variables(operand)
        case Comparison():
            yield from variables(part.left)
            yield from variables(part.right)
        case Negation():
            for goal in part.goals:
                yield from variables(goal)


def atoms(body: tuple[Goal, ...]) -> Iterator[tuple[Atom, bool]]:
    """Yield the atoms of a body, each with whether it is denied."""
    for goal in body:
        match goal:
            case Atom():
                yield goal, False
            case Negation():
                yield from ((inner, True) for inner in goal.goals if isinstance(inner, Atom))


def shown(predicate: Indicator) -> str:
    """Return a predicate as Prolog writes it.

    Examples
    --------
    >>> shown(("touches", 2))
    'touches/2'
    """
    return f"{predicate[0]}/{predicate[1]}"
