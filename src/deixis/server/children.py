"""The server's side of a child: a question, its answer, and the end of either."""

from __future__ import annotations

import asyncio
import contextlib
import json
import os
import socket
import subprocess
import sys
import time
from collections.abc import Mapping
from typing import Any, Final, Self, cast

from deixis.errors import EngineError
from deixis.server.wire import LENGTHS, packed

Answer = tuple[dict[str, Any], bytes]

_CALM: Final = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", "MKL_NUM_THREADS": "1"}
"""A process that is forked must have one thread: libraries are asked to start none."""

LEAST_PRIORITY: Final = 19


class Lost(EngineError):
    """The child ended before it answered: it was killed, or the memory limit was reached."""


class Child(asyncio.Protocol):
    """One child process, which answers one question at a time.

    Attributes
    ----------
    pid : int
    parent : Child or None
        The process it was forked from, which alone can end it safely; None for the first.
    """

    def __init__(self, end: socket.socket, pid: int, parent: Child | None) -> None:
        self._end, self.pid, self.parent = end, pid, parent
        self.alive = True
        self._buffer = bytearray()
        self._waiting: asyncio.Future[Answer] | None = None
        self._transport: asyncio.Transport | None = None
        self._turn = asyncio.Lock()
        self._process: subprocess.Popen[bytes] | None = None

    @classmethod
    async def first(cls) -> Self:
        """Start the process that all others are forked from."""
        ours, theirs = socket.socketpair()
        command = [sys.executable, "-m", "deixis.server.root", str(theirs.fileno())]
        process = subprocess.Popen(
            command,
            pass_fds=[theirs.fileno()],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            cwd="/",
            env=os.environ | _CALM,
            # Ctrl-C is for the server. In its session, for systems share time by session, then by priority.
            process_group=0,
        )
        theirs.close()
        child = await cls._connected(ours, process.pid, None)
        child._process = process
        return child

    async def fork(self) -> Child:
        """Return a new child that is like this one."""
        async with self._turn:
            ours, theirs = socket.socketpair()
            answer = self._answer()
            # A descriptor goes by the socket itself: asyncio has no word for it, and nothing waits before us.
            with theirs, contextlib.suppress(OSError):
                socket.send_fds(self._end, [packed({"do": "fork"})], [theirs.fileno()])
            header, _ = await answer
            return await self._connected(ours, header["pid"], self)

    @classmethod
    async def _connected(cls, end: socket.socket, pid: int, parent: Child | None) -> Self:
        child = cls(end, pid, parent)
        end.setblocking(False)
        await asyncio.get_running_loop().create_connection(lambda: child, sock=end)
        return child

    async def call(self, do: str, body: bytes = b"", **header: Any) -> Answer:
        """Ask, and return the answer.

        Raises
        ------
        Lost
            The child ended.
        """
        async with self._turn:
            return await self.ask({"do": do, **header}, body)

    def ask(self, header: Mapping[str, Any], body: bytes = b"") -> asyncio.Future[Answer]:
        """Ask, and return the answer to come; only when no other question is open."""
        if self._transport is not None and self.alive:
            self._transport.write(packed(header, body))
        return self._answer()

    def _answer(self) -> asyncio.Future[Answer]:
        self._waiting = asyncio.get_running_loop().create_future()
        if not self.alive:
            self._waiting.set_exception(Lost("a process that answers questions has ended: ask again"))
        return self._waiting

    def fail(self, error: Exception) -> None:
        """Let the open question end with an error, without waiting for the child."""
        if self._waiting is not None and not self._waiting.done():
            self._waiting.set_exception(error)

    def processor_seconds(self) -> float:
        """Return how long it has computed; the time of day where the system does not tell."""
        try:
            # The clock of another process, as clock_getcpuclockid makes its number on Linux.
            return time.clock_gettime((~self.pid << 3) | 2)
        except OSError:
            return time.monotonic()

    def demote(self, priority: int = LEAST_PRIORITY) -> None:
        """Let it go on after others; by default only when nothing else wants the processor."""
        with contextlib.suppress(ProcessLookupError, PermissionError):
            os.setpriority(os.PRIO_PROCESS, self.pid, priority)

    async def retire(self) -> None:
        """End it when all that it was asked up to now is answered."""
        async with self._turn:
            await self.end()

    async def end(self) -> None:
        """End it at once, whatever it does."""
        if self._transport is not None:
            self._transport.close()
        self.alive = False
        if self._process is not None:
            self._process.kill()
            await asyncio.to_thread(self._process.wait)
        elif self.parent is not None and self.parent.alive:
            with contextlib.suppress(Lost):
                await self.parent.call("kill", pid=self.pid)
        await asyncio.sleep(0)

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Keep the transport."""
        # A socket's transport, of whichever loop, writes: not every loop's says so by its class.
        self._transport = cast(asyncio.Transport, transport)

    def data_received(self, data: bytes) -> None:
        """Collect an answer."""
        self._buffer += data
        if len(self._buffer) < LENGTHS.size:
            return
        head, size = LENGTHS.unpack_from(self._buffer)
        start = LENGTHS.size + head
        if len(self._buffer) < start + size:
            return
        header = json.loads(self._buffer[LENGTHS.size : start])
        body = bytes(self._buffer[start : start + size])
        del self._buffer[: start + size]
        if self._waiting is not None and not self._waiting.done():
            self._waiting.set_result((header, body))

    def connection_lost(self, exc: Exception | None) -> None:  # noqa: ARG002 - asyncio's signature
        """Tell whoever waits."""
        self.alive = False
        self.fail(Lost("the question took more memory than the limit, or its process was ended"))
