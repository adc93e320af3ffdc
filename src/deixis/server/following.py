"""Living scenes over HTTP: updates in, changes out as they happen, and the page that follows them."""

from __future__ import annotations

from typing import Annotated, Any, Final

from fastapi import APIRouter, Header, Query, Request, Response
from fastapi.responses import HTMLResponse, StreamingResponse

from deixis.errors import MissingDependency
from deixis.server import incoming
from deixis.server.dataset import Dataset
from deixis.server.events import Streams
from deixis.server.problems import Problem
from deixis.server.settings import Settings
from deixis.server.told import UpdateTold
from deixis.view import policy_of

_UPDATE: Final[dict[str, Any]] = {
    "type": "object",
    "additionalProperties": False,
    "properties": {
        "objects": {"type": "array", "items": {"type": "object"}, "description": "As in a scene file."},
        "moves": {
            "type": "object",
            "description": "Metres along x, y, z by the ids of what is shifted.",
            "additionalProperties": {"type": "array", "items": {"type": "number"}},
        },
        "removed": {"type": "array", "items": {"type": "string"}},
        "views": {"type": "array", "items": {"type": "object"}, "description": "As in a scene file."},
        "removed_views": {"type": "array", "items": {"type": "string"}},
        "stamp": {"type": "number", "description": "Given back with what changed."},
    },
    "example": {"moves": {"cup": [0.0, 0.0, 0.1]}},
}

_EVENTS: Final = (
    "Events `changes` (relations gained and lost, as the answer to the update told them), `reload` (load the "
    "scene anew: it was replaced, too much changed at once, or what was missed is not kept) and `gone` (the "
    "scene was removed; the stream ends). Each has an id, and data in JSON."
)

_PLACE: Final = 64
"""Characters of an event's id, at most."""


def following(dataset: Dataset, settings: Settings, streams: Streams) -> APIRouter:
    """Return the routes of living scenes."""
    router = APIRouter(prefix="/scenes", tags=["living scenes"])

    @router.post(
        "/{scene}/updates",
        openapi_extra={
            "requestBody": {"required": True, "content": {"application/json": {"schema": _UPDATE}}}
        },
    )
    async def update(scene: str, request: Request) -> UpdateTold:
        """Add, move and remove things and views; needs --writable and the token.

        What it changed is answered when it is done and on the disk. Updates of a scene come one after the
        other; one that is refused changes nothing.
        """
        incoming.must_be_writable(request, settings)
        return UpdateTold(**await dataset.update(scene, await incoming.body_of(request, settings)))

    @router.get(
        "/{scene}/changes",
        response_class=StreamingResponse,
        responses={
            200: {"description": _EVENTS, "content": {"text/event-stream": {"schema": {"type": "string"}}}}
        },
    )
    async def changes(
        scene: str,
        since: Annotated[
            str | None,
            Query(max_length=_PLACE, description="The id of an event: what came after it is told first."),
        ] = None,
        last_event_id: Annotated[
            str | None, Header(max_length=_PLACE, description="The same, as a browser says it.")
        ] = None,
    ) -> Response:
        """Tell what changes, as it happens, for as long as the client listens."""
        place = since if last_event_id is None else last_event_id
        return streams.response(dataset.events(scene), place)

    @router.get("/{scene}/view", response_class=HTMLResponse)
    async def view(scene: str) -> HTMLResponse:
        """Return a page that shows the scene, its relations and their reasons, for people; it follows it."""
        try:
            policy = policy_of(follows=True)
        except MissingDependency as error:
            raise Problem(404, str(error)) from error
        headers = {"Content-Security-Policy": f"{policy}; frame-ancestors 'none'"}
        return HTMLResponse(await dataset.page(scene), headers=headers)

    @router.get(
        "/{scene}/view/data",
        responses={200: {"description": "What the page shows.", "content": {"application/json": {}}}},
        response_class=Response,
    )
    async def view_data(scene: str) -> Response:
        """Return the data of the page: what one that is open takes over when the scene has changed."""
        headers = {"Cache-Control": "no-store"}
        return Response(await dataset.page_data(scene), media_type="application/json", headers=headers)

    return router
