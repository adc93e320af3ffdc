"""Frame format v1: what a robot saw at one time, as a JSON file beside its images or cloud; its schema."""

from __future__ import annotations

from typing import Annotated, Any, Final, Literal, Self

from pydantic import Field, ValidationError, model_validator

from deixis.errors import SceneError
from deixis.scene_format import (
    MAX_LABELS,
    Coordinate,
    FileName,
    LabelPart,
    Name,
    Part,
    Point,
    exactly,
    optional,
    tidy,
)
from deixis.strict_json import quoted

VERSION: Final = 1

SCHEMA_ID: Final = "urn:deixis:schema:frame:1"

Row = Annotated[list[Coordinate], Field(min_length=4, max_length=4), exactly(4)]
Number = Annotated[int, Field(ge=1, le=2**31 - 1)]
Pixels = Annotated[int, Field(ge=1, le=65_535)]


class IntrinsicsPart(Part):
    """A pinhole camera."""

    width: Pixels = Field(description="Pixels.")
    height: Pixels = Field(description="Pixels.")
    fx: Coordinate = Field(gt=0.0, description="Focal length, pixels.")
    fy: Coordinate = Field(gt=0.0, description="Focal length, pixels.")
    cx: Coordinate = Field(description="Principal point, pixels from the middle of the first column.")
    cy: Coordinate = Field(description="Principal point, pixels from the middle of the first row.")


class PosePart(Part):
    """Where the camera is: takes its optical frame (X right, Y down, Z forward) to the world frame."""

    position: Point = optional("Metres, world frame.")
    quaternion: Row = optional("x, y, z, w; of any length but zero.")
    matrix: Annotated[list[Row], Field(min_length=4, max_length=4), exactly(4)] = optional(
        "Four rows, instead of position and quaternion."
    )

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        given = self.model_fields_set
        if given not in ({"position", "quaternion"}, {"matrix"}):
            raise ValueError("takes position and quaternion, or matrix: give one of the two")
        return self


class RobotPart(Part):
    """Where the robot stands: what is left and right is seen from there."""

    position: Point = Field(description="Metres, world frame.")
    heading: Coordinate = Field(
        default=0.0, description="Radians, counter-clockwise from the world's X axis."
    )
    label: Name = Field(default="robot", description="What it is called.")


class ThingPart(Part):
    """What an instance may be called."""

    instance: Number = Field(description="Its number in the instance image, or in the cloud.")
    labels: Annotated[list[LabelPart], Field(min_length=1, max_length=MAX_LABELS)] = Field(
        description="Ranked names with scores."
    )


class FramePart(Part):
    """A depth image with instances, or a cloud with them, and where it was taken from."""

    deixis_frame: Literal[1] = Field(description="Version of this format.")
    stamp: Annotated[float, Field(ge=-1.0e12, le=1.0e12)] = Field(
        description="Seconds since the epoch of the recording."
    )
    robot: RobotPart = Field(description="Where the robot stands.")
    intrinsics: IntrinsicsPart = optional("Of the depth camera; needed with 'depth'.")
    pose: PosePart = optional("Of the depth camera; needed with 'depth'.")
    depth: FileName = optional(
        "A file in the frame's folder: .png of 16 bits, or .npy with metres. 0 is no depth."
    )
    depth_scale: Annotated[float, Field(gt=0.0, le=1.0)] = Field(
        default=0.001, description="Metres for each step of a depth image in a .png."
    )
    instances: FileName = optional(
        "A .png of 8 or 16 bits, or .npy of whole numbers: which thing each pixel shows, 0 none."
    )
    cloud: FileName = optional(
        "Instead of 'depth': a .ply, .pcd or .npz with points in the world frame, metres, "
        "and the instance of each."
    )
    noise: Annotated[float, Field(ge=0.0, le=1.0)] = optional(
        "Standard deviation of the depths, metres; measured in the image where it is left out."
    )
    things: list[ThingPart] = Field(default=[], description="What the instances may be called.")

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        given = self.model_fields_set
        image = {"depth", "instances", "intrinsics", "pose"}
        if ("cloud" in given) == ("depth" in given):
            raise ValueError("holds neither or both of depth and cloud: give one of the two")
        missing = sorted(image - given) if "depth" in given else []
        if missing:
            raise ValueError(f"has a depth image but no {missing[0]}: add it")
        extra = sorted(given & (image | {"depth_scale"})) if "cloud" in given else []
        if extra:
            raise ValueError(f"has a cloud, which is in the world frame, and {extra[0]}: drop it")
        numbers = [thing.instance for thing in self.things]
        if len(set(numbers)) < len(numbers):
            twice = next(one for one in numbers if numbers.count(one) > 1)
            raise ValueError(f"names instance {twice} more than once: keep one")
        return self


def frame_schema() -> dict[str, Any]:
    """Return the JSON Schema (draft 2020-12) of frame format v1.

    >>> frame_schema()["$id"]
    'urn:deixis:schema:frame:1'
    """
    schema = FramePart.model_json_schema()
    tidy(schema)
    schema["title"] = "Deixis frame"
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", "$id": SCHEMA_ID, **schema}


def parse_frame(data: object, what: str) -> FramePart:
    """Return the checked parts of a frame given as JSON values, or raise :class:`SceneError`.

    >>> parse_frame({"deixis_frame": 1, "stamp": 0}, "it")
    Traceback (most recent call last):
    deixis.errors.SceneError: it: robot is missing: add it
    """
    if not isinstance(data, dict) or "deixis_frame" not in data:
        raise SceneError(f"{what}: a frame is a JSON object with the key 'deixis_frame': is it one?")
    if type(data["deixis_frame"]) is not int or data["deixis_frame"] != VERSION:
        raise SceneError(f"{what}: the key 'deixis_frame' is {quoted(data['deixis_frame'])}: give {VERSION}")
    try:
        return FramePart.model_validate(data)
    except ValidationError as cause:
        problem = cause.errors(include_url=False)[0]
        place = "".join(f"[{one}]" if isinstance(one, int) else f".{one}" for one in problem["loc"]).lstrip(
            "."
        )
        match problem["type"]:
            case "missing":
                reason = f"{place} is missing: add it"
            case "extra_forbidden":
                reason = f"unknown key {quoted(place)}: known are {', '.join(FramePart.model_fields)}"
            case "value_error":
                reason = f"{place or 'the frame'} {problem['ctx']['error']}"
            case _:
                reason = f"{place} is {quoted(problem['input'])}: {problem['msg']}"
        raise SceneError(f"{what}: {reason}") from None
