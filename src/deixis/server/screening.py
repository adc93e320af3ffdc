"""What a SPARQL text may be before any engine sees it: how long, how deep, and that it fetches nothing.

The engine's parser recurses, and ends its process on a few thousand brackets; and it would fetch what a
SERVICE or LOAD names. So the text is cut into tokens first, which takes linear time.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import islice
from typing import Final, NamedTuple

from deixis.errors import QueryError

_TOKEN: Final = re.compile(
    r"""
      (?P<comment>\#[^\r\n]*)
    | (?P<string>'''(?:[^'\\]|\\.|'{1,2}(?!'))*''' | \"\"\"(?:[^"\\]|\\.|"{1,2}(?!"))*\"\"\"
        | '(?!'')(?:[^'\\\r\n]|\\.)*' | "(?!\"\")(?:[^"\\\r\n]|\\.)*")
    | (?P<iri><[^<>"{}|^`\\\x00-\x20]*>)
    | (?P<prefixed>[^\W\d_](?>[\w.\-]{0,100}):|:|_:)(?:[\w:.\-]|%[0-9A-Fa-f]{2}|\\.)*
    | (?P<variable>[?$]\w+)
    | (?P<word>[A-Za-z][\w]*)
    | (?P<open><<|[({\[]) | (?P<close>>>|[)}\]])
    | (?P<number>\d+)
    | (?P<other>\S)
    """,
    re.VERBOSE | re.DOTALL,
)

_PAIRS: Final = {")": "(", "}": "{", "]": "[", ">>": "<<"}

_OPERATORS: Final = frozenset("!+-^/|*")
"""Signs that nest without brackets."""

_HIDDEN: Final = re.compile(r"\b(?:service|load)\b", re.IGNORECASE)
"""What, after a bracket, may be read as a clause instead of a part of an IRI: ``?a<?b)SERVICE?s#>``."""

_UPDATES: Final = frozenset(
    ("INSERT", "DELETE", "WITH", "CLEAR", "CREATE", "DROP", "COPY", "MOVE", "ADD", "LOAD")
)
_QUERIES: Final = frozenset(("SELECT", "ASK", "CONSTRUCT", "DESCRIBE"))

_MOST_SIGNS: Final = 256
"""Operators in a row, of paths and expressions: each is a level of the parser."""

_MOST_CHAIN: Final = 2048
"""Operators in one text."""

_MOST_UNCLOSED: Final = 8
"""Quotes that begin no string."""

_MOST_PARTS: Final = 10_000
"""Parts of a query, which is cut into them while all others wait; an update has a process of its own."""


class Forbidden(QueryError):
    """The text asks to fetch from elsewhere, or to change what may not be changed."""


class Token(NamedTuple):
    """A part of a text: its kind, where it is, and how many brackets are around it."""

    kind: str
    text: str
    start: int
    end: int
    depth: int

    @property
    def word(self) -> str:
        """Return a keyword in capitals; nothing else is one."""
        return self.text.upper() if self.kind == "word" else ""


def tokens(text: str, depth: int) -> Iterator[Token]:
    """Yield the parts of a query or update, without comments.

    Raises
    ------
    QueryError
        There are brackets within brackets, deeper than ``depth``, or too many operators.

    Examples
    --------
    >>> [one.text for one in tokens("ASK { ?s <urn:p> 'SERVICE' } # LOAD", 9)]
    ['ASK', '{', '?s', '<urn:p>', "'SERVICE'", '}']
    """
    around: list[str] = []
    signs = chain = unclosed = 0
    for match in _TOKEN.finditer(text):
        kind, part = match.lastgroup or "other", match[0]
        if kind == "comment":
            continue
        if kind == "close" and (opened := _PAIRS[part]) in around:
            # What is left open inside was no bracket: two signs of comparison side by side.
            while around.pop() != opened:
                pass
        if kind == "other" and part in ("'", '"'):
            # Each is looked at up to the end of the text; a few are let be, for the engine to judge.
            unclosed += 1
            if unclosed > _MOST_UNCLOSED:
                raise QueryError(f"strings are not closed, up to character {match.start() + 1}: close them")
        yield Token(kind, part, match.start(), match.end(), len(around))
        if kind == "open":
            around.append(part)
            if len(around) > depth:
                raise QueryError(f"brackets are nested deeper than {depth}: write it flatter")
        sign = kind == "other" and part in _OPERATORS
        signs, chain = (signs + 1, chain + 1) if sign else (0, chain)
        if signs > _MOST_SIGNS or chain > _MOST_CHAIN:
            raise QueryError("there are too many operators: write it shorter")


@dataclass(frozen=True, slots=True)
class Screened:
    """A text that may be given to the engine.

    Attributes
    ----------
    text : str
    tokens : tuple of Token
    form : str
        Its first keyword after the prologue: ``SELECT``, ``INSERT`` ...; empty where there is none.
    graphs : tuple of str
        The graphs it takes its dataset from, by FROM or USING, that are written as IRIs.
    chooses : bool
        Whether it takes its dataset from graphs at all.
    """

    text: str
    tokens: tuple[Token, ...]
    form: str
    graphs: tuple[str, ...]
    chooses: bool

    def check_graphs(self, known: Sequence[str]) -> None:
        """Raise :class:`Forbidden` where a graph would have to be fetched: it is not here, nor made here."""
        written = Counter(one.text for one in self.tokens if one.kind == "iri")
        for name in {*self.graphs} - {*known}:
            if written[f"<{name}>"] <= 1:
                raise Forbidden(f"there is no graph <{name[:200]}> here, and this server fetches nothing")


def screen(text: str, longest: int, depth: int, *, update: bool = False) -> Screened:
    """Return a text with its parts.

    Raises
    ------
    QueryError
        It is too long, too deep or holds what no text may hold.
    Forbidden
        It would fetch from elsewhere, or is an update where a query is expected.
    """
    if len(text) > longest:
        raise QueryError(
            f"the text has {len(text)} characters, and at most {longest} are read: write it shorter"
        )
    if "\x00" in text:
        raise QueryError("the text holds the character U+0000: leave it out")
    found = tokens(text, depth)
    parts = tuple(found if update else islice(found, _MOST_PARTS))
    if next(found, None) is not None:
        raise QueryError(f"the text has more than {_MOST_PARTS} parts: write it shorter, or ask twice")
    for at, one in enumerate(parts):
        if _fetches(one, parts[at + 1 : at + 2], parts[at - 1] if at else None):
            raise Forbidden(
                "SERVICE is switched off: this server fetches nothing from elsewhere; ask there yourself"
            )
        if one.depth == 0 and "LOAD" in one.word:
            raise Forbidden(
                "LOAD is switched off: this server fetches nothing from elsewhere; send the data instead"
            )
    form = next((one.word for one in parts if one.word in _UPDATES | _QUERIES), "")
    if not update and form in _UPDATES:
        raise Forbidden(f"{form} is an update: send it as one, with POST and update=")
    chosen = list(_chosen(parts))
    graphs = tuple(one.text[1:-1] for one in chosen if one.kind == "iri")
    return Screened(text, parts, form, graphs, bool(chosen))


def _chosen(parts: tuple[Token, ...]) -> Iterator[Token]:
    """Yield what stands after FROM, USING, and these with NAMED."""
    clause = False
    for one in parts:
        if one.depth == 0 and one.word in ("FROM", "USING"):
            clause = True
        elif clause and one.word != "NAMED":
            yield one
            clause = False


def _fetches(one: Token, following: tuple[Token, ...], before: Token | None) -> bool:
    """Return whether a part may be read as SERVICE: the engine's keywords need no space around them."""
    match one.kind:
        case "word":
            return "SERVICE" in one.word
        case "iri":
            bracket = one.text.find(")")
            return bracket >= 0 and _HIDDEN.search(one.text, bracket) is not None
        case "prefixed" if "SERVICE" in one.text.upper().partition(":")[0]:
            graph = before is not None and before.word == "GRAPH"
            return not graph and bool(following) and following[0].text == "{"
    return False
