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

from deixis.errors import MissingDependency, SceneError
from deixis.logs.telling import Teller
from deixis.logs.transforms import seconds
from deixis.relations import Relation
from deixis.scene import Scene
from deixis.strict_json import quoted

if TYPE_CHECKING:
    from foxglove.messages import SceneEntity

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

            from deixis.logs import drawing
        except ImportError as cause:
            raise MissingDependency(
                f"MCAP is written with foxglove-sdk, which cannot be imported ({cause}): "
                "pip install 'deixis[ros]'"
            ) from cause
        self._channels, self._drawing = channels, drawing
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
        if not 0 <= stamp < _LATEST:
            raise SceneError(f"the stamp {seconds(stamp)} is not between 1970 and 2106: MCAP cannot hold it")
        drawer = self._drawing.Drawer(scene, self._frame, stamp)
        topics: dict[str, dict[str, SceneEntity]] = {
            topic: {} for topic, names in self._shown.items() if names
        }
        topics[THINGS] = drawer.things()
        for name, entities in drawer.relations(list(relations), say or Teller(scene)).items():
            topics[f"{RELATIONS}/{name}"] = entities
        for topic, entities in topics.items():
            gone = sorted(self._shown.get(topic, set()) - entities.keys())
            self._log(topic, self._channels.SceneUpdateChannel, drawer.update(entities, gone), stamp)
            self._shown[topic] = set(entities)
            self.entities += len(entities)
        for view in scene.views:
            # A topic is a path: what else an id may have is written as a line.
            topic = f"{VIEWS}/{re.sub('[^A-Za-z0-9_]', '_', view.id)}"
            self._log(topic, self._channels.PoseInFrameChannel, drawer.pose(view), stamp)

    def _log(self, topic: str, kind: Callable[..., Any], message: object, stamp: int) -> None:
        if topic not in self._topics:
            self._topics[topic] = kind(topic, context=self._context)
        self._topics[topic].log(message, log_time=stamp)
        self.messages += 1
