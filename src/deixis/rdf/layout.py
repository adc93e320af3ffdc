"""How facts and relations look as RDF.

=====================  ==========================================================================
a name                 ``urn:deixis:id:NAME``, percent-encoded; a string ``urn:deixis:text:...``
one argument           ``NAME rdf:type TERM``
two arguments          ``NAME TERM VALUE``
more, or number first  a node of its own: ``NODE rdf:type TERM``, ``NODE TERM.1 VALUE`` ...
a number               a literal of type ``xsd:double``
=====================  ==========================================================================

TERM is ``urn:deixis:term:`` and the vocabulary's word for RDF, or name and number of arguments.
"""

from __future__ import annotations

from typing import Final
from urllib.parse import quote, unquote

from deixis.ruleset import Indicator, Kind
from deixis.vocabulary import BY_NAME

ID: Final = "urn:deixis:id:"
TEXT: Final = "urn:deixis:text:"
TERM: Final = "urn:deixis:term:"
NODE: Final = "urn:deixis:node:"
TYPE: Final = "http://www.w3.org/1999/02/22-rdf-syntax-ns#type"
DOUBLE: Final = "http://www.w3.org/2001/XMLSchema#double"


def iri(kind: Kind, text: str) -> str:
    """Return the IRI of a name or a string.

    Examples
    --------
    >>> iri("name", "O'Hara <x>"), text_of(iri("name", "O'Hara <x>"))
    ('urn:deixis:id:O%27Hara%20%3Cx%3E', "O'Hara <x>")
    """
    return (TEXT if kind == "string" else ID) + quote(text, safe="")


def text_of(found: str) -> str:
    """Return the name or string that an IRI stands for."""
    return unquote(found.removeprefix(ID).removeprefix(TEXT), errors="strict")


def term(predicate: Indicator) -> str:
    """Return the IRI of a predicate.

    Examples
    --------
    >>> term(("on_top_of", 2)), term(("dries", 1))
    ('urn:deixis:term:onTopOf', 'urn:deixis:term:dries.1')
    """
    name, arity = predicate
    known = BY_NAME.get(name)
    if known is not None and known.arity == arity:
        return TERM + known.rdf
    return f"{TERM}{quote(name, safe='')}.{arity}"


def is_node(kinds: tuple[Kind, ...]) -> bool:
    """Return whether a row with these kinds of arguments is a node of its own."""
    return len(kinds) > 2 or kinds[0] == "number"
