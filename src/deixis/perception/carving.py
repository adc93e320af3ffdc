"""Carving: points that another frame looks through are not there.

Noise moves a point along the ray it was measured on, which from the side is sideways. So where a frame sees,
around the place a point of a thing would have in it, nothing of the thing and everything further away, the
point is noise. Where the frame sees something nearer, or nothing, it says nothing.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
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
    depth : (h, w) float
        Metres; 0 or NaN where there is none.
    margin : float
        Metres by which what is seen must lie behind a point.
    instances : (h, w) int
        Which thing of the frame each pixel shows.
    things : dict of int to int
        Which thing of the map each of those is, counted from 1.
    """

    view: str
    camera: Camera
    depth: Array
    margin: float
    instances: NDArray[np.integer]
    things: dict[int, int]

    @classmethod
    def of(cls, frame: Frame, view: str, noise: float, things: dict[int, int]) -> Backdrop:
        """Return the backdrop of a frame, with the things of the map that it shows."""
        return cls(view, frame.camera, frame.depth, max(BEHIND * noise, LEAST), frame.instances, things)

    @cached_property
    def nearest(self) -> NDArray[np.float32]:
        """Return the least depth around each pixel, metres; 0 where some pixel there has none."""
        from scipy.ndimage import minimum_filter

        depth = np.nan_to_num(self.depth).astype(np.float32)
        return np.asarray(minimum_filter(depth, 3, mode="nearest"))

    def looks_through(self, points: Array, thing: int) -> Mask:
        """Return which points of a thing are not there, (n,)."""
        camera = self.camera
        x, y, z = ((points - camera.position) @ camera.camera2world[:3, :3]).T
        ahead = z > 0.1
        depth = np.where(ahead, z, 1.0)
        u = np.rint(camera.fx * x / depth + camera.cx)
        v = np.rint(camera.fy * y / depth + camera.cy)
        inside = ahead & (u >= 1) & (u < camera.width - 1) & (v >= 1) & (v < camera.height - 1)
        result = np.zeros(len(points), dtype=np.bool_)
        at = np.flatnonzero(inside)
        column, row = u[at].astype(np.int64), v[at].astype(np.int64)
        behind = self.nearest[row, column] > depth[at] + self.margin
        at, row, column = at[behind], row[behind], column[behind]
        own = [number for number, owner in self.things.items() if owner == thing]
        mine = np.zeros(len(at), dtype=np.bool_)
        for down in (-1, 0, 1):
            for right in (-1, 0, 1):
                mine |= np.isin(self.instances[row + down, column + right], own)
        result[at[~mine]] = True
        return result if np.count_nonzero(result) <= DOUBT * len(points) else np.zeros_like(result)
