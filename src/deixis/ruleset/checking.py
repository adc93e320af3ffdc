"""Rule files together: a checked set of rules, or all that is wrong with it."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from functools import cached_property
from pathlib import Path
from typing import Any, Final

from deixis.errors import RuleError
from deixis.hints import either
from deixis.ruleset.base import BASE_FACTS
from deixis.ruleset.graph import Graph
from deixis.ruleset.kinds import Kinds, lengths
from deixis.ruleset.model import (
    SAYS,
    VIOLATIONS,
    Indicator,
    Kind,
    Place,
    Problem,
    Rule,
    RuleFile,
    atoms,
    shown,
)
from deixis.ruleset.reading import read_file
from deixis.ruleset.reserved import reserved
from deixis.ruleset.safety import unsafe

_MOST_GUESSES: Final = 20
"""Of what may have been meant, in a file: each takes a look at all names."""

_LONGEST_WAY: Final = 12


@dataclass(frozen=True)
class Ruleset:
    """Rules that are safe, stratified and of known kinds, ready to be run by any engine.

    Attributes
    ----------
    files : tuple of RuleFile
        The theory's, then the user's.
    rules : tuple of Rule
        Of all files.
    kinds : dict
        The kind of each argument of each predicate, base facts included.
    user : frozenset of Indicator
        What the user's files define.
    """

    files: tuple[RuleFile, ...]
    rules: tuple[Rule, ...]
    kinds: dict[Indicator, tuple[Kind, ...]]
    user: frozenset[Indicator]

    @cached_property
    def plans(self) -> dict[Any, Any]:
        """Return what is known already of how to derive what: see :meth:`deixis.ruleset.plan.Plan.of`."""
        return {}

    @cached_property
    def graph(self) -> Graph:
        """Return which predicate rests on which."""
        return Graph.of(self.rules)

    @cached_property
    def lengths(self) -> dict[Indicator, tuple[bool, ...]]:
        """Return for each argument whether it is a length."""
        return lengths(self.rules, self.kinds)

    @cached_property
    def by_head(self) -> dict[Indicator, tuple[Rule, ...]]:
        """Return the rules of each predicate that is no base fact, in the order of the files."""
        found: dict[Indicator, list[Rule]] = {one: [] for one in self.kinds if one not in BASE_FACTS}
        for rule in self.rules:
            found[rule.head.predicate].append(rule)
        return {one: tuple(rules) for one, rules in found.items()}

    @cached_property
    def docs(self) -> dict[Indicator, str]:
        """Return the comment in front of each predicate."""
        return {one: text for file in reversed(self.files) for one, text in file.docs.items()}


def examine(theory: Sequence[Path], user: Sequence[Path] = ()) -> tuple[Ruleset, list[Problem]]:
    """Return the rules of some files, and all that is wrong with them.

    Parameters
    ----------
    theory : sequence of path
        Files that may define anything.
    user : sequence of path
        Files that may define what the theory does not.

    Raises
    ------
    RuleError
        A file does not exist or is no text.
    """
    problems: list[Problem] = []
    files = []
    for path in (*theory, *user):
        file, found = read_file(path)
        files.append(file)
        problems += found
    ruleset, found = assemble(files[: len(theory)], files[len(theory) :], partial=bool(problems))
    return ruleset, problems + found


def load(theory: Sequence[Path], user: Sequence[Path] = ()) -> Ruleset:
    """Return the rules of some files.

    Raises
    ------
    RuleError
        With all that is wrong with them, each with its place and what to do.
    """
    ruleset, problems = examine(theory, user)
    refuse(problems)
    return ruleset


def refuse(problems: Iterable[Problem]) -> None:
    """Raise :class:`RuleError` if there is any problem."""
    listed = [str(one) for one in problems]
    if listed:
        raise RuleError("\n  ".join(["the rule files are not as they should be:", *listed]))


def assemble(
    theory: Sequence[RuleFile], user: Sequence[RuleFile] = (), *, partial: bool = False
) -> tuple[Ruleset, list[Problem]]:
    """Return the rules of files that were read, and all that is wrong with them.

    Parameters
    ----------
    partial : bool
        Whether clauses are missing that could not be read: then what is not defined may be defined there.
    """
    problems: list[Problem] = []
    owners = dict.fromkeys(BASE_FACTS, "the base facts")
    for file in theory:
        _own(file, owners, f"the theory, in {file.path.name}")
    problems += _taken(user, owners)
    files = (*theory, *user)
    rules = tuple(rule for file in files for rule in file.rules)
    declared = {one for file in files for one, _ in file.declared}
    known = declared | set(BASE_FACTS) | {rule.head.predicate for rule in rules}
    for file in files:
        problems += _apart(file)
        problems += _unknown(file, files, known, partial)
    for rule in rules:
        problems += unsafe(rule)
    kinds = Kinds(rules, problems.append)
    used = known | {atom.predicate for rule in rules for atom, _ in atoms(rule.body)}
    mine = {one for file in user for one, _ in file.declared} | {
        r.head.predicate for f in user for r in f.rules
    }
    ruleset = Ruleset(files, rules, {one: kinds.of(one) for one in sorted(used)}, frozenset(mine))
    problems += _unstratified(ruleset.graph)
    problems.sort(key=lambda one: (files_order(files, one), one.place.line, one.place.column, one.warning))
    return ruleset, list(_first_at_each_place(problems))


def _first_at_each_place(problems: Iterable[Problem]) -> Iterator[Problem]:
    """Yield the problems without those that stand where another one does: one cause, one message."""
    seen: set[Place] = set()
    for one in problems:
        if one.place not in seen:
            seen.add(one.place)
            yield one


def files_order(files: Sequence[RuleFile], problem: Problem) -> int:
    """Return the position of a problem's file."""
    return next((at for at, file in enumerate(files) if file.path == problem.place.file), len(files))


