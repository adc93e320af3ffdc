"""Foxglove: scenes and what holds in them as an MCAP file, which Foxglove and its like show.

Each message shows all there is on its topic, so that one may begin anywhere in the recording: things on
``/deixis/things``, the arrows of each relation on ``/deixis/relations/NAME``, the poses of views on
``/deixis/views/ID``. What is there no more is deleted. Lengths are metres, in the fixed frame.
"""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterable
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any, Final, Self

import numpy as np

from deixis.errors import MissingDependency, SceneError
from deixis.logs.drawing import arrows, shape
from deixis.logs.telling import Teller
from deixis.logs.transforms import seconds
from deixis.relations import Relation
from deixis.scene import Scene, SpatialObject
from deixis.strict_json import quoted

if TYPE_CHECKING:
    from foxglove.messages import SceneEntity, Timestamp

THINGS: Final = "/deixis/things"
RELATIONS: Final = "/deixis/relations"
VIEWS: Final = "/deixis/views"

_LATEST: Final = 2**32 * 10**9
"""Nanoseconds: later ones no time stamp of the format can hold."""


class FoxgloveFile:
    """An MCAP file that is being written; it is there when all of it is written, or not at all.

    Parameters
    ----------
    path : path
    frame : str
        Name of the fixed frame.

    Attributes
    ----------
    entities : int
        Things and arrows written so far, each as often as it was.
    messages : int

    Raises
    ------
    MissingDependency
        foxglove-sdk is not installed.
    SceneError
        The file cannot be written.
    """

    def __init__(self, path: str | os.PathLike[str], frame: str = "map") -> None:
        try:
            import foxglove
            from foxglove import channels
        except ImportError as cause:
            raise MissingDependency(
                f"MCAP is written with foxglove-sdk, which cannot be imported ({cause}): "
                "pip install 'deixis[ros]'"
            ) from cause
        self._channels = channels
        self._place = Path(path).resolve()
        self._draft = self._place.with_name(f".{self._place.name}.{os.getpid()}.part")
        self._frame = frame
        self._context = foxglove.Context()
        self._topics: dict[str, Any] = {}
        self._shown: dict[str, set[str]] = {}
        self.entities = self.messages = 0
        if self._place.exists() and not self._place.is_file():
            raise SceneError(f"{quoted(str(path), 200)} is no file: give the name of one, or a new name")
        try:
            self._writer = foxglove.open_mcap(self._draft, allow_overwrite=True, context=self._context)
        except (OSError, RuntimeError) as cause:
            raise SceneError(f"{quoted(str(path), 200)} cannot be written: {cause}") from cause

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        try:
            self._writer.close()
            if error is None:
                self._draft.replace(self._place)
        except (OSError, RuntimeError) as cause:
            raise SceneError(f"{quoted(str(self._place), 200)} cannot be written: {cause}") from cause
        finally:
            self._draft.unlink(missing_ok=True)

    def write(
        self,
        stamp: int,
        scene: Scene,
        relations: Iterable[Relation],
        say: Callable[[Relation], str] | None = None,
    ) -> None:
        """Write what is so at a stamp.

        Parameters
        ----------
        stamp : int
            Nanoseconds since the epoch.
        scene : Scene
        relations : iterable of Relation
            Each becomes an arrow from its figure to its reference, if both are things of the scene.
        say : callable, optional
            Returns the sentence of a relation; by default plain ones without reasons.
        """
        from foxglove.messages import Timestamp

        if not 0 <= stamp < _LATEST:
            raise SceneError(f"the stamp {seconds(stamp)} is not between 1970 and 2106: MCAP cannot hold it")
        time = Timestamp(stamp // 10**9, stamp % 10**9)
        self._send(THINGS, stamp, time, {one.id: self._thing(one, time) for one in scene.objects})
        say = say or Teller(scene)
        topics: dict[str, dict[str, SceneEntity]] = {
            topic: {} for topic, shown in self._shown.items() if shown and topic != THINGS
        }
        there = {thing.id for thing in scene.objects}
        found = [one for one in relations if one.figure in there and one.reference in there]
        for one, arrow in zip(found, arrows(scene, found), strict=True):
            topics.setdefault(f"{RELATIONS}/{one.relation}", {})[_name(one)] = self._arrow(
                one, arrow, say(one), time
            )
        for topic, entities in topics.items():
            self._send(topic, stamp, time, entities)
        self._look(stamp, time, scene)

    def _thing(self, thing: SpatialObject, time: Timestamp) -> SceneEntity:
        from foxglove.messages import SceneEntity

        told = {"id": thing.id, "kind": thing.kind}
        for number, label in enumerate(thing.labels, 1):
            told[f"label {number}"] = f"{label.name} ({label.score:g})"
        return SceneEntity(
            timestamp=time,
            frame_id=self._frame,
            id=thing.id,
            metadata=_pairs(told),
            **shape(thing),
        )

    def _arrow(self, one: Relation, arrow: Any, sentence: str, time: Timestamp) -> SceneEntity:
        from foxglove.messages import SceneEntity

        told = {"sentence": sentence, "relation": one.relation, "figure": one.figure}
        told["reference"] = one.reference
        if one.view is not None:
            told["view"] = one.view
        if one.margin is not None:
            told["margin_m"] = repr(one.margin)
        return SceneEntity(
            timestamp=time, frame_id=self._frame, id=_name(one), metadata=_pairs(told), arrows=[arrow]
        )

    def _send(self, topic: str, stamp: int, time: Timestamp, entities: dict[str, SceneEntity]) -> None:
        from foxglove.messages import SceneEntityDeletion, SceneUpdate

        gone = sorted(self._shown.get(topic, set()) - entities.keys())
        update = SceneUpdate(
            deletions=[SceneEntityDeletion(timestamp=time, id=name) for name in gone],
            entities=list(entities.values()),
        )
        self._channel(topic, self._channels.SceneUpdateChannel).log(update, log_time=stamp)
        self._shown[topic] = set(entities)
        self.entities += len(entities)

    def _look(self, stamp: int, time: Timestamp, scene: Scene) -> None:
        from foxglove.messages import Pose, PoseInFrame, Quaternion, Vector3

        for view in scene.views:
            x, y, z = view.position.tolist()
            half = 0.5 * view.heading
            pose = Pose(
                position=Vector3(x=x, y=y, z=z),
                orientation=Quaternion(x=0.0, y=0.0, z=float(np.sin(half)), w=float(np.cos(half))),
            )
            # A topic is a path: what else an id may have is written as a line.
            topic = f"{VIEWS}/{re.sub('[^A-Za-z0-9_]', '_', view.id)}"
            told = PoseInFrame(timestamp=time, frame_id=self._frame, pose=pose)
            self._channel(topic, self._channels.PoseInFrameChannel).log(told, log_time=stamp)

    def _channel(self, topic: str, kind: Callable[..., Any]) -> Any:
        self.messages += 1
        if topic not in self._topics:
            self._topics[topic] = kind(topic, context=self._context)
        return self._topics[topic]


def _name(one: Relation) -> str:
    """Return what the arrow of a relation is called, each its own."""
    return "|".join([one.relation, one.figure, one.reference, *([] if one.view is None else [one.view])])


def _pairs(told: dict[str, str]) -> list[Any]:
    from foxglove.messages import KeyValuePair

    return [KeyValuePair(key=key, value=value) for key, value in told.items()]
