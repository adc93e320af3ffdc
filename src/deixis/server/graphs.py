"""The Graph Store Protocol: graphs by their names, read by anyone, written only where that is allowed."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final
from uuid import uuid4

from starlette.requests import Request
from starlette.responses import Response

from deixis.server import incoming
from deixis.server.dataset import Dataset
from deixis.server.media import DATASETS, GRAPHS, content_type, wanted
from deixis.server.multipart import parts_of
from deixis.server.problems import Problem
from deixis.server.protocol import NOT_KEPT
from deixis.server.rewriting import absolute
from deixis.server.settings import Settings

_READ: Final = {"text/turtle": "ttl", "application/n-triples": "nt", "application/trig": "trig"}
"""Formats that graphs are written in: entities and contexts, of RDF/XML and JSON-LD, are bombs and calls."""


_FORM: Final = "multipart/form-data"


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
        created = everything and request.method == "POST"
        if created:
            # Nobody said where: in a graph of its own, whose address is its name.
            name = f"{_address(request)}/{uuid4()}"
        elif everything:
            raise Problem(400, "say which graph: ?graph=IRI or ?default")
        known = name is None or name in (await self._dataset.fresh()).names
        if request.method == "DELETE":
            if not known:
                raise Problem(404, f"there is no graph <{name}>")
            await self._dataset.change({"do": "drop", "name": name}, b"")
            return Response(status_code=204)
        parts = await self._sent(request)
        message = {
            "do": "put",
            "name": name,
            "parts": [(form, len(text)) for form, text in parts],
            "replace": request.method == "PUT",
            "base": _address(request),
        }
        await self._dataset.change(message, b"".join(text for _, text in parts))
        headers = {"Location": str(name)} if created else {}
        return Response(status_code=204 if known else 201, headers=headers)

    async def _sent(self, request: Request) -> list[tuple[str, bytes]]:
        """Return the format and the text of what was sent: one, or several in a form."""
        media = incoming.media_of(request) or "text/turtle"
        if media == _FORM and request.method != "POST":
            raise Problem(415, f"{_FORM} is for POST: PUT the graph itself")
        if media != _FORM:
            return [(_format(media), await incoming.body_of(request, self._settings))]
        parts = parts_of(
            await incoming.body_of(request, self._settings), request.headers.get("content-type", "")
        )
        return [(_format(incoming.media_type(kind)), text) for kind, text in parts]

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
        told, body = await (await self._dataset.fresh()).ask(header)
        if told.get("missing"):
            raise Problem(404, f"there is no graph <{name}>: GET /sparql lists those there are")
        return Response(body, headers={"Content-Type": content_type(media), **NOT_KEPT})


def _format(media: str) -> str:
    if media not in _READ:
        raise Problem(415, f"{media[:100]!r} is not read: send the graph as one of {', '.join(_READ)}")
    return _READ[media]


def _address(request: Request) -> str:
    return str(request.url.replace(query="", fragment=""))


def _named(request: Request) -> tuple[str | None, bool]:
    """Return the graph that is meant, None for the default one; and whether all are."""
    fields = incoming.fields_of(request.scope["query_string"])
    if request.path_params.get("graph"):
        if any(key in ("graph", "default") for key, _ in fields):
            raise Problem(400, "the address names a graph already: leave ?graph and ?default out")
        return absolute(_address(request)), False
    names = [value for key, value in fields if key == "graph"]
    default = any(key == "default" for key, _ in fields)
    if len(names) + default > 1:
        raise Problem(400, "say which graph: one ?graph=IRI, or ?default")
    if names:
        return absolute(names[0]), False
    return None, not default
