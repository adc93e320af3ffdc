"""The Graph Store Protocol: graphs by their names, read by anyone, written only where that is allowed."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

from starlette.requests import Request
from starlette.responses import Response

from deixis.server import incoming
from deixis.server.dataset import Dataset
from deixis.server.media import DATASETS, GRAPHS, content_type, wanted
from deixis.server.problems import Problem
from deixis.server.protocol import NOT_KEPT
from deixis.server.rewriting import absolute
from deixis.server.settings import Settings

_READ: Final = {"text/turtle": "ttl", "application/n-triples": "nt", "application/trig": "trig"}
"""Formats that graphs are written in: entities and contexts, of RDF/XML and JSON-LD, are bombs and calls."""


class Graphs:
    """The graph store.

    Parameters
    ----------
    dataset : Dataset
    settings : Settings
    """

    def __init__(self, dataset: Dataset, settings: Settings) -> None:
        self._dataset, self._settings = dataset, settings

    async def handle(self, request: Request) -> Response:
        """Answer one request."""
        name, everything = _named(request)
        if request.method in ("GET", "HEAD"):
            return await self._read(request, name, everything)
        incoming.must_be_writable(request, self._settings)
        if everything:
            raise Problem(400, "say which graph: ?graph=IRI or ?default")
        known = name is None or name in self._dataset.current.names
        if request.method == "DELETE":
            if not known:
                raise Problem(404, f"there is no graph <{name}>")
            await self._dataset.change({"do": "drop", "name": name}, b"")
            return Response(status_code=204)
        media = incoming.media_of(request) or "text/turtle"
        if media not in _READ:
            raise Problem(415, f"send the graph as one of {', '.join(_READ)}")
        body = await incoming.body_of(request, self._settings)
        message = {
            "do": "put",
            "name": name,
            "form": _READ[media],
            "replace": request.method == "PUT",
            "base": str(request.url.replace(query="", fragment="")),
        }
        await self._dataset.change(message, body)
        return Response(status_code=204 if known else 201)

    async def _read(self, request: Request, name: str | None, everything: bool) -> Response:
        offered: Mapping[str, str] = DATASETS if everything else GRAPHS
        media = wanted(request.headers.get("accept", ""), tuple(offered))
        header: dict[str, Any] = {
            "do": "graph",
            "all": everything,
            "name": name,
            "form": offered[media],
            "size": self._settings.limits.answer,
        }
        told, body = await self._dataset.current.ask(header)
        if told.get("missing"):
            raise Problem(404, f"there is no graph <{name}>: GET /sparql lists those there are")
        return Response(body, headers={"Content-Type": content_type(media), **NOT_KEPT})


def _named(request: Request) -> tuple[str | None, bool]:
    """Return the graph that is meant, None for the default one; and whether all are."""
    fields = incoming.fields_of(request.scope["query_string"])
    names = [value for key, value in fields if key == "graph"]
    default = any(key == "default" for key, _ in fields)
    if len(names) + default > 1:
        raise Problem(400, "say which graph: one ?graph=IRI, or ?default")
    if names:
        return absolute(names[0]), False
    return None, not default
