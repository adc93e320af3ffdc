"""What is served: scenes, the graphs that clients wrote, and the snapshot that readers see.

Changes come one after the other. Each makes a whole new snapshot beside the old one, is brought to the
disk, and then takes the old one's place: a reader sees all of a scene or nothing of it.
"""

from __future__ import annotations

import asyncio
from collections import OrderedDict
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from deixis.errors import DeixisError, QueryTimeout, SceneError
from deixis.rdf.names import SceneNames
from deixis.server.children import Answer, Child, Lost
from deixis.server.lanes import Memory
from deixis.server.problems import Overloaded, Problem, raised
from deixis.server.settings import Settings
from deixis.server.snapshot import Snapshot
from deixis.server.store import Store


@dataclass(frozen=True, slots=True)
class Loaded:
    """A scene as it is served."""

    told: dict[str, Any]
    text: bytes
    quads: bytes
    graphs: dict[str, str]

    def with_past(self, quads: bytes, graph: str) -> Loaded:
        """Return it with when relations held, in a graph of its own."""
        return replace(self, quads=self.quads + quads, graphs=self.graphs | {"history": graph})


class Dataset:
    """All that a server serves.

    Parameters
    ----------
    settings : Settings
    """

    def __init__(self, settings: Settings) -> None:
        self._settings = settings
        self._store = None if settings.store is None else Store(settings.store)
        self._memory = Memory()
        self._changing, self._waking = asyncio.Lock(), asyncio.Lock()
        self._awake: OrderedDict[str, tuple[Loaded, Child]] = OrderedDict()
        self._asked: dict[str, int] = {}
        self._own = b""
        self.scenes: dict[str, Loaded] = {}
        self._root: Child | None = None
        self._current: Snapshot | None = None

    @property
    def current(self) -> Snapshot:
        """Return what readers see now."""
        if self._current is None:
            raise Problem(503, "the server is starting: ask again in a moment", {"Retry-After": "1"})
        return self._current

    @property
    def root(self) -> Child:
        """Return the process that others are forked from."""
        if self._root is None:
            raise AssertionError("the server was not started")
        return self._root

    async def start(self, scenes: dict[str, bytes], past: Mapping[str, bytes]) -> None:
        """Load what is in the store, and some scenes more, which are put into it; not so their past."""
        self._root = await Child.first()
        kept = dict(self._store.scenes()) if self._store else {}
        self._own = self._store.graphs() if self._store else b""
        for name, text in (kept | scenes).items():
            loaded = await self._load(name, text)
            if name in past:
                loaded = loaded.with_past(past[name], SceneNames(name).history)
            self.scenes[name] = loaded
            if self._store and kept.get(name) != loaded.text:
                self._store.save(name, loaded.text.decode())
        self._current = await self._snapshot(self.scenes, self._own)

    async def stop(self) -> None:
        """End all processes."""
        for _, child in self._awake.values():
            await child.end()
        if self._current is not None:
            await self._current.retire()
        if self._root is not None:
            await self._root.end()
        if self._store is not None:
            self._store.close()

    async def put(self, name: str, text: bytes) -> tuple[Loaded, bool]:
        """Take in a scene; return it, and whether it is new."""
        async with self._changing:
            loaded = await self._load(name, text)
            scenes = self.scenes | {name: loaded}
            snapshot = await self._snapshot(scenes, self._own)
            if self._store is not None:
                await asyncio.to_thread(self._store.save, name, loaded.text.decode())
            new = name not in self.scenes
            await self._swap(snapshot, scenes, self._own)
            return loaded, new

    async def remove(self, name: str) -> bool:
        """Remove a scene; return whether there was one."""
        async with self._changing:
            if name not in self.scenes:
                return False
            scenes = {one: loaded for one, loaded in self.scenes.items() if one != name}
            snapshot = await self._snapshot(scenes, self._own)
            if self._store is not None:
                await asyncio.to_thread(self._store.remove, name)
            await self._swap(snapshot, scenes, self._own)
            return True

    async def change(self, header: dict[str, Any], body: bytes) -> None:
        """Carry out an update, or write or drop a graph, in a process of its own."""
        async with self._changing:
            child = await self.current.worker()
            try:
                _, own = await self._answered(child, header, body, self._settings.limits.timeout)
            finally:
                await child.end()
            snapshot = await self._snapshot(self.scenes, own)
            if self._store is not None:
                await asyncio.to_thread(self._store.save_graphs, own)
            await self._swap(snapshot, self.scenes, own)

    async def reason(self, name: str, do: str, header: dict[str, Any] | None = None) -> dict[str, Any]:
        """Ask the process of one scene."""
        return (await self._reasoned(name, do, header))[0]

    async def page(self, name: str) -> bytes:
        """Return the page of one scene."""
        return (await self._reasoned(name, "view", {"timeout": self._settings.limits.timeout}))[1]

    async def _reasoned(self, name: str, do: str, header: dict[str, Any] | None) -> Answer:
        limits = self._settings.limits
        loaded = self.scenes.get(name)
        if loaded is None:
            raise Problem(404, f"there is no scene {name!r}: GET /scenes lists those there are")
        if self._asked.get(name, 0) >= limits.workers:
            raise Overloaded(f"{limits.workers} questions about this scene are waiting: ask again later")
        self._asked[name] = self._asked.get(name, 0) + 1
        try:
            child = await self._wake(name, loaded)
            message = {"do": do} | ({} if header is None else {"with": header})
            # The engines have time-outs of their own; this one is for what does not keep to them.
            return await self._answered(child, message, b"", 2.0 * limits.timeout)
        finally:
            self._asked[name] -= 1

    async def _wake(self, name: str, loaded: Loaded) -> Child:
        async with self._waking:
            known = self._awake.get(name)
            if known is not None and known[0] is loaded and known[1].alive:
                self._awake.move_to_end(name)
                return known[1]
            child = await self._reasoner()
            message = {"do": "scene", "export": False}
            await self._answered(child, message, loaded.text, self._settings.limits.timeout)
            if known is not None:
                await known[1].end()
            self._awake[name] = loaded, child
            self._awake.move_to_end(name)
            while len(self._awake) > self._settings.limits.scenes_awake:
                _, (_, oldest) = self._awake.popitem(last=False)
                await oldest.end()
            return child

    async def _reasoner(self) -> Child:
        child = await self.root.fork()
        await child.call("restrict", memory=2 * self._settings.limits.memory, files=True)
        return child

    async def _load(self, name: str, text: bytes) -> Loaded:
        child = await self._reasoner()
        try:
            message = {"do": "scene", "export": True}
            told, quads = await self._answered(child, message, text, 6.0 * self._settings.limits.timeout)
        finally:
            await child.end()
        if told["id"] != name:
            raise SceneError(
                f"the scene calls itself {told['id']!r}: its id and its address must be the same"
            )
        plain = {key: told[key] for key in ("id", "objects", "views", "notes")}
        return Loaded(plain, told["text"].encode(), quads, told["graphs"])

    async def _answered(self, child: Child, header: dict[str, Any], body: bytes, timeout: float) -> Answer:
        """Ask a child, and end it if it takes too long or is lost."""
        try:
            async with asyncio.timeout(timeout):
                answer = await child.call(header.pop("do"), body, **header)
        except TimeoutError:
            await child.end()
            raise QueryTimeout(f"no answer within {timeout:g} s: ask something narrower") from None
        told = answer[0]
        if told.get("error") == "unexpected":
            raise Lost(f"a process failed: {told['text'].strip().splitlines()[-1]}")
        if "error" in told:
            raise raised(told["error"], told["text"])
        return answer

    async def _snapshot(self, scenes: dict[str, Loaded], own: bytes) -> Snapshot:
        quads = b"".join(one.quads for one in scenes.values())
        owned = [name for one in scenes.values() for name in one.graphs.values()]
        try:
            return await Snapshot.of(self.root, quads, own, owned, self._settings.limits, self._memory)
        except TimeoutError:
            raise DeixisError("the dataset took too long to load: serve fewer scenes") from None

    async def _swap(self, snapshot: Snapshot, scenes: dict[str, Loaded], own: bytes) -> None:
        old, self._current = self.current, snapshot
        self.scenes, self._own = scenes, own
        await old.retire()
