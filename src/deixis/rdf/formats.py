"""The serialisations of RDF that are written and read, by their names and file endings."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path
from typing import Final

from deixis.errors import ReaderError
from deixis.rdf.oxigraph import ox
from deixis.strict_json import quoted

DATASETS: Final = {
    "trig": ox.RdfFormat.TRIG,
    "nq": ox.RdfFormat.N_QUADS,
    "jsonld": ox.RdfFormat.JSON_LD,
}
"""Those that hold several graphs, and so a whole export."""

GRAPHS: Final = {"ttl": ox.RdfFormat.TURTLE, "nt": ox.RdfFormat.N_TRIPLES}
"""Those that hold one graph."""

FORMATS: Final = DATASETS | GRAPHS

# What may hold "<<" without meaning a triple term: strings, IRIs, comments, escapes in names.
_TOKENS: Final = re.compile(
    rb'"""(?:[^"\\]|\\.|"(?!""))*"""|\'\'\'(?:[^\'\\]|\\.|\'(?!\'\'))*\'\'\''
    rb'|"(?:[^"\\\r\n]|\\.)*"|\'(?:[^\'\\\r\n]|\\.)*\'|<[^<>"\s]*>|\#[^\r\n]*|\\.|(<<)',
    re.DOTALL,
)


MAX_DEPTH: Final = 100
"""Deepest nesting of a JSON-LD text: the parser's time grows with its square."""

_BRACKETS: Final = re.compile(rb'"(?:[^"\\]|\\.)*"|([\[{])|([\]}])', re.DOTALL)


def ending(path: Path, also: Sequence[str] = ()) -> str:
    """Return the format that a file's ending names: one of RDF, or of those that a caller has also.

    Raises
    ------
    ReaderError
        It names none.

    Examples
    --------
    >>> ending(Path("kitchen.TriG"))
    'trig'
    """
    found = path.suffix.lower().removeprefix(".")
    if found not in (*FORMATS, *also):
        known = ", ".join(f".{name}" for name in (*FORMATS, *also))
        what = "known format" if also else "format of RDF"
        raise ReaderError(f"{quoted(path.name, 200)} ends in no {what}: name it with one of {known}")
    return found


def parsed(text: bytes, form: str, what: str) -> list[ox.Quad]:
    """Return the quads of a text.

    Contexts of JSON-LD are never fetched. Triple terms (RDF 1.2) and deep JSON are refused before the parser
    sees them: the ones would end the process when deeply nested, the other would keep it busy for minutes.

    Raises
    ------
    ReaderError
        It is not well formed, or not RDF 1.1.
    """
    if form == "jsonld" and _deep(text):
        raise ReaderError(f"{what} is nested more than {MAX_DEPTH} deep: flatten it")
    if form != "jsonld" and any(token[1] for token in _TOKENS.finditer(text)):
        raise ReaderError(f"{what} holds triple terms, which are RDF 1.2: write it as RDF 1.1")
    try:
        return list(ox.parse(text, format=FORMATS[form]))
    except (SyntaxError, ValueError) as cause:
        raise ReaderError(f"{what} is not {form}: {quoted(str(cause), 300)}") from cause


def _deep(text: bytes) -> bool:
    depth = 0
    for token in _BRACKETS.finditer(text):
        depth += bool(token[1]) - bool(token[2])
        if depth > MAX_DEPTH:
            return True
    return False
