"""Reading: a bag as a scene that changes, moment by moment."""

from __future__ import annotations

import heapq
import math
import os
from collections.abc import Generator, Iterator, Mapping
from dataclasses import dataclass, field
from itertools import count
from typing import Any, Final, Self

import numpy as np

from deixis.errors import ReaderError, SceneError
from deixis.logs.bags import BOXES, POSES, TREES, Bag, Message
from deixis.logs.detections import Detected, detected, stamp_of
from deixis.logs.placing import Placing
from deixis.logs.report import Report
from deixis.logs.topics import boxes_topic, pose_topic
from deixis.logs.tracks import Sighting, Tracking, Tracks
from deixis.logs.transforms import Transforms, Unknown, frame_name, seconds
from deixis.regions import BoxRegion, Kind, MeshRegion, region_box
from deixis.scene import Scene, SpatialObject, View
from deixis.strict_json import quoted
from deixis.thresholds import MAX_COORDINATE
from deixis.updates import Update

WAIT: Final = 5 * 10**9
"""Nanoseconds of recording for which what is shown waits for tf that was recorded after it."""

MOST: Final = 4096
"""Messages that wait at once; with more the first waits no longer."""

FORGET: Final = 5.0
"""Seconds after which what nothing shows any more is gone."""

ROBOT: Final = "robot"
"""Id and label of the view from the robot."""

SURFACES: Final = ("ceiling", "floor", "wall")
"""Labels of what is a surface, never a figure."""


@dataclass(frozen=True)
class Choices:
    """How a bag is read.

    Attributes
    ----------
    frame : str
        The fixed frame, with Z up: all numbers of the scene are in it.
    topic : str or None
        Of the detections; by default the only one there is.
    robot : str or None
        Who looks: a frame, or a topic of poses. By default nobody does.
    tf : str
        The topic of moving frames; that of static ones has ``_static`` after it.
    forget : float
        Seconds after which what nothing shows any more is gone; ``math.inf`` for never.
    hold : float
        Seconds before the first and after the last that tf tells for which that counts.
    level : float
        Degrees: a box tilted by no more is stood upright.
    tracking : {"auto", "overlap"}
        Whether ids of a tracker count.
    names : mapping
        What classes are called, by the ids in the messages.
    around : Scene or None
        What is always there, in the fixed frame: walls, furniture; its thresholds count.
    """

    frame: str = "map"
    topic: str | None = None
    robot: str | None = None
    tf: str = "/tf"
    forget: float = FORGET
    hold: float = 0.0
    level: float = 0.0
    tracking: Tracking = "auto"
    names: Mapping[str, str] = field(default_factory=dict)
    around: Scene | None = None

    def __post_init__(self) -> None:
        for name, value in (("forget", self.forget), ("hold", self.hold), ("level", self.level)):
            if not value >= 0.0:
                raise ReaderError(f"{name} is {value:g}: give zero or more")
        if self.around is not None and any(one.id == ROBOT for one in self.around.views):
            raise ReaderError(f"scene {quoted(self.around.id)} has a view {ROBOT!r}: rename it")


