"""The camera: a pinhole with a pose, and depth images turned into points in the world frame.

The camera's frame is the optical one: X to the right, Y down, Z forward, metres; a pixel's coordinates
are those of its middle, so that the pixel at the upper left is (0, 0). Depth is measured along Z.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from deixis.errors import SceneError
from deixis.frames import Array, Index

SQUARE = 1.0e-3
"""How far a pose may be from a rotation, entry by entry, before it is refused rather than made one."""


@dataclass(frozen=True, eq=False)
class Camera:
    """A pinhole camera somewhere.

    Attributes
    ----------
    width, height : int
        Pixels.
    fx, fy : float
        Focal lengths, pixels.
    cx, cy : float
        The principal point, pixels.
    camera2world : (4, 4) float
        Takes points of the optical frame to the world frame.

    Raises
    ------
    SceneError
        A number is not finite, a focal length is not positive, or the pose is no rotation and translation.

    Examples
    --------
    >>> camera = Camera(3, 3, 1.0, 1.0, 1.0, 1.0, np.eye(4))
    >>> camera.points(np.array([1]), np.array([2]), np.array([4.0])).tolist()
    [[0.0, 4.0, 4.0]]
    """

    width: int
    height: int
    fx: float
    fy: float
    cx: float
    cy: float
    camera2world: Array

    def __post_init__(self) -> None:
        pose = np.array(self.camera2world, dtype=np.float64)
        numbers = [self.fx, self.fy, self.cx, self.cy]
        if not np.isfinite(numbers).all() or min(self.fx, self.fy) <= 0.0:
            raise SceneError(
                "the camera's intrinsics are not finite and positive: give fx, fy, cx, cy in pixels"
            )
        if pose.shape != (4, 4) or not np.isfinite(pose).all() or (pose[3] != [0.0, 0.0, 0.0, 1.0]).any():
            raise SceneError("the camera's pose is no rigid motion: give four rows, the last 0, 0, 0, 1")
        turn = pose[:3, :3]
        if np.abs(turn @ turn.T - np.eye(3)).max() > SQUARE or np.linalg.det(turn) < 0.0:
            raise SceneError("the camera's pose does not turn without stretching: give a rotation")
        # The nearest rotation: what was rounded on the way here is made exact.
        left, _, right = np.linalg.svd(turn)
        pose[:3, :3] = left @ right
        pose.setflags(write=False)
        object.__setattr__(self, "camera2world", pose)

    @property
    def position(self) -> Array:
        """Return where the camera is, (3,) metres, world frame."""
        return self.camera2world[:3, 3]

    def rays(self, u: Array | Index, v: Array | Index) -> Array:
        """Return what pixels look along, (n, 3), world frame, with one metre of depth each.

        Parameters
        ----------
        u, v : (n,)
            Columns and rows.
        """
        x, y = (u - self.cx) / self.fx, (v - self.cy) / self.fy
        turn = self.camera2world[:3, :3]
        return np.asarray(x[:, None] * turn[:, 0] + y[:, None] * turn[:, 1] + turn[:, 2])

    def points(self, u: Array | Index, v: Array | Index, depth: Array) -> Array:
        """Return the points that pixels show, (n, 3) metres, world frame.

        Parameters
        ----------
        u, v : (n,)
            Columns and rows.
        depth : (n,)
            Metres along the optical axis.
        """
        return np.asarray(depth[:, None] * self.rays(u, v) + self.position)
