"""One state of the dataset, and the processes that answer questions about it.

A question is answered by a child that was forked ready. What is slow goes on with the least priority, and
only a few of them at a time; what takes too long, or whose asker is gone, is killed. The state never
changes: a change makes another one.
"""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Awaitable, Callable, Sequence
from typing import Any, Final, Self

from deixis.errors import QueryTimeout
from deixis.server.children import Answer, Child, Lost
from deixis.server.lanes import Lane, Memory
from deixis.server.problems import Gone, Overloaded, raised
from deixis.server.settings import Limits

_log = logging.getLogger(__name__)

_LOOKS: Final = 4
"""How often a question is looked at before it can be slow."""

_HURRY: Final = 2.0
"""By how much patience is shorter while there is no room for another slow question."""

_UNKNOWN: Final = 10
"""Priority of a question that was not asked before: 19 is the least."""

_LOADING: Final = 600.0
"""Seconds that loading a dataset may take."""


class Snapshot:
    """A loaded dataset with its workers; made by :meth:`of`.

    Attributes
    ----------
    names : list of str
        The named graphs.
    """

    def __init__(self, home: Child, limits: Limits, memory: Memory) -> None:
        self._home, self._limits, self._memory = home, limits, memory
        self._quick = Lane(limits.workers, limits.queue, self.worker)
        self._new = Lane(limits.newcomers, limits.queue, self._later_worker)
        self._slow = self._users = 0
        self._tasks: set[asyncio.Task[None]] = set()
        self._retired = False
        self.names: list[str] = []
        self.quads = 0

    @classmethod
    async def of(
        cls, root: Child, quads: bytes, own: bytes, owned: Sequence[str], limits: Limits, memory: Memory
    ) -> Self:
        """Return a dataset, loaded and with a worker ready."""
        home = await root.fork()
        made = cls(home, limits, memory)
        try:
            async with asyncio.timeout(_LOADING):
                header, _ = await home.call("load", quads + own, split=len(quads), owned=list(owned))
                if "error" in header:
                    raise raised(header["error"], header["text"])
                made.quads = header["quads"]
                made.names = (await home.call("names"))[0]["names"]
                await made._quick.fill()
                await made._new.fill()
        except BaseException:
            await home.end()
            raise
        return made

    async def worker(self) -> Child:
        """Return a new process with the dataset in it, which can open nothing and has a memory limit."""
        child = await self._home.fork()
        await child.call("restrict", memory=self._limits.memory, files=False, leaf=True)
        return child

    async def _later_worker(self) -> Child:
        """Return a worker for questions that nobody knows yet: they come after those that are known."""
        child = await self.worker()
        child.demote(_UNKNOWN)
        return child

    async def ask(
        self,
        header: dict[str, Any],
        body: bytes = b"",
        *,
        gone: Callable[[], Awaitable[object]] | None = None,
        timeout: float | None = None,
    ) -> Answer:
        """Return the answer of a worker.

        Parameters
        ----------
        header : dict
            With what to do as ``do``.
        body : bytes
        gone : callable, optional
            Returns when the asker is gone.
        timeout : float, optional
            Seconds, by default and at most the server's.

        Raises
        ------
        QueryTimeout
            It took longer.
        Overloaded
            Too many questions are open, or too many slow ones.
        Lost
            It took more memory than the limit.
        """
        self._users += 1
        try:
            return await self._asked(
                header, body, gone, min(timeout or self._limits.timeout, self._limits.timeout)
            )
        finally:
            self._users -= 1
            if self._retired and not self._users:
                self._later(self._close())

    async def _asked(
        self,
        header: dict[str, Any],
        body: bytes,
        gone: Callable[[], Awaitable[object]] | None,
        timeout: float,
    ) -> Answer:
        lane = self._quick if body in self._memory.quick else self._new
        known = body in self._memory.slow
        if known:
            self._admit_slow()
            try:
                child = await lane.worker()
            except BaseException:
                self._slow -= 1
                raise
        else:
            child = await lane.enter()
        loop = asyncio.get_running_loop()
        slow, watcher = known, None
        used = child.processor_seconds()

        def look() -> None:
            """Tell whether the question is slow: by the processor's time, for the others' may be meant."""
            nonlocal slow, watcher
            if gone is not None and watcher is None:
                watcher = loop.create_task(_tell(gone, child))
            if slow:
                return
            patience = self._limits.patience / (_HURRY if self._slow >= self._limits.slow else 1.0)
            if child.processor_seconds() - used < patience:
                timers[1] = loop.call_later(step, look)
                return
            self._memory.was_slow(body)
            try:
                self._admit_slow()
            except Overloaded as error:
                child.fail(error)
                return
            slow = True
            child.demote()
            lane.leave()

        late = QueryTimeout(f"no answer within {timeout:g} s: ask something narrower, or add a LIMIT")
        step = self._limits.patience / _LOOKS
        timers = [loop.call_later(timeout, child.fail, late), loop.call_later(step, look)]
        well = False
        try:
            if known:
                child.demote()
            answer = await child.ask(header, body)
            well = not slow
        finally:
            for timer in timers:
                timer.cancel()
            if watcher is not None:
                watcher.cancel()
            if slow:
                self._slow -= 1
            else:
                lane.leave()
            if well and child.alive:
                self._memory.was_quick(body)
                lane.take_back(child)
            else:
                self._later(self._replace(child, lane))
        told = answer[0]
        if "error" in told:
            if told["error"] == "unexpected":
                _log.error("a worker failed: %s", told["text"])
                raise Lost("the question could not be answered: the log of the server tells why")
            raise raised(told["error"], told["text"])
        return answer

    def _admit_slow(self) -> None:
        if self._slow >= self._limits.slow:
            raise Overloaded(f"{self._slow} slow questions are being answered: ask again later, or narrower")
        self._slow += 1

    async def _replace(self, child: Child, lane: Lane) -> None:
        await child.end()
        if not self._retired:
            await lane.fill()

    def _later(self, work: Any) -> None:
        task = asyncio.get_running_loop().create_task(work)
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

    async def retire(self) -> None:
        """End it as soon as the last question it is asked has its answer."""
        self._retired = True
        if not self._users:
            await self._close()

    async def _close(self) -> None:
        await self._quick.close()
        await self._new.close()
        await self._home.end()


async def _tell(gone: Callable[[], Awaitable[object]], child: Child) -> None:
    await gone()
    child.fail(Gone("the client closed the connection"))