def _own(file: RuleFile, owners: dict[Indicator, str], owner: str) -> None:
    for predicate in [one for one, _ in file.declared] + [rule.head.predicate for rule in file.rules]:
        owners.setdefault(predicate, owner)


def _taken(user: Sequence[RuleFile], owners: dict[Indicator, str]) -> Iterator[Problem]:
    """Yield where a user's file defines what belongs to something else, and remember what is its own."""
    for file in user:
        told = set()
        places = [*file.declared, *((rule.head.predicate, rule.place) for rule in file.rules)]
        for predicate, place in places:
            if predicate == SAYS:
                continue
            if predicate in VIOLATIONS:
                if file.module is not None and predicate not in told:
                    told.add(predicate)
                    hint = "leave :- module(...) out: several files may state violations"
                    yield Problem(place, f"{shown(predicate)} is defined in a module", hint)
                continue
            owner = owners.get(predicate) or reserved(predicate)
            if owner and predicate not in told:
                told.add(predicate)
                yield Problem(place, f"{shown(predicate)} belongs to {owner}", "give yours another name")
        _own(file, owners, f"{file.path}")


def _apart(file: RuleFile) -> Iterator[Problem]:
    """Yield where the clauses of a predicate do not stand together."""
    seen: set[Indicator] = set()
    last: Indicator | None = None
    for rule in file.rules:
        predicate = rule.head.predicate
        if predicate != last and predicate in seen:
            hint = "Prolog wants all clauses of a predicate side by side"
            yield Problem(rule.place, f"clauses of {shown(predicate)} are not together", hint)
        seen.add(predicate)
        last = predicate


def _unknown(
    file: RuleFile, files: Sequence[RuleFile], known: set[Indicator], partial: bool
) -> Iterator[Problem]:
    """Yield what a file calls, imports or exports that is not there."""
    by_name = {one.path.stem: one for one in files}
    own = {one for one, _ in file.declared} | {rule.head.predicate for rule in file.rules}
    seen = set(own)
    guesses = 0
    for name, place in file.imports:
        imported = by_name.get(Path(name).stem)
        if imported is None:
            hint = _did_you_mean(Path(name).stem, list(by_name)) or "give its file beside this one"
            yield Problem(place, f"no rule file {name!r} is loaded", hint)
        else:
            seen |= set(imported.exports) or {rule.head.predicate for rule in imported.rules}
    if not partial:
        for predicate in file.exports:
            if predicate not in known and file.rules:
                place = file.rules[0].place
                yield Problem(place, f"{shown(predicate)} is exported and not defined", "define it")
    for rule in file.rules:
        for atom, _ in atoms(rule.body):
            if atom.predicate not in known:
                if not partial or not any(atom.predicate in one.exports for one in files):
                    guesses += 1
                    hint = _meant(atom.predicate, known) if guesses <= _MOST_GUESSES else ""
                    yield Problem(atom.place, f"{shown(atom.predicate)} is not defined", hint)
            elif file.module is not None and atom.predicate not in seen:
                owner = next((one for one in files if atom.predicate in _defines(one)), None)
                what = f":- use_module({owner.path.stem})" if owner else ""
                text = f"{shown(atom.predicate)} is not imported"
                yield Problem(atom.place, text, f"write {what}" if what else "")


def _defines(file: RuleFile) -> set[Indicator]:
    return {one for one, _ in file.declared} | {rule.head.predicate for rule in file.rules}


def _meant(predicate: Indicator, known: set[Indicator]) -> str:
    name, arity = predicate
    same = sorted(other for other_name, other in known if other_name == name)
    if same:
        counts = either([*map(str, same)])
        return f"{name} has {counts} argument{'s' if same != [1] else ''}"
    close = get_close_matches(name, sorted({other for other, _ in known}), n=3)
    found = [shown((other, count)) for one in close for other, count in sorted(known) if other == one]
    if found:
        return f"did you mean {either(found[:3])}?"
    return f"define it, or write :- dynamic {shown((name, arity))}."


def _did_you_mean(name: str, known: Sequence[str]) -> str:
    close = get_close_matches(name, known, n=1)
    return f"did you mean {close[0]}?" if close else ""


def _unstratified(graph: Graph) -> Iterator[Problem]:
    for edge, way in graph.denied_cycles():
        named = [shown(one) for one in (edge.head, *way)]
        if len(named) > _LONGEST_WAY:
            named[_LONGEST_WAY // 2 : -_LONGEST_WAY // 2] = ["..."]
        yield Problem(
            edge.place,
            f"{shown(edge.head)} rests on its own denial: {' needs '.join(named)}",
            "no order derives it: break the circle",
        )
