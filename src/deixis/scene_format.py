"""Scene format v1: the one door through which scenes come in, and its JSON Schema.

What passes here is well formed; anything else is refused with one sentence that names the object, the
field and the remedy. This module is imported only when a scene is parsed or the schema is asked for.
"""

from __future__ import annotations

import difflib
import unicodedata
from typing import Annotated, Any, Final, Literal, Self

import numpy as np
from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Discriminator,
    Field,
    Tag,
    ValidationError,
    model_validator,
)

from deixis.errors import SceneError
from deixis.strict_json import quoted
from deixis.thresholds import MAX_COORDINATE

VERSION: Final = 1
"""The version of the format that this library reads and writes."""

SCHEMA_ID: Final = "urn:deixis:schema:scene:1"

MAX_LABELS: Final = 5

REGIONS: Final = ("box", "points", "mesh", "polygon")

# U+061C and the marks, embeddings, overrides and isolates: they reorder the text around an id.
_BIDI: Final = frozenset("\u061c\u200e\u200f\u202a\u202b\u202c\u202d\u202e\u2066\u2067\u2068\u2069")


def _plain(name: str) -> str:
    for character in name:
        category = unicodedata.category(character)
        if category in ("Cc", "Cs", "Zl", "Zp") or character in _BIDI:
            raise ValueError(f"holds the character U+{ord(character):04X}: leave out control characters")
    return name


def listed(value: Any) -> Any:
    """Let tuples and arrays stand for lists, as Python callers expect; everything else stays as it is."""
    if isinstance(value, np.ndarray):
        return value.tolist()
    return list(value) if isinstance(value, tuple) else value


def exactly(count: int) -> BeforeValidator:
    """Return the check that a list has so many entries: the schema's limits would name one of them only."""

    def check(value: Any) -> Any:
        entries = listed(value)
        if isinstance(entries, list) and len(entries) != count:
            noun = "entry" if len(entries) == 1 else "entries"
            raise ValueError(f"has {len(entries)} {noun}: give exactly {count}")
        return entries

    return BeforeValidator(check)


def _inline_or_file(value: Any) -> str:
    return "file" if isinstance(value, str) else "inline"


class Part(BaseModel):
    """What a file is made of: known keys with values of their own kind, and nothing else."""

    model_config = ConfigDict(extra="forbid", strict=True, allow_inf_nan=False, frozen=True)


Name = Annotated[str, Field(min_length=1, max_length=256), AfterValidator(_plain)]
Coordinate = Annotated[float, Field(ge=-MAX_COORDINATE, le=MAX_COORDINATE)]
Extent = Annotated[float, Field(ge=0.0, le=MAX_COORDINATE)]
Point = Annotated[list[Coordinate], Field(min_length=3, max_length=3), exactly(3)]
Size = Annotated[list[Extent], Field(min_length=3, max_length=3), exactly(3)]
Points = Annotated[list[Point], Field(min_length=1, fail_fast=True), BeforeValidator(listed)]
Index = Annotated[int, Field(ge=0)]
Face = Annotated[list[Index], Field(min_length=3, max_length=3), exactly(3)]
Faces = Annotated[list[Face], Field(min_length=1, fail_fast=True), BeforeValidator(listed)]
FileName = Annotated[str, Field(min_length=1, max_length=1024)]


def optional(description: str, **limits: Any) -> Any:
    """Return a field that may be left out but, unlike a nullable one, may not be null."""
    return Field(default=None, description=description, **limits)


class LabelPart(Part):
    """One of an object's ranked names."""

    name: Name = Field(description="What the thing is called, in lower case, such as 'fire extinguisher'.")
    score: float = Field(ge=0.0, le=1.0, description="How sure the recogniser is, from 0 to 1.")


class BoxPart(Part):
    """A box with a level base."""

    center: Point = Field(description="Centre, metres, world frame.")
    size: Size = Field(description="Full extents along the box's own X, Y, Z, metres; zero is allowed.")
    yaw: Coordinate = Field(
        default=0.0,
        description="Radians, counter-clockwise seen from above, from the world's X axis to the box's.",
    )


class MeshPart(Part):
    """A triangle mesh written out."""

    vertices: Points = Field(description="Vertices, metres, world frame.")
    faces: Faces = Field(description="Triangles: three positions in the list of vertices, counted from 0.")


PointsOrFile = Annotated[
    Annotated[Points, Tag("inline")] | Annotated[FileName, Tag("file")], Discriminator(_inline_or_file)
]
MeshOrFile = Annotated[
    Annotated[MeshPart, Tag("inline")] | Annotated[FileName, Tag("file")], Discriminator(_inline_or_file)
]


