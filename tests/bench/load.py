"""A load on an HTTP server: connections that ask, wait for the answer and ask again, for some seconds.

    python -m bench.load PORT CONNECTIONS SECONDS < requests.json

Runs in a process of its own, so that it does not hold up what it measures. Prints as JSON the seconds that
each honest answer took, how many honest requests failed, and how many hostile ones were sent.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import sys
import time

import uvloop

MOST_OPEN = 512
"""Hostile requests that may be open at the same time."""

BACK_OFF = 0.01
"""Seconds until one that was hung up on tries again: at once would take the processor from the rest."""


async def ask(reader: asyncio.StreamReader, writer: asyncio.StreamWriter, request: bytes) -> int:
    """Send a request and read its answer; return the status."""
    writer.write(request)
    head = await reader.readuntil(b"\r\n\r\n")
    lowered = head.lower()
    _, found, rest = lowered.partition(b"content-length:")
    if found:
        await reader.readexactly(int(rest.split(b"\r\n", 1)[0]))
    elif b"transfer-encoding: chunked" in lowered:
        while size := int((await reader.readline()).strip() or b"0", 16):
            await reader.readexactly(size + 2)
        await reader.readline()
    return int(head.split(b" ", 2)[1])


class Load:
    """Honest clients, and hostile requests sent beside theirs without waiting for the answer."""

    def __init__(self, port: int, seconds: float, honest: list[bytes], hostile: list[bytes]) -> None:
        self.port, self.honest, self.hostile = port, honest, hostile
        self.end = time.perf_counter() + seconds
        self.taken: list[float] = []
        self.failed = self.sent = 0
        self._open: set[asyncio.Task[None]] = set()

    async def client(self, at: int) -> None:
        """Ask until the time is over; reconnect where the server hung up."""
        while time.perf_counter() < self.end:
            try:
                reader, writer = await asyncio.open_connection("127.0.0.1", self.port)
            except OSError:
                self.failed += 1
                await asyncio.sleep(BACK_OFF)
                continue
            try:
                while time.perf_counter() < self.end:
                    at += 1
                    if at % 9 == 0 and self.hostile and len(self._open) < MOST_OPEN:
                        self._attack()
                    start = time.perf_counter()
                    async with asyncio.timeout(30):
                        status = await ask(reader, writer, self.honest[at % len(self.honest)])
                    if status == 200:
                        self.taken.append(time.perf_counter() - start)
                    else:
                        self.failed += 1
            except (OSError, asyncio.IncompleteReadError, TimeoutError):
                self.failed += 1
                await asyncio.sleep(BACK_OFF)
            finally:
                writer.close()

    def _attack(self) -> None:
        self.sent += 1
        task = asyncio.get_running_loop().create_task(
            self._hostile(self.hostile[self.sent % len(self.hostile)])
        )
        self._open.add(task)
        task.add_done_callback(self._open.discard)

    async def _hostile(self, request: bytes) -> None:
        with contextlib.suppress(OSError, asyncio.IncompleteReadError, TimeoutError):
            reader, writer = await asyncio.open_connection("127.0.0.1", self.port)
            try:
                async with asyncio.timeout(30):
                    await ask(reader, writer, request)
            finally:
                writer.close()


async def main(port: int, connections: int, seconds: float) -> None:
    """Run the load and print what came of it."""
    given = json.load(sys.stdin)
    honest, hostile = ([one.encode() for one in given[kind]] for kind in ("honest", "hostile"))
    load = Load(port, seconds, honest, hostile)
    await asyncio.gather(*(load.client(n * 7) for n in range(connections)))
    print(json.dumps({"taken": load.taken, "failed": load.failed, "hostile": load.sent}))


if __name__ == "__main__":
    uvloop.install()
    asyncio.run(main(int(sys.argv[1]), int(sys.argv[2]), float(sys.argv[3])))
