"""What a server serves, spoken to without HTTP: nothing is left behind, and no two states are mixed."""

from __future__ import annotations

import asyncio
import json
from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import Any

import pytest

from deixis.rdf.evaluator import TooLarge
from deixis.server import Settings, reasons
from deixis.server.children import Child
from deixis.server.dataset import Dataset
from deixis.server.keepers import Keepers
from deixis.server.loaded import Loaded
from deixis.server.reasons import Reasons
from deixis.server.store import Store, StoreError
from endpoint import HANS
from scenes import box

LIFTED = b'{"moves": {"sweater": [0, 0, 0.1]}}'


def serving(work: Callable[[Dataset], Awaitable[None]], store: Path | None = None) -> None:
    """Do something with a dataset that has the sample scene."""

    async def run() -> None:
        dataset = Dataset(Settings(store=store, token="secret", writable=True))  # noqa: S106 - a test's
        try:
            await dataset.start({"hans": HANS.read_bytes()}, {})
            await work(dataset)
        finally:
            await dataset.stop()

    asyncio.run(run())


def test_what_cannot_be_kept_leaves_no_process_behind(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    begun: list[Child] = []
    original = Child.fork

    async def fork(self: Child) -> Child:
        begun.append(await original(self))
        return begun[-1]

    def full(*_: object) -> None:
        raise StoreError("no space left on device")

    async def work(dataset: Dataset) -> None:
        monkeypatch.setattr(Child, "fork", fork)
        for name in ("save", "remove", "save_graphs"):
            monkeypatch.setattr(Store, name, full)
        changes: list[Awaitable[object]] = [
            dataset.put("hans", HANS.read_bytes()),
            dataset.remove("hans"),
            dataset.change({"do": "drop", "name": "urn:none"}, b""),
        ]
        for change in changes:
            with pytest.raises(StoreError, match="no space"):
                await change
        assert begun
        assert not any(child.alive for child in begun)

    serving(work, tmp_path / "store")


def test_what_cannot_be_removed_is_said(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    store = Store(tmp_path / "store")
    store.save("room", '{"id": "room"}')

    def refused(*_: object, **__: object) -> None:
        raise PermissionError(1, "Operation not permitted")

    monkeypatch.setattr(Path, "unlink", refused)
    with pytest.raises(StoreError, match="cannot be removed: Operation not permitted"):
        store.remove("room")
    assert dict(store.scenes()) == {"room": b'{"id": "room"}'}
    store.close()


def test_a_page_is_of_the_event_that_it_names() -> None:
    async def work(dataset: Dataset) -> None:
        before = dataset.scenes["hans"]
        asked = asyncio.create_task(dataset.page_data("hans"))
        # It has begun to ask; just then the scene changes.
        await asyncio.sleep(0)
        lifted = Reasons()
        lifted.load(before.text, export=False)
        after = Loaded.of(*lifted.tell(LIFTED, most=0))
        after.event = "later"
        dataset.scenes = {"hans": after}
        for given, event in ((await asked, before.event), (await dataset.page_data("hans"), "later")):
            assert json.loads(given)["now"]["event"] == event

    serving(work)


class Idle:
    """A keeper's process that does nothing, and ends slowly."""

    def __init__(self) -> None:
        self.alive = True

    async def end(self) -> None:
        self.alive = False
        await asyncio.sleep(0)


def test_a_keeper_that_is_taken_is_not_ended_as_one_to_spare() -> None:
    async def make(_: bytes) -> Any:
        return Idle()

    async def work() -> None:
        keepers = Keepers(make, 1)
        one, two, three = [await keepers.take(name, "e", b"") for name in ("one", "two", "three")]
        # Three are known, two too many, and two of them are to spare at once.
        one.busy = two.busy = False
        giving = asyncio.create_task(keepers.give_back(three))
        await asyncio.sleep(0)
        again = await keepers.take("two", "e", b"")
        await giving
        assert again.child.alive
        await keepers.give_back(again)
        await keepers.close()

    asyncio.run(work())


def test_a_scene_that_could_not_be_read_again_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    kept = Reasons()
    kept.load(HANS.read_bytes(), export=False)
    size = len(kept.kb.scene.to_json().encode())
    monkeypatch.setattr(reasons, "MAX_FILE_BYTES", size + 10)
    kept.tell(b"{}", most=0)
    more = box("one more", (0, 0, 1), (0.1, 0.1, 0.1))
    with pytest.raises(TooLarge, match=f"the limit is {size + 10:,}"):
        kept.tell(json.dumps({"objects": [more]}).encode(), most=0)