class ObjectPart(Part):
    """A thing or a surface, with what it is and where it is."""

    model_config = ConfigDict(
        json_schema_extra={
            "oneOf": [{"required": [region]} for region in REGIONS],
            "not": {"required": ["label", "labels"]},
            "if": {"required": ["polygon"]},
            "then": {"required": ["kind"], "properties": {"kind": {"const": "surface"}}},
        }
    )

    id: Name = Field(description="Unique among the objects; answers name the object by it.")
    kind: Literal["object", "surface"] = Field(
        default="object",
        description="A surface is a wall, floor or ceiling: always a reference, without thickness.",
    )
    label: Name = optional("What the thing is, when there is one sure name.")
    labels: Annotated[list[LabelPart], Field(min_length=1, max_length=MAX_LABELS)] = optional(
        "Ranked names with scores, instead of 'label'."
    )
    box: BoxPart = optional("The region as a box.")
    points: PointsOrFile = optional(
        "The region as points, or the path of a .ply, .obj, .stl, .glb or .off file in the scene's folder; "
        "coordinates are taken as they are, in the world frame. Points sample all of an object, a few "
        "centimetres apart: see 'strays'."
    )
    mesh: MeshOrFile = optional("The region as a triangle mesh, or the path of a file as for 'points'.")
    polygon: Annotated[list[Point], Field(min_length=3, fail_fast=True), BeforeValidator(listed)] = optional(
        "A surface's corners in order, metres, world frame."
    )

    seen_in: Annotated[list[Name], Field(min_length=1), BeforeValidator(listed)] = optional(
        "The views it was seen in, by their ids, where that is known."
    )

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        given = [region for region in REGIONS if region in self.model_fields_set]
        if len(given) != 1:
            has = f"has {' and '.join(given)}" if given else "has no region"
            raise ValueError(f"{has}: give exactly one of {', '.join(REGIONS)}")
        if given == ["polygon"] and self.kind != "surface":
            raise ValueError('has a polygon but is no surface: add "kind": "surface", or give a box')
        if {"label", "labels"} <= self.model_fields_set:
            raise ValueError("has both label and labels: keep one")
        return self


class ViewPart(Part):
    """A place the scene is seen from: the robot's, or anyone's."""

    id: Name = Field(description="Unique among the views; 'world' is taken by the cardinal directions.")
    label: Name = optional("Who looks, such as 'robot' or 'you'.")
    position: Point = Field(description="Metres, world frame.")
    heading: Coordinate = Field(
        default=0.0,
        description="Radians, counter-clockwise from the world's X axis; no relation depends on it.",
    )
    stamp: float = optional("Seconds since the epoch of the recording.")


class ThresholdsPart(Part):
    """Thresholds that differ from the defaults."""

    granularity: Coordinate = optional("D, metres: no region is thinner, and a gap up to D is contact.")
    penetration: Coordinate = optional("P, metres: an overlap up to P deep is still contact.")
    closeness: Coordinate = optional("T, metres: at most this distance is near.")
    halfspace_scale: Coordinate = optional("s: a halfspace is s times the reference's full extent deep.")
    pose_noise: Coordinate = optional("Metres: an answer with a smaller margin is marked uncertain.")
    piece_gap: Coordinate = optional(
        "Metres: points further apart than this are in one piece only by way of others between them."
    )


class ScenePart(Part):
    """Things, surfaces and viewpoints of one place, in metres, in a right-handed world frame with Z up."""

    model_config = ConfigDict(title="Deixis scene")

    deixis: Literal[1] = Field(description="Version of this format.")
    id: Name = Field(description="Names the scene in answers.")
    objects: list[ObjectPart] = Field(default=[], description="Things and surfaces, in any order.")
    views: list[ViewPart] = Field(default=[], description="Where the scene is seen from.")
    strays: Literal["drop", "refuse"] = Field(
        default="drop",
        description="What becomes of points that are not in one piece with most of their object's: they are "
        "left out, with a note, or the scene is refused.",
    )
    thresholds: ThresholdsPart = Field(
        default_factory=ThresholdsPart, description="What is left out keeps its default."
    )


def scene_schema() -> dict[str, Any]:
    """Return the JSON Schema (draft 2020-12) of scene format v1.

    >>> scene_schema()["$id"]
    'urn:deixis:schema:scene:1'
    """
    head = {"$schema": "https://json-schema.org/draft/2020-12/schema", "$id": SCHEMA_ID}
    schema = ScenePart.model_json_schema()
    tidy(schema)
    return {**head, **schema}


def tidy(schema: Any) -> None:
    """Drop what the generator adds and the format does not mean: null defaults and derived titles."""
    if isinstance(schema, list):
        for part in schema:
            tidy(part)
    elif isinstance(schema, dict):
        if "default" in schema and schema["default"] is None:
            del schema["default"]
        for name, part in schema.items():
            if name == "properties":
                for field in part.values():
                    field.pop("title", None)
            tidy(part)