class Log:
    """A bag as a scene that changes. Iterating yields the stamp (nanoseconds) and the scene of each moment.

    It is read once, from the beginning to the end, and never held as a whole. Made by :func:`read_bag`.

    Attributes
    ----------
    start : Scene
        Before the first moment: empty, with the thresholds that count.
    report : Report
        What was read and left out so far.
    """

    def __init__(self, bag: Bag, choices: Choices) -> None:
        self._bag, self._choices = bag, choices
        self.topic = boxes_topic(bag, choices.topic)
        self.report = Report()
        self.frame = frame_name(choices.frame)
        hold = choices.hold * 1.0e9
        self._known = Transforms(int(hold) if math.isfinite(hold) else 2**63)
        self._poses = pose_topic(bag, choices.robot)
        around = choices.around
        self.start = Scene("log") if around is None else Scene("log", thresholds=around.thresholds)
        self._fixed = set() if around is None else {one.id for one in around.objects}
        self._tracks = Tracks(choices.forget * 1.0e9, choices.tracking, self.start.thresholds, self._fixed)
        self._placing = Placing(self._known, self.frame, choices.level, self.report)
        self._there: dict[str, SpatialObject] = {}
        self._looks: View | None = None
        self._begun = False

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._bag.close()

    def __iter__(self) -> Iterator[tuple[int, Scene]]:
        scene = self.start
        for stamp, update in self.updates():
            scene = update.applied(scene)
            yield stamp, scene

    def updates(self) -> Iterator[tuple[int, Update]]:
        """Yield the stamp of each moment, nanoseconds, and what it changes in the scene before it.

        Raises
        ------
        ReaderError
            The bag is damaged, what was read of it being yielded before; the message says how much that was.
            Or it was read already.
        """
        if self._begun:
            raise ReaderError(f"{self._bag.name} was read already: open it anew")
        self._begun = True
        for shown in self._in_order():
            update = self._update(shown)
            self.report.frames += 1
            self.report.first = shown.stamp if self.report.first is None else self.report.first
            self.report.last = shown.stamp
            yield shown.stamp, update

    def _in_order(self) -> Iterator[Detected]:
        """Yield what messages show in the order of their stamps, once tf had time to be recorded."""
        tf, static = self._choices.tf, f"{self._choices.tf}_static"
        for message in self._bag.messages([static], TREES):
            self._tell(message, static=True)
        waiting: list[tuple[int, int, int, Detected]] = []
        number, latest = count(), -math.inf
        topics = [self.topic, tf, *([self._poses] if self._poses else [])]
        damage: ReaderError | None = None
        try:
            for message in self._bag.messages(topics, (*BOXES, *TREES, *POSES)):
                if message.topic == tf:
                    self._tell(message, static=False)
                elif message.topic == self._poses:
                    self._tell_pose(message)
                else:
                    shown = detected(message, self.report, self._choices.names)
                    heapq.heappush(waiting, (shown.stamp, next(number), message.recorded, shown))
                while waiting and (len(waiting) > MOST or message.recorded - waiting[0][2] >= WAIT):
                    latest = yield from self._next(waiting, latest)
        except ReaderError as cause:
            damage = cause  # what was read until then is shown first
        while waiting:
            latest = yield from self._next(waiting, latest)
        if damage is not None:
            raise damage

    def _next(
        self, waiting: list[tuple[int, int, int, Detected]], latest: float
    ) -> Generator[Detected, None, float]:
        shown = heapq.heappop(waiting)[3]
        if shown.stamp <= latest:
            self.report.skip("a message is of no later moment than the one before it", seconds(shown.stamp))
            return latest
        yield shown
        return shown.stamp

    def _tell(self, message: Message, *, static: bool) -> None:
        for one in message.value.transforms:
            place, turn = one.transform.translation, one.transform.rotation
            child, parent = frame_name(one.child_frame_id), frame_name(one.header.frame_id)
            if not self._known.tell(
                child,
                parent,
                stamp_of(one.header),
                (place.x, place.y, place.z),
                (turn.x, turn.y, turn.z, turn.w),
                static=static,
            ):
                self.report.skip("a transform is none", f"of {quoted(child)} in {quoted(parent)}")

    def _tell_pose(self, message: Message) -> None:
        """Take in a pose as that of a frame with the topic's name, which begins with a slash."""
        pose = message.value.pose
        pose = getattr(pose, "pose", pose)
        place, turn = pose.position, pose.orientation
        parent = frame_name(message.value.header.frame_id)
        if not self._known.tell(
            message.topic,
            parent,
            stamp_of(message.value.header),
            (place.x, place.y, place.z),
            (turn.x, turn.y, turn.z, turn.w),
        ):
            self.report.skip("a pose is none", f"of {message.topic} in {quoted(parent)}")

    def _update(self, shown: Detected) -> Update:
        seen = self._tracks.see(shown.stamp, self._sightings(shown))
        objects = []
        for name, (region, labels) in seen.things.items():
            kind: Kind = "surface" if labels and labels[0].name.casefold() in SURFACES else "object"
            before = self._there.get(name)
            thing = SpatialObject(name, labels, kind, region)
            if before is None or not _same(before, thing):
                objects.append(thing)
                self._there[name] = thing
        for name in seen.gone:
            del self._there[name]
        around = self._choices.around if self.report.frames == 0 else None
        view = self._view(shown.stamp)
        before_view, self._looks = self._looks, view
        views = () if view is None or _same_pose(before_view, view) else (view,)
        left = (ROBOT,) if view is None and before_view is not None else ()
        if around is not None:
            objects = [*around.objects, *objects]
            views = (*around.views, *views)
        return Update(tuple(objects), seen.gone, views, left, shown.stamp / 1.0e9)

    def _sightings(self, shown: Detected) -> list[Sighting]:
        """Return the things that a message shows, none twice by its id."""
        tracked = self._choices.tracking == "auto"
        found: list[Sighting] = []
        by_id: dict[str, int] = {}
        for one, region in zip(shown.found, self._placing.regions(shown.found), strict=True):
            if region is None:
                continue
            if tracked and one.track in self._fixed:
                raise SceneError(
                    f"a track of the bag and an object of the scene around it are both called "
                    f"{quoted(one.track)}: rename the object"
                )
            box = region_box(region, "object", self.start.thresholds)
            sighting = Sighting(one.track if tracked else "", one.labels, region, box)
            rival = by_id.get(sighting.track)
            if rival is None:
                if sighting.track:
                    by_id[sighting.track] = len(found)
                found.append(sighting)
                continue
            self.report.skip(
                "another detection of the message has its id", f"{quoted(one.track)}, {seconds(shown.stamp)}"
            )
            if sighting.score > found[rival].score:
                found[rival] = sighting
        self.report.detections += len(found)
        return found

    def _view(self, stamp: int) -> View | None:
        """Return the view from the robot; None where nobody looks, or from where is not known."""
        robot = self._choices.robot
        if robot is None:
            return None
        pose = self._known.pose(self._poses or frame_name(robot), self.frame, stamp)
        if isinstance(pose, Unknown):
            self.report.skip(f"the robot is not placed: {pose.reason}", pose.detail)
            return None
        if np.abs(pose.position).max() > MAX_COORDINATE:
            self.report.skip(f"the robot is beyond {MAX_COORDINATE:g} m", f"at {seconds(stamp)}")
            return None
        ahead = pose.turn.apply([1.0, 0.0, 0.0])
        return View(ROBOT, ROBOT, pose.position, float(np.arctan2(ahead[1], ahead[0])), stamp / 1.0e9)


