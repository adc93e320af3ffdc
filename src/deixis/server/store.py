"""Scenes and graphs on disk: a file for each, written whole or not at all, on the disk before it is told."""

from __future__ import annotations

import fcntl
import hashlib
import json
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Final

from deixis.errors import DeixisError

_DRAFT: Final = ".part"


class StoreError(DeixisError):
    """The directory cannot be used as a store, or a file in it cannot be written."""


class Store:
    """A directory of scenes, used by one server at a time.

    Parameters
    ----------
    path : Path
        Made if need be.

    Raises
    ------
    StoreError
        Another server uses it, or it cannot be written.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as place:
    ...     store = Store(Path(place) / "store")
    ...     store.save("flat 2", '{"deixis": 1, "id": "flat 2"}')
    ...     dict(store.scenes())
    ...     store.close()
    {'flat 2': b'{"deixis": 1, "id": "flat 2"}'}
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._scenes, self._own = path / "scenes", path / "graphs.nq"
        try:
            self._scenes.mkdir(parents=True, exist_ok=True)
            self._lock = (path / "lock").open("a+", encoding="utf-8")
        except OSError as error:
            raise StoreError(f"{path} cannot be a store: {error.strerror}") from None
        try:
            fcntl.flock(self._lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            self._lock.seek(0)
            owner = self._lock.read().strip()
            raise StoreError(f"{path} is used by the server with process id {owner}: stop it first") from None
        self._lock.truncate(0)
        self._lock.write(str(os.getpid()))
        self._lock.flush()
        # What a killed server left half written was never told to anyone.
        for draft in (*self._scenes.glob(f"*{_DRAFT}"), *path.glob(f"*{_DRAFT}")):
            draft.unlink()

    def close(self) -> None:
        """Let another server use it."""
        self._lock.close()

    def scenes(self) -> Iterator[tuple[str, bytes]]:
        """Yield id and text of each scene, by id."""
        found = {}
        for file in self._scenes.glob("*.json"):
            text = file.read_bytes()
            try:
                name = str(json.loads(text)["id"])
            except (ValueError, KeyError, TypeError):
                raise StoreError(f"{file} is no scene: repair it or move it away") from None
            found[name] = text
        yield from sorted(found.items())

    def save(self, name: str, text: str) -> None:
        """Keep a scene."""
        self._write(self._file(name), text.encode())

    def remove(self, name: str) -> None:
        """Remove a scene."""
        place = self._file(name)
        try:
            place.unlink(missing_ok=True)
            _settle(self._scenes)
        except OSError as error:
            raise StoreError(f"{place} cannot be removed: {error.strerror}") from error

    def graphs(self) -> bytes:
        """Return what clients wrote, as N-Quads."""
        return self._own.read_bytes() if self._own.exists() else b""

    def save_graphs(self, quads: bytes) -> None:
        """Keep what clients wrote."""
        self._write(self._own, quads)

    def _file(self, name: str) -> Path:
        # An id is anyone's, and may be longer than a file's name.
        return self._scenes / f"{hashlib.sha256(name.encode()).hexdigest()}.json"

    def _write(self, place: Path, data: bytes) -> None:
        draft = place.with_name(place.name + _DRAFT)
        try:
            with draft.open("wb") as file:
                file.write(data)
                file.flush()
                os.fsync(file.fileno())
            draft.replace(place)
            _settle(place.parent)
        except OSError as error:
            draft.unlink(missing_ok=True)
            raise StoreError(f"{place} cannot be written: {error.strerror}") from error


def _settle(folder: Path) -> None:
    """Bring a folder's list of files to the disk: until then a rename may be forgotten."""
    handle = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)
