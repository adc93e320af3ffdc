r"""Python values as Prolog text that reads back as the same value, whatever its characters.

The one rule for text: between quotes, every character that is not a letter, a digit or harmless ASCII
punctuation is written as ``\xHH\`` or ``\UHHHHHHHH``. There is no other way from an id to Prolog text
in this package.
"""

from __future__ import annotations

import math
import re
from fractions import Fraction
from typing import Final

from deixis.errors import QueryError
from deixis.prolog.terms import Atom, Compound, Term, Variable

# Quotes, the backslash, everything invisible and every surrogate stay out; \w is letters, digits and _.
_UNSAFE: Final = re.compile(r"[^\w !#$%&()*+,\-./:;<=>?@\[\]^{|}~]")

_PLAIN_ID: Final = re.compile(r"[a-z][a-z_]*[0-9]+")

_MOST_DIGITS_BITS: Final = 4096
"""Integers longer than this are written in hexadecimal: Python refuses to print very long decimals."""


def atom(text: str) -> str:
    r"""Return the quoted atom of these characters.

    Raises
    ------
    QueryError
        The text holds half a surrogate pair, which is no character.

    Examples
    --------
    >>> print(atom("O'Hara\n"))
    'O\x27\Hara\xa\'
    """
    return f"'{_body(text)}'"


def id_atom(text: str) -> str:
    """Return the atom of an id: without quotes, which reads faster, where it is like ``cup12``.

    Letters and then a digit: no operator of Prolog looks like that.

    Raises
    ------
    QueryError
        The text holds half a surrogate pair, which is no character.

    Examples
    --------
    >>> print(id_atom("cup12"), id_atom("mod"), id_atom("Cup 12"))
    cup12 'mod' 'Cup 12'
    """
    return text if _PLAIN_ID.fullmatch(text) else atom(text)


def string(text: str) -> str:
    """Return the quoted Prolog string of these characters.

    Raises
    ------
    QueryError
        The text holds half a surrogate pair, which is no character.

    Examples
    --------
    >>> print(string("cup"))
    "cup"
    """
    return f'"{_body(text)}"'


def number(value: float | Fraction) -> str:
    """Return the text of a finite number; an integer stays an integer, a float a float.

    Raises
    ------
    QueryError
        The number is not finite, or is a truth value.

    Examples
    --------
    >>> number(1e-05), number(7), number(1e22)
    ('1e-05', '7', '1e+22')
    """
    if isinstance(value, bool) or not isinstance(value, (int, float, Fraction)):
        raise QueryError(f"{value!r} is not a number")
    if isinstance(value, Fraction):
        return f"{value.numerator}r{value.denominator}"
    if isinstance(value, int):
        return str(int(value)) if value.bit_length() <= _MOST_DIGITS_BITS else hex(value)
    if not math.isfinite(value):
        # Written as nan or inf it would be an atom, as NaN or Infinity a variable that matches anything.
        raise QueryError(f"{value!r} is not a finite number")
    return repr(float(value))


def term(value: Term) -> str:
    """Return the text of a term; each kind of variable name stands for one variable of the text.

    Raises
    ------
    QueryError
        A number is not finite, a text holds half a surrogate pair, or a value stands for no term.

    Examples
    --------
    >>> print(term([Atom("cup1"), "cup1", Compound("at", (0.5,))]))
    ['cup1',"cup1",'at'(0.5)]
    """
    match value:
        case Atom():
            return atom(value)
        case str():
            return string(value)
        case list():
            return f"[{','.join(map(term, value))}]"
        case Compound(functor, args):
            return f"{atom(functor)}({','.join(map(term, args))})"
        case Variable(name):
            return f"V{''.join(f'{ord(character):x}_' for character in name)}"
        case int() | float() | Fraction():
            return number(value)
    raise QueryError(f"{value!r} stands for no Prolog term")


def _body(text: str) -> str:
    return _UNSAFE.sub(_escape, text) if _UNSAFE.search(text) else text


def _escape(found: re.Match[str]) -> str:
    code = ord(found[0])
    if 0xD800 <= code <= 0xDFFF:
        raise QueryError(f"the text {found.string!r} holds half a surrogate pair: give whole characters")
    # 9.0.4 takes \xd8000\, read digit by digit, for half a surrogate pair.
    return f"\\x{code:x}\\" if code <= 0xFFFF else f"\\U{code:08x}"
