"""The JSON interface: scenes, things, relations, questions and reasons, described by OpenAPI."""

from __future__ import annotations

from typing import Annotated, Any

from fastapi import APIRouter, Query, Request, Response
from fastapi.responses import HTMLResponse
from pydantic import BaseModel, Field

from deixis.errors import MissingDependency
from deixis.server import incoming
from deixis.server.dataset import Dataset
from deixis.server.problems import Problem
from deixis.server.settings import Settings
from deixis.view import policy_of

MOST_A_PAGE = 10_000
"""Relations or answers on one page."""


class ViewTold(BaseModel):
    """A pose the scene is seen from."""

    id: str
    label: str


class SceneTold(BaseModel):
    """A scene that is served."""

    id: str
    objects: int = Field(description="How many things it has.")
    views: list[ViewTold]
    notes: list[str] = Field(description="What was found odd when it was loaded.")
    graphs: dict[str, str] = Field(description="The named graphs it has in SPARQL.")


class SceneList(BaseModel):
    """All scenes."""

    scenes: list[SceneTold]


class LabelTold(BaseModel):
    """What a thing may be called."""

    name: str
    score: float


class BoxTold(BaseModel):
    """A box: metres, and radians about the vertical."""

    center: list[float]
    size: list[float]
    yaw: float


class ThingTold(BaseModel):
    """A thing or a surface."""

    id: str
    kind: str
    labels: list[LabelTold]
    box: BoxTold


class ThingList(BaseModel):
    """All things of a scene."""

    objects: list[ThingTold]


class RelationTold(BaseModel):
    """A relation that holds, and the metres by which a length would have to change for it to cease."""

    relation: str
    figure: str
    reference: str
    view: str | None
    margin: float | None


class WithheldTold(BaseModel):
    """A view that says nothing of the sides of a reference, and why."""

    view: str
    reference: str
    reason: str


class RelationPage(BaseModel):
    """Relations, a page of them."""

    relations: list[RelationTold]
    total: int
    next: str | None = Field(description="The cursor of the next page; null on the last.")
    withheld: list[WithheldTold]


class Goal(BaseModel):
    """A question in the Datalog subset of the rule files."""

    goal: str = Field(examples=["on_top_of(X, Y), \\+ touches(X, wall)"], max_length=4096)
    limit: int = Field(1000, ge=1, le=MOST_A_PAGE)


class Bindings(BaseModel):
    """Answers to a goal."""

    goal: str
    holds: bool
    bindings: list[dict[str, str | float]]
    truncated: bool = Field(description="Whether there are more than were asked for.")


def api(dataset: Dataset, settings: Settings) -> APIRouter:
    """Return the routes of the JSON interface."""
    router = APIRouter(prefix="/scenes", tags=["scenes"])

    @router.get("")
    async def scenes() -> SceneList:
        """List the scenes."""
        return SceneList(scenes=[_told(dataset, name) for name in dataset.scenes])

    @router.get("/{scene}")
    async def scene_file(scene: str) -> Response:
        """Return a scene as a scene file."""
        if scene not in dataset.scenes:
            raise Problem(404, f"there is no scene {scene!r}: GET /scenes lists those there are")
        return Response(dataset.scenes[scene].text, media_type="application/json")

    @router.put("/{scene}", status_code=200, responses={201: {"model": SceneTold}})
    async def put_scene(scene: str, request: Request, response: Response) -> SceneTold:
        """Load or replace a scene (a scene file in the body); needs the token."""
        incoming.must_show_token(request, settings)
        text = await incoming.body_of(request, settings)
        _, new = await dataset.put(scene, text)
        response.status_code = 201 if new else 200
        return _told(dataset, scene)

    @router.delete("/{scene}", status_code=204)
    async def delete_scene(scene: str, request: Request) -> None:
        """Remove a scene; needs the token."""
        incoming.must_show_token(request, settings)
        if not await dataset.remove(scene):
            raise Problem(404, f"there is no scene {scene!r}: GET /scenes lists those there are")

    @router.get("/{scene}/objects")
    async def objects(scene: str) -> ThingList:
        """Return the things of a scene with their labels and boxes."""
        return ThingList(**await dataset.reason(scene, "objects"))

    @router.get("/{scene}/relations")
    async def relations(
        scene: str,
        relation: Annotated[list[str] | None, Query(description="Only these relations.")] = None,
        figure: str | None = None,
        reference: str | None = None,
        view: Annotated[str | None, Query(description="Only this view's, and those of no view.")] = None,
        label: Annotated[str | None, Query(description="A label of the figure or the reference.")] = None,
        margin: Annotated[
            float | None, Query(description="The least margin, metres.", allow_inf_nan=False)
        ] = None,
        limit: Annotated[int, Query(ge=1, le=MOST_A_PAGE)] = 1000,
        cursor: Annotated[str | None, Query(description="`next` of the page before.")] = None,
    ) -> RelationPage:
        """Return the relations that hold, filtered, a page at a time."""
        given: dict[str, Any] = {
            "relation": relation, "figure": figure, "reference": reference, "view": view, "label": label,
            "margin": margin, "limit": limit, "cursor": cursor,
        }  # fmt: skip
        return RelationPage(**await dataset.reason(scene, "relations", given))

    @router.post("/{scene}/ask")
    async def ask(scene: str, goal: Goal) -> Bindings:
        """Answer a goal of the Datalog subset: relations, comparisons and their negation."""
        given = {"goal": goal.goal, "limit": goal.limit, "timeout": settings.limits.timeout}
        return Bindings(**await dataset.reason(scene, "ask", given))

    @router.get("/{scene}/why")
    async def why(scene: str, goal: Annotated[str, Query(max_length=4096)]) -> dict[str, Any]:
        """Return the proof of a relation, as `leans_on(ladder, wall)`, or how far it is from holding."""
        return await dataset.reason(scene, "why", {"goal": goal, "timeout": settings.limits.timeout})

    @router.get("/{scene}/view", response_class=HTMLResponse)
    async def view(scene: str) -> HTMLResponse:
        """Return a page that shows the scene, its relations and their reasons, for people."""
        try:
            policy = policy_of()
        except MissingDependency as error:
            raise Problem(404, str(error)) from error
        headers = {"Content-Security-Policy": f"{policy}; frame-ancestors 'none'"}
        return HTMLResponse(await dataset.page(scene), headers=headers)

    return router


def _told(dataset: Dataset, name: str) -> SceneTold:
    loaded = dataset.scenes[name]
    return SceneTold(**loaded.told, graphs=loaded.graphs)
