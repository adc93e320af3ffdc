"""Names that a user's rule file cannot define, since SWI-Prolog or our own Prolog files have them."""

from __future__ import annotations

from functools import cache
from importlib.resources import files

from deixis._files import rules_dir
from deixis.ruleset.clauses import Clause, Lines, clauses
from deixis.ruleset.model import Indicator
from deixis.ruleset.syntax import Raw, SyntaxProblem, read_clause

PROLOG_ONLY = ("axioms", "explain")
"""Files of the theory that are ordinary Prolog, outside the subset; what they export is taken."""

SHELL = ("shell", "guess", "manual")
"""The same of the shell."""


def reserved(predicate: Indicator) -> str:
    """Return whose a predicate is, or the empty text where it is free.

    Examples
    --------
    >>> reserved(("why", 1)), reserved(("atom_length", 2)), reserved(("wobbly", 1))
    ('the theory, in explain.pl', 'Prolog itself', '')
    """
    if f"{predicate[0]}/{predicate[1]}" in _system():
        return "Prolog itself"
    return _exports().get(predicate, "")


@cache
def _system() -> frozenset[str]:
    text = files("deixis.ruleset").joinpath("prolog_names.txt").read_text(encoding="utf-8")
    return frozenset(text.split())


@cache
def _exports() -> dict[Indicator, str]:
    found = {}
    for stem in (*PROLOG_ONLY, *SHELL):
        path = rules_dir() / f"{stem}.pl"
        text = path.read_text(encoding="utf-8")
        first = next(iter(clauses(text, Lines(path, text))))
        for predicate in _exported(first.text) if isinstance(first, Clause) else ():
            found[predicate] = f"the theory, in {path.name}"
    return found


def _exported(text: str) -> list[Indicator]:
    """Return what a module/2 directive exports."""
    try:
        raw = read_clause(text)
    except SyntaxProblem:
        return []
    exports: tuple[Raw, ...] = raw.parts[0].parts[1].parts if raw.kind == "directive" else ()
    return [(one.parts[0].text, int(one.parts[1].text)) for one in exports]
