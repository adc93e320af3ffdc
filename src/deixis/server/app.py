"""The application: routes, and what stands before them."""

from __future__ import annotations

from collections.abc import AsyncIterator, Awaitable, Callable, Mapping
from contextlib import asynccontextmanager
from types import MappingProxyType
from typing import Final

from fastapi import FastAPI
from fastapi.exceptions import RequestValidationError
from starlette.exceptions import HTTPException
from starlette.middleware.cors import CORSMiddleware
from starlette.middleware.trustedhost import TrustedHostMiddleware
from starlette.requests import Request
from starlette.responses import JSONResponse, Response
from starlette.routing import Route
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from deixis import __version__
from deixis.errors import DeixisError
from deixis.server.api import api
from deixis.server.dataset import Dataset
from deixis.server.events import Streams
from deixis.server.following import following
from deixis.server.graphs import Graphs
from deixis.server.page import page
from deixis.server.problems import Problem, not_allowed, problem, response
from deixis.server.protocol import Protocol
from deixis.server.settings import Settings

EMPTY: Final[Mapping[str, bytes]] = MappingProxyType({})

_POLICY = "default-src 'none'; frame-ancestors 'none'"
_GUARDS = {
    b"x-content-type-options": b"nosniff",
    b"referrer-policy": b"no-referrer",
    b"content-security-policy": _POLICY.encode(),
}


class Guards:
    """Puts headers on every response that keep a browser from making more of it than it is."""

    def __init__(self, app: ASGIApp) -> None:
        self._app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request on."""

        async def guarded(message: Message) -> None:
            if message["type"] == "http.response.start":
                headers = message["headers"]
                names = {name.lower() for name, _ in headers}
                headers.extend((name, value) for name, value in _GUARDS.items() if name not in names)
            await send(message)

        await self._app(scope, receive, guarded if scope["type"] == "http" else send)


def create_app(settings: Settings, scenes: Mapping[str, bytes], past: Mapping[str, bytes] = EMPTY) -> FastAPI:
    """Return the server as an ASGI application.

    Parameters
    ----------
    settings : Settings
    scenes : mapping of str to bytes
        Scene files by the ids of their scenes, loaded beside those in the store.
    past : mapping of str to bytes
        Of scenes that are maps: when relations held, as N-Quads.
    """
    dataset = Dataset(settings)

    @asynccontextmanager
    async def lifespan(_: FastAPI) -> AsyncIterator[None]:
        try:
            await dataset.start(dict(scenes), past)
            yield
        finally:
            await dataset.stop()

    app = FastAPI(
        title="Deixis",
        version=__version__,
        description="Scenes, their commonsense spatial relations, and why they hold. SPARQL is at /sparql.",
        docs_url=None,
        redoc_url=None,
        lifespan=lifespan,
        redirect_slashes=False,
    )
    for kind in (DeixisError, HTTPException, RequestValidationError):
        app.add_exception_handler(kind, _failed)
    protocol, graphs = Protocol(dataset, settings), Graphs(dataset, settings)
    for path in ("/sparql", "/sparql/"):
        app.router.routes.append(_route(path, protocol.handle, ["GET", "POST"]))
    for path in ("/graphs", "/graphs/{graph:path}"):
        app.router.routes.append(_route(path, graphs.handle, ["GET", "PUT", "POST", "DELETE"]))
    for path in ("/", "/page/{file:path}"):
        app.router.routes.append(_route(path, page, ["GET"]))
    limits = settings.limits
    # The other half of the connections is for those who ask.
    streams = Streams(max(1, min(limits.streams, limits.connections // 2)), limits.heartbeat)
    app.router.routes.append(_route("/health", _health(dataset, streams), ["GET"]))
    app.state.listed = list(app.router.routes)
    for router in (api(dataset, settings), following(dataset, settings, streams)):
        app.state.listed += router.routes
        app.include_router(router)
    app.state.hush = dataset.hush
    app.add_middleware(TrustedHostMiddleware, allowed_hosts=list(_hosts(settings)), www_redirect=False)
    if settings.origins:
        app.add_middleware(
            CORSMiddleware,
            allow_origins=list(settings.origins),
            allow_methods=["GET", "HEAD", "POST", "PUT", "DELETE"],
            allow_headers=["Authorization", "Content-Type", "Last-Event-ID"],
            expose_headers=["Deixis-Note", "Deixis-Truncated", "Location", "Retry-After"],
        )
    app.add_middleware(Guards)
    return app


def _route(path: str, handle: Callable[[Request], Awaitable[Response]], methods: list[str]) -> Route:
    return Route(path, handle, methods=methods)


def _health(dataset: Dataset, streams: Streams) -> Callable[[Request], Awaitable[Response]]:
    async def health(_: Request) -> Response:
        told = {"scenes": len(dataset.scenes), "quads": dataset.current.quads, "following": streams.open}
        return JSONResponse(told)

    return health


def _hosts(settings: Settings) -> set[str]:
    """Return the names by which the server may be called: a page that rebinds its own name is none."""
    own = set() if settings.host in ("0.0.0.0", "::") else {settings.host}  # noqa: S104 - asked, not bound
    return {"localhost", "127.0.0.1", *own, *settings.hosts}


async def _failed(request: Request, error: Exception) -> Response:
    match error:
        case DeixisError():
            return response(error)
        case RequestValidationError():
            text = "; ".join(f"{'.'.join(map(str, one['loc']))}: {one['msg']}" for one in error.errors()[:5])
            return problem(422, text)
        case HTTPException(status_code=405):
            return not_allowed(request)
        case HTTPException():
            return problem(error.status_code, str(error.detail), error.headers)
    raise Problem(500, "unexpected") from error
