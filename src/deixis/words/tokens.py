"""Tokens of a question: question words, prepositions by the lexicon, and all other words as they are."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from typing import Any, Final

from lark import Token
from lark.lexer import Lexer

from deixis.words.lexicon import ENTRIES

_PIECE: Final = re.compile(r"'[^']*'(?!\w)|\"[^\"]*\"|[^\s?!,\"]+")
"""Something in quotes, or a run of other characters than blanks and marks."""

_KEYWORDS: Final = {
    "what": "WHAT", "which": "WHICH", "where": "WHERE", "why": "WHY",
    "is": "BE", "are": "BE", "was": "BE", "were": "BE",
    "does": "DOES", "do": "DOES", "not": "NOT",
    "the": "DETERMINER", "a": "DETERMINER", "an": "DETERMINER", "any": "DETERMINER", "some": "DETERMINER",
    "this": "DETERMINER", "that": "DETERMINER", "all": "DETERMINER",
}  # fmt: skip

_PHRASES: Final = {
    ("how", "many"): ("HOW_MANY",),
    ("isn't",): ("BE", "NOT"),
    ("aren't",): ("BE", "NOT"),
    ("doesn't",): ("DOES", "NOT"),
    ("don't",): ("DOES", "NOT"),
    ("what's",): ("WHAT", "BE"),
    ("where's",): ("WHERE", "BE"),
    ("is", "there"): ("BE",),
    ("are", "there"): ("BE",),
    ("as", "seen", "from"): ("FROM",),
    ("seen", "from"): ("FROM",),
    ("viewed", "from"): ("FROM",),
    ("from",): ("FROM",),
}

_PARTICIPLES: Final = {
    "lean": "leaning", "hang": "hanging", "stand": "standing", "sit": "sitting", "lie": "lying",
    "rest": "resting",
}  # fmt: skip
_VERBS: Final = {
    form: _PARTICIPLES[verb] for entry in ENTRIES for verb in entry.verbs for form in (verb, f"{verb}s")
}

# "left" alone is an adjective, as in "the left book": only with "of" is it a preposition.
_FORMS: Final = {
    tuple(form.split()): entry.word
    for entry in ENTRIES
    for form in entry.forms
    if not entry.word.endswith(" of") or form.endswith(" of")
}
_LONGEST: Final = max(map(len, _FORMS))


class QuestionLexer(Lexer):
    """Tells the words of a question apart for lark; a preposition's value is its entry in the lexicon."""

    def __init__(self, lexer_conf: Any) -> None:
        """Take lark's settings, which change nothing here."""

    def lex(self, data: str) -> Iterator[Token]:  # type: ignore[override]
        """Yield the tokens of a question, with where they begin."""
        return tokens(data)


def tokens(question: str) -> Iterator[Token]:
    """Yield the tokens of a question.

    Examples
    --------
    >>> [(str(one.type), str(one)) for one in tokens("What leans against the 'on' switch?")]
    [('WHAT', 'What'), ('BE', 'leans'), ('PREP', 'leaning on'), ('DETERMINER', 'the'), ('QUOTED', 'on'),
     ('WORD', 'switch')]
    """
    pieces = [(found[0], found.start()) for found in _PIECE.finditer(question.replace("\u2019", "'"))]
    if pieces and not _quoted(pieces[-1][0]):
        pieces[-1] = pieces[-1][0].rstrip("."), pieces[-1][1]
    low = [text.casefold() for text, _ in pieces]
    at = 0
    while at < len(pieces):
        text, start = pieces[at]
        if _quoted(text):
            found, length = [("QUOTED", text[1:-1])], 1
        else:
            found, length = _read(low, text, at)
        last, offset = pieces[at + length - 1]
        for kind, value in found:
            if value:
                yield Token(kind, value, start_pos=start, end_pos=offset + len(last))
        at += length


def _quoted(text: str) -> bool:
    return len(text) > 1 and text[0] in "'\"" and text[-1] == text[0]


def _read(low: Sequence[str], text: str, at: int) -> tuple[list[tuple[str, str]], int]:
    """Return the types and values of the tokens that begin at a piece, and how many pieces they take."""
    for phrase, kinds in _PHRASES.items():
        if tuple(low[at : at + len(phrase)]) == phrase:
            return [(kind, text) for kind in kinds], len(phrase)
    known = _preposition(low, at)
    if known is not None:
        return [("PREP", known[0])], known[1]
    if low[at] in _VERBS and (known := _preposition(low, at + 1)) is not None:
        # "leans on" says "is leaning on", and "stands on" says "is on".
        whole = _preposition([_VERBS[low[at]], *low[at + 1 : at + 1 + known[1]]], 0)
        return [("BE", text), ("PREP", known[0] if whole is None else whole[0])], 1 + known[1]
    if low[at] in _VERBS.values() and _preposition(low, at + 1) is not None:
        return [], 1
    return [(_KEYWORDS.get(low[at], "WORD"), text)], 1


def _preposition(low: Sequence[str], at: int) -> tuple[str, int] | None:
    """Return the entry of the longest preposition that begins at a piece, and how many pieces it takes."""
    for length in range(min(_LONGEST, len(low) - at), 0, -1):
        word = _FORMS.get(tuple(low[at : at + length]))
        if word is not None:
            return word, length
    return None
