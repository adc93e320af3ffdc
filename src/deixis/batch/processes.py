"""Processes that work through items, any of which may end at any moment without harm to the others.

Each has a pipe of its own, and nothing is shared: where processes take turns at one queue, as in the pools
that there are, one that is ended while it holds the lock of the queue stops all (decision 0054).
"""

from __future__ import annotations

import multiprocessing
import signal
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from multiprocessing.connection import Connection, wait
from typing import Any, Final, Generic, Self, TypeVar

Item = TypeVar("Item")
Result = TypeVar("Result")

# Started anew, not forked: what threads of this process hold must not be copied.
_CONTEXT = multiprocessing.get_context("spawn")

_PATIENCE: Final = 5.0
"""Seconds in which a process whose pipe is closed ends by itself, and says why."""


@dataclass(frozen=True, slots=True)
class Ended(Generic[Item]):
    """What an item comes to whose process ended: the item, and the process's exit code, -9 after SIGKILL."""

    item: Item
    code: int


class Processes:
    """Some processes; started when there is something to do, ended with the ``with`` block.

    Parameters
    ----------
    count : int

    Examples
    --------
    >>> with Processes(2) as processes:
    ...     sorted(processes.each(abs, [-2, 3, -4]))
    [2, 3, 4]
    """

    def __init__(self, count: int) -> None:
        self._seats = [_Seat() for _ in range(count)]

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        for seat in self._seats:
            seat.end()

    def each(
        self, function: Callable[[Item], Result], items: Iterable[Item]
    ) -> Iterator[Result | Ended[Item]]:
        """Yield what a function returns for each item, as it comes; one call of this at a time.

        An exception that it raises is raised here. Items are taken as processes get ready for them.
        """
        todo = iter(items)
        free, busy = list(self._seats), dict[Any, tuple[_Seat, Item]]()
        while True:
            for seat, item in zip(tuple(free), todo):  # noqa: B905 - stops at whichever is first at its end
                free.remove(seat)
                busy[seat.give(function, item)] = seat, item
            if not busy:
                return
            for pipe in wait(list(busy)):
                seat, item = busy.pop(pipe)
                free.append(seat)
                try:
                    good, told = seat.take()
                except (EOFError, OSError):
                    yield Ended(item, seat.end(_PATIENCE))
                    continue
                if not good:
                    raise told
                yield told


class _Seat:
    """One process at a time, and this end of its pipe."""

    def __init__(self) -> None:
        self._process: Any = None
        self._pipe: Any = None

    def give(self, function: Callable[[Any], object], item: object) -> Connection:
        """Send an item to the process, started if need be; return the pipe that says when it is done."""
        if self._process is not None and not self._process.is_alive():
            self.end()
        if self._process is None:
            self._pipe, other = _CONTEXT.Pipe()
            self._process = _CONTEXT.Process(target=_serve, args=(other,), daemon=True)
            self._process.start()
            other.close()
        # Where it has just ended, `take` will see that.
        with suppress(BrokenPipeError):
            self._pipe.send((function, item))
        pipe: Connection = self._pipe
        return pipe

    def take(self) -> Any:
        """Return whether it went well, and the result or the exception."""
        return self._pipe.recv()

    def end(self, patience: float = 0.0) -> int:
        """End the process, if it has not ended after so many seconds; return its exit code."""
        if self._process is None:
            return 0
        self._process.join(patience)
        self._process.kill()
        self._process.join()
        code: int = self._process.exitcode
        self._pipe.close()
        self._process = self._pipe = None
        return code


def _serve(pipe: Connection) -> None:
    """Do what comes through the pipe, until nobody is at its other end."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # for whoever started this process to decide
    try:
        while True:
            function, item = pipe.recv()
            try:
                told = True, function(item)
            except Exception as error:  # noqa: BLE001 - raised on the other side
                told = False, error
            pipe.send(told)
    except (EOFError, BrokenPipeError):
        return
