"""What each argument is, inferred: a name, a string, or a number, and whether that number is a length.

The rules have no declarations, but every base fact has its kinds (:mod:`deixis.ruleset.base`), constants show
theirs, and a variable has one kind wherever it stands. So a name is never compared with a number, and what
three engines think of ``1 == 1.0`` or ``"a" == a`` cannot matter.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence

from deixis.ruleset.base import BASE_FACTS, NO_LENGTH
from deixis.ruleset.model import (
    ORDER,
    Arithmetic,
    Atom,
    Comparison,
    Constant,
    Expression,
    Goal,
    Indicator,
    Kind,
    Negation,
    Place,
    Problem,
    Rule,
    Variable,
    shown,
)

Slot = tuple[Indicator, int] | tuple[int, str]
"""An argument of a predicate, or a variable of a rule (by the rule's position)."""

Tell = Callable[[Problem], None]

_SAYS = {"name": "a name", "number": "a number", "string": "a string"}


class Kinds:
    """Kinds of all arguments and variables of some rules, found by union of what must be the same.

    Parameters
    ----------
    rules : sequence of Rule
    tell : callable
        Called with each problem found.
    """

    def __init__(self, rules: Sequence[Rule], tell: Tell) -> None:
        self._parent: dict[Slot, Slot] = {}
        self._kind: dict[Slot, Kind] = {}
        self._tell = tell
        for predicate, columns in BASE_FACTS.items():
            for position, column in enumerate(columns):
                self._kind[(predicate, position)] = "name" if column == "name" else "number"
        for number, rule in enumerate(rules):
            self._atom(number, rule.head)
            for goal in rule.body:
                self._goal(number, goal)
        for number, rule in enumerate(rules):
            self._numbers(number, rule)

    def of(self, predicate: Indicator) -> tuple[Kind, ...]:
        """Return the kinds of a predicate's arguments; what nothing tells is a name."""
        return tuple(self._known((predicate, position)) or "name" for position in range(predicate[1]))

    def variable(self, rule: int, name: str) -> Kind:
        """Return the kind of a variable of a rule."""
        return self._known((rule, name)) or "name"

    def _find(self, slot: Slot) -> Slot:
        while (parent := self._parent.get(slot, slot)) != slot:
            self._parent[slot] = self._parent.get(parent, parent)
            slot = parent
        return slot

    def _known(self, slot: Slot) -> Kind | None:
        return self._kind.get(self._find(slot))

    def _same(self, one: Slot, other: Slot, place: Place, what: str) -> None:
        first, second = self._find(one), self._find(other)
        if first == second:
            return
        kinds = self._kind.get(first), self._kind.get(second)
        if kinds[0] and kinds[1] and kinds[0] != kinds[1]:
            self._tell(
                Problem(
                    place,
                    f"{what} is {_SAYS[kinds[0]]} here and {_SAYS[kinds[1]]} elsewhere",
                    "each argument and each variable is of one kind",
                )
            )
            return
        self._parent[first] = second
        if kinds[0]:
            self._kind[second] = kinds[0]

    def _is(self, slot: Slot, kind: Kind, place: Place, what: str) -> None:
        known = self._known(slot)
        if known and known != kind:
            self._tell(
                Problem(
                    place,
                    f"{what} is {_SAYS[kind]} here and {_SAYS[known]} elsewhere",
                    _hint(known, kind),
                )
            )
        else:
            self._kind[self._find(slot)] = kind

    def _atom(self, rule: int, atom: Atom) -> None:
        for position, value in enumerate(atom.args):
            slot: Slot = (atom.predicate, position)
            what = f"argument {position + 1} of {shown(atom.predicate)}"
            if isinstance(value, Constant):
                self._is(slot, value.kind, value.place, what)
            else:
                self._same((rule, value.name), slot, value.place, value.name if not value.anonymous else what)

    def _goal(self, rule: int, goal: Goal) -> None:
        match goal:
            case Atom():
                self._atom(rule, goal)
            case Comparison():
                self._comparison(rule, goal)
            case Negation():
                for inner in goal.goals:
                    self._goal(rule, inner)

    def _comparison(self, rule: int, goal: Comparison) -> None:
        if goal.operator in ORDER:
            for side in (goal.left, goal.right):
                self._number(rule, side, goal.operator)
            return
        for side in (goal.left, goal.right):
            if isinstance(side, Arithmetic):
                self._tell(
                    Problem(side.place, f"a sum is compared with {goal.operator}", "write =:= or =\\=")
                )
                return
        left, right = goal.left, goal.right
        if isinstance(left, Variable) and isinstance(right, Variable):
            self._same((rule, left.name), (rule, right.name), goal.place, left.name)
        elif isinstance(left, Variable) and isinstance(right, Constant):
            self._is((rule, left.name), right.kind, right.place, left.name)
        elif isinstance(left, Constant) and isinstance(right, Variable):
            self._is((rule, right.name), left.kind, left.place, right.name)
        else:
            self._tell(Problem(goal.place, "two constants are compared", "leave the comparison out"))

    def _number(self, rule: int, side: Expression, operator: str) -> None:
        match side:
            case Variable():
                self._is((rule, side.name), "number", side.place, side.name)
            case Constant():
                if side.kind != "number":
                    hint = "names are == or \\=="
                    self._tell(Problem(side.place, f"{_SAYS[side.kind]} is compared with {operator}", hint))
            case Arithmetic():
                for operand in side.operands:
                    self._number(rule, operand, operator)

    def _numbers(self, number: int, rule: Rule) -> None:
        """Tell where numbers would have to be equal to the last bit: engines differ on 1 and 1.0."""
        seen: set[str] = set()
        for goal in rule.body:
            if isinstance(goal, Comparison):
                self._equal_numbers(number, goal)
                continue
            for atom in (goal,) if isinstance(goal, Atom) else goal.goals:
                if isinstance(atom, Comparison):
                    self._equal_numbers(number, atom)
                    continue
                for value in atom.args:
                    if isinstance(value, Constant) and value.kind == "number":
                        text = f"the number {value.value:g} is looked up"
                        self._tell(Problem(value.place, text, "write a variable, and compare it with =:="))
                    elif isinstance(value, Variable) and self.variable(number, value.name) == "number":
                        if value.name in seen:
                            text = f"the number {value.name} is looked up"
                            hint = "name it anew here, and compare the two with =:="
                            self._tell(Problem(value.place, text, hint))
                        seen.add(value.name)

    def _equal_numbers(self, rule: int, goal: Comparison) -> None:
        if goal.operator in ORDER or not isinstance(goal.left, (Variable, Constant)):
            return
        side = goal.left if isinstance(goal.left, Variable) else goal.right
        if isinstance(side, Variable) and self.variable(rule, side.name) == "number":
            operator = "=:=" if goal.operator in ("==", "=") else "=\\="
            self._tell(Problem(goal.place, f"numbers are compared with {goal.operator}", f"write {operator}"))


def _hint(known: Kind, kind: Kind) -> str:
    if {known, kind} == {"name", "string"}:
        return "names stand in single quotes, strings in double quotes"
    return "each argument and each variable is of one kind"


def lengths(
    rules: Iterable[Rule], kinds: Mapping[Indicator, Sequence[Kind]]
) -> dict[Indicator, tuple[bool, ...]]:
    """Return for each argument whether it is a length in metres, so that comparing it has a margin.

    A number that can come from something that is no length is none.

    Parameters
    ----------
    rules : iterable of Rule
    kinds : mapping
        Of every predicate, as :meth:`Kinds.of` returns.
    """
    listed = list(rules)
    found = {
        predicate: [kind == "number" for kind in of]
        for predicate, of in kinds.items()
        if predicate not in BASE_FACTS
    }
    for predicate, columns in BASE_FACTS.items():
        found[predicate] = [column == "length" for column in columns]
    changed = True
    while changed:
        changed = False
        for rule in listed:
            known = rule_lengths(rule.body, found)
            head = found[rule.head.predicate]
            for position, value in enumerate(rule.head.args):
                if head[position] and isinstance(value, Variable) and not known.get(value.name, False):
                    head[position], changed = False, True
    return {predicate: tuple(flags) for predicate, flags in found.items()}


def rule_lengths(body: Iterable[Goal], found: Mapping[Indicator, Sequence[bool]]) -> dict[str, bool]:
    """Return for each variable that a goal binds whether it is a length."""
    known: dict[str, bool] = {}
    for goal in body:
        inner = goal.goals if isinstance(goal, Negation) else (goal,)
        for atom in inner:
            if not isinstance(atom, Atom):
                continue
            for value, flag in zip(atom.args, found[atom.predicate], strict=True):
                if isinstance(value, Variable):
                    known.setdefault(value.name, flag and _measured(atom))
    return known


def _measured(atom: Atom) -> bool:
    if atom.predicate != ("threshold", 2):
        return True
    name = atom.args[0]
    return isinstance(name, Constant) and name.value not in NO_LENGTH
