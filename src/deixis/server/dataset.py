"""What is served: scenes, the graphs that clients wrote, and the snapshot that readers see.

Changes come one after the other. Each makes a whole new snapshot beside the old one, is brought to the
disk, and then takes the old one's place: a reader sees all of a scene or nothing of it. An update of a scene
is brought to the disk and told; the snapshot is made anew when it is asked for next.
"""

from __future__ import annotations

import asyncio
import json
import time
from collections.abc import AsyncIterator, Mapping
from contextlib import asynccontextmanager
from typing import Any, Final

from deixis.errors import DeixisError, QueryTimeout, SceneError
from deixis.rdf.names import SceneNames
from deixis.server.children import Answer, Child
from deixis.server.events import Events
from deixis.server.keepers import Keeper, Keepers
from deixis.server.lanes import Memory
from deixis.server.loaded import Life, Loaded
from deixis.server.problems import Overloaded, Problem
from deixis.server.reasoners import Reasoners, answered
from deixis.server.settings import Settings
from deixis.server.snapshot import Snapshot
from deixis.server.store import Store

_PAUSE: Final = 30.0
"""Seconds for which graphs that could not be made are not tried again."""


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
        # Snapshots are made one after the other; what is on the disk and what is served change together.
        self._changing, self._committing = asyncio.Lock(), asyncio.Lock()
        self._lives: dict[str, Life] = {}
        self._waiting = 0
        # How many updates there were, and how many of them the snapshot has.
        self._updates = self._seen = 0
        self._refreshing: asyncio.Task[None] | None = None
        self._own = b""
        # Of scenes that are maps: when relations held, as it was known at the start.
        self._past: dict[str, bytes] = {}
        self.scenes: dict[str, Loaded] = {}
        self._processes: tuple[Child, Reasoners, Keepers] | None = None
        self._current: Snapshot | None = None

    @property
    def current(self) -> Snapshot:
        """Return what readers see now."""
        if self._current is None:
            raise Problem(503, "the server is starting: ask again in a moment", {"Retry-After": "1"})
        return self._current

    @property
    def processes(self) -> tuple[Child, Reasoners, Keepers]:
        """Return the process that others are forked from, those that reason, and those that keep."""
        if self._processes is None:
            raise AssertionError("the server was not started")
        return self._processes

    async def start(self, scenes: dict[str, bytes], past: Mapping[str, bytes]) -> None:
        """Load what is in the store, and some scenes more, which are put into it; not so their past."""
        root, limits = await Child.first(), self._settings.limits
        reasoners = Reasoners(root, limits)
        self._processes = root, reasoners, Keepers(reasoners.of, limits.scenes_awake)
        kept = dict(self._store.scenes()) if self._store else {}
        self._own = self._store.graphs() if self._store else b""
        self._past = {name: quads for name, quads in past.items() if name in scenes}
        for name, text in (kept | scenes).items():
            loaded = self._with_past(name, await reasoners.load(name, text))
            self._serve(name, loaded)
            if self._store and kept.get(name) != loaded.text:
                self._store.save(name, loaded.text.decode())
        self._current = await self._snapshot(self.scenes, self._own)

    def hush(self) -> None:
        """Let all streams of events end."""
        for life in self._lives.values():
            life.events.end()

    async def stop(self) -> None:
        """End all processes."""
        if self._refreshing is not None:
            self._refreshing.cancel()
        if self._current is not None:
            await self._current.retire()
        if self._processes is not None:
            root, reasoners, keepers = self._processes
            await reasoners.close()
            await keepers.close()
            await root.end()
        if self._store is not None:
            self._store.close()

    async def put(self, name: str, text: bytes) -> tuple[Loaded, bool]:
        """Take in a scene; return it, and whether it is new."""
        async with self._changing:
            loaded = await self.processes[1].load(name, text)
            seen = self._updates
            snapshot = await self._snapshot(self.scenes | {name: loaded}, self._own)
            async with _kept(snapshot), self._committing:
                if self._store is not None:
                    await asyncio.to_thread(self._store.save, name, loaded.text.decode())
                new = name not in self.scenes
                self._past.pop(name, None)
                self._serve(name, loaded, '{"because": "the scene was replaced"}')
            await self._swap(snapshot, seen)
            return loaded, new

    async def remove(self, name: str) -> bool:
        """Remove a scene; return whether there was one."""
        async with self._changing:
            if name not in self.scenes:
                return False
            seen = self._updates
            scenes = {one: loaded for one, loaded in self.scenes.items() if one != name}
            snapshot = await self._snapshot(scenes, self._own)
            async with _kept(snapshot), self._committing:
                if self._store is not None:
                    await asyncio.to_thread(self._store.remove, name)
                self.scenes = {one: loaded for one, loaded in self.scenes.items() if one != name}
                self._past.pop(name, None)
                events = self._lives.pop(name).events
                events.add("gone", '{"because": "the scene was removed"}')
                events.end()
            await self._swap(snapshot, seen)
            return True

    async def update(self, name: str, text: bytes) -> dict[str, Any]:
        """Take in an update of a scene; return what it changed."""
        if self._waiting >= self._settings.limits.updates:
            raise Overloaded(f"{self._waiting} updates are waiting: send the next when one has its answer")
        self._waiting += 1
        try:
            while True:
                life = self._life(name)
                async with life.turn:
                    told = None if self._lives.get(name) is not life else await self._told(name, text)
                if told is not None:
                    return told
                # Replaced meanwhile: what the update says may mean something else now.
        finally:
            self._waiting -= 1

    async def _told(self, name: str, text: bytes) -> dict[str, Any] | None:
        """Tell a scene's keeper; return what changed, None where the scene was replaced meanwhile."""
        limits, loaded, keepers = self._settings.limits, self._loaded(name), self.processes[2]
        keeper = await keepers.take(name, loaded.event, loaded.text)
        try:
            # Until it is on the disk, the keeper is ahead of what is served.
            keeper.event = None
            header = {"do": "tell", "with": {"most": limits.event}}
            try:
                answer = await answered(keeper.child, header, text, timeout=2.0 * limits.timeout)
            except SceneError:
                keeper.event = loaded.event
                raise
            except QueryTimeout:
                seconds = 2.0 * limits.timeout
                raise QueryTimeout(
                    f"the update took more than {seconds:g} s and changes nothing: send less at once"
                ) from None
            return await self._commit(name, loaded, keeper, *answer)
        finally:
            await keepers.give_back(keeper)

    async def _commit(
        self, name: str, before: Loaded, keeper: Keeper, header: Mapping[str, Any], body: bytes
    ) -> dict[str, Any] | None:
        """Serve a scene as an update has made it, unless it is another one by now."""
        after = self._with_past(name, Loaded.of(header, body[: header["split"]]))
        changes, count = body[header["split"] :].decode(), header["count"]
        async with self._committing:
            if self.scenes.get(name) is not before:
                return None
            if self._store is not None:
                await asyncio.to_thread(self._store.save, name, after.text.decode())
            kind, data = "changes", changes
            if not changes:
                kind = "reload"
                data = json.dumps({"because": f"{count} relations changed: more than one event tells"})
            keeper.event = after.event = self._lives[name].events.add(kind, data)
            self.scenes = self.scenes | {name: after}
            self._updates += 1
        found = json.loads(changes) if changes else {"gained": [], "lost": []}
        return {"stamp": None, **found, "event": after.event, "count": count, "truncated": not changes}

    def events(self, name: str) -> Events:
        """Return what happens to a scene."""
        return self._life(name).events

    def _with_past(self, name: str, loaded: Loaded) -> Loaded:
        """Return the scene with the name of the graph of its past among its graphs."""
        if name in self._past:
            loaded.graphs = loaded.graphs | {"history": SceneNames(name).history}
        return loaded

    def _life(self, name: str) -> Life:
        self._loaded(name)
        return self._lives[name]

    def _loaded(self, name: str) -> Loaded:
        loaded = self.scenes.get(name)
        if loaded is None:
            raise Problem(404, f"there is no scene {name!r}: GET /scenes lists those there are")
        return loaded

    def _serve(self, name: str, loaded: Loaded, because: str = "") -> None:
        """Serve a scene from now on, and tell those who follow it."""
        life = self._lives.get(name)
        if life is None:
            life = self._lives[name] = Life(self._settings.limits.kept)
            loaded.event = life.events.last
        else:
            loaded.event = life.events.add("reload", because)
        self.scenes = self.scenes | {name: loaded}

    async def fresh(self) -> Snapshot:
        """Return what readers see now; where scenes were updated, it is made anew.

        Raises
        ------
        QueryTimeout
            That takes longer than a question may take; it goes on.
        """
        wanted, limits = self._updates, self._settings.limits
        try:
            async with asyncio.timeout(limits.timeout):
                while self._seen < wanted:
                    if self._refreshing is None or self._refreshing.done():
                        self._refreshing = asyncio.get_running_loop().create_task(self._refresh())
                        self._refreshing.add_done_callback(_noted)
                    await asyncio.shield(self._refreshing)
        except TimeoutError:
            raise QueryTimeout("the graphs of a scene that was updated are being made: ask again") from None
        return self.current

    async def _refresh(self) -> None:
        async with self._changing:
            seen = self._updates
            await self._swap(await self._snapshot(self.scenes, self._own), seen)

    async def change(self, header: dict[str, Any], body: bytes) -> None:
        """Carry out an update, or write or drop a graph, in a process of its own."""
        await self.fresh()
        async with self._changing:
            child = await self.current.worker()
            try:
                _, own = await answered(child, header, body, timeout=self._settings.limits.timeout)
            finally:
                await child.end()
            seen = self._updates
            snapshot = await self._snapshot(self.scenes, own)
            async with _kept(snapshot):
                if self._store is not None:
                    await asyncio.to_thread(self._store.save_graphs, own)
            self._own = own
            await self._swap(snapshot, seen)

    async def reason(self, name: str, do: str, header: dict[str, Any] | None = None) -> dict[str, Any]:
        """Ask the process of one scene."""
        return (await self._reasoned(name, do, header))[0]

    async def page(self, name: str) -> bytes:
        """Return the page of one scene."""
        return (await self._shown(name, "view", self._loaded(name)))[1]

    async def page_data(self, name: str) -> bytes:
        """Return the data of the page of one scene, in JSON."""
        loaded = self._loaded(name)
        if loaded.page is None:
            work = self._shown(name, "shown", loaded)
            loaded.page = asyncio.get_running_loop().create_task(work)

            def noted(task: asyncio.Task[Answer]) -> None:
                if task.cancelled() or task.exception() is not None:
                    loaded.page = None

            loaded.page.add_done_callback(noted)
        return (await asyncio.shield(loaded.page))[1]

    async def _shown(self, name: str, do: str, loaded: Loaded) -> Answer:
        """Ask for a page or its data, which are those of one state of the scene and name its event."""
        given = {"timeout": self._settings.limits.timeout, "event": loaded.event}
        return await self.processes[1].ask(name, loaded, do, given)

    async def _reasoned(self, name: str, do: str, given: dict[str, Any] | None) -> Answer:
        return await self.processes[1].ask(name, self._loaded(name), do, given)

    async def _export(self, name: str, loaded: Loaded) -> bytes:
        """Return the quads of a scene, made now if it was updated."""
        if loaded.quads is None:
            if loaded.failed is None or time.monotonic() > loaded.failed[0] + _PAUSE:
                try:
                    loaded.quads = (await self.processes[1].load(name, loaded.text)).quads or b""
                    return loaded.quads
                except DeixisError as error:
                    loaded.failed = time.monotonic(), str(error)
            raise Problem(
                503,
                f"the graphs of scene {name!r} could not be made: {loaded.failed[1]}; "
                "an update that makes it smaller helps, or to remove it",
                {"Retry-After": str(int(_PAUSE))},
            )
        return loaded.quads

    async def _snapshot(self, scenes: dict[str, Loaded], own: bytes) -> Snapshot:
        exports = [await self._export(name, one) for name, one in scenes.items()]
        past = [self._past[name] for name, one in scenes.items() if "history" in one.graphs]
        quads = b"".join([*exports, *past])
        owned = [name for one in scenes.values() for name in one.graphs.values()]
        root = self.processes[0]
        try:
            return await Snapshot.of(root, quads, own, owned, self._settings.limits, self._memory)
        except TimeoutError:
            raise DeixisError("the dataset took too long to load: serve fewer scenes") from None

    async def _swap(self, snapshot: Snapshot, seen: int) -> None:
        """Show readers a snapshot, which has so many updates."""
        old, self._current, self._seen = self.current, snapshot, seen
        await old.retire()


@asynccontextmanager
async def _kept(snapshot: Snapshot) -> AsyncIterator[None]:
    """Give up a snapshot, with its processes, if what is to be done before it is shown fails."""
    try:
        yield
    except BaseException:
        await snapshot.retire()
        raise


def _noted(task: asyncio.Task[None]) -> None:
    """Take note of how a task ended: whoever waits for it is told, and the next who asks tries again."""
    if not task.cancelled():
        task.exception()
