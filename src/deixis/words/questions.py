"""Questions: plain English of a small pattern set, read with lark."""

from __future__ import annotations

from dataclasses import dataclass
from difflib import get_close_matches
from functools import cache
from importlib.resources import files
from typing import Final, Literal

from lark import Lark, Token, Tree
from lark.exceptions import UnexpectedInput, UnexpectedToken

from deixis.errors import QueryError
from deixis.words.lexicon import ENTRIES, NOT_GROUNDED
from deixis.words.phrases import short
from deixis.words.tokens import QuestionLexer, tokens

PATTERNS: Final = (
    "what is on the table?",
    "what is the cup on?",
    "which books are near the lamp?",
    "where is the cup?",
    "is the cup on the table?",
    "how many books are on the shelf?",
    "what is left of the table from the robot?",
    "which things lean on the wall?",
    "why is the cup on the table?",
    "why isn't the cup in the sink?",
)
"""One question of each kind that can be answered, with any preposition of the lexicon."""

LONGEST_QUESTION: Final = 1000
"""Characters."""

Ask = Literal["what", "ground", "which", "where", "whether", "why", "why_not", "count"]


@dataclass(frozen=True, slots=True)
class Noun:
    """A noun phrase: its words, whether it is definite, whether it was quoted, and where it begins."""

    text: str
    definite: bool
    quoted: bool
    start: int


@dataclass(frozen=True, slots=True)
class Question:
    """What is asked.

    Attributes
    ----------
    asks : str
    figure, ground : Noun or None
    word : str
        The preposition's entry in the lexicon; the empty text where there is none.
    view : str or None
        The words after "from".
    """

    asks: Ask
    figure: Noun | None
    ground: Noun | None
    word: str
    view: str | None


def read(text: str) -> Question:
    """Return what a text asks.

    Raises
    ------
    QueryError
        It is none of the questions that can be answered; the message says from which character on it cannot
        be read, what may have been meant, and what can be answered.

    Examples
    --------
    >>> read("what is on the table?").word
    'on'
    """
    if len(text) > LONGEST_QUESTION:
        raise QueryError(f"a question has at most {LONGEST_QUESTION} characters, this one {len(text)}")
    try:
        tree = _parser().parse(text)
    except UnexpectedInput as found:
        raise QueryError("\n".join((f"{_trouble(text, found)}; I can answer:", *PATTERNS))) from None
    return _question(tree)


@cache
def _parser() -> Lark:
    grammar = files("deixis.words").joinpath("question.lark").read_text(encoding="utf-8")
    return Lark(grammar, parser="lalr", lexer=QuestionLexer, maybe_placeholders=False)


def _question(tree: Tree[Token]) -> Question:
    nouns = [_noun(part) for part in tree.children if isinstance(part, Tree) and part.data == "noun"]
    words = [str(part) for part in tree.children if isinstance(part, Token) and part.type == "PREP"]
    views = [part for part in tree.children if isinstance(part, Tree) and part.data == "view"]
    view = " ".join(map(str, views[0].children[1:])) if views else None
    asks: Ask = tree.data  # type: ignore[assignment]
    figure, ground = {
        "what": (None, nouns[-1]),
        "ground": (nouns[0], None),
        "where": (nouns[0], None),
    }.get(asks, (nouns[0], nouns[-1]))
    return Question(asks, figure, ground, words[0] if words else "", view)


def _noun(tree: Tree[Token]) -> Noun:
    parts = [part for part in tree.children if isinstance(part, Token)]
    definite, quoted = True, len(parts) == 1 and parts[0].type == "QUOTED"
    if parts[0].type == "DETERMINER":
        definite = parts[0].casefold() in ("the", "this", "that")
        parts = parts[1:]
        quoted = len(parts) == 1 and parts[0].type == "QUOTED"
    return Noun(" ".join(map(str, parts)), definite, quoted, parts[0].start_pos or 0)


def _trouble(text: str, found: UnexpectedInput) -> str:
    """Say what cannot be read, from where on, and what may have been meant."""
    token = found.token if isinstance(found, UnexpectedToken) else None
    unknown = _no_preposition(text)
    if unknown:
        return unknown
    if token is None or token.type == "$END":
        return f"character {len(text.rstrip()) + 1}: the question ends too early"
    start, end = token.start_pos or 0, token.end_pos or 0
    return f"character {start + 1}: {short(text[start:end])!r} is not expected here"


def _no_preposition(text: str) -> str:
    """Say which word may have been meant for a preposition, where the question has none."""
    read = list(tokens(text))
    if any(one.type == "PREP" for one in read):
        return ""
    known = [form for entry in ENTRIES for form in entry.forms]
    for one in read:
        word = str(one).casefold()
        place = f"character {(one.start_pos or 0) + 1}"
        if one.type in ("WORD", "FROM") and word in NOT_GROUNDED:
            return f"{place}: {word!r} {NOT_GROUNDED[word]}"
        close = get_close_matches(word, known, n=1, cutoff=0.75) if one.type == "WORD" else []
        if close:
            return f"{place}: {short(str(one))!r} is no preposition I know: did you mean {close[0]!r}?"
    return ""
