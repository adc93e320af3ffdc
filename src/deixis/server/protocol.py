"""The SPARQL 1.1 Protocol: queries and updates over HTTP, and the service description."""

from __future__ import annotations

import asyncio
from collections.abc import Sequence
from functools import lru_cache
from typing import Any, Final

from starlette.requests import Request
from starlette.responses import Response

from deixis.errors import QueryError
from deixis.rdf.description import description
from deixis.server import incoming
from deixis.server.dataset import Dataset
from deixis.server.media import GRAPHS, TABLES, content_type, wanted
from deixis.server.problems import Problem
from deixis.server.rewriting import absolute, limited, using
from deixis.server.screening import Screened, screen
from deixis.server.settings import Settings
from deixis.server.terms import unknown_terms

_QUERY: Final = "application/sparql-query"
_UPDATE: Final = "application/sparql-update"
_FORM: Final = "application/x-www-form-urlencoded"
_GRAPH_FORMS: Final = frozenset(("CONSTRUCT", "DESCRIBE"))
_TABLES, _GRAPHS = tuple(TABLES), tuple(GRAPHS)

_SHORT: Final = 4096
"""Characters of a query that is kept in mind: a thousand of them are a few megabytes."""

_ENCODED: Final = 12
"""Bytes that a character may take in a form."""

NOT_KEPT: Final = {"Cache-Control": "no-store", "Vary": "Accept"}
"""Answers are of this moment."""


class Protocol:
    """The endpoint.

    Parameters
    ----------
    dataset : Dataset
    settings : Settings
    """

    def __init__(self, dataset: Dataset, settings: Settings) -> None:
        self._dataset, self._settings = dataset, settings
        self._kept = lru_cache(1024)(self._prepare)

    async def handle(self, request: Request) -> Response:
        """Answer one request."""
        url = incoming.fields_of(request.scope["query_string"])
        if request.method in ("GET", "HEAD"):
            if any(name == "update" for name, _ in url):
                raise Problem(405, "updates are sent with POST", {"Allow": "POST"})
            if not any(name == "query" for name, _ in url):
                return await self._description(request)
            return await self._query(request, _one(url, "query"), url)
        media = incoming.media_of(request)
        if media not in (_FORM, _QUERY, _UPDATE):
            raise Problem(415, f"send {_FORM}, {_QUERY} or {_UPDATE}, and say so in Content-Type")
        if media == _UPDATE:
            incoming.must_be_writable(request, self._settings)
        body = await incoming.body_of(request, self._settings, self._most(request))
        if media == _FORM:
            form = incoming.fields_of(body)
            asks = [name for name, _ in form if name in ("query", "update")]
            if len(asks) != 1:
                raise Problem(400, "send one query= or one update= in the form")
            if asks[0] == "update":
                return await self._update(request, _one(form, "update"), [*url, *form])
            return await self._query(request, _one(form, "query"), [*url, *form])
        if any(name in ("query", "update") for name, _ in url):
            raise Problem(400, "the text is in the body: leave query= and update= out of the address")
        text = incoming.text_of(body)
        return await (self._update if media == _UPDATE else self._query)(request, text, url)

    async def _query(self, request: Request, text: str, fields: incoming.Fields) -> Response:
        screened, cut, more, notes = (self._kept if len(text) <= _SHORT else self._prepare)(text)
        accept = request.headers.get("accept", "")
        graph = screened.form in _GRAPH_FORMS
        media = wanted(accept, _GRAPHS if graph else _TABLES)
        options: dict[str, Any] = {
            "table": "json" if graph else TABLES[media],
            "graph": GRAPHS[media] if graph else "ttl",
            "rows": self._settings.limits.rows,
            "size": self._settings.limits.answer,
            "more": more,
            "written": None if cut == text else text,
            "default": _all(fields, "default-graph-uri"),
            "named": _all(fields, "named-graph-uri"),
            "base": _base(request),
            "union": not screened.chooses,
        }
        current = await self._dataset.fresh()
        if not options["default"] and not options["named"]:
            screened.check_graphs(current.names)

        async def gone() -> None:
            while (await request.receive())["type"] != "http.disconnect":
                pass

        told, body = await current.ask(
            {"do": "query", "with": options}, cut.encode(), gone=gone, timeout=_seconds(fields)
        )
        return answered(told, body, media, notes)

    def _most(self, request: Request) -> int:
        """Return how long a body may be: only an update is longer than a query."""
        limits = self._settings.limits
        try:
            incoming.must_be_writable(request, self._settings)
        except Problem:
            return min(limits.body, _ENCODED * limits.text)
        return limits.body

    def _prepare(self, text: str) -> tuple[Screened, str, str | None, list[str]]:
        limits = self._settings.limits
        query = screen(text, limits.text, limits.depth)
        more = limited(query, limits.rows + 1)
        cut = text if more is None else limited(query, limits.rows) or text
        return query, cut, more, unknown_terms(query)

    async def _update(self, request: Request, text: str, fields: incoming.Fields) -> Response:
        incoming.must_be_writable(request, self._settings)
        limits = self._settings.limits
        # An update may be long: others are answered meanwhile.
        update = await asyncio.to_thread(screen, text, limits.body, limits.depth, update=True)
        names = "using-graph-uri", "using-named-graph-uri"
        update.check_graphs((await self._dataset.fresh()).names)
        changed = using(update, *(_all(fields, name) for name in names))
        await self._dataset.change({"do": "update", "base": _base(request)}, changed.encode())
        return Response(status_code=204)

    async def _description(self, request: Request) -> Response:
        media = wanted(request.headers.get("accept", ""), _GRAPHS)
        names = (await self._dataset.fresh()).names
        told = description(_base(request), names, GRAPHS[media], update=self._settings.writable)
        return Response(told, headers={"Content-Type": content_type(media), **NOT_KEPT})


def answered(told: dict[str, Any], body: bytes, media: str, notes: Sequence[str] = ()) -> Response:
    """Return an answer as a response: status 206 and a header say that a limit cut it, as the body does.

    Notes on the question are a header, for the answer is what it would be without.
    """
    headers = {"Content-Type": content_type(media), **NOT_KEPT}
    if notes:
        headers["Deixis-Note"] = "; ".join(notes)
    if "truncated" not in told:
        return Response(body, headers=headers)
    return Response(body, 206, {**headers, "Deixis-Truncated": f"rows={told['truncated']}"})


def _one(fields: incoming.Fields, name: str) -> str:
    found = [value for key, value in fields if key == name]
    if len(found) != 1:
        raise Problem(400, f"there are {len(found)} parameters {name}: give one")
    return found[0]


def _all(fields: incoming.Fields, name: str) -> Sequence[str]:
    return [absolute(value) for key, value in fields if key == name]


def _base(request: Request) -> str:
    return str(request.url.replace(query="", fragment=""))


def _seconds(fields: incoming.Fields) -> float | None:
    """Return the time that the asker allows, which is never more than the server does."""
    given = [value for key, value in fields if key == "timeout"]
    if not given:
        return None
    try:
        seconds = float(given[-1])
    except ValueError:
        seconds = 0.0
    if not 0.0 < seconds < 1e9:
        raise QueryError("timeout is a number of seconds greater than 0")
    return seconds
