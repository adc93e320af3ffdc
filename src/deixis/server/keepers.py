"""Processes that keep scenes while they change: each takes the updates of one scene, one after the other.

They are others than those that answer questions, so no question holds up an update, nor the other way round.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Awaitable, Callable
from dataclasses import dataclass

from deixis.server.children import Child


@dataclass(slots=True, eq=False)
class Keeper:
    """A process that keeps a scene.

    Attributes
    ----------
    name : str
    child : Child
    event : str or None
        As of which event it has the scene; None while it is ahead of what is served, or may be.
    busy : bool
        Whether it is needed now.
    """

    name: str
    child: Child
    event: str | None
    busy: bool = False


class Keepers:
    """The keepers of the scenes updated of late.

    Parameters
    ----------
    make : callable
        Returns a process that has taken in a scene in JSON.
    most : int
        How many stay when nobody needs them.
    """

    def __init__(self, make: Callable[[bytes], Awaitable[Child]], most: int) -> None:
        self._make, self._most = make, most
        self._known: OrderedDict[str, Keeper] = OrderedDict()

    async def take(self, name: str, event: str, text: bytes) -> Keeper:
        """Return the keeper of a scene as of an event; until it is given back nobody else may take it."""
        keeper = self._known.pop(name, None)
        if keeper is not None and (keeper.event != event or not keeper.child.alive):
            if not keeper.busy:
                await keeper.child.end()
            keeper = None
        if keeper is None:
            keeper = Keeper(name, await self._make(text), event)
        keeper.busy = True
        self._known[name] = keeper
        return keeper

    async def give_back(self, keeper: Keeper) -> None:
        """Let others take a keeper; the one that was not needed for longest may be ended."""
        keeper.busy = False
        if self._known.get(keeper.name) is not keeper:
            await keeper.child.end()
        spare = [name for name, one in self._known.items() if not one.busy]
        # All at once: while one is ended, others may be taken.
        ended = [self._known.pop(name) for name in spare[: max(0, len(self._known) - self._most)]]
        for one in ended:
            await one.child.end()

    async def close(self) -> None:
        """End all."""
        while self._known:
            await self._known.popitem()[1].child.end()
