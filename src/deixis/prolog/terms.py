"""Prolog terms as Python values, so that nothing is lost on the way: an atom is not a string.

=====================  ===========================
Prolog                 Python
=====================  ===========================
atom                   :class:`Atom`, a ``str``
string                 ``str``
integer of any size    ``int``
float                  ``float``
rational               ``fractions.Fraction``
list                   ``list``
compound               :class:`Compound`
unbound variable       :class:`Variable`
=====================  ===========================
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import TypeAlias

from deixis.errors import EngineError


class Atom(str):
    """An atom: equal to the ``str`` of the same characters, and still told apart by its class.

    Examples
    --------
    >>> Atom("cup1")
    Atom('cup1')
    >>> Atom("cup1") == "cup1"
    True
    """

    __slots__ = ()

    def __repr__(self) -> str:
        return f"Atom({str.__repr__(self)})"


@dataclass(frozen=True, slots=True)
class Variable:
    """An unbound variable, by the name the question gave it; ``_1``, ``_2`` where it gave none."""

    name: str


@dataclass(frozen=True, slots=True)
class Compound:
    """A compound term.

    Examples
    --------
    >>> Compound("at", (Atom("cup1"), 0.5)).functor
    'at'
    """

    functor: str
    args: tuple[Term, ...]


Term: TypeAlias = "Atom | str | int | float | Fraction | Variable | Compound | list[Term]"


def decode(value: object) -> Term:
    """Return the term that a decoded JSON value of the bridge stands for.

    Atoms come as ``["a", name]``, compounds as ``["c", functor, argument ...]``, lists as
    ``["l", item ...]``, variables as ``["v", name]``; integers beyond 60 bits, rationals and floats that
    are not finite, which JSON lacks, as ``["i", hex]``, ``["r", hex, hex]`` and ``["f", name]``.

    Raises
    ------
    EngineError
        The value stands for no term.

    Examples
    --------
    >>> decode(["c", "at", ["a", "cup1"], 0.5])
    Compound(functor='at', args=(Atom('cup1'), 0.5))
    """
    match value:
        case str() | int() | float():
            return value
        case ["a", str(name)]:
            return Atom(name)
        case ["l", *items]:
            return [decode(item) for item in items]
        case ["c", str(functor), *args]:
            return Compound(functor, tuple(decode(arg) for arg in args))
        case ["v", str(name)]:
            return Variable(name)
        case ["i", str(digits)]:
            return int(digits, 16)
        case ["r", str(over), str(under)]:
            return Fraction(int(over, 16), int(under, 16))
        case ["f", str(name)]:
            return float(name)
    raise EngineError(f"the bridge sent {value!r}, which stands for no term")
