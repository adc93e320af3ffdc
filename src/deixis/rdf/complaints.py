"""What the parser of SPARQL says of a text it cannot read, for people."""

from __future__ import annotations

import re
from itertools import islice
from typing import Final

from deixis.rdf.layout import TERM
from deixis.rdf.namespaces import PREFIXES

_PLACE: Final = re.compile(r"error at (\d+):(\d+): expected (.*)", re.DOTALL)

_PHRASE: Final = re.compile(r"[A-Z]\w+ (?:[\w']+ ?){2,}")
"""Among the signs and alphabets that the parser would have liked: what is said in words."""

_PREFIXED: Final = re.compile(r"(?<![\w?$<:.\-])((?:[^\W\d_][\w.\-]*)?):")

_OTHER: Final = re.compile(r"""<[^<>\s]*>|"[^"]*"|'[^']*'""")
"""Where a colon ends no prefix."""

_KNOWN: Final = {**PREFIXES, "deixis": TERM}

_MOST_NAMES: Final = 9
"""Prefixes that are looked for, the last first."""

_SHOWN: Final = 40
"""Characters of the text that are shown before the place."""

_MOST: Final = 300
"""Characters of a complaint that is told as it is."""


def complaint(error: Exception, text: str) -> str:
    r"""Return what is wrong with a query or update, and where.

    Parameters
    ----------
    error : Exception
        What the parser raised.
    text : str
        What it read.

    Examples
    --------
    >>> complaint(SyntaxError("error at 1:10: expected CONSTRUCT"), "SELEC * {}")
    'a syntax error at line 1, column 10, after "SELEC * {"'
    >>> complaint(SyntaxError("error at 1:20: expected Prefix not found"), "ASK { ?a rdfs:label ?b }")
    'the prefix rdfs: is not declared; begin with PREFIX rdfs: <http://www.w3.org/2000/01/rdf-schema#>'
    """
    told = str(error.args[0] if error.args else error)
    place = _PLACE.match(told)
    if place is None:
        return " ".join(told.split())[:_MOST]
    line, column = int(place[1]), int(place[2])
    lines = text.split("\n")
    written = lines[line - 1] if line <= len(lines) else ""
    before, after = written[: column - 1], written[column - 1 :]
    names = _PREFIXED.findall(_OTHER.sub(" ", before + ":" if after.startswith(":") else before))
    for name in islice(dict.fromkeys(reversed(names)), _MOST_NAMES):
        if not re.search(rf"(?i)\bprefix\s+{re.escape(name)}:", text):
            return (
                f"the prefix {name}: is not declared; begin with PREFIX {name}: <{_KNOWN.get(name, '...')}>"
            )
    reasons = [one.strip() for one in _PHRASE.findall(place[3]) if one.strip() != "Prefix not found"]
    where = f'a syntax error at line {line}, column {column}, after "{before[-_SHOWN:]}"'
    return "; ".join([where, *reasons])
