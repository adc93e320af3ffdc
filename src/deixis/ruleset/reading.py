"""From the text of a rule file to its rules; whatever is outside the subset is named."""

from __future__ import annotations

import re
from itertools import count
from pathlib import Path
from typing import Final

from deixis.errors import RuleError
from deixis.ruleset.clauses import MOST_CHARACTERS, Clause, Lines, clauses
from deixis.ruleset.model import (
    ORDER,
    SAME,
    Arithmetic,
    Atom,
    Comparison,
    Constant,
    Expression,
    Goal,
    Indicator,
    Negation,
    Place,
    Problem,
    Rule,
    RuleFile,
    Value,
    Variable,
)
from deixis.ruleset.syntax import Raw, SyntaxProblem, read_clause, unquoted

LARGEST_NUMBER: Final = 1.0e15
"""Up to here sums of a few whole numbers are exact in a double."""

MOST_ARGUMENTS: Final = 16
MOST_OPERANDS: Final = 8

_OUTSIDE: Final = {
    "!": ("the cut ! is not in the subset", "let conditions exclude each other"),
    ";": ("';' is not in the subset", "write a clause for each alternative"),
    "|": ("'|' is not in the subset", "write a clause for each alternative"),
    "->": ("if-then-else is not in the subset", "write a clause for each case, with the condition in it"),
    "*->": ("if-then-else is not in the subset", "write a clause for each case, with the condition in it"),
    "-->": ("grammar rules are not in the subset", "write head :- body"),
    "{}": ("'{}' is not in the subset", ""),
    "is": ("'is' is not in the subset", "compare the sum itself, as in D =< T + 0.1"),
    ":": ("a module in front of a goal is not in the subset", "leave it out: all rules share one vocabulary"),
    "@<": ("the order of terms is not in the subset", "names are only == or \\=="),
    "=..": ("'=..' takes terms apart, which is not in the subset", ""),
    "^": ("'^' is not in the subset", "in \\+ variables that stand nowhere else mean any"),
}  # fmt: skip

_CALLS: Final = {
    "assert": "rules derive and change nothing", "asserta": "rules derive and change nothing",
    "assertz": "rules derive and change nothing", "retract": "rules derive and change nothing",
    "retractall": "rules derive and change nothing", "findall": "there are no lists",
    "forall": "write \\+ ( goal, \\+ ...) with a predicate for the inner part", "not": "write \\+ goal",
    "call": "write the goal out", "once": "answers are a set anyway", "fail": "leave the clause out",
    "true": "leave it out", "format": "rules print nothing", "write": "rules print nothing",
    "member": "there are no lists", "bagof": "there are no lists", "setof": "there are no lists",
    "aggregate_all": "there are no lists", "atom_length": "names are whole", "sub_atom": "names are whole",
    "atom_concat": "names are whole", "number": "each argument is of one kind",
    "atom": "each argument is of one kind", "var": "all variables are bound",
    "nonvar": "all variables are bound", "ground": "all variables are bound",
    "between": "there is no counting", "dif": "write \\==", "halt": "rules derive and change nothing",
    "shell": "rules derive and change nothing", "tnot": "write \\+ goal", "succ": "there is no counting",
    "plus": "compare the sum itself", "ignore": "leave it out",
}  # fmt: skip


class _Refused(Exception):
    def __init__(self, raw: Raw, message: str, hint: str = "") -> None:
        super().__init__(message)
        self.start, self.message, self.hint = raw.start, message, hint


def read_file(path: Path) -> tuple[RuleFile, list[Problem]]:
    """Return what a file says, and what keeps parts of it from being read.

    Raises
    ------
    RuleError
        There is no such file, or it is no UTF-8 text.
    """
    try:
        raw = path.read_bytes()
    except OSError as error:
        if not path.is_file():
            raise RuleError(f"there is no rule file {path}") from None
        raise RuleError(f"the rule file {path} cannot be read: {error.strerror}") from None
    if len(raw) > 4 * MOST_CHARACTERS:
        raise RuleError(f"the rule file {path} is larger than {MOST_CHARACTERS} characters: split it")
    try:
        text = raw.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise RuleError(f"the rule file {path} is no UTF-8 text: byte {error.start} cannot be read") from None
    return read_text(text, path)


