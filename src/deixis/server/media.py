"""Formats by their media types, and which of them a client wants (RFC 9110, 12.5.1)."""

from __future__ import annotations

from functools import lru_cache
from typing import Final

import mimeparse

from deixis.server.problems import Problem

TABLES: Final = {
    "application/json": "json",
    "text/xml": "xml",
    "application/xml": "xml",
    "text/tab-separated-values": "tsv",
    "text/csv": "csv",
    "application/sparql-results+xml": "xml",
    "application/sparql-results+json": "json",
}
"""Of tables and truth values; of two that a client likes as much, the later is sent."""

GRAPHS: Final = {
    "application/json": "jsonld",
    "application/xml": "rdf",
    "text/xml": "rdf",
    "application/ld+json": "jsonld",
    "application/n-quads": "nq",
    "application/trig": "trig",
    "application/rdf+xml": "rdf",
    "application/n-triples": "nt",
    "text/turtle": "ttl",
}
"""Of graphs."""

DATASETS: Final = {"application/ld+json": "jsonld", "application/n-quads": "nq", "application/trig": "trig"}
"""Of all graphs together."""

_LONGEST: Final = 2000
"""Characters of an Accept header: browsers send 150."""


@lru_cache(1024)
def wanted(accept: str, offered: tuple[str, ...]) -> str:
    """Return the offered media type that a client likes best.

    Raises
    ------
    Problem
        It likes none of them (406).

    Examples
    --------
    >>> wanted("text/csv;q=0.5, application/sparql-results+xml", tuple(TABLES))
    'application/sparql-results+xml'
    """
    best = ""
    if len(accept) <= _LONGEST:
        try:
            best = mimeparse.best_match(offered, accept.strip() or "*/*")
        except (mimeparse.MimeTypeParseException, ValueError):
            best = ""
    if not best:
        raise Problem(
            406, f"none of what Accept names is offered; offered are {', '.join(reversed(offered))}"
        )
    return best


def content_type(media: str) -> str:
    """Return the header for a media type, with the character set where it is a text."""
    return f"{media}; charset=utf-8" if media.startswith("text/") else media
