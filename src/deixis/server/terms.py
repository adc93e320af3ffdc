"""Terms of ours in a query that there are none of: it is answered, with no rows, and its asker is told."""

from __future__ import annotations

import re
from collections.abc import Iterator
from difflib import get_close_matches
from functools import cache
from typing import Final
from urllib.parse import quote

from deixis.rdf.functions import DOCUMENTED
from deixis.rdf.layout import TERM
from deixis.rdf.ontology import ontology
from deixis.server.screening import Screened, Token
from deixis.vocabulary import BY_NAME

_MOST: Final = 5
"""Terms that are told: a header is no place for more."""

_LONGEST: Final = 60
"""Characters of a term that are told."""

_OF_RULES: Final = re.compile(r"\.\d+$")
"""How terms end that are predicates of rules: their number of arguments."""

_ESCAPE: Final = re.compile(r"\\(.)")


@cache
def _known() -> frozenset[str]:
    """Return the terms of the ontology, and the functions."""
    stated = re.findall(r"^:(\S+) a ", ontology(), re.MULTILINE)
    return frozenset((*stated, *(one.name for one in DOCUMENTED)))


@cache
def _small() -> dict[str, str]:
    """Return the same by their small letters: of a property and a class the property, asked for more."""
    return {name.lower(): name for name in sorted(_known())}


def unknown_terms(query: Screened) -> list[str]:
    """Return a note on each term in our namespace that neither ontology nor functions have.

    Predicates of rules, such as ``violation.2``, may be anything.

    Examples
    --------
    >>> from deixis.server.screening import screen
    >>> unknown_terms(screen("PREFIX d: <urn:deixis:term:> ASK { ?a d:left_of ?b; d:near ?c }", 99, 9))
    ['unknown term left_of: did you mean leftOf?']
    """
    known = _known()
    found = [
        name
        for name in dict.fromkeys(_terms(query.tokens))
        if name and name not in known and not _OF_RULES.search(name)
    ]
    return [f"unknown term {quote(name[:_LONGEST], safe='')}{_hint(name)}" for name in found[:_MOST]]


def _hint(name: str) -> str:
    known = _small()
    meant = BY_NAME[name].rdf if name in BY_NAME else known.get(name.lower())
    if meant is None:
        close = get_close_matches(name[:_LONGEST].lower(), known, n=1)
        meant = known[close[0]] if close else None
    return "" if meant is None else f": did you mean {meant}?"


def _terms(parts: tuple[Token, ...]) -> Iterator[str]:
    """Yield the names in our namespace, by its prefix or written out."""
    prefixes: dict[str, str] = {}
    for at, one in enumerate(parts):
        before = parts[at - 1] if at else None
        if one.kind == "iri":
            iri = one.text[1:-1]
            if before is not None and before.kind == "prefixed" and at > 1 and parts[at - 2].word == "PREFIX":
                prefixes[before.text] = iri
            elif iri.startswith(TERM):
                yield iri.removeprefix(TERM)
        elif one.kind == "prefixed":
            prefix, _, local = one.text.rstrip(".").partition(":")
            iri = prefixes.get(f"{prefix}:", "") + _ESCAPE.sub(r"\1", local)
            if iri.startswith(TERM):
                yield iri.removeprefix(TERM)