def read_text(text: str, path: Path) -> tuple[RuleFile, list[Problem]]:
    """Return what the text of a rule file says, and what keeps parts of it from being read.

    Examples
    --------
    >>> file, problems = read_text("p(X) :- touches(X, floor).", Path("mine.pl"))
    >>> file.rules[0].head.predicate, problems
    (('p', 1), [])
    """
    text = text.replace("\r\n", "\n")
    lines = Lines(path, text)
    reader = _Reader(path, lines)
    if len(text) > MOST_CHARACTERS:
        reader.problem(0, f"the file is longer than {MOST_CHARACTERS} characters", "split it")
    else:
        for one in clauses(text, lines):
            if isinstance(one, Problem):
                reader.problems.append(one)
            else:
                reader.clause(one)
    return reader.file(), reader.problems


class _Reader:
    """Turns the clauses of one file into rules, one after the other."""

    def __init__(self, path: Path, lines: Lines) -> None:
        self.path, self.lines = path, lines
        self.problems: list[Problem] = []
        self.module: str | None = None
        self.exports: list[Indicator] = []
        self.imports: list[tuple[str, Place]] = []
        self.declared: list[tuple[Indicator, Place]] = []
        self.rules: list[Rule] = []
        self.docs: dict[Indicator, str] = {}
        self._offset = 0
        self._anonymous = count()

    def file(self) -> RuleFile:
        return RuleFile(
            self.path,
            self.module,
            tuple(self.exports),
            tuple(self.imports),
            tuple(self.declared),
            tuple(self.rules),
            self.docs,
        )

    def problem(self, offset: int, message: str, hint: str = "") -> None:
        self.problems.append(Problem(self.lines.at(offset), message, hint))

    def clause(self, clause: Clause) -> None:
        self._offset = clause.start
        try:
            raw = read_clause(clause.text)
            if raw.kind == "directive":
                self._directive(_bare(raw.parts[0]))
            else:
                rule = self._rule(raw, _doc(clause.comment))
                self.rules.append(rule)
                if rule.doc:
                    self.docs.setdefault(rule.head.predicate, rule.doc)
        except SyntaxProblem as found:
            self.problem(clause.start + found.offset, found.message, found.hint)
        except _Refused as refused:
            self.problem(clause.start + refused.start, refused.message, refused.hint)

    def _place(self, raw: Raw) -> Place:
        return self.lines.at(self._offset + raw.start)

    def _rule(self, raw: Raw, doc: str) -> Rule:
        if raw.kind == "outside":
            raise _outside(raw)
        head = raw.parts[0]
        if head.kind not in ("compound", "name"):
            if head.kind == "outside":
                raise _outside(head)
            raise _Refused(head, "this is no head of a rule", "begin with a predicate, as in p(X) :- ...")
        body: tuple[Goal, ...] = ()
        if raw.kind == "rule":
            parts = _bare(raw.parts[1])
            body = tuple(
                self._goal(one) for one in (parts.parts if parts.kind == "conjunction" else (parts,))
            )
        return Rule(self._atom(head), body, doc)

    def _goal(self, raw: Raw) -> Goal:
        raw = _bare(raw)
        match raw.kind:
            case "compound" | "name" | "comparison":
                return self._plain(raw)
            case "negation":
                inner = _bare(raw.parts[0])
                parts = inner.parts if inner.kind == "conjunction" else (inner,)
                goals = tuple(self._plain(_bare(one)) for one in parts)
                if not any(isinstance(one, Atom) for one in goals):
                    raise _Refused(raw, "a denial of comparisons only", "write the opposite comparison")
                return Negation(goals, self._place(raw))
            case "conjunction":
                raise _Refused(raw, "brackets around a conjunction are not in the subset", "leave them out")
            case "variable":
                raise _Refused(raw, "a variable is no goal", "write the goal out")
        raise _outside(raw)

    def _plain(self, raw: Raw) -> Atom | Comparison:
        match raw.kind:
            case "negation":
                raise _Refused(
                    raw,
                    "a denial within a denial is not in the subset",
                    "give the inner part a name of its own",
                )
            case "conjunction":
                raise _Refused(raw, "brackets around a conjunction are not in the subset", "leave them out")
            case "variable":
                raise _Refused(raw, "a variable is no goal", "write the goal out")
            case "comparison":
                left, right = (self._expression(part) for part in raw.parts)
                return Comparison(raw.text, left, right, self._place(raw))
            case "compound" | "name":
                name = _text(raw, raw.text)
                if name in _CALLS:
                    raise _Refused(raw, f"{name!r} is not in the subset", _CALLS[name])
                return self._atom(raw)
        raise _outside(raw)

    def _atom(self, raw: Raw) -> Atom:
        if raw.kind == "name":
            raise _Refused(raw, f"{raw.text} has no argument", "a predicate has one argument at least")
        if len(raw.parts) > MOST_ARGUMENTS:
            raise _Refused(raw, f"a predicate has at most {MOST_ARGUMENTS} arguments")
        return Atom(_text(raw, raw.text), tuple(self._value(part) for part in raw.parts), self._place(raw))

    def _value(self, raw: Raw) -> Value:
        raw = _bare(raw)
        place = self._place(raw)
        match raw.kind:
            case "variable":
                if raw.text == "_":
                    return Variable(f"_#{next(self._anonymous)}", place)
                return Variable(raw.text, place)
            case "name":
                return Constant("name", _text(raw, raw.text), place)
            case "string":
                return Constant("string", _text(raw, raw.text), place)
            case "number":
                return Constant("number", _number(raw), place)
            case "compound":
                raise _Refused(raw, "a term within a term is not in the subset", "give each part an argument")
            case "list":
                raise _Refused(raw, "lists are not in the subset", "write a fact for each member")
            case "plus" | "sign" | "times":
                raise _Refused(raw, "a sum is no argument", "compare it, as in D =< T + 0.1")
        raise _outside(raw)

    def _expression(self, raw: Raw) -> Expression:
        operands = count(1)

        def one(raw: Raw) -> Expression:
            raw = _bare(raw)
            match raw.kind:
                case "plus":
                    left, right = raw.parts
                    return Arithmetic(
                        "-" if raw.text == "-" else "+", (one(left), one(right)), self._place(raw)
                    )
                case "sign":
                    if raw.text.startswith("+"):
                        raise _Refused(raw, "a plus in front of a value means nothing", "leave it out")
                    return Arithmetic("-", (one(raw.parts[0]),), self._place(raw))
                case "times":
                    raise _Refused(
                        raw,
                        f"'{raw.text}' is not in the subset",
                        "numbers are compared, added and subtracted",
                    )
                case "compound":
                    raise _Refused(
                        raw, "a term is compared with nothing", "numbers are added and subtracted only"
                    )
            if next(operands) > MOST_OPERANDS:
                raise _Refused(raw, f"a sum has at most {MOST_OPERANDS} numbers")
            return self._value(raw)

        return one(raw)

    def _directive(self, raw: Raw) -> None:
        first, *rest = raw.parts if raw.kind == "conjunction" else (raw,)
        if first.kind == "declaration":
            raw = first
            if raw.text != "dynamic":
                hints = {
                    "discontiguous": "put the clauses of a predicate together",
                    "table": "recursion needs none",
                }
                raise _Refused(raw, f"'{raw.text}' is not in the subset", hints.get(raw.text, ""))
            for part in (raw.parts[0], *rest):
                self._dynamic(part)
            return
        name = _text(raw, raw.text) if raw.kind in ("compound", "name") else ""
        if name == "dynamic":
            for part in raw.parts:
                self._dynamic(part)
        elif name == "module" and len(raw.parts) == 2 and raw.parts[0].kind == "name":
            if self.module is not None or self.rules or self.declared:
                raise _Refused(raw, "module/2 is not the first term", "put it at the top of the file")
            self.module = _text(raw.parts[0], raw.parts[0].text)
            if raw.parts[1].kind != "list":
                raise _Refused(raw.parts[1], "exports are a list", "write [p/2, q/1]")
            self.exports += [_indicator(part) for part in raw.parts[1].parts]
        elif name == "use_module" and 1 <= len(raw.parts) <= 2:
            what = raw.parts[0]
            if what.kind == "name":
                self.imports.append((_text(what, what.text), self._place(what)))
            elif what.kind != "compound" or what.text != "library":
                raise _Refused(what, "use_module names a rule file", "write use_module(commonsense)")
        elif name != "encoding":
            what_else = f"the directive {name or raw.text!r}" if name else "this directive"
            raise _Refused(raw, f"{what_else} is not in the subset", "module, use_module and dynamic are")

    def _dynamic(self, raw: Raw) -> None:
        raw = _bare(raw)
        parts = raw.parts if raw.kind in ("conjunction", "list") else (raw,)
        self.declared += [(_indicator(part), self._place(part)) for part in parts]


