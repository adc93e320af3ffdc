"""Bags: recordings of ROS 2 (sqlite3, MCAP) and ROS 1, read message by message with rosbags, without ROS."""

from __future__ import annotations

import os
from collections.abc import Callable, Collection, Iterator
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, Self

from deixis.errors import DeixisError, MissingDependency, ReaderError
from deixis.logs.definitions import DETECTION, DETECTIONS, VERSIONS, store
from deixis.logs.transforms import seconds
from deixis.strict_json import quoted

if TYPE_CHECKING:
    from rosbags.interfaces import Connection
    from rosbags.typesys.store import Typestore

BOXES: Final = (DETECTIONS, DETECTION)
"""Types of messages that show things."""

TREES: Final = ("tf2_msgs/msg/TFMessage", "tf/msg/tfMessage")
"""Types of messages that tell of frames."""

POSES: Final = (
    "geometry_msgs/msg/PoseStamped",
    "geometry_msgs/msg/PoseWithCovarianceStamped",
    "nav_msgs/msg/Odometry",
)
"""Types of messages that tell where something is."""

_MOST: Final = 1_000_000
"""Entries of one sequence in a message."""


@dataclass(frozen=True, slots=True)
class Topic:
    """A topic of a bag: its name, the type of its messages, and how many there are."""

    name: str
    kind: str
    count: int


@dataclass(frozen=True, slots=True)
class Message:
    """A message: its topic, when it was recorded (nanoseconds), itself, and the fields of its types."""

    topic: str
    recorded: int
    value: Any
    fields: Callable[[str], frozenset[str]]


class Bag:
    """A recording that is read from its beginning to its end.

    Parameters
    ----------
    path : path
        A folder with ``metadata.yaml``, or a file that ends in ``.mcap``, ``.db3`` or, of ROS 1, ``.bag``.

    Raises
    ------
    MissingDependency
        rosbags is not installed.
    ReaderError
        There is no bag, or it is damaged.
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        try:
            from rosbags import rosbag1, rosbag2
        except ImportError as cause:
            raise MissingDependency(
                f"bags are read with rosbags, which cannot be imported ({cause}): pip install 'deixis[ros]'"
            ) from cause
        place = Path(path)
        self.name = quoted(str(place), 200)
        self._ros1 = place.suffix == ".bag"
        self._read, self._last = 0, 0
        self._decoders: dict[tuple[str, str], _Decoder] = {}
        if not place.exists():
            raise ReaderError(f"{self.name} does not exist: give the folder of a bag, or its file")
        if place.is_dir() and not (place / "metadata.yaml").exists():
            raise ReaderError(f"{self.name} has no metadata.yaml: give the .mcap or .db3 file in it itself")
        with self._guarded():
            self._reader: Any = rosbag1.Reader(place) if self._ros1 else rosbag2.Reader(place)
            self._reader.open()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Close the files."""
        with self._guarded():
            self._reader.close()

    @property
    def topics(self) -> tuple[Topic, ...]:
        """Return the topics, by name."""
        counts: dict[tuple[str, str], int] = {}
        for one in self._reader.connections:
            counts[one.topic, one.msgtype] = counts.get((one.topic, one.msgtype), 0) + one.msgcount
        return tuple(Topic(name, kind, count) for (name, kind), count in sorted(counts.items()))

    def messages(self, topics: Collection[str], kinds: Collection[str]) -> Iterator[Message]:
        """Yield the messages of some topics in the order in which they were recorded.

        Raises
        ------
        ReaderError
            The bag is damaged; the message says how much of it was read.
        """
        wanted = [one for one in self._reader.connections if one.topic in topics and one.msgtype in kinds]
        if not wanted:
            return
        with self._guarded():
            rows = self._reader.messages(connections=wanted)
        while True:
            with self._guarded():
                row = next(rows, None)
                if row is None:
                    return
                connection, recorded, raw = row[0], int(row[1]), row[2]
                decoder = self._decoder(connection)
                value = decoder(raw)
            self._read, self._last = self._read + 1, recorded
            yield Message(connection.topic, recorded, value, decoder.fields)

    def _decoder(self, connection: Connection) -> _Decoder:
        key = connection.msgtype, connection.msgdef.data
        if key not in self._decoders:
            self._decoders[key] = _Decoder(connection, self._ros1)
        return self._decoders[key]

    def _guarded(self) -> AbstractContextManager[None]:
        return _guarded(self._told)

    def _told(self) -> str:
        if not self._read:
            return f"{self.name} cannot be read as a bag"
        return f"{self.name} is damaged: {self._read} messages were read, the last of {seconds(self._last)}"


@contextmanager
def _guarded(told: Callable[[], str]) -> Iterator[None]:
    """Turn whatever a decoder stumbles over in a damaged file into one kind of error."""
    try:
        yield
    except DeixisError:
        raise
    except Exception as cause:
        told_by = cause.args[0] if len(cause.args) == 1 else cause
        reason = " ".join(str(told_by).strip("(),.'").split()) or type(cause).__name__
        raise ReaderError(
            f"{told()}: {reason[:200]}: `ros2 bag reindex` or `mcap recover` may help"
        ) from cause


class _Decoder:
    """Makes messages of bytes, by the definition in the bag, else by the one known that fits."""

    def __init__(self, connection: Connection, ros1: bool) -> None:
        from rosbags.interfaces import MessageDefinitionFormat

        self._kind, self._ros1 = connection.msgtype, ros1
        if connection.msgdef.format is not MessageDefinitionFormat.NONE:
            self._stores = [_defined(connection)]
        elif self._kind in BOXES:
            self._stores = [store(version) for version in VERSIONS]
        else:
            self._stores = [store("4")]

    def __call__(self, raw: bytes) -> Any:
        from rosbags.serde import SerdeError

        fitting, values = [], []
        for one in self._stores:
            try:
                values.append(self._value(one, raw))
            except SerdeError:
                if len(self._stores) == 1:
                    raise
            else:
                fitting.append(one)
        if not fitting:
            raise ReaderError(
                f"messages of {quoted(self._kind)} are of no version that is known, and the bag does not "
                "define them: convert it to MCAP with the definitions (`ros2 bag convert`)"
            )
        self._stores = fitting
        return values[0]

    def _value(self, types: Typestore, raw: bytes) -> Any:
        read = types.deserialize_ros1 if self._ros1 else types.deserialize_cdr
        return read(raw, self._kind)

    def fields(self, kind: str) -> frozenset[str]:
        """Return the names of the fields of a type."""
        known = self._stores[0].fielddefs.get(kind)
        return frozenset() if known is None else frozenset(name for name, _ in known[1])


def _defined(connection: Connection) -> Typestore:
    """Return the types that a bag defines for a topic."""
    from rosbags.interfaces import MessageDefinitionFormat
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    if connection.msgdef.format is not MessageDefinitionFormat.MSG:
        raise ReaderError(
            f"topic {quoted(connection.topic)}: the bag defines {quoted(connection.msgtype)} in IDL, "
            "which is not read: record it where the package has .msg files"
        )
    made = get_typestore(Stores.EMPTY)
    made.max_sequence_length = _MOST
    made.register(get_types_from_msg(connection.msgdef.data, connection.msgtype))
    return made
