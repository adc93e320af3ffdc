"""Clauses as raw terms: a superset of the subset, read with lark."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cache
from hashlib import sha256
from importlib.resources import files
from pathlib import Path
from typing import Any, Final

from lark import Lark, Token, Transformer, v_args
from lark import __version__ as lark_version
from lark.exceptions import UnexpectedEOF, UnexpectedInput, UnexpectedToken
from lark.grammar import Rule
from lark.lexer import TerminalDef

DEEPEST: Final = 60
"""Terms within terms."""


@dataclass(frozen=True, slots=True)
class Raw:
    """A term as it is written: its kind, its text, its parts, where it begins and how deep it goes."""

    kind: str
    text: str
    parts: tuple[Raw, ...]
    start: int
    depth: int


class SyntaxProblem(Exception):
    """A clause that cannot be read: where in it, and why."""

    def __init__(self, offset: int, message: str, hint: str = "") -> None:
        super().__init__(message)
        self.offset, self.message, self.hint = offset, message, hint


def read_clause(text: str) -> Raw:
    """Return the term of one clause.

    Raises
    ------
    SyntaxProblem
        It is none, or goes too deep.

    Examples
    --------
    >>> read_clause("p(X) :- q(X)").kind
    'rule'
    """
    try:
        raw: Raw = _parser().parse(text)  # type: ignore[assignment]
    except UnexpectedEOF:
        raise SyntaxProblem(len(text.rstrip()), "the clause ends too early") from None
    except UnexpectedToken as found:
        raise _unexpected(text, found) from None
    except UnexpectedInput as found:
        offset = int(found.pos_in_stream or 0)  # type: ignore[redundant-expr]
        character = text[offset : offset + 1]
        raise SyntaxProblem(offset, f"{character!r} means nothing here", _hint_for(text[offset:])) from None
    if raw.depth > DEEPEST:
        raise SyntaxProblem(raw.start, f"terms are nested more than {DEEPEST} deep", "write it flat")
    return raw


def _unexpected(text: str, found: UnexpectedToken) -> SyntaxProblem:
    token = found.token
    if token.type == "$END":
        return SyntaxProblem(len(text.rstrip()), "the clause ends too early", "is a bracket not closed?")
    offset = token.start_pos or 0
    before = text[:offset].rstrip()[-1:]
    if token.type == "OPEN" and offset and text[offset - 1].isspace() and (before.isalnum() or before == "'"):
        return SyntaxProblem(offset, "'(' stands apart from its name", "write p(X), not p (X)")
    if token.type in ("NAME", "VARIABLE", "FUNCTOR", "NUMBER") and before:
        hint = "is a comma, an operator or the full stop of the clause before missing?"
        return SyntaxProblem(offset, f"{str(token)!r} is not expected here", hint)
    if token.type == "NOT":
        return SyntaxProblem(offset, "'\\+' denies a whole goal", "put it in front of the goal")
    return SyntaxProblem(offset, f"{str(token)!r} is not expected here", _hint_for(text[offset:]))


def _hint_for(text: str) -> str:
    if text.startswith("<="):
        return "less or equal is =<"
    if text.startswith(("!=", "<>")):
        return "numbers differ by =\\=, names by \\=="
    if text.startswith("."):
        return "put a space or a new line behind a full stop"
    return ""


def _raw(kind: str, token: Token | Raw, parts: Iterable[Raw] = (), text: str | None = None) -> Raw:
    start = token.start if isinstance(token, Raw) else token.start_pos or 0
    held = tuple(parts)
    if text is None:
        text = token.text if isinstance(token, Raw) else str(token)
    return Raw(kind, text, held, start, 1 + max((part.depth for part in held), default=0))


@v_args(inline=True)
class _Build(Transformer[Token, Any]):
    """Builds raw terms while parsing, so that depth costs no recursion."""

    def start(self, term: Raw) -> Raw:
        return _raw("fact", term, [term])

    def directive(self, arrow: Token, term: Raw) -> Raw:
        return _raw("directive", arrow, [term])

    query = directive

    def rule(self, head: Raw, arrow: Token, body: Raw) -> Raw:
        return _raw("rule", head, [head, body], str(arrow))

    def grammar_rule(self, head: Raw, arrow: Token, body: Raw) -> Raw:
        return Raw("outside", str(arrow), (head, body), arrow.start_pos or 0, 1)

    def _outside(self, left: Raw, token: Token, right: Raw) -> Raw:
        return _raw("outside", token, [left, right])

    disjunction = if_then = other = _outside

    def times(self, left: Raw, token: Token, right: Raw) -> Raw:
        return _raw("times", token, [left, right])

    def plus(self, left: Raw, token: Token, right: Raw) -> Raw:
        return _raw("plus", left, [left, right], str(token))

    def comparison(self, left: Raw, token: Token, right: Raw) -> Raw:
        return _raw("comparison", token, [left, right])

    def sign(self, token: Token, value: Raw) -> Raw:
        close = value.kind == "number" and value.start == (token.end_pos or 0)
        return _raw("number" if close else "sign", token, () if close else [value], f"{token}{value.text}")

    def conjoined(self, left: Raw, right: Raw) -> Raw:
        # One list for the whole conjunction, however long: depth counts brackets, not commas.
        parts = left.parts if left.kind == "conjunction" else (left,)
        depth = max(left.depth, right.depth + 1)
        return Raw("conjunction", ",", (*parts, right), left.start, depth)

    def declaration(self, token: Token, what: Raw) -> Raw:
        return _raw("declaration", token, [what])

    def negation(self, token: Token, goal: Raw) -> Raw:
        return _raw("negation", token, [goal])

    def variable(self, token: Token) -> Raw:
        return _raw("variable", token)

    def number(self, token: Token) -> Raw:
        return _raw("number", token)

    def string(self, token: Token) -> Raw:
        return _raw("string", token)

    def name(self, token: Token) -> Raw:
        return _raw("name", token)

    def compound(self, token: Token, args: list[Raw]) -> Raw:
        return _raw("compound", token, args)

    def bracketed(self, token: Token, term: Raw) -> Raw:
        return _raw("bracketed", token, [term])

    def listed(self, token: Token, args: list[Raw] | None = None, *_: object) -> Raw:
        return _raw("list", token, args or ())

    def curly(self, token: Token, term: Raw) -> Raw:
        return _raw("outside", token, [term], "{}")

    def cut(self, token: Token) -> Raw:
        return _raw("outside", token)

    def one(self, item: Raw) -> list[Raw]:
        return [item]

    def more(self, items: list[Raw], item: Raw) -> list[Raw]:
        items.append(item)
        return items


@cache
def _parser() -> Lark:
    """Return the parser, from its tables where they were made of this grammar by this version of lark.

    Making them takes longer than all else that reading a rule file takes.
    """
    here = files("deixis.ruleset")
    grammar = here.joinpath("grammar.lark").read_text(encoding="utf-8")
    tables = json.loads(here.joinpath("grammar.json").read_text(encoding="utf-8"))
    if tables["made_of"] == _made_of(grammar):
        data, memo = _whole_keys(tables["data"]), _whole_keys(tables["memo"])
        made: Lark = Lark._load_from_dict(data, memo, transformer=_Build())  # type: ignore[no-untyped-call]
        return made
    return Lark(grammar, parser="lalr", transformer=_Build(), maybe_placeholders=False)


def parser_tables(grammar: str) -> str:
    """Return the text of ``grammar.json`` for a grammar; ``python -m deixis.ruleset.syntax`` writes it."""
    parser = Lark(grammar, parser="lalr", maybe_placeholders=False)
    data, memo = parser.memo_serialize([TerminalDef, Rule])
    return json.dumps({"made_of": _made_of(grammar), "data": data, "memo": memo}, sort_keys=True) + "\n"


def _made_of(grammar: str) -> str:
    return f"lark {lark_version}, {sha256(grammar.encode()).hexdigest()}"


def _whole_keys(value: Any) -> Any:
    """Return JSON with its keys as the whole numbers they were."""
    if isinstance(value, dict):
        return {int(key) if key.isdigit() else key: _whole_keys(one) for key, one in value.items()}
    return [_whole_keys(one) for one in value] if isinstance(value, list) else value


_ESCAPE: Final = re.compile(
    r"\\(?:x(?P<hex>[0-9a-fA-F]+)\\?|(?P<octal>[0-7]+)\\?|u(?P<u>[0-9a-fA-F]{4})|U(?P<U>[0-9a-fA-F]{8})"
    r"|(?P<newline>\n)|(?P<simple>.))|(?P<twice>''|\"\")",
    re.DOTALL,
)
_SIMPLE: Final = {
    "a": "\a", "b": "\b", "f": "\f", "n": "\n", "r": "\r", "t": "\t", "v": "\v", "s": " ",
    "e": "\x1b", "z": None, "\\": "\\", "'": "'", '"': '"', "`": "`", "c": None,
}  # fmt: skip


def unquoted(text: str) -> str:
    r"""Return the characters that a quoted name or string stands for.

    Raises
    ------
    SyntaxProblem
        It holds an escape that Prolog does not know, or half a surrogate pair.

    Examples
    --------
    >>> unquoted(r"'O''Hara\x21\'")
    "O'Hara!"
    """
    quote = text[0]

    def one(found: re.Match[str]) -> str:
        if found["twice"]:
            return quote if found[0][0] == quote else found[0]
        if found["newline"]:
            return ""
        digits = found["hex"] or found["u"] or found["U"]
        if digits or found["octal"]:
            code = int(digits, 16) if digits else int(found["octal"], 8)
            if code > 0x10FFFF or 0xD800 <= code <= 0xDFFF or code == 0:
                raise SyntaxProblem(found.start(), f"{found[0]} is no character")
            return chr(code)
        known = _SIMPLE.get(found["simple"])
        if known is None:
            raise SyntaxProblem(found.start(), f"the escape {found[0]} is not known", "write \\\\ for \\")
        return known

    return _ESCAPE.sub(one, text[1:-1])


if __name__ == "__main__":
    _here = Path(__file__).parent
    _text = (_here / "grammar.lark").read_text(encoding="utf-8")
    (_here / "grammar.json").write_text(parser_tables(_text), encoding="utf-8")