def _indicator(raw: Raw) -> Indicator:
    raw = _bare(raw)
    if raw.kind == "times" and raw.text == "/":
        name, arity = raw.parts
        if name.kind == "name" and arity.kind == "number" and arity.text.isdigit() and len(arity.text) < 4:
            return _text(name, name.text), int(arity.text)
    raise _Refused(raw, "a predicate is named as name/arity", "write p/2")


def _bare(raw: Raw) -> Raw:
    while raw.kind == "bracketed":
        raw = raw.parts[0]
    return raw


def _text(raw: Raw, text: str) -> str:
    if text[:1] not in ("'", '"'):
        return text
    try:
        return unquoted(text)
    except SyntaxProblem as found:
        raise SyntaxProblem(raw.start + 1 + found.offset, found.message, found.hint) from None


def _number(raw: Raw) -> float:
    if not re.fullmatch(r"-?[0-9]+(\.[0-9]+)?([eE][+-]?[0-9]+)?", raw.text):
        raise _Refused(raw, f"{raw.text} is not in the subset", "write numbers like 3, 0.05 or 1.0e-3")
    value = float(raw.text)
    if abs(value) > LARGEST_NUMBER:
        raise _Refused(raw, f"{raw.text} is beyond {LARGEST_NUMBER:g}", "smaller numbers stay exact")
    return value + 0.0


