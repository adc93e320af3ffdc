"""Boxes as detectors tell them, turned any way, as regions in the fixed frame."""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np

from deixis.frames import Array
from deixis.regions import BoxRegion, MeshRegion

EXACT: Final = 1.0e-6
"""Radians: a box tilted by less stands upright but for rounding."""

_CORNERS: Final = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
_FACES: Final = np.array(
    [[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1],
     [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]]
)  # fmt: skip
"""Of the corners as they stand in the list, counter-clockwise seen from outside."""


class Turned(NamedTuple):
    """The region of a box, and by how much the box is tilted, radians."""

    region: BoxRegion | MeshRegion
    tilt: float


def turned_box(center: Array, matrix: Array, size: Array, level: float = EXACT) -> Turned:
    """Return the region of a box.

    A box with an upright edge is a box of the scene, whichever of its own axes that is. Any other is the
    mesh of its six faces, tilted as it is: nothing of its turn is left out.

    Parameters
    ----------
    center : (3,) float
        Metres, fixed frame.
    matrix : (3, 3) float
        Its columns are the box's own axes in the fixed frame.
    size : (3,) float
        Full extents along its own axes, metres.
    level : float
        Radians: a box tilted by no more is stood upright.

    Examples
    --------
    >>> lying = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    >>> box = turned_box(np.zeros(3), lying, np.array([1.0, 2.0, 3.0]))
    >>> box.region.size.tolist(), box.region.yaw, box.tilt
    ([3.0, 1.0, 2.0], 0.0, 0.0)
    """
    up = int(np.abs(matrix[2]).argmax())
    tilt = float(np.arctan2(np.hypot(matrix[0, up], matrix[1, up]), abs(matrix[2, up])))
    if tilt > max(level, EXACT):
        return Turned(MeshRegion(center + (_CORNERS * size) @ matrix.T, _FACES), tilt)
    first, second = (up + 1) % 3, (up + 2) % 3
    yaw = float(np.arctan2(matrix[1, first], matrix[0, first]))
    return Turned(BoxRegion(center, size[[first, second, up]], yaw), tilt)