def parse_scene(data: object) -> ScenePart:
    """Return the checked parts of a scene given as JSON values, or raise :class:`SceneError`.

    >>> parse_scene({"deixis": 1, "id": "a", "objects": [{"id": "cup", "box": {"center": [0, 0, 0]}}]})
    Traceback (most recent call last):
    deixis.errors.SceneError: object 'cup': box.size is missing: add it
    """
    if not isinstance(data, dict):
        raise SceneError(f"a scene is a JSON object with the key 'deixis', not {_kind(data)}")
    version = data.get("deixis")
    if version is None:
        raise SceneError("the key 'deixis' is missing: add \"deixis\": 1, or convert with 'deixis import'")
    if type(version) is not int or version != VERSION:
        raise SceneError(f"the key 'deixis' is {quoted(version)}: this release reads version {VERSION}")
    try:
        return ScenePart.model_validate(data)
    except ValidationError as cause:
        problems = cause.errors(include_url=False)
        more = f" (and {len(problems) - 1} more)" if len(problems) > 1 else ""
        raise SceneError(_sentence(problems[0], data) + more) from None


_MODELS: Final[dict[str, type[Part]]] = {
    "": ScenePart,
    "objects": ObjectPart,
    "views": ViewPart,
    "labels": LabelPart,
    "box": BoxPart,
    "mesh": MeshPart,
    "thresholds": ThresholdsPart,
}


def _sentence(problem: Any, data: dict[str, Any]) -> str:
    """Return one sentence for one problem that pydantic found: what, where, and what to do."""
    loc = problem["loc"]
    # The names of a union's branches follow the field they belong to; they mean nothing to a reader.
    place = [
        step
        for before, step in zip(("", *loc), loc, strict=False)
        if not (before in ("points", "mesh") and step in ("inline", "file"))
    ]
    where, rest = _owner(place, data)
    field = ""
    for step in rest:
        field += f"[{step}]" if isinstance(step, int) else f".{step}" if field else step
    kind, limits, value = problem["type"], problem.get("ctx", {}), problem["input"]
    subject = f"{where}: {field}" if field else where
    match kind:
        case "missing":
            return f"{subject} is missing: add it"
        case "extra_forbidden":
            key = str(rest[-1])
            parent = [step for step in place[:-1] if isinstance(step, str)]
            known = list(_MODELS[parent[-1] if parent else ""].model_fields)
            near = difflib.get_close_matches(key, known, n=1)
            hint = f"did you mean {near[0]!r}?" if near else f"known keys are {', '.join(known)}"
            return f"{where}: unknown key {quoted(key)}: {hint}"
        case "value_error":
            return f"{subject} {limits['error']}" if field else f"{where} {limits['error']}"
        case "float_type" | "int_type" | "float_parsing" | "int_from_float":
            number = "a whole number" if kind.startswith("int") else "a number"
            return f"{subject} is {_kind(value)}: give {number}"
        case "finite_number":
            return f"{subject} is {value}: give a finite number"
        case "greater_than_equal" | "less_than_equal":
            bound = limits.get("ge", limits.get("le"))
            side = "below" if "ge" in limits else "above"
            return f"{subject} is {quoted(value)}, {side} {bound:g}: give a number within the limits"
        case "too_short" | "too_long" if limits.get("field_type") == "List":
            least, most = limits.get("min_length"), limits.get("max_length")
            wanted = f"at least {least}" if least is not None else f"at most {most}"
            noun = "entry" if limits["actual_length"] == 1 else "entries"
            return f"{subject} has {limits['actual_length']} {noun}: give {wanted}"
        case "string_too_short" | "string_too_long":
            return f"{subject} is {quoted(value)}: give 1 to 256 characters"
        case "string_type" | "string_unicode":
            text = "not valid Unicode" if isinstance(value, str) else _kind(value)
            return f"{subject} is {text}: give a string"
        case "list_type":
            return f"{subject} is {_kind(value)}: give a list"
        case "model_type":
            return f"{subject} is {_kind(value)}: give an object with named fields"
        case "literal_error":
            return f"{subject} is {quoted(value)}: give {limits['expected']}"
    return f"{subject}: {problem['msg']}"


def _owner(place: list[str | int], data: dict[str, Any]) -> tuple[str, list[str | int]]:
    """Return what a place in the file belongs to, in words, and the rest of the place within it."""
    if len(place) >= 2 and place[0] in ("objects", "views") and isinstance(place[1], int):
        item = listed(data[place[0]])[place[1]]
        name = item.get("id") if isinstance(item, dict) else None
        noun = str(place[0])[:-1]
        return f"{noun} {quoted(name)}" if isinstance(name, str) else f"{noun} number {place[1] + 1}", place[
            2:
        ]
    name = data.get("id")
    return (f"scene {quoted(name)}" if isinstance(name, str) else "the scene"), place


def _kind(value: object) -> str:
    """Return the JSON name of a value's kind, for a message."""
    match value:
        case None:
            return "null"
        case bool():
            return "true" if value else "false"
        case str():
            return f"the string {quoted(value)}"
        case list() | tuple():
            return "a list"
        case dict():
            return "an object"
        case int() if abs(value) > 1 << 1023:
            return "a number too large for float64"
        case int() | float():
            return f"the number {quoted(value)}"
    return f"a {type(value).__name__}"
