"""Bags written by tests: ROS 2 in sqlite3 and MCAP, with and without definitions, and ROS 1."""

from __future__ import annotations

import sqlite3
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import numpy as np
from rosbags import rosbag1, rosbag2
from rosbags.rosbag2 import StoragePlugin
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from scipy.spatial.transform import Rotation

from deixis.logs.definitions import VERSIONS, store

SECOND = 10**9
START = 1_700_000_000 * SECOND
"""Nanoseconds: when what tests write begins."""

UPRIGHT = (0.0, 0.0, 0.0, 1.0)

_ROS1 = {
    "vision_msgs/msg/ObjectHypothesisWithPose": (
        "int64 id\nfloat64 score\ngeometry_msgs/PoseWithCovariance pose\n"
    ),
    "vision_msgs/msg/BoundingBox3D": "geometry_msgs/Pose center\ngeometry_msgs/Vector3 size\n",
    "vision_msgs/msg/Detection3D": (
        "std_msgs/Header header\nvision_msgs/ObjectHypothesisWithPose[] results\n"
        "vision_msgs/BoundingBox3D bbox\nsensor_msgs/PointCloud2 source_cloud\n"
    ),
    "vision_msgs/msg/Detection3DArray": "std_msgs/Header header\nvision_msgs/Detection3D[] detections\n",
    "tf2_msgs/msg/TFMessage": "geometry_msgs/TransformStamped[] transforms\n",
}


@dataclass(frozen=True)
class Box:
    """A box as a detector finds it; stamp and frame are those of the message unless given."""

    label: str
    center: Sequence[float]
    size: Sequence[float]
    quaternion: Sequence[float] = UPRIGHT
    track: str = ""
    score: float = 0.9
    frame: str = ""
    stamp: int = 0
    more: Sequence[tuple[str, float]] = ()


