"""``deixis serve``: the application on a socket, until it is told to stop."""

from __future__ import annotations

import errno
import logging
import socket
from collections.abc import Callable, Sequence
from contextlib import suppress
from typing import Final

import uvicorn

from deixis.addresses import is_map
from deixis.errors import DeixisError
from deixis.scene import Scene
from deixis.server.app import create_app
from deixis.server.connections import bounded
from deixis.server.settings import Settings

_BACKLOG: Final = 512


class _Server(uvicorn.Server):
    """A server that says when it listens, and does not wait for clients that follow a scene."""

    def __init__(
        self, config: uvicorn.Config, ready: Callable[[], object], hush: Callable[[], object]
    ) -> None:
        super().__init__(config)
        self._ready, self._hush = ready, hush

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        await super().startup(sockets)
        if self.started:
            self._ready()

    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        self._hush()
        await super().shutdown(sockets)


class _Unbound(logging.Filter):
    """Keeps the error that an address cannot be bound out of uvicorn's log: it is ours to tell."""

    def __init__(self) -> None:
        super().__init__()
        self.error: OSError | None = None

    def filter(self, record: logging.LogRecord) -> bool:
        if not isinstance(record.msg, OSError):
            return True
        self.error = record.msg
        return False

    @property
    def reason(self) -> str:
        if self.error is None or self.error.errno == errno.EADDRINUSE:
            return "is the port taken?"
        # asyncio puts in front of it what it attempted.
        return str(self.error.strerror).rpartition(": ")[2]


def serve(scenes: Sequence[str], settings: Settings, ready: Callable[[], object] = lambda: None) -> None:
    """Serve scene files and maps, and return when the server is stopped.

    Of a map the scene as it was told last is served, and when each relation held, as it is known now.

    Parameters
    ----------
    scenes : sequence of str
        Files, or addresses of maps.
    settings : Settings
    ready : callable
        Called as soon as clients may come.

    Raises
    ------
    SceneError, MapError
        A file is no scene, or a map cannot be read.
    DeixisError
        Two scenes have the same id, or updates are allowed to everyone.
    """
    if settings.writable and settings.token is None:
        raise DeixisError("--writable needs a token: set --token or DEIXIS_TOKEN")
    texts: dict[str, bytes] = {}
    past: dict[str, bytes] = {}
    for address in scenes:
        if is_map(address):
            scene, quads = _mapped(address)
            past[scene.id] = quads
        else:
            scene = Scene.load(address)
        if scene.id in texts:
            raise DeixisError(f"two of them hold a scene {scene.id!r}: rename one")
        texts[scene.id] = scene.to_json().encode()
    connection = bounded(settings.limits)
    app = create_app(settings, texts, past)
    config = uvicorn.Config(
        app,
        host=settings.host,
        port=settings.port,
        access_log=False,
        # What a client does wrong is answered, and is no news: a log can be filled.
        log_level="error",
        proxy_headers=False,
        server_header=False,
        date_header=True,
        backlog=_BACKLOG,
        http=connection,
        # Where all connections are busy, none can make room.
        limit_concurrency=connection.most + 1,
        timeout_graceful_shutdown=5,
        ws="none",
        lifespan="on",
    )
    server = _Server(config, ready, app.state.hush)
    unbound, log = _Unbound(), logging.getLogger("uvicorn.error")
    log.addFilter(unbound)
    try:
        # Where it cannot start it would end the process with the code of a time-out.
        with suppress(SystemExit):
            server.run()
    finally:
        log.removeFilter(unbound)
    if not server.started:
        raise DeixisError(f"the server could not start on {settings.host}:{settings.port}: {unbound.reason}")


def _mapped(address: str) -> tuple[Scene, bytes]:
    """Return the scene of a map as it was told last, and its history as N-Quads."""
    # Not before there is a map: it takes a while.
    from deixis.rdf.history import history_nquads
    from deixis.semantic_map import open_map

    with open_map(address) as kept:
        scene = kept.scene()
        return scene, history_nquads(scene, kept.intervals(), kept.labels(), kept.views())
