"""PrologEngine: the rules and one scene's facts in a SWI-Prolog of its own, which a question cannot harm."""

from __future__ import annotations

import json
import tempfile
import threading
import time
from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, Self

from deixis.errors import EngineError, QueryError, QueryTimeout, RuleError
from deixis.prolog.child import Child
from deixis.prolog.find import find_prolog, find_pyswip
from deixis.prolog.quote import atom, string, term
from deixis.prolog.replies import result, spoils
from deixis.prolog.terms import Term, decode

MEMORY: Final = 2 << 30
"""What the child may use by default, bytes: half for Prolog's stacks, a quarter for tables."""

LONGEST_QUESTION: Final = 1 << 16
"""Characters."""

_LARGE: Final = 1 << 20
"""Characters of facts beyond which they go through a private file."""

_START_WITHIN: Final = 60.0
_LOAD_WITHIN: Final = 300.0


@dataclass(frozen=True)
class Answers:
    """The answers to a question.

    Attributes
    ----------
    bindings : tuple of mapping
        One for each distinct answer, in the order of the proofs: the value of each variable of the
        question, by the name it has there, without those whose name begins with ``_``. A question
        without variables has one empty answer where it holds.
    truncated : bool
        Whether there are more answers than the limit let through.
    output : str
        What the question printed.
    unknown : tuple of str
        Names in the question that a relation is asked of, and that no thing and no view has: to Prolog
        such a relation is false, and no error.
    """

    bindings: tuple[Mapping[str, Term], ...]
    truncated: bool = False
    output: str = ""
    unknown: tuple[str, ...] = ()

    def __bool__(self) -> bool:
        """Return whether the question holds."""
        return bool(self.bindings)


