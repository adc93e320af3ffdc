"""Carving: points that another frame looks through are not there.

Noise moves a point along the ray it was measured on, which from the side is sideways. So where a frame sees,
around the place a point of a thing would have in it, nothing of the thing and everything further away, the
point is noise. Where the frame sees something nearer, or nothing, it says nothing.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from deixis.frames import Array, Mask
from deixis.perception.camera import Camera
from deixis.perception.frame import Frame

BEHIND: Final = 3.0
"""Standard deviations of noise by which what is seen must lie behind the point."""

LEAST: Final = 0.02
"""Metres: and never less than this."""

DOUBT: Final = 0.3
"""Share of a cloud from which on it is rather the poses that disagree: then nothing is carved."""


@dataclass(frozen=True, eq=False)
class Backdrop:
    """What a frame sees, kept for other frames' points.

    Attributes
    ----------
    view : str
    camera : Camera
    nearest : (h, w) float32
        The least depth around each pixel, metres; 0 where some pixel there has none.
    owner : (h, w) int32
        The thing of the map that each pixel shows, counted from 1.
    """

    view: str
    camera: Camera
    nearest: NDArray[np.float32]
    owner: NDArray[np.int32]
    margin: float
    instances: NDArray[np.integer]

    @classmethod
    def of(cls, frame: Frame, view: str, noise: float) -> Backdrop:
        """Return the backdrop of a frame, of which no pixel is claimed yet."""
        from scipy.ndimage import minimum_filter

        depth = np.nan_to_num(frame.depth).astype(np.float32)
        nearest = minimum_filter(depth, 3, mode="nearest")
        owner = np.zeros(depth.shape, dtype=np.int32)
        return cls(view, frame.camera, nearest, owner, max(BEHIND * noise, LEAST), frame.instances)

    def claim(self, number: int, thing: int) -> None:
        """Say which thing of the map an instance of the image is."""
        self.owner[self.instances == number] = thing

    def looks_through(self, points: Array, thing: int) -> Mask:
        """Return which points of a thing are not there, (n,)."""
        camera = self.camera
        own = (points - camera.position) @ camera.camera2world[:3, :3]
        ahead = own[:, 2] > 0.1
        depth = np.where(ahead, own[:, 2], 1.0)
        u = np.rint(camera.fx * own[:, 0] / depth + camera.cx)
        v = np.rint(camera.fy * own[:, 1] / depth + camera.cy)
        inside = ahead & (u >= 1) & (u < camera.width - 1) & (v >= 1) & (v < camera.height - 1)
        result = np.zeros(len(points), dtype=np.bool_)
        at = np.flatnonzero(inside)
        column, row = u[at].astype(np.int64), v[at].astype(np.int64)
        behind = self.nearest[row, column] > depth[at] + self.margin
        at, row, column = at[behind], row[behind], column[behind]
        mine = np.zeros(len(at), dtype=np.bool_)
        for down in (-1, 0, 1):
            for right in (-1, 0, 1):
                mine |= self.owner[row + down, column + right] == thing
        result[at[~mine]] = True
        return result if np.count_nonzero(result) <= DOUBT * len(points) else np.zeros_like(result)
