"""Definitions of vision_msgs for bags that hold none: ROS 2 kept them out of sqlite3 files until Iron.

The messages changed between versions. Which one a bag has is seen when the first message with a detection is
decoded: each field must be where it should, and no byte left over.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from rosbags.typesys.store import Typestore

DETECTIONS: Final = "vision_msgs/msg/Detection3DArray"
DETECTION: Final = "vision_msgs/msg/Detection3D"

_ARRAY: Final = "std_msgs/Header header\nvision_msgs/Detection3D[] detections\n"
_BOX: Final = "geometry_msgs/Pose center\ngeometry_msgs/Vector3 size\n"
_OLD_RESULT: Final = "string id\nfloat64 score\ngeometry_msgs/PoseWithCovariance pose\n"
_NEW_RESULT: Final = "vision_msgs/ObjectHypothesis hypothesis\ngeometry_msgs/PoseWithCovariance pose\n"
_DETECTION: Final = (
    "std_msgs/Header header\nvision_msgs/ObjectHypothesisWithPose[] results\nvision_msgs/BoundingBox3D bbox\n"
)
_CLOUD: Final = "sensor_msgs/PointCloud2 source_cloud\n"

VERSIONS: Final = {
    "4": (_NEW_RESULT, _DETECTION + "string id\n"),
    "2": (_OLD_RESULT, _DETECTION + _CLOUD + "bool is_tracking\nstring tracking_id\n"),
    "1": (_OLD_RESULT, _DETECTION + _CLOUD),
}
"""By major version, 3 as 4, the newest first: what ObjectHypothesisWithPose and Detection3D are made of."""


def store(version: str) -> Typestore:
    """Return the messages of ROS 2 with a version of vision_msgs.

    Examples
    --------
    >>> [name for name, _ in store("4").fielddefs[DETECTION][1]]
    ['header', 'results', 'bbox', 'id']
    """
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    result, detection = VERSIONS[version]
    made = get_typestore(Stores.ROS2_HUMBLE)
    for name, text in (
        ("vision_msgs/msg/ObjectHypothesis", "string class_id\nfloat64 score\n"),
        ("vision_msgs/msg/ObjectHypothesisWithPose", result),
        ("vision_msgs/msg/BoundingBox3D", _BOX),
        (DETECTION, detection),
        (DETECTIONS, _ARRAY),
    ):
        made.register(get_types_from_msg(text, name))
    return made
