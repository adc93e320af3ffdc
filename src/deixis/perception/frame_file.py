"""Frame files: a frame of format v1 with the images or the cloud beside it."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np

from deixis.errors import SceneError
from deixis.frames import Array
from deixis.mesh_file import locate
from deixis.perception import clouds, images
from deixis.perception.camera import Camera
from deixis.perception.frame import CloudFrame, Frame
from deixis.perception.frame_format import FramePart, PosePart, parse_frame
from deixis.scene import Label
from deixis.strict_json import parse, quoted, read_bytes


def load_frame(path: str | os.PathLike[str]) -> Frame | CloudFrame:
    """Return the frame in a file of frame format v1.

    Parameters
    ----------
    path : path
        Of a JSON file. What it names must lie in its folder. A cloud is only looked at here, and read when
        the frame is added to a map.

    Raises
    ------
    SceneError
        Anything is missing, unknown, of the wrong kind or size, or damaged; the message names it.
    """
    place = Path(path)
    name = quoted(place.name, 200)
    part = parse_frame(parse(read_bytes(place, SceneError), SceneError, name), name)
    try:
        return _frame(part, place.parent)
    except SceneError as cause:
        raise SceneError(f"{name}: {cause}") from cause


def _frame(part: FramePart, folder: Path) -> Frame | CloudFrame:
    given = part.model_fields_set
    labels = {
        thing.instance: tuple(Label(label.name, float(label.score)) for label in thing.labels)
        for thing in part.things
    }
    robot = np.array(part.robot.position, dtype=np.float64)
    noise = part.noise if "noise" in given else None
    if "cloud" in given:
        cloud = clouds.open_cloud(locate(part.cloud, folder, clouds.KINDS, "frame"))
        return CloudFrame(part.stamp, cloud, labels, robot, part.robot.heading, part.robot.label, noise)
    lens = part.intrinsics
    size = lens.width, lens.height
    camera = Camera(*size, lens.fx, lens.fy, lens.cx, lens.cy, _matrix(part.pose))
    depth = images.read_depth(locate(part.depth, folder, images.KINDS, "frame"), size, part.depth_scale)
    numbers = images.read_instances(locate(part.instances, folder, images.KINDS, "frame"), size)
    return Frame(
        part.stamp, camera, depth, numbers, labels, robot, part.robot.heading, part.robot.label, noise
    )


def _matrix(pose: PosePart) -> Array:
    """Return a pose as a matrix (4, 4)."""
    if "matrix" in pose.model_fields_set:
        return np.array(pose.matrix, dtype=np.float64)
    from scipy.spatial.transform import Rotation

    quaternion = np.array(pose.quaternion, dtype=np.float64)
    if float(np.linalg.norm(quaternion)) < 1.0e-6:
        raise SceneError("pose.quaternion is zero: give x, y, z, w")
    matrix = np.eye(4)
    matrix[:3, :3] = Rotation.from_quat(quaternion).as_matrix()
    matrix[:3, 3] = pose.position
    return matrix
