"""The JSON interface: scenes, things, relations, questions and reasons, described by OpenAPI."""

from __future__ import annotations

from typing import Annotated, Any

from fastapi import APIRouter, Query, Request, Response
from pydantic import BaseModel, Field

from deixis.server import incoming
from deixis.server.dataset import Dataset
from deixis.server.problems import Problem
from deixis.server.settings import Settings

MOST_A_PAGE = 10_000
"""Relations or answers on one page."""

MOST_REASONS = 1000
"""Proofs, or consequences with their reasons, in one reply."""


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


class StepTold(BaseModel):
    """A step of a proof, and the reasons it rests on."""

    kind: str = Field(description="rule, fact, comparison, negation or conjunction")
    predicate: str
    args: list[str | float | None]
    text: str = Field(description="The step in one sentence.")
    margin: float | None = Field(description="Metres to spare; negative where the step fails.")
    axiom: int | None
    rule: dict[str, str | int] | None = Field(description="Its file and line.")
    shown: bool = Field(description="Whether an outline for people shows it.")
    children: list[StepTold]


class AnswerTold(BaseModel):
    """Why a relation holds, or how far it is from holding."""

    goal: str
    holds: bool
    text: str
    proof: StepTold | None
    nearest: StepTold | None
    measured_as: dict[str, str]


class ProofsTold(BaseModel):
    """All proofs of a relation, the best first."""

    goal: str
    holds: bool
    proofs: list[StepTold]
    truncated: bool = Field(description="Whether there are more than were asked for.")


class MissTold(BaseModel):
    """A rule that could have concluded it, and what fails."""

    derivation: StepTold
    obstacles: list[str]


class RefusalTold(BaseModel):
    """What keeps each rule from concluding a relation, the nearest first."""

    holds: bool
    text: str
    hindrance: str | None
    misses: list[MissTold]


class WhyNotTold(RefusalTold):
    """The same, with the question and a sentence."""

    goal: str
    sentence: str


class FactTold(BaseModel):
    """Why the one relation holds."""

    holds: bool
    text: str
    proof: StepTold | None
    nearest: StepTold | None
    measured_as: dict[str, str]


class ContrastTold(BaseModel):
    """Why one relation holds rather than another."""

    goal: str
    rather_than: str
    sentence: str
    text: str
    fact: FactTold
    other: RefusalTold


class MoveTold(BaseModel):
    """A move that was verified: it makes the relation hold, or cease to."""

    move: str = Field(description="The thing that is moved.")
    offset: list[float] = Field(description="Metres along x, y, z.")
    distance: float
    holds: bool = Field(description="Whether the relation holds after it.")


class ChangeTold(BaseModel):
    """The smallest move that changes a relation; null where none within three metres does."""

    goal: str
    change: MoveTold | None


Metres = Annotated[float, Field(ge=-1000.0, le=1000.0, allow_inf_nan=False)]


class Moves(BaseModel):
    """Things to be moved, each by metres along x, y, z."""

    moves: dict[str, tuple[Metres, Metres, Metres]] = Field(
        examples=[{"cup": [0, 0, -0.04]}], min_length=1, max_length=100
    )
    limit: int = Field(100, ge=1, le=MOST_REASONS)


class ConsequenceTold(RelationTold):
    """A relation that would begin or cease to hold, and why."""

    because: str


class ConsequencesTold(BaseModel):
    """What would be otherwise if things stood elsewhere."""

    gained: list[ConsequenceTold]
    lost: list[ConsequenceTold]
    truncated: bool = Field(description="Whether there is more than was asked for.")


class NamesTold(BaseModel):
    """What each thing is called, by its id."""

    names: dict[str, str]


GoalAsked = Annotated[str, Query(max_length=4096, description="A relation, as `leans_on(ladder, wall)`.")]


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

    timeout = settings.limits.timeout

    @router.get("/{scene}/names")
    async def names(
        scene: str, view: Annotated[str | None, Query(description="From this view.")] = None
    ) -> NamesTold:
        """Return what each thing is called: a phrase that picks out it and no other."""
        return NamesTold(**await dataset.reason(scene, "called", {"view": view, "timeout": timeout}))

    @router.get("/{scene}/why")
    async def why(scene: str, goal: GoalAsked) -> AnswerTold:
        """Return the proof of a relation, or how far it is from holding."""
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

    @router.post("/{scene}/what-if")
    async def what_if(scene: str, moves: Moves) -> ConsequencesTold:
        """Return the relations gained and lost if things stood elsewhere, each with its reason."""
        given = {"moves": moves.moves, "limit": moves.limit, "timeout": timeout}
        return ConsequencesTold(**await dataset.reason(scene, "what_if", given))

    return router


def _told(dataset: Dataset, name: str) -> SceneTold:
    loaded = dataset.scenes[name]
    return SceneTold(**loaded.told, graphs=loaded.graphs)