@dataclass
class Written:
    """A bag that is being written.

    Parameters
    ----------
    path : Path
        A folder of ROS 2; a file that ends in .bag of ROS 1.
    storage : "sqlite3" or "mcap"
    version : str
        Of vision_msgs.
    """

    path: Path
    storage: str = "sqlite3"
    version: str = "4"
    topic: str = "/detections"
    _connections: dict[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.ros1 = self.path.suffix == ".bag"
        if self.ros1:
            self.types = get_typestore(Stores.ROS1_NOETIC)
            for name, text in _ROS1.items():
                self.types.register(get_types_from_msg(text, name))
            self.writer: Any = rosbag1.Writer(self.path)
        else:
            self.types = store(self.version)
            plugin = StoragePlugin.MCAP if self.storage == "mcap" else StoragePlugin.SQLITE3
            self.writer = rosbag2.Writer(self.path, version=9, storage_plugin=plugin)

    def __enter__(self) -> Self:
        self.writer.open()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.writer.close()

    def detections(
        self, stamp: int, boxes: Sequence[Box], frame: str = "map", *, recorded: int | None = None
    ) -> None:
        """Write what a detector found at a stamp, nanoseconds."""
        kind = "vision_msgs/msg/Detection3DArray"
        value = self._make(
            kind, header=self._header(stamp, frame), detections=[self._detection(one) for one in boxes]
        )
        self.write(self.topic, kind, value, stamp if recorded is None else recorded)

    def tf(
        self,
        stamp: int,
        parent: str,
        child: str,
        position: Sequence[float],
        quaternion: Sequence[float] = UPRIGHT,
        *,
        static: bool = False,
        recorded: int | None = None,
    ) -> None:
        """Write the pose of a frame in its parent."""
        transform = self._make(
            "geometry_msgs/msg/Transform",
            translation=self._xyz("Vector3", position),
            rotation=self._xyz("Quaternion", quaternion),
        )
        stamped = self._make(
            "geometry_msgs/msg/TransformStamped",
            header=self._header(stamp, parent),
            child_frame_id=child,
            transform=transform,
        )
        kind = "tf2_msgs/msg/TFMessage"
        value = self._make(kind, transforms=[stamped])
        self.write("/tf_static" if static else "/tf", kind, value, stamp if recorded is None else recorded)

    def pose(
        self,
        stamp: int,
        topic: str,
        frame: str,
        position: Sequence[float],
        quaternion: Sequence[float] = UPRIGHT,
    ) -> None:
        """Write a PoseStamped."""
        kind = "geometry_msgs/msg/PoseStamped"
        value = self._make(kind, header=self._header(stamp, frame), pose=self._pose(position, quaternion))
        self.write(topic, kind, value, stamp)

    def write(self, topic: str, kind: str, value: Any, recorded: int) -> None:
        """Write any message."""
        if topic not in self._connections:
            self._connections[topic] = self.writer.add_connection(topic, kind, typestore=self.types)
        serialize = self.types.serialize_ros1 if self.ros1 else self.types.serialize_cdr
        self.writer.write(self._connections[topic], recorded, serialize(value, kind))

    def _make(self, kind: str, **fields: Any) -> Any:
        return self.types.types[kind](**fields)

    def _header(self, stamp: int, frame: str) -> Any:
        time = self._make("builtin_interfaces/msg/Time", sec=stamp // SECOND, nanosec=stamp % SECOND)
        more = {"seq": 0} if self.ros1 else {}
        return self._make("std_msgs/msg/Header", **more, stamp=time, frame_id=frame)

    def _xyz(self, kind: str, values: Sequence[float]) -> Any:
        return self._make(f"geometry_msgs/msg/{kind}", **dict(zip("xyzw", map(float, values), strict=False)))

    def _pose(self, position: Sequence[float], quaternion: Sequence[float]) -> Any:
        return self._make(
            "geometry_msgs/msg/Pose",
            position=self._xyz("Point", position),
            orientation=self._xyz("Quaternion", quaternion),
        )

    def _result(self, label: str, score: float) -> Any:
        pose = self._make(
            "geometry_msgs/msg/PoseWithCovariance",
            pose=self._pose((0.0, 0.0, 0.0), UPRIGHT),
            covariance=np.zeros(36),
        )
        kind = "vision_msgs/msg/ObjectHypothesisWithPose"
        if not self.ros1 and "hypothesis" in VERSIONS[self.version][0]:
            told = self._make("vision_msgs/msg/ObjectHypothesis", class_id=label, score=score)
            return self._make(kind, hypothesis=told, pose=pose)
        return self._make(kind, id=int(label) if self.ros1 else label, score=score, pose=pose)

    def _detection(self, one: Box) -> Any:
        bbox = self._make(
            "vision_msgs/msg/BoundingBox3D",
            center=self._pose(one.center, one.quaternion),
            size=self._xyz("Vector3", one.size),
        )
        ranked = [(one.label, one.score), *one.more] if one.label else list(one.more)
        fields: dict[str, Any] = {
            "header": self._header(one.stamp, one.frame),
            "results": [self._result(*each) for each in ranked],
            "bbox": bbox,
        }
        kind = "vision_msgs/msg/Detection3D"
        known = [name for name, _ in self.types.fielddefs[kind][1]]
        if "source_cloud" in known:
            fields["source_cloud"] = self._make(
                "sensor_msgs/msg/PointCloud2",
                header=self._header(0, ""), height=0, width=0, fields=[], is_bigendian=False, point_step=0,
                row_step=0, data=np.zeros(0, dtype=np.uint8), is_dense=True,
            )  # fmt: skip
        if "tracking_id" in known:
            fields |= {"is_tracking": bool(one.track), "tracking_id": one.track}
        elif "id" in known:
            fields["id"] = one.track
        return self._make(kind, **fields)


def forget_definitions(bag: Path) -> None:
    """Make an sqlite3 bag what it was before Iron: without the definitions of its messages."""
    (place,) = bag.glob("*.db3")
    with sqlite3.connect(place) as database:
        database.execute("UPDATE schema SET schema_version = 3")
        database.execute("DROP TABLE message_definitions")
        database.execute("ALTER TABLE topics DROP COLUMN type_description_hash")
    database.close()


def kitchen(path: Path, storage: str = "sqlite3", version: str = "4") -> Path:
    """Write the bag that is told of in the README.

    For 12 seconds, once a second, a robot's camera finds a table with a book on it and a cup. The cup is in
    the air; after 5 s someone has put it on the table, beside the book. The robot stands in front, at
    y = -2.5 m; from 6 s on it drives round the table until it is behind. From 10 s on nobody sees the book.
    """
    # Optical frames have Z ahead and Y down.
    mounted = np.array([0.2, 0.0, 0.5]), Rotation.from_quat([-0.5, 0.5, -0.5, 0.5])
    with Written(path, storage, version) as bag:
        bag.tf(START, "base_link", "camera", mounted[0], mounted[1].as_quat(), static=True)
        bag.tf(START, "map", "odom", (1.0, 0.0, 0.0), static=True)
        for at in range(13):
            stamp = START + at * SECOND
            # A little before and a little after, so that the pose at the stamp is between two.
            for shift in (-0.1, 0.1):
                place, turn = _driven(at + shift)
                told = stamp + round(shift * SECOND)
                bag.tf(told, "odom", "base_link", place - [1.0, 0.0, 0.0], turn.as_quat(), recorded=stamp)
            (place, turn), (before, _), (after, _) = (_driven(at + shift) for shift in (0.0, -0.1, 0.1))
            camera = 0.5 * (before + after) + turn.apply(mounted[0]), turn * mounted[1]
            height = 0.85 if at >= 5 else 1.25
            seen = [
                ("table", (0.0, 0.0, 0.4), (1.6, 0.8, 0.8)),
                ("cup", (0.2, 0.1, height), (0.1, 0.1, 0.1)),
                ("book", (0.4, 0.1, 0.825), (0.2, 0.3, 0.05)),
            ]
            found = [_seen_from(*camera, *one) for one in seen[: 3 if at < 10 else 2]]
            bag.detections(stamp, found, "camera", recorded=stamp + SECOND // 20)
    return path


def _driven(at: float) -> tuple[Any, Rotation]:
    """Return where the robot of the kitchen is after so many seconds; it looks at the table."""
    angle = np.radians(30.0 * max(at - 6.0, 0.0) - 90.0)
    place = np.array([2.5 * np.cos(angle), 2.5 * np.sin(angle), 0.0])
    return place, Rotation.from_euler("z", angle + np.pi)


def _seen_from(eye: Any, turn: Rotation, label: str, center: Sequence[float], size: Sequence[float]) -> Box:
    """Return a box that is level in the map as a camera finds it."""
    back = turn.inv()
    return Box(label, back.apply(np.array(center) - eye).tolist(), size, back.as_quat().tolist())