def read_bag(path: str | os.PathLike[str], **choices: Any) -> Log:
    """Return a recording as a scene that changes.

    Parameters
    ----------
    path : path
        A folder with ``metadata.yaml``, or a file that ends in ``.mcap``, ``.db3`` or, of ROS 1, ``.bag``.
    **choices
        As of :class:`Choices`.

    Raises
    ------
    MissingDependency
        rosbags is not installed.
    ReaderError
        There is no bag, it is damaged, or it has no topic of detections, or several.
    """
    wanted = Choices(**choices)
    bag = Bag(path)
    try:
        return Log(bag, wanted)
    except BaseException:
        bag.close()
        raise


def _same(one: SpatialObject, other: SpatialObject) -> bool:
    """Return whether two sightings of a thing tell the same."""
    a, b = one.region, other.region
    if (one.labels, one.kind) != (other.labels, other.kind):
        return False
    if isinstance(a, BoxRegion) and isinstance(b, BoxRegion):
        return a.yaw == b.yaw and bool((a.center == b.center).all() and (a.size == b.size).all())
    if isinstance(a, MeshRegion) and isinstance(b, MeshRegion):
        return bool((a.vertices == b.vertices).all())
    return False


def _same_pose(one: View | None, other: View) -> bool:
    return one is not None and one.heading == other.heading and bool((one.position == other.position).all())
