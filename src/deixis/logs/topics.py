"""Topics: which one of a bag shows things, and which tells where the robot is."""

from __future__ import annotations

from deixis.errors import ReaderError
from deixis.logs.bags import BOXES, POSES, Bag
from deixis.logs.definitions import DETECTIONS
from deixis.strict_json import quoted


def boxes_topic(bag: Bag, topic: str | None) -> str:
    """Return the topic of detections, or say which there are."""
    boxes = [one for one in bag.topics if one.kind in BOXES]
    listed = ", ".join(f"{quoted(one.name)} ({one.count} messages)" for one in boxes)
    there = f"topics with detections are {listed}" if boxes else _kinds(bag)
    if topic is None:
        if len(boxes) == 1:
            return boxes[0].name
        several = "has several: give one of them" if boxes else "has no topic of detections"
        raise ReaderError(f"{bag.name} {several}: {there}")
    if not any(one.name == topic for one in boxes):
        other = next((one.kind for one in bag.topics if one.name == topic), None)
        what = "is not in it" if other is None else f"has messages of the type {quoted(other, 120)}"
        raise ReaderError(f"{bag.name}: topic {quoted(topic)} {what}: {there}")
    return topic


def _kinds(bag: Bag) -> str:
    kinds = sorted({one.kind for one in bag.topics})
    return f"none is of the type {DETECTIONS}; its types are {', '.join(map(quoted, kinds)) or 'none'}"


def pose_topic(bag: Bag, robot: str | None) -> str | None:
    """Return the topic of the robot's poses, if it is a topic that tells them."""
    if robot is None or not any(one.name == robot for one in bag.topics):
        return None
    kind = next((one.kind for one in bag.topics if one.name == robot and one.kind in POSES), None)
    if kind is None:
        listed = [one.name for one in bag.topics if one.kind in POSES]
        there = f"topics with poses are {', '.join(map(quoted, listed))}" if listed else "there are none"
        raise ReaderError(f"{bag.name}: topic {quoted(robot)} tells no poses: {there}; or give a frame of tf")
    return robot
