"""Prolog terms for people and for JSON."""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Any, Final

from deixis.prolog.quote import atom, number, string
from deixis.prolog.terms import Atom, Compound, Term, Variable

_SAFE_INTEGER: Final = 2**53


def term_text(term: Term) -> str:
    """Return a term as Prolog text; what a terminal might obey is escaped.

    Examples
    --------
    >>> term_text(Compound("at", (Atom("Cup 1"), 0.5)))
    "at('Cup 1',0.5)"
    """
    match term:
        case Atom():
            return _bare(term)
        case str():
            return string(term)
        case Variable():
            return term.name
        case Fraction():
            return f"{term.numerator}r{term.denominator}"
        case Compound():
            return f"{_bare(term.functor)}({','.join(map(term_text, term.args))})"
        case list():
            return f"[{','.join(map(term_text, term))}]"
        case int():
            return number(term)
        case float():
            return repr(term)


def _bare(name: str) -> str:
    """Return an atom's text without quotes where Prolog needs none."""
    plain = name.isascii() and name[:1].islower() and name.replace("_", "a").isalnum()
    return name if plain else atom(name)


def term_json(term: Term) -> Any:
    """Return a term as a JSON value: atoms and strings as strings, numbers as numbers, compounds as objects.

    Examples
    --------
    >>> term_json(Compound("at", (Atom("cup"), 0.5)))
    {'functor': 'at', 'args': ['cup', 0.5]}
    """
    match term:
        case Variable():
            return {"variable": term.name}
        case Fraction():
            return {"numerator": term.numerator, "denominator": term.denominator}
        case Compound():
            return {"functor": term.functor, "args": [term_json(one) for one in term.args]}
        case list():
            return [term_json(one) for one in term]
        case str():
            return str(term)
        case float() if not math.isfinite(term):
            # JSON has no such numbers.
            return str(term)
        case int() if abs(term) > _SAFE_INTEGER:
            # Most readers of JSON take numbers for float64.
            return number(term)
        case _:
            return term
