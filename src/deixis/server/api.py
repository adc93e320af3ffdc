"""The JSON interface: scenes, things, relations, questions and reasons, described by OpenAPI."""

from __future__ import annotations

from typing import Annotated, Any, TypeVar

from fastapi import APIRouter, Query, Request, Response
from pydantic import BaseModel, ValidationError

from deixis.server import incoming
from deixis.server.dataset import Dataset
from deixis.server.problems import Problem
from deixis.server.settings import Settings
from deixis.server.told import (
    MOST_A_PAGE,
    MOST_REASONS,
    AnswerTold,
    Bindings,
    ChangeTold,
    ConsequencesTold,
    ContrastTold,
    Goal,
    Moves,
    NamesTold,
    ProofsTold,
    RelationPage,
    SceneList,
    SceneTold,
    ThingList,
    WhyNotTold,
)

Model = TypeVar("Model", bound=BaseModel)

GoalAsked = Annotated[str, Query(max_length=4096, description="A relation, as `leans_on(ladder, wall)`.")]


def _described(kind: type[BaseModel]) -> dict[str, Any]:
    """Describe a body: FastAPI would read one of any size, ours is read with bounds."""
    schema = kind.model_json_schema()
    return {"requestBody": {"required": True, "content": {"application/json": {"schema": schema}}}}


async def _taken(kind: type[Model], request: Request, settings: Settings) -> Model:
    """Return the body of a request, read with bounds and checked."""
    body = await incoming.body_of(request, settings, settings.limits.text)
    try:
        return kind.model_validate_json(body)
    except ValidationError as error:
        text = "; ".join(f"{'.'.join(map(str, one['loc']))}: {one['msg']}" for one in error.errors()[:5])
        raise Problem(422, text.removeprefix(": ")) from None


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

    @router.post("/{scene}/ask", openapi_extra=_described(Goal))
    async def ask(scene: str, request: Request) -> Bindings:
        """Answer a goal of the Datalog subset: relations, comparisons and their negation."""
        goal = await _taken(Goal, request, settings)
        given = {"goal": goal.goal, "limit": goal.limit, "timeout": settings.limits.timeout}
        return Bindings(**await dataset.reason(scene, "ask", given))

    timeout = settings.limits.timeout

    @router.get("/{scene}/names")
    async def names(
        scene: str, view: Annotated[str | None, Query(description="From this view.")] = None
    ) -> NamesTold:
        """Return what each thing is called: a phrase that picks out it and no other."""
        return NamesTold(**await dataset.reason(scene, "called", {"view": view, "timeout": timeout}))

    @router.get("/{scene}/why")
    async def why(scene: str, goal: GoalAsked) -> AnswerTold:
        """Return the proof of a relation with its evidence, or how far it is from holding."""
        return AnswerTold(**await dataset.reason(scene, "why", {"goal": goal, "timeout": timeout}))

    @router.get("/{scene}/why-all")
    async def why_all(
        scene: str, goal: GoalAsked, limit: Annotated[int, Query(ge=1, le=MOST_REASONS)] = 20
    ) -> ProofsTold:
        """Return all proofs of a relation, the best first."""
        given = {"goal": goal, "limit": limit, "timeout": timeout}
        return ProofsTold(**await dataset.reason(scene, "why_all", given))

    @router.get("/{scene}/why-not")
    async def why_not(scene: str, goal: GoalAsked) -> WhyNotTold:
        """Return what keeps each rule from concluding a relation, the nearest first."""
        return WhyNotTold(**await dataset.reason(scene, "why_not", {"goal": goal, "timeout": timeout}))

    @router.get("/{scene}/contrast")
    async def contrast(scene: str, goal: GoalAsked, rather_than: GoalAsked) -> ContrastTold:
        """Return why one relation holds rather than another."""
        given = {"goal": goal, "rather_than": rather_than, "timeout": timeout}
        return ContrastTold(**await dataset.reason(scene, "contrast", given))

    @router.get("/{scene}/change")
    async def change(scene: str, goal: GoalAsked) -> ChangeTold:
        """Return the smallest move of a relation's figure that makes it hold, or cease to; verified."""
        return ChangeTold(**await dataset.reason(scene, "change", {"goal": goal}))

    @router.post("/{scene}/what-if", openapi_extra=_described(Moves))
    async def what_if(scene: str, request: Request) -> ConsequencesTold:
        """Return the relations gained and lost if things stood elsewhere, each with its reason."""
        moves = await _taken(Moves, request, settings)
        given = {"moves": moves.moves, "limit": moves.limit, "timeout": timeout}
        return ConsequencesTold(**await dataset.reason(scene, "what_if", given))

    return router


def _told(dataset: Dataset, name: str) -> SceneTold:
    loaded = dataset.scenes[name]
    return SceneTold(**loaded.told, graphs=loaded.graphs)
