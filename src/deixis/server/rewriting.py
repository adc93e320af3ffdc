"""Two changes to a text that the protocol or the limits ask for and the engine has no other word for."""

from __future__ import annotations

import re
from collections.abc import Sequence
from itertools import pairwise
from typing import Final

from deixis.errors import QueryError
from deixis.server.screening import Screened

_IRI: Final = re.compile(r"[A-Za-z][A-Za-z0-9+.\-]*:[^<>\"{}|^`\\\x00-\x20]*")


def absolute(iri: str) -> str:
    """Return an IRI that may stand between ``<`` and ``>``.

    Raises
    ------
    QueryError
        It is none.
    """
    if not _IRI.fullmatch(iri):
        raise QueryError(f"{iri[:200]!r} is no absolute IRI")
    return iri


def limited(query: Screened, rows: int) -> str | None:
    r"""Return a SELECT that gives no more than so many rows, or None where it gives no more anyway.

    Examples
    --------
    >>> from deixis.server.screening import screen
    >>> limited(screen("SELECT * { ?s ?p ?o } # all", 99, 9), 10)
    'SELECT * { ?s ?p ?o }\nLIMIT 10\n # all'
    """
    if query.form != "SELECT":
        return None
    text, outer = query.text, [one for one in query.tokens if one.depth == 0]
    for one, following in pairwise(outer):
        if one.word == "LIMIT" and following.kind == "number":
            if int(following.text[:12]) < rows:
                return None
            return f"{text[: one.start]}\nLIMIT {rows}\n{text[following.end :]}"
    # VALUES, where it ends the query, comes after LIMIT.
    values = [one.start for one in outer if one.word == "VALUES"]
    end = values[0] if values else query.tokens[-1].end
    return f"{text[:end]}\nLIMIT {rows}\n{text[end:]}"


def using(update: Screened, default: Sequence[str], named: Sequence[str]) -> str:
    """Return an update whose WHERE clauses see the protocol's graphs.

    Raises
    ------
    QueryError
        It names graphs itself, by USING or WITH; or it is a DELETE WHERE, which takes none.
    """
    clause = "".join(f" USING <{absolute(one)}>" for one in default)
    clause += "".join(f" USING NAMED <{absolute(one)}>" for one in named)
    if not clause:
        return update.text
    text, at, before = "", 0, ""
    for one in update.tokens:
        if one.depth == 0 and one.word in ("USING", "WITH"):
            raise QueryError(
                f"using-graph-uri and using-named-graph-uri leave no room for {one.word}: use one of the two"
            )
        if one.depth == 0 and one.word == "WHERE":
            if before == "DELETE":
                raise QueryError(
                    "DELETE WHERE takes no graphs from outside: write DELETE { ... } WHERE { ... }"
                )
            text += update.text[at : one.start] + clause + " "
            at = one.start
        before = one.word
    return text + update.text[at:]
