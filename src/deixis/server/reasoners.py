"""Processes that have a scene: those that load one, and those that are kept ready to answer questions."""

from __future__ import annotations

import asyncio
from collections import OrderedDict
from collections.abc import Mapping
from typing import Any

from deixis.errors import QueryTimeout, SceneError
from deixis.server.children import Answer, Child, Lost
from deixis.server.loaded import Loaded
from deixis.server.problems import Overloaded, raised
from deixis.server.settings import Limits


async def answered(child: Child, header: Mapping[str, Any], body: bytes = b"", *, timeout: float) -> Answer:
    """Ask a child, and end it if it takes too long or is lost."""
    given = dict(header)
    try:
        async with asyncio.timeout(timeout):
            answer = await child.call(given.pop("do"), body, **given)
    except TimeoutError:
        await child.end()
        raise QueryTimeout(f"no answer within {timeout:g} s: ask something narrower") from None
    told = answer[0]
    if told.get("error") == "unexpected":
        raise Lost(f"a process failed: {told['text'].strip().splitlines()[-1]}")
    if "error" in told:
        raise raised(told["error"], told["text"])
    return answer


class Reasoners:
    """The processes of scenes.

    Parameters
    ----------
    root : Child
        What they are forked from.
    limits : Limits
    """

    def __init__(self, root: Child, limits: Limits) -> None:
        self._root, self._limits = root, limits
        self._waking = asyncio.Lock()
        self._awake: OrderedDict[str, tuple[Loaded, Child]] = OrderedDict()
        self._asked: dict[str, int] = {}
        self._retiring: set[asyncio.Task[None]] = set()

    async def load(self, name: str, text: bytes) -> Loaded:
        """Return a scene with its quads, by a process of its own."""
        child = await self._new()
        try:
            message = {"do": "scene", "export": True}
            told, quads = await answered(child, message, text, timeout=6.0 * self._limits.timeout)
        finally:
            await child.end()
        if told["id"] != name:
            raise SceneError(
                f"the scene calls itself {told['id']!r}: its id and its address must be the same"
            )
        return Loaded.of(told, told["text"].encode(), quads)

    async def of(self, text: bytes) -> Child:
        """Return a new process that has taken in a scene."""
        child = await self._new()
        try:
            message = {"do": "scene", "export": False}
            await answered(child, message, text, timeout=2.0 * self._limits.timeout)
        except BaseException:
            await child.end()
            raise
        return child

    async def ask(self, name: str, loaded: Loaded, do: str, given: Mapping[str, Any] | None) -> Answer:
        """Ask the process of a scene."""
        limits = self._limits
        if self._asked.get(name, 0) >= limits.workers:
            raise Overloaded(f"{limits.workers} questions about this scene are waiting: ask again later")
        self._asked[name] = self._asked.get(name, 0) + 1
        try:
            child = await self._wake(name, loaded)
            message = {"do": do} | ({} if given is None else {"with": given})
            # The engines have time-outs of their own; this one is for what does not keep to them.
            return await answered(child, message, timeout=2.0 * limits.timeout)
        finally:
            self._asked[name] -= 1
            if not self._asked[name]:
                del self._asked[name]

    async def close(self) -> None:
        """End those that are kept ready."""
        for task in self._retiring:
            task.cancel()
        for _, child in self._awake.values():
            await child.end()

    async def _wake(self, name: str, loaded: Loaded) -> Child:
        async with self._waking:
            known = self._awake.get(name)
            if known is not None and known[0] is loaded and known[1].alive:
                self._awake.move_to_end(name)
                return known[1]
            child = await self.of(loaded.text)
            if known is not None:
                self._retire(known[1])
            self._awake[name] = loaded, child
            self._awake.move_to_end(name)
            while len(self._awake) > self._limits.scenes_awake:
                self._retire(self._awake.popitem(last=False)[1][1])
            return child

    def _retire(self, child: Child) -> None:
        """End a process when it has answered: the scene of before may have been asked about just now."""
        task = asyncio.get_running_loop().create_task(child.retire())
        self._retiring.add(task)
        task.add_done_callback(self._retiring.discard)

    async def _new(self) -> Child:
        child = await self._root.fork()
        await child.call("restrict", memory=2 * self._limits.memory, files=True)
        return child
