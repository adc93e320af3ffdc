"""What the bridge replied: the result, or the typed error that a reply stands for."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

from deixis.errors import DeixisError, EngineError, QueryError, QueryTimeout, RuleError
from deixis.hints import either

_PROPOSALS: Final = 3
_WIDEST: Final = 200


def spoils(told: Mapping[str, Any]) -> bool:
    """Return whether Prolog was stopped in the midst of something that it may not be able to resume.

    A limit can strike while a library is being loaded, which then stays half loaded.

    Examples
    --------
    >>> spoils({"error": "memory", "message": "..."})
    True
    """
    return told.get("error") in ("memory", "inferences")


def result(told: Mapping[str, Any], question: str = "") -> Any:
    """Return the result of a reply.

    Parameters
    ----------
    told : mapping
        The reply, decoded.
    question : str
        What was asked, to show where its syntax is wrong.

    Raises
    ------
    QueryError
        The question is wrong, or what it needs is not allowed.
    QueryTimeout
        The question took more steps than allowed.
    RuleError
        The rule files are wrong.
    EngineError
        Anything else.

    Examples
    --------
    >>> result({"ok": 3})
    3
    """
    if "ok" in told:
        return told["ok"]
    raise _error(told, question)


def _error(told: Mapping[str, Any], question: str) -> DeixisError:
    message = str(told["message"])
    match told["error"]:
        case "syntax":
            return QueryError(message.lower() + _mark(question, told["position"]))
        case "unknown":
            return QueryError(message + _proposals(told["name"], told["arity"], told["known"]))
        case "query" | "permission":
            return QueryError(message)
        case "memory":
            return QueryError(f"{message}: ask something narrower, or give a limit")
        case "inferences":
            return QueryTimeout(f"{message}: ask something narrower, or allow more")
        case "rules":
            return RuleError("\n  ".join([f"{message}:", *told["complaints"]]))
    return EngineError(message)


def _mark(question: str, position: int | None) -> str:
    """Return the line of the question with a mark below the place where reading stopped."""
    if position is None or not question:
        return ""
    position = min(position, len(question))
    # Reading stops where a token ends: what comes next is what was not understood.
    position += len(question[position:]) - len(question[position:].lstrip())
    start = question.rfind("\n", 0, position) + 1
    line = question[start:].split("\n", 1)[0]
    if len(line) > _WIDEST:
        return f" at character {position + 1}"
    return f" at character {position + 1}\n  {line}\n  {' ' * (position - start)}^"


def _proposals(name: str, arity: int, known: list[tuple[str, int]]) -> str:
    """Return the names that may have been meant, the same name with other arguments first."""
    from difflib import get_close_matches

    same = sorted(other for other_name, other in known if other_name == name and other != arity)
    found = [f"{name}/{other}" for other in same]
    for close in get_close_matches(name, sorted({other for other, _ in known}), n=_PROPOSALS):
        found += [f"{close}/{other}" for other_name, other in known if other_name == close != name]
    return f": did you mean {either(found[:_PROPOSALS])}?" if found else ""
