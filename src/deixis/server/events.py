"""What happens to a scene, told to those who follow it: numbered events, the last of them kept.

All who follow read the same list, each in its own time: of a client nothing is kept but its place in it. One
that reads too slowly, or was away for too long, finds its place gone and is told to load the scene anew.
"""

from __future__ import annotations

import asyncio
import json
import secrets
from collections import deque
from collections.abc import AsyncIterator
from typing import Final

from fastapi.sse import KEEPALIVE_COMMENT, format_sse_event
from starlette.responses import StreamingResponse
from starlette.types import Receive, Scope, Send

from deixis.server.problems import Overloaded

FOLLOWS: Final = "deixis.follows"
"""In the scope of a request that is answered by a stream of events."""

_MOST: Final = 1000
"""Events that are kept of a scene, however short."""

_AGAIN: Final = 2000
"""Milliseconds after which a client should connect again when the connection is lost."""

_MISSED: Final = "events were missed that are not kept any more"

_HEADERS: Final = {"Cache-Control": "no-store", "X-Accel-Buffering": "no"}
"""Neither a cache nor a proxy may hold events back."""


class Events:
    """The events of one scene.

    Parameters
    ----------
    kept : int
        Bytes of events that are kept.

    Examples
    --------
    >>> events = Events(100)
    >>> first = events.add("changes", '{"gained": [], "lost": []}')
    >>> first == events.last, events.after(0)[1].decode().splitlines()[0]
    (True, 'event: changes')
    """

    def __init__(self, kept: int) -> None:
        # A number alone might be one of another life of the server.
        self._life, self._number = secrets.token_hex(4), 0
        self._most, self._size = kept, 0
        self._kept: deque[bytes] = deque()
        self._news = asyncio.Event()
        self.ended = False

    @property
    def last(self) -> str:
        """Return the id of the last event."""
        return self.name(self._number)

    def name(self, number: int) -> str:
        """Return the id of an event."""
        return f"{self._life}-{number}"

    def add(self, kind: str, data: str) -> str:
        """Add an event; return its id."""
        self._number += 1
        text = format_sse_event(event=kind, data_str=data, id=self.last)
        self._kept.append(text)
        self._size += len(text)
        while len(self._kept) > 1 and (self._size > self._most or len(self._kept) > _MOST):
            self._size -= len(self._kept.popleft())
        self._wake()
        return self.last

    def end(self) -> None:
        """Let the streams end."""
        self.ended = True
        self._wake()

    def place(self, name: str) -> int | None:
        """Return the number of an event by its id; None where it is none of ours."""
        life, _, number = name.partition("-")
        known = life == self._life and number.isascii() and number.isdigit() and len(number) < 20
        return int(number) if known and int(number) <= self._number else None

    def after(self, number: int) -> tuple[int, bytes] | None:
        """Return the event after another, and its number; None where there is none.

        Raises
        ------
        LookupError
            It is not kept any more.
        """
        if number == self._number:
            return None
        at = number - self._number + len(self._kept)
        if at < 0:
            raise LookupError(number)
        return number + 1, self._kept[at]

    async def news(self) -> None:
        """Wait for what happens next."""
        await self._news.wait()

    def _wake(self) -> None:
        self._news.set()
        self._news = asyncio.Event()

    async def since(self, name: str | None, heartbeat: float) -> AsyncIterator[bytes]:
        """Yield what happened since an event, and what happens from now on, as text/event-stream."""
        at = self._number if name is None else self.place(name)
        # Whoever loses the connection before anything happened goes on from here.
        yield format_sse_event(retry=_AGAIN, id=None if at is None else self.name(at))
        while True:
            try:
                found = self.after(-1 if at is None else at)
            except LookupError:
                at = self._number
                data = json.dumps({"because": _MISSED})
                yield format_sse_event(event="reload", data_str=data, id=self.last)
                continue
            if found is not None:
                at, text = found
                yield text
            elif self.ended:
                return
            else:
                try:
                    async with asyncio.timeout(heartbeat):
                        await self.news()
                except TimeoutError:
                    yield KEEPALIVE_COMMENT


class Streams:
    """All clients that follow a scene: at most so many.

    Parameters
    ----------
    most : int
    heartbeat : float
        Seconds.
    """

    def __init__(self, most: int, heartbeat: float) -> None:
        self._most, self._heartbeat = most, heartbeat
        self.open = 0

    def response(self, events: Events, since: str | None) -> Stream:
        """Return a stream of what happened since an event, and happens from now on.

        Raises
        ------
        Overloaded
            There are too many.
        """
        if self.open >= self._most:
            raise Overloaded(f"{self.open} clients follow scenes already: ask again later")
        return Stream(self, events.since(since, self._heartbeat))


class Stream(StreamingResponse):
    """One client's; it is counted until the client is gone."""

    media_type = "text/event-stream"

    def __init__(self, streams: Streams, content: AsyncIterator[bytes]) -> None:
        super().__init__(content, headers=_HEADERS)
        self._streams = streams
        streams.open += 1

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Send what happens for as long as the client stays."""
        scope[FOLLOWS] = True
        try:
            await super().__call__(scope, receive, send)
        finally:
            self._streams.open -= 1
