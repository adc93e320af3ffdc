"""Frames of reference: angles about the vertical axis, bearings, and the contextualised frame.

All frames share the direction of Z (up), so a frame is an origin and a yaw. Angles are radians, counted
counter-clockwise seen from above; the world frame F_g is right-handed with Z up, in metres.

=========  ==========================  ==========================================
paper      here                        what it is
=========  ==========================  ==========================================
F_g        ``world``                   the global frame
F_r        a view's pose               the robot (or any onlooker)
F_r'       ``bearing``                 F_r turned to face a reference's centroid
F_o        ``yaw`` of a box            the object's own frame
F_c        ``contextualise``           F_o's origin with the axes of F_r' (axiom 12)
=========  ==========================  ==========================================
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
Index = NDArray[np.int64]

QUARTER: Final = np.pi / 2.0

TIE: Final = 1.0e-7
"""Two turns closer than this, radians, are equally small: the choice between them is marked ambiguous."""

AXES: Final = ("X+", "X-", "Y+", "Y-", "Z+", "Z-")
"""The six semi-axes in the order of every array; in F_c: behind, in front, left, right, above, below."""

HORIZONTAL: Final = AXES[:4]

WORLD: Final = "world"
"""The view atom under which the cardinal relations (axioms 21-25) and the vertical ones are stated."""


def wrap_angle(angle: Array) -> Array:
    """Return angles in [-pi, pi), radians.

    >>> wrap_angle(np.array([0.0, 3.5 * np.pi]))
    array([ 0.        , -1.57079633])
    """
    return np.asarray((angle + np.pi) % (2.0 * np.pi) - np.pi, dtype=np.float64)


def bearing(origin: Array, targets: Array) -> Array:
    """Return the yaw of F_r': the direction in which a view sees each target.

    Parameters
    ----------
    origin : (3,) float
        Position of the view, metres, world frame.
    targets : (n, 3) float
        Centroids, metres, world frame.

    Returns
    -------
    (n,) float
        Radians. A target straight above or below has the bearing 0, which callers must not use.

    Examples
    --------
    >>> bearing(np.zeros(3), np.array([[0.0, 2.0, 1.0]])).round(4)
    array([1.5708])
    """
    return np.asarray(np.arctan2(targets[:, 1] - origin[1], targets[:, 0] - origin[0]), dtype=np.float64)


def quarter_turns(yaw: Array, target: Array) -> tuple[NDArray[np.int64], Array]:
    """Return k and theta such that ``yaw + theta == target - k * pi/2`` with the least |theta| (axiom 12).

    The printed axiom asks for the minimal theta; read as minimal |theta| <= pi/4 (decision 0003).

    Parameters
    ----------
    yaw, target : (n,) float
        Radians: the box's own yaw and the yaw to align it with.

    Returns
    -------
    k : (n,) int
        Quarter turns from the aligned box's X axis to the target's X axis.
    theta : (n,) float
        Radians, in [-pi/4, pi/4].

    Examples
    --------
    >>> k, theta = quarter_turns(np.array([0.1]), np.array([np.pi / 2]))
    >>> int(k[0]), round(float(theta[0]), 6)
    (1, -0.1)
    """
    difference = target - yaw
    k = np.rint(difference / QUARTER)
    return k.astype(np.int64), difference - k * QUARTER
