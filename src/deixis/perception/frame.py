"""Frame: what a robot saw at one time, read from a frame file or made in Python."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from deixis.errors import SceneError
from deixis.frames import Array
from deixis.perception.camera import Camera
from deixis.perception.clouds import CloudFile
from deixis.scene import Label


@dataclass(frozen=True, eq=False)
class Frame:
    """A depth image with the regions recognised in it, and where the camera and the robot were.

    Attributes
    ----------
    stamp : float
        Seconds since the epoch of the recording.
    camera : Camera
    depth : (h, w) float
        Metres along the optical axis; 0 or NaN where there is none.
    instances : (h, w) int
        Which thing each pixel shows, 0 none.
    labels : mapping of int to tuple of Label
        What each thing may be called, best first.
    position : (3,) float
        The robot's, metres, world frame.
    heading : float
        The robot's, radians from the world's X axis.
    robot : str
        What the robot is called.
    noise : float or None
        Standard deviation of the depths, metres; None to measure it in the image.
    """

    stamp: float
    camera: Camera
    depth: Array
    instances: NDArray[np.integer]
    labels: Mapping[int, tuple[Label, ...]] = field(default_factory=dict)
    position: Array = field(default_factory=lambda: np.zeros(3))
    heading: float = 0.0
    robot: str = "robot"
    noise: float | None = None

    def __post_init__(self) -> None:
        shape = (self.camera.height, self.camera.width)
        for noun, image in (("depth", self.depth), ("instance", self.instances)):
            if image.shape != shape:
                has = " x ".join(map(str, image.shape[::-1]))
                raise SceneError(
                    f"the {noun} image is {has} pixels, the camera {shape[1]} x {shape[0]}: give its own"
                )
        if not np.isfinite(self.stamp):
            raise SceneError("the frame's stamp is not finite: give seconds since the epoch")
        if self.noise is not None and not 0.0 <= self.noise < np.inf:
            raise SceneError("the frame's noise is not finite: give metres, zero or more, or leave it out")


@dataclass(frozen=True, eq=False)
class CloudFrame:
    """A cloud in the world frame with the regions recognised in it, and where the robot was.

    Attributes
    ----------
    stamp : float
        Seconds since the epoch of the recording.
    cloud : CloudFile
    labels : mapping of int to tuple of Label
    position : (3,) float
        The robot's, metres, world frame.
    heading : float
    robot : str
    noise : float or None
        Standard deviation of the points, metres.
    """

    stamp: float
    cloud: CloudFile
    labels: Mapping[int, tuple[Label, ...]] = field(default_factory=dict)
    position: Array = field(default_factory=lambda: np.zeros(3))
    heading: float = 0.0
    robot: str = "robot"
    noise: float | None = None
