"""Inspections: which rules a scene breaks, which things break them, and why.

A rule file states a breach as a clause of ``violation/2`` or ``violation/3``: the name of the rule, the thing
at fault, and another thing that is needed to see why. ``rules/safety.pl`` is an example.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from deixis.errors import RuleError
from deixis.explain import Answer, Proof
from deixis.prolog.quote import term
from deixis.prolog.terms import Atom, Compound
from deixis.relations import rounded
from deixis.render import Shown
from deixis.render.html import Part
from deixis.ruleset.model import VIOLATIONS, Constant

if TYPE_CHECKING:
    from deixis.engines import Found
    from deixis.ruleset import Ruleset
    from deixis.scene import Scene


@dataclass(frozen=True, slots=True)
class Checked:
    """A rule that was checked.

    Attributes
    ----------
    rule : str
        Its name.
    says : str
        The last paragraph of the comment in front of its first clause.
    file : str
        Name of the rule file.
    line : int
        First line of the first clause.
    """

    rule: str
    says: str
    file: str
    line: int

    def to_dict(self) -> dict[str, Any]:
        """Return the rule as a dict, ready for JSON."""
        return {"rule": self.rule, "says": self.says, "file": self.file, "line": self.line}


@dataclass(frozen=True, slots=True)
class Violation:
    """A breach of a rule.

    Attributes
    ----------
    rule : str
        Name of the rule.
    things : tuple of str
        Ids: the thing at fault, and another where the rule names one.
    margin : float or None
        Metres by which a measured length would have to change for the breach to cease; None where no
        length decides.
    text : str
        The breach in one sentence.
    proof : Proof or None
        Why; None where no reasons were asked for.
    """

    rule: str
    things: tuple[str, ...]
    margin: float | None
    text: str
    proof: Proof | None

    def to_dict(self) -> dict[str, Any]:
        """Return the breach as nested dicts, ready for JSON."""
        return {
            "rule": self.rule,
            "things": list(self.things),
            "margin": self.margin,
            "text": self.text,
            "proof": None if self.proof is None else self.proof.to_dict(),
        }


@dataclass(frozen=True, slots=True)
class Inspection(Shown):
    """What was checked in a scene, and what is wrong there.

    Attributes
    ----------
    scene : str
    view : str or None
        The only view that was looked from; None for all.
    checked : tuple of Checked
        The rules, in the order of their files.
    things : int
        How many objects and surfaces the scene has.
    violations : tuple of Violation
        In the order of the rules, then by ids.
    """

    scene: str
    view: str | None
    checked: tuple[Checked, ...]
    things: int
    violations: tuple[Violation, ...]

    @property
    def passed(self) -> bool:
        """Return whether no rule is broken."""
        return not self.violations

    def summary(self) -> str:
        """Return in a line what was checked, and with what result.

        Examples
        --------
        >>> Inspection("room", None, (), 3, ()).summary()
        '0 rules checked on 3 things: no violation'
        """
        count = len(self.violations)
        found = f"{count} violation{'s' * (count > 1)}" if count else "no violation"
        rules = f"{len(self.checked)} rule{'s' * (len(self.checked) != 1)}"
        return f"{rules} checked on {self.things} thing{'s' * (self.things != 1)}: {found}"

    def parts(self) -> list[Part]:
        """Return each breach with its proof below it, and what was checked."""
        breaches: list[Part] = [
            (f"{one.rule}: {one.text}", [] if one.proof is None else [one.proof]) for one in self.violations
        ]
        return [*breaches, (f"{self.summary()}.", [])]

    def to_dict(self) -> dict[str, Any]:
        """Return the inspection as nested dicts, ready for JSON."""
        return {
            "scene": self.scene,
            "view": self.view,
            "checked": {"rules": [one.to_dict() for one in self.checked], "things": self.things},
            "violations": [one.to_dict() for one in self.violations],
        }


def inspect(
    scene: Scene, ruleset: Ruleset, breaches: Iterable[Found], why: Callable[[str], Answer] | None
) -> Inspection:
    """Return an inspection from the breaches that were derived, with reasons where ``why`` is given."""
    checked = stated(ruleset)
    violations = []
    for (name, _), row, margin in in_order(breaches, checked):
        text, proof = f"{name}({', '.join(row)})", None
        if why is not None:
            proof = why(term(Compound(name, tuple(map(Atom, row))))).proof
            text = text if proof is None else proof.text
        violations.append(Violation(row[0], row[1:], rounded(margin), text, proof))
    return Inspection(scene.id, None, checked, len(scene.objects), tuple(violations))


def stated(ruleset: Ruleset) -> tuple[Checked, ...]:
    """Return the rules whose breaches the user's files state, in the order of the files.

    Raises
    ------
    RuleError
        There is none, or one has no name.
    """
    found: dict[str, Checked] = {}
    for rule in ruleset.rules:
        if rule.head.predicate not in VIOLATIONS:
            continue
        name = rule.head.args[0]
        if not isinstance(name, Constant) or name.kind != "name":
            raise RuleError(
                f"{name.place}: a violation begins with the name of its rule, as in violation(hot, T)"
            )
        says = " ".join(rule.doc.split("\n\n")[-1].split())
        place = rule.place
        found.setdefault(str(name.value), Checked(str(name.value), says, place.file.name, place.line))
    if not found:
        raise RuleError(
            "no rule file states a violation: write violation(name_of_the_rule, Thing) :- ..., "
            "or give no rule file for the rules of safety"
        )
    return tuple(found.values())


def in_order(rows: Iterable[Found], checked: Sequence[Checked]) -> list[Found]:
    """Return the breaches that were derived, in the order of the rules, then by ids."""
    order = {one.rule: position for position, one in enumerate(checked)}
    return sorted(rows, key=lambda found: (order[found[1][0]], found[1][1:]))
