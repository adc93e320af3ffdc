"""Who is answered when: a lane has places, workers of one priority, and a queue."""

from __future__ import annotations

import asyncio
from collections import OrderedDict, deque
from collections.abc import Awaitable, Callable
from typing import Final

from deixis.server.children import Child
from deixis.server.problems import Overloaded

_REMEMBERED: Final = 4096
"""Texts that are kept in mind."""


class Texts:
    """Texts of late, by their hashes; the oldest forgotten first.

    Examples
    --------
    >>> slow = Texts()
    >>> slow.add(b"SELECT ...")
    >>> b"SELECT ..." in slow, b"ASK {}" in slow
    (True, False)
    """

    def __init__(self) -> None:
        self._known: OrderedDict[int, None] = OrderedDict()

    def add(self, text: bytes) -> None:
        """Remember a text."""
        key = hash(text)
        self._known[key] = None
        self._known.move_to_end(key)
        if len(self._known) > _REMEMBERED:
            self._known.popitem(last=False)

    def discard(self, text: bytes) -> None:
        """Forget a text."""
        self._known.pop(hash(text), None)

    def __contains__(self, text: bytes) -> bool:
        return hash(text) in self._known


class Memory:
    """What is known of questions by their texts: which were slow of late, and which quick."""

    def __init__(self) -> None:
        self.slow, self.quick = Texts(), Texts()

    def was_slow(self, text: bytes) -> None:
        """Remember that a question was slow."""
        self.slow.add(text)
        self.quick.discard(text)

    def was_quick(self, text: bytes) -> None:
        """Remember that a question was quick."""
        if text not in self.quick:
            self.quick.add(text)


class Lane:
    """Places for questions that are answered at the same time, and a queue for the others.

    Parameters
    ----------
    places, queue : int
        How many questions are answered, and how many may wait.
    make : callable
        Returns a new worker.
    """

    def __init__(self, places: int, queue: int, make: Callable[[], Awaitable[Child]]) -> None:
        self._places, self._queue, self._make = places, queue, make
        self._idle: list[Child] = []
        self._taken = 0
        self._waiting: deque[asyncio.Future[None]] = deque()

    async def enter(self) -> Child:
        """Take a place, as soon as there is one, and a worker.

        Raises
        ------
        Overloaded
            Too many wait already.
        """
        if self._taken >= self._places:
            if len(self._waiting) >= self._queue:
                raise Overloaded(f"{self._queue} questions are waiting: ask again later")
            turn: asyncio.Future[None] = asyncio.get_running_loop().create_future()
            self._waiting.append(turn)
            try:
                await turn
            except asyncio.CancelledError:
                if turn.done() and not turn.cancelled():
                    self.leave()
                raise
        else:
            self._taken += 1
        try:
            return await self.worker()
        except BaseException:
            self.leave()
            raise

    def leave(self) -> None:
        """Pass the place to the next in the queue, or give it up."""
        while self._waiting:
            turn = self._waiting.popleft()
            if not turn.done():
                turn.set_result(None)
                return
        self._taken -= 1

    async def worker(self) -> Child:
        """Return a worker that waits, or a new one."""
        while self._idle:
            child = self._idle.pop()
            if child.alive:
                return child
        return await self._make()

    def take_back(self, child: Child) -> None:
        """Keep a worker for the next question."""
        self._idle.append(child)

    async def fill(self) -> None:
        """Have a worker ready for each place."""
        while len(self._idle) + self._taken < self._places:
            self._idle.append(await self._make())

    async def close(self) -> None:
        """End the workers that wait."""
        while self._idle:
            await self._idle.pop().end()
