"""Connections with bounds: on how long a request may take to come, how large its head is, who never reads.

uvicorn waits for the rest of a request, and for a client to read, as long as the client likes. Here a
connection that is waited for is closed after some seconds; and when there are too many, the one that has been
waited for longest makes room. So whoever sends a byte a second holds up nobody who sends whole requests.
"""

from __future__ import annotations

import asyncio
import resource
from typing import Any, ClassVar, Final

from uvicorn.protocols.http.httptools_impl import HttpToolsProtocol

from deixis.server.events import FOLLOWS
from deixis.server.problems import problem
from deixis.server.settings import Limits

_PHRASES: Final = {408: "Request Timeout", 431: "Request Header Fields Too Large"}

_OTHER_FILES: Final = 256
"""Descriptors that the server needs beside those of its connections."""

_LEAST_READ: Final = 1024
"""Bytes a second that a client must read at least."""


class Connection(HttpToolsProtocol):
    """One connection; made by uvicorn, of the class that :func:`bounded` returns."""

    limits: ClassVar[Limits]
    most: ClassVar[int]
    awaited: ClassVar[dict[Connection, None]]
    """Those whose next request has not come in full, the longest awaited first."""

    _head_late: asyncio.TimerHandle | None = None
    _stuck: asyncio.TimerHandle | None = None
    _got = 0
    _begun = False

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """Take the connection; where there are too many, another one is closed."""
        super().connection_made(transport)
        self._await()
        longest = next(iter(self.awaited))
        if len(self.connections) > self.most and longest is not self:
            # It is told of its end later, and others may come before that.
            self.awaited.pop(longest)
            self.connections.discard(longest)
            longest.transport.abort()

    def connection_lost(self, exc: Exception | None) -> None:
        """Forget it."""
        for timer in (self._head_late, self._stuck):
            if timer is not None:
                timer.cancel()
        self._head_late = self._stuck = None
        self.awaited.pop(self, None)
        super().connection_lost(exc)

    def shutdown(self) -> None:
        """End after the answer that is being sent; a stream of events that nobody reads ends now."""
        super().shutdown()
        if self._stuck is not None and FOLLOWS in self.cycle.scope:
            self.transport.abort()

    def data_received(self, data: bytes) -> None:
        """Take what comes, up to a bound."""
        self._got += len(data)
        super().data_received(data)
        if self._got <= self.limits.head or self.transport.is_closing():
            return
        if self._head_late is not None:
            self._refuse(431, f"the head of the request is larger than {self.limits.head} bytes")
        elif self._got > self.limits.head + 2 * self.limits.body:
            # More than the body can be: what surrounds its chunks, or comes after them.
            self.transport.abort()

    def on_message_begin(self) -> None:
        """Begin a request."""
        self._begun = True
        super().on_message_begin()

    def on_headers_complete(self) -> None:
        """Begin to answer."""
        if self._head_late is not None:
            self._head_late.cancel()
            self._head_late = None
        super().on_headers_complete()

    def on_message_complete(self) -> None:
        """Note that a request is there in full."""
        self._got, self._begun = 0, False
        self.awaited.pop(self, None)
        super().on_message_complete()

    def on_response_complete(self) -> None:
        """Wait for the next request, unless it is there already."""
        super().on_response_complete()
        if self.cycle.response_complete and not self.transport.is_closing():
            self._await()

    def pause_writing(self) -> None:
        """See to it that a client reads what it asked for."""
        super().pause_writing()
        self._stuck = self.loop.call_later(
            self.limits.send_seconds, self._look, self.transport.get_write_buffer_size()
        )

    def resume_writing(self) -> None:
        """Go on."""
        if self._stuck is not None:
            self._stuck.cancel()
            self._stuck = None
        super().resume_writing()

    def _await(self) -> None:
        self.awaited.pop(self, None)
        self.awaited[self] = None
        if self._head_late is not None:
            self._head_late.cancel()
        self._head_late = self.loop.call_later(self.limits.head_seconds, self._give_up)

    def _give_up(self) -> None:
        # Before the first request there is no cycle.
        if self._begun and getattr(self.cycle, "response_complete", True):
            self._refuse(408, f"the head of the request did not come within {self.limits.head_seconds:g} s")
        self.transport.close()

    def _refuse(self, status: int, detail: str) -> None:
        body = bytes(problem(status, detail).body)
        head = (
            f"HTTP/1.1 {status} {_PHRASES[status]}\r\ncontent-type: application/problem+json\r\n"
            f"content-length: {len(body)}\r\nconnection: close\r\n\r\n"
        )
        self.transport.write(head.encode() + body)
        self.transport.close()

    def _look(self, before: int) -> None:
        left = self.transport.get_write_buffer_size()
        if before - left < _LEAST_READ * self.limits.send_seconds:
            self.transport.abort()
        else:
            self._stuck = self.loop.call_later(self.limits.send_seconds, self._look, left)


def bounded(of: Limits) -> type[Connection]:
    """Return the class of a server's connections.

    Parameters
    ----------
    of : Limits

    Examples
    --------
    >>> issubclass(bounded(Limits(connections=10)), Connection)
    True
    """

    class Bounded(Connection):
        limits = of
        most = room(of.connections)
        awaited: ClassVar[dict[Any, None]] = {}

    return Bounded


def room(wanted: int) -> int:
    """Return how many connections there may be: files are raised to as many as the system allows."""
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    needed = wanted + _OTHER_FILES
    if soft != resource.RLIM_INFINITY and soft < needed:
        soft = needed if hard == resource.RLIM_INFINITY else min(needed, hard)
        resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))
    return wanted if soft == resource.RLIM_INFINITY else max(1, min(wanted, soft - _OTHER_FILES))
