"""Where each clause of a rule file begins and ends, and the comments between them.

A clause ends with a full stop followed by white space, ``%`` or the end of the file, outside quotes and
comments. Finding the ends first lets the parser go on after a clause it cannot read.
"""

from __future__ import annotations

import re
from bisect import bisect_right
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from deixis.ruleset.model import Place, Problem

MOST_CHARACTERS: Final = 1 << 18
"""Of a file."""

LONGEST_CLAUSE: Final = 1 << 16
"""Characters."""

DEEPEST: Final = 50
"""Brackets within brackets."""

_TOKEN: Final = re.compile(
    r"""
      (?P<comment>%[^\n]*|/\*.*?\*/)
    | (?P<open_comment>/\*)
    | 0'(?:\\.|''|[^\\])
    | '(?:[^'\\\n]|\\x[0-9a-fA-F]+\\?|\\[0-7]+\\?|\\.|'')*'
    | "(?:[^"\\\n]|\\x[0-9a-fA-F]+\\?|\\[0-7]+\\?|\\.|"")*"
    | (?P<open_quote>['"`])
    | (?P<symbols>[+*/\\^<>=~:.?@\#&$-]+)
    | (?P<space>\s+)
    | (?P<bracket>[()\[\]{}])
    | [A-Za-z0-9_]+
    | .
    """,
    re.DOTALL | re.VERBOSE,
)


@dataclass(frozen=True, slots=True)
class Clause:
    """The text of one clause without its full stop, where it begins, and the comment in front of it."""

    text: str
    start: int
    comment: str


class Lines:
    """Turns an offset into a text into line and column."""

    def __init__(self, path: Path, text: str) -> None:
        self.path = path
        self._starts = [0, *(found.end() for found in re.finditer("\n", text))]

    def at(self, offset: int) -> Place:
        """Return the place of a character."""
        line = bisect_right(self._starts, offset)
        return Place(self.path, line, offset - self._starts[line - 1] + 1)


def clauses(text: str, lines: Lines) -> Iterator[Clause | Problem]:
    r"""Yield the clauses of a text, and what keeps a stretch of it from being one.

    Parameters
    ----------
    text : str
        Of a rule file.
    lines : Lines
        Of the same text.

    Examples
    --------
    >>> text = "%!  p(?X)\np(a). p('b. c')."
    >>> [one.text for one in clauses(text, Lines(Path("x.pl"), text))]
    ['p(a)', "p('b. c')"]
    """
    start, comments, depth, spoilt = -1, [], 0, False
    for token in _TOKEN.finditer(text):
        if token["open_comment"]:
            yield Problem(lines.at(token.start()), "the comment is not closed", "end it with */")
            return
        if token["comment"]:
            if start < 0:
                comments.append(token[0])
            continue
        if token["space"]:
            if start < 0 and token[0].count("\n") > 1 and comments:
                if comments[-1].startswith("/*"):
                    comments.clear()
                else:
                    comments.append("%")  # a blank line parts the paragraphs
            continue
        if start < 0:
            start, depth, spoilt = token.start(), 0, False
        if token["open_quote"] and not spoilt:
            spoilt = True
            what = "back quotes are not in the subset" if token[0] == "`" else "the quote is not closed"
            yield Problem(lines.at(token.start()), what, "quote names with ' on one line")
        if token["bracket"]:
            depth += 1 if token[0] in "([{" else -1
            if depth > DEEPEST and not spoilt:
                spoilt = True
                yield Problem(
                    lines.at(token.start()),
                    f"brackets are nested more than {DEEPEST} deep",
                    "rules of the subset need two or three",
                )
        symbols = token["symbols"]
        if not (symbols == "." and _ends(text, token.end())):
            continue
        if token.start() - start > LONGEST_CLAUSE and not spoilt:
            spoilt = True
            yield Problem(
                lines.at(start), f"the clause is longer than {LONGEST_CLAUSE} characters", "split it"
            )
        if not spoilt:
            yield Clause(text[start : token.start()], start, "\n".join(comments))
        start = -1
        comments.clear()
    if start >= 0 and not spoilt:
        yield Problem(
            lines.at(start), "the clause has no end", "end each clause with a full stop and a new line"
        )


def _ends(text: str, offset: int) -> bool:
    return offset >= len(text) or text[offset].isspace() or text[offset] == "%"
