"""Contact: how far two solids are apart, or how deep they overlap, and along which direction.

Distances are exact: GJK between convex solids, bounding volume trees between meshes (the FCL library). The
overlap of convex solids is the least translation that parts them. That of meshes is an estimate, and never
more: the depth of the deepest point of either within the matter of the other.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, Final
from weakref import WeakKeyDictionary

import numpy as np

from deixis.cavity import solid_depth
from deixis.errors import MissingDependency
from deixis.frames import Array, Mask
from deixis.solids import Solid

STEEP: Final = float(np.sqrt(0.5))
"""A direction with at least this much of its length along Z is upright rather than level."""

_NEAR: Final = 1.0e-4
"""Metres: what is nearer than this is given the direction of its contact, not that of its nearest points."""

_EXACT: Final = 1.0e-7
"""Metres: a nearest point that is off the surface by less is on it."""


@dataclass(frozen=True, slots=True)
class Pose:
    """Where a solid lies in the frame of another: turned about Z, then shifted, metres."""

    cos: float
    sin: float
    shift: Array

    def place(self, points: Any) -> Any:
        """Return points of the one in the frame of the other."""
        x, y, z = points[:, 0], points[:, 1], points[:, 2]
        c, s, t = self.cos, self.sin, self.shift
        result = np.empty_like(points)
        result[:, 0] = c * x - s * y + t[0]
        result[:, 1] = s * x + c * y + t[1]
        result[:, 2] = z + t[2]
        return result

    def turn(self, vectors: Array) -> Array:
        """Return directions of the one in the frame of the other."""
        turned = vectors.copy()
        turned[..., 0] = self.cos * vectors[..., 0] - self.sin * vectors[..., 1]
        turned[..., 1] = self.sin * vectors[..., 0] + self.cos * vectors[..., 1]
        return turned

    @property
    def back(self) -> Pose:
        """Return where the other lies in the frame of the one."""
        c, s, (x, y, z) = self.cos, self.sin, self.shift
        return Pose(c, -s, np.array([-(c * x + s * y), s * x - c * y, -z]))

    @property
    def matrix(self) -> Array:
        """Return the turn as a matrix, (3, 3)."""
        return np.array([[self.cos, -self.sin, 0.0], [self.sin, self.cos, 0.0], [0.0, 0.0, 1.0]])