class PrologEngine:
    """Rule files and base facts in a child process with limits on time and memory.

    The child is started at once, and again by the next call whenever it was lost: then the rules and the
    facts are loaded anew. It may be used from many threads, one request at a time.

    Parameters
    ----------
    rule_files : sequence of path
        In the order of loading. Files with a module header are imported; others see all that was
        imported before.
    tabled : sequence of (str, int)
        Predicates of the rule files whose answers are kept in tables, so that recursion ends.
    memory_bytes : int
        Address space of the child.

    Raises
    ------
    PrologNotFoundError
        There is no usable SWI-Prolog.
    RuleError
        A rule file does not exist.

    Examples
    --------
    >>> with PrologEngine([]) as engine:
    ...     engine.ask("member(X, [cup, mug])", limit=1)
    Answers(bindings=({'X': Atom('cup')},), truncated=True, output='', unknown=())
    """

    def __init__(
        self,
        rule_files: Sequence[Path],
        *,
        tabled: Sequence[tuple[str, int]] = (),
        memory_bytes: int = MEMORY,
    ) -> None:
        self._rules = tuple(Path(file).resolve() for file in rule_files)
        for file in self._rules:
            if not file.is_file():
                raise RuleError(f"there is no rule file {file}")
        self._tabled = ",".join(f"{atom(name)}/{arity}" for name, arity in tabled)
        self._memory = memory_bytes
        self._facts: tuple[tuple[str, ...], ...] | None = None
        self._lock = threading.Lock()
        self._closed = False
        self._starting = False
        self._child: Child | None = None
        self._start()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def load(self, facts: str | Sequence[Sequence[str]]) -> int:
        """Replace all facts by those of a Prolog list, or of parts of several, and return how many there are.

        Parameters
        ----------
        facts : str or sequence of sequence of str
            What :func:`deixis.prolog.text.facts_text` returns, or :func:`~deixis.prolog.text.facts_parts`: of
            many facts parts are read faster, one beside the other, and lists take less memory.

        Raises
        ------
        EngineError
            The text is no list of base facts, or the child was lost. The facts are then what they were.
        RuleError
            The rule files do not load.
        """
        parts = ((facts,),) if isinstance(facts, str) else tuple(map(tuple, facts))
        with self._lock:
            child = self._ready()
            with ExitStack() as on_trouble:
                # What a failed load leaves is unknown: the next child begins with the facts of before.
                on_trouble.callback(self._drop)
                count = int(self._load(child, parts))
                on_trouble.pop_all()
            self._facts = parts
        return count

    def ask(
        self,
        goal: str,
        *,
        limit: int | None = None,
        timeout: float | None = 10.0,
        inferences: int | None = None,
    ) -> Answers:
        """Return the answers to a question in Prolog.

        Parameters
        ----------
        goal : str
            A goal, with or without the full stop. It may call what the rule files define or export, and
            what only computes.
        limit : int or None
            At most so many answers.
        timeout : float or None
            Seconds, after which the child is killed.
        inferences : int or None
            Steps of the proof, a limit that does not depend on the machine.

        Raises
        ------
        QueryError
            The question is no Prolog, calls what is not known or not allowed, or needs too much memory.
        QueryTimeout
            It took longer than ``timeout`` or ``inferences``.
        RuleError
            The rule files do not load, or a rule calls what none of them defines.
        EngineError
            The child was lost.
        """
        asked = string(question_text(goal))
        if limit is not None and limit < 1:
            raise QueryError(f"the limit is {limit}: ask for one answer at least")
        bounds = (str(int(bound)) if bound is not None else "none" for bound in (limit, inferences))
        reply = self._request(f"ask({asked},{','.join(bounds)})", timeout, goal)
        names = reply["names"]
        return Answers(
            tuple(dict(zip(names, map(decode, row), strict=True)) for row in reply["rows"]),
            reply["truncated"],
            reply["output"],
            tuple(reply["strangers"]),
        )

    def relations(
        self, predicates: Sequence[tuple[str, int]], *, timeout: float | None = 60.0
    ) -> dict[str, list[tuple[Term, ...]]]:
        """Return all answers of some predicates at once, each sorted and without repetition.

        Parameters
        ----------
        predicates : sequence of (str, int)
            Name and number of arguments; no name twice.
        timeout : float or None
            Seconds.

        Returns
        -------
        dict
            Name to rows, in the order asked for.

        Raises
        ------
        QueryError
            A predicate is not defined, has no argument, or a name is asked for twice.
        QueryTimeout
            It took too long.
        RuleError
            The rule files do not load, or a rule leaves a variable unbound.
        EngineError
            The child was lost.
        """
        names = [name for name, _ in predicates]
        if len(set(names)) < len(names) or any(arity < 1 for _, arity in predicates):
            raise QueryError("each relation is to be asked for once, and has one argument at least")
        wanted = ",".join(f"{atom(name)}/{int(arity)}" for name, arity in predicates)
        reply = self._request(f"relations([{wanted}])", timeout)
        cells = [decode(cell) for cell in reply["cells"]]
        found: dict[str, list[tuple[Term, ...]]] = {}
        for (name, arity), row in zip(predicates, reply["rows"], strict=True):
            values = iter([cells[at] for at in row])
            found[name] = list(zip(*[values] * arity, strict=True))
        return found

    def call(self, operation: str, *args: Term, timeout: float | None = 10.0) -> Any:
        """Return what an operation of the rule files says, as decoded JSON; None where it has no answer.

        Parameters
        ----------
        operation : str
            First argument of a clause of ``bridge:operation/3``.
        *args : Term
            A ``str`` becomes a Prolog string, an :class:`~deixis.prolog.terms.Atom` an atom.
        timeout : float or None
            Seconds.

        Raises
        ------
        QueryError, QueryTimeout, RuleError, EngineError
            As :meth:`ask`; EngineError also where no rule file defines the operation.
        """
        return self._request(f"call({atom(operation)},{term(list(args))})", timeout)

    def close(self) -> None:
        """End the child, also in the midst of a question; calling again does nothing."""
        self._closed = True
        child = self._child
        if child is not None:
            child.kill()
        with self._lock:
            self._drop()

    def _request(self, request: str, timeout: float | None, question: str = "") -> Any:
        """Return the result of one request; its time counts from when its turn comes."""
        with self._lock:
            child = self._ready()
            try:
                told = self._exchange(child, request, timeout)
            except TimeoutError:
                raise QueryTimeout(
                    f"no answer within {timeout:g} s: ask something narrower, or allow more time"
                ) from None
        return result(told, question)

    def _ready(self) -> Child:
        """Return a child that has the rules and the facts."""
        if self._closed:
            raise EngineError("the engine is closed")
        child = self._child
        if child is None or not child.usable:
            self._drop()
            child = self._start()
        if self._starting:
            with ExitStack() as on_trouble:
                on_trouble.callback(self._drop)
                self._greet(child)
                if self._facts is not None:
                    self._load(child, self._facts)
                on_trouble.pop_all()
            self._starting = False
        return child

    def _start(self) -> Child:
        """Start a child and hand it the rules, without waiting for it."""
        prolog = find_prolog()
        self._child = child = Child(prolog.library, prolog.home, find_pyswip(), self._memory)
        self._starting = True
        files = ",".join(atom(str(file)) for file in self._rules)
        child.send(f"rules([{files}],[{self._tabled}])", None)
        return child

    def _greet(self, child: Child) -> None:
        """Wait until the rules are loaded."""
        try:
            result(json.loads(child.receive(time.monotonic() + _START_WITHIN)))
        except TimeoutError:
            raise EngineError(f"the rules did not load within {_START_WITHIN:g} s") from None

    def _load(self, child: Child, parts: tuple[tuple[str, ...], ...]) -> Any:
        lists = [one for part in parts for one in part]
        try:
            if sum(map(len, lists)) < _LARGE:
                return result(self._exchange(child, f"load([{','.join(lists)}])", _LOAD_WITHIN))
            # Prolog reads a file faster than a string, which is copied on its way.
            with ExitStack() as files:
                names = []
                for part in parts:
                    file = files.enter_context(
                        tempfile.NamedTemporaryFile("w", encoding="utf-8", prefix="deixis-")
                    )
                    file.writelines(f"{one} .\n" for one in part)
                    file.flush()
                    names.append(atom(file.name))
                return result(self._exchange(child, f"load_files([{','.join(names)}])", _LOAD_WITHIN))
        except TimeoutError:
            raise EngineError(f"the facts did not load within {_LOAD_WITHIN:g} s") from None
        except QueryError as error:
            raise EngineError(f"the facts cannot be loaded: {error}") from error

    def _exchange(self, child: Child, request: str, timeout: float | None) -> dict[str, Any]:
        """Return the reply to one request; whatever prevents it, a signal too, costs the child."""
        deadline = None if timeout is None else time.monotonic() + timeout
        with ExitStack() as on_trouble:
            on_trouble.callback(self._drop)
            try:
                child.send(request, deadline)
                told: dict[str, Any] = json.loads(child.receive(deadline))
            except EngineError:
                if self._closed:
                    raise EngineError("the engine was closed before it could answer") from None
                raise
            if not spoils(told):
                on_trouble.pop_all()
        return told

    def _drop(self) -> None:
        if self._child is not None:
            self._child.close()
        self._child = None


def question_text(goal: str) -> str:
    """Return the text of a question, if it may be sent at all.

    Raises
    ------
    QueryError
        It is empty, or longer than :data:`LONGEST_QUESTION`.

    Examples
    --------
    >>> question_text("on_top_of(X, table).")
    'on_top_of(X, table).'
    """
    if not goal.strip(" \t\r\n."):
        raise QueryError("the question is empty")
    if len(goal) > LONGEST_QUESTION:
        raise QueryError(f"the question is longer than {LONGEST_QUESTION} characters")
    return goal
