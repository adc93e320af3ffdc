"""What the JSON interface takes and gives, as types that its description is made of."""

from __future__ import annotations

from typing import Annotated, Any, Final

from pydantic import BaseModel, Field

MOST_A_PAGE: Final = 10_000
"""Relations or answers on one page."""

MOST_REASONS: Final = 1000
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


class UpdateTold(BaseModel):
    """What an update changed."""

    event: str = Field(description="The id of the event that tells of it.")
    stamp: float | None = Field(description="Of the update.")
    gained: list[RelationTold] = Field(description="What holds now and did not.")
    lost: list[RelationTold] = Field(description="What held and does not now, with the margin it had.")
    count: int = Field(description="How many relations were gained or lost.")
    truncated: bool = Field(description="Whether they are too many to be told one by one: none is then.")


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
    notes: list[str] = Field(description="Names in the goal that nothing has: no relation holds of them.")


class StepTold(BaseModel):
    """A step of a proof, and the reasons it rests on."""

    kind: str = Field(description="rule, fact, comparison, negation or conjunction")
    predicate: str
    args: list[str | float | None]
    text: str = Field(description="The step in one sentence.")
    clause: str | None = Field(
        description="Of a first reason its text after the conclusion, with a pronoun for what both are about."
    )
    margin: float | None = Field(description="Metres to spare; negative where the step fails.")
    axiom: int | None
    rule: dict[str, str | int] | None = Field(description="Its file and line.")
    shown: bool = Field(description="Whether an outline for people shows it.")
    evidence: dict[str, Any] | None = Field(
        description="What a leaf rests on, in numbers and geometry: see kb/explanation.schema.json."
    )
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
    because: list[str] = Field(description="What keeps it from holding, as clauses after the text.")
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
    collides: list[str] = Field(description="Things that it would then share space with, and does not now.")


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
