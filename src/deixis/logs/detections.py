"""Detections: messages of vision_msgs of any version as values of one kind."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import cache, lru_cache
from typing import TYPE_CHECKING, Any, Final, NamedTuple

from deixis.errors import ReaderError
from deixis.logs.bags import Message
from deixis.logs.definitions import DETECTION, DETECTIONS
from deixis.logs.report import Report
from deixis.logs.transforms import frame_name, seconds
from deixis.scene import Label
from deixis.strict_json import quoted

if TYPE_CHECKING:
    from pydantic import TypeAdapter

MOST_LABELS: Final = 5
"""Hypotheses that are kept of each detection, the best."""

Numbers = tuple[float, ...]


class Detection(NamedTuple):
    """A box that a detector found.

    Attributes
    ----------
    stamp : int
        Nanoseconds.
    frame : str
        In which the numbers are meant.
    center, size : x, y, z
        Metres; the size along the box's own axes.
    quaternion : x, y, z, w
    labels : tuple of Label
        Best first.
    track : str
        What a tracker calls the thing; empty where it was not tracked.
    """

    stamp: int
    frame: str
    center: Numbers
    size: Numbers
    quaternion: Numbers
    labels: tuple[Label, ...]
    track: str


class Detected(NamedTuple):
    """What one message shows, and of when it is, nanoseconds."""

    stamp: int
    found: list[Detection]


def stamp_of(header: Any) -> int:
    """Return the stamp of a header, nanoseconds."""
    return int(header.stamp.sec) * 10**9 + int(header.stamp.nanosec)


def detected(message: Message, report: Report, names: Mapping[str, str]) -> Detected:
    """Return what a message of detections shows.

    A detection has a header of its own; where that names no frame, or has the stamp 0, the message's counts.
    Where that has no stamp either, the time of recording does, which is noted.

    Parameters
    ----------
    message : Message
    report : Report
        Told of what is taken otherwise than it stands.
    names : mapping
        What classes are called, by the ids that the detector uses; others are called by their ids.

    Raises
    ------
    ReaderError
        The messages of the bag are of no version of vision_msgs that is known.
    """
    kinds = _kinds(message)
    value = message.value
    parts = value.detections if value.__msgtype__ == DETECTIONS else [value]
    stamp = stamp_of(value.header)
    if stamp == 0:
        stamp = message.recorded
        report.note("a message has no stamp: the time of recording counts", f"at {seconds(stamp)}")
    frame = frame_name(value.header.frame_id)
    return Detected(stamp, [_detection(part, kinds, stamp, frame, report, names) for part in parts])


class _Kinds(NamedTuple):
    """Where a version of vision_msgs keeps what changed place."""

    nested: bool
    track: str
    flag: bool


def _kinds(message: Message) -> _Kinds:
    own = message.fields(DETECTION)
    result = message.fields("vision_msgs/msg/ObjectHypothesisWithPose")
    missing = {"results", "bbox", "header"} - own
    if missing or not ("hypothesis" in result or {"id", "score"} <= result):
        raise ReaderError(
            f"topic {quoted(message.topic)}: vision_msgs is of an unknown version: a detection has "
            f"{', '.join(sorted(own))}; a hypothesis has {', '.join(sorted(result))}"
        )
    track = "tracking_id" if "tracking_id" in own else "id" if "id" in own else ""
    return _Kinds("hypothesis" in result, track, "is_tracking" in own)


def _detection(
    part: Any, kinds: _Kinds, stamp: int, frame: str, report: Report, names: Mapping[str, str]
) -> Detection:
    own = stamp_of(part.header) or stamp
    place, size, turn = part.bbox.center.position, part.bbox.size, part.bbox.center.orientation
    scores: dict[str, float] = {}
    for result in part.results:
        told = result.hypothesis if kinds.nested else result
        class_id = str(told.class_id if kinds.nested else told.id)
        name = names.get(class_id, class_id)
        if not name:
            continue
        if not usable(name):
            report.note("a label is no name: it is left out", quoted(name))
            continue
        score = float(told.score)
        if not 0.0 <= score <= 1.0:
            report.note("a score is not from 0 to 1: it counts as 0 or 1", f"{score:g} at {seconds(own)}")
            score = 1.0 if score > 1.0 else 0.0
        scores[name] = max(score, scores.get(name, 0.0))
    labels = tuple(Label(name, score) for name, score in scores.items())
    if len(labels) > MOST_LABELS:
        labels = tuple(sorted(labels, key=lambda one: -one.score)[:MOST_LABELS])
    track = str(getattr(part, kinds.track)) if kinds.track else ""
    if kinds.flag and not part.is_tracking:
        track = ""
    if track and not usable(track):
        report.note("the id of a track is no name: it is left out", quoted(track))
        track = ""
    return Detection(
        own,
        frame_name(part.header.frame_id) or frame,
        (place.x, place.y, place.z),
        (size.x, size.y, size.z),
        (turn.x, turn.y, turn.z, turn.w),
        labels,
        track,
    )


def faults(one: Detection, most: float) -> str | None:
    """Return what keeps a detection from being a box, if anything does.

    Parameters
    ----------
    one : Detection
    most : float
        Metres: the largest number that a scene takes.
    """
    numbers = (*one.center, *one.size, *one.quaternion)
    if not all(map(math.isfinite, numbers)):
        return "a number is not finite"
    if max(map(abs, numbers)) > most:
        return f"a number is beyond {most:g} m"
    if min(one.size) < 0.0:
        return "a size is negative"
    return None if one.stamp >= 0 else "its stamp is before 1970"


@lru_cache(maxsize=4096)
def usable(name: str) -> bool:
    """Return whether a scene may have a thing or a label of this name.

    Examples
    --------
    >>> usable("cup"), usable("cup" + chr(7)), usable("x" * 300)
    (True, False, False)
    """
    from pydantic import ValidationError

    try:
        _names().validate_python(name, strict=True)
    except ValidationError:
        return False
    return True


@cache
def _names() -> TypeAdapter[str]:
    """Return what checks names as scene files are checked, made once: it takes longer than a check."""
    from pydantic import TypeAdapter

    from deixis.scene_format import Name

    return TypeAdapter(Name)