def _outside(raw: Raw) -> _Refused:
    if raw.kind == "list":
        return _Refused(raw, "lists are not in the subset", "write a fact for each member")
    if raw.kind in ("number", "string", "plus", "sign", "times"):
        return _Refused(raw, "this is no goal", "write a predicate or a comparison")
    if raw.kind == "declaration":
        return _Refused(raw, f"{raw.text!r} is no goal")
    if raw.kind in ORDER | SAME or raw.kind == "comparison":
        return _Refused(raw, "a comparison stands in a body only")
    message, hint = _OUTSIDE.get(raw.text, (f"{raw.text!r} is not in the subset", ""))
    return _Refused(raw, message, hint)


def _doc(comment: str) -> str:
    """Return the words of a comment in front of a clause, without its marks; its head is a paragraph."""
    lines = comment.split("\n")
    starts = [at for at, line in enumerate(lines) if line.startswith(("%!", "%%", "/**"))]
    if starts:
        lines = [lines[starts[-1]], "%", *lines[starts[-1] + 1 :]]
    stripped = (re.sub(r"^\s*(%[%!]?|/\*\*?|\*/|\*(?!/))\s?|\*/\s*$", "", line) for line in lines)
    return re.sub(r"\n{3,}", "\n\n", "\n".join(line.strip() for line in stripped)).strip()
