"""Profiles: what of a solid one sees along an axis, cell by cell: where matter begins and where it ends."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, Final, Protocol

import numpy as np
from numpy.typing import NDArray

from deixis.frames import Array
from deixis.solids.sampling import Single
from deixis.solids.solid import Solid

DIAGONAL: Final = float(np.sqrt(2.0))


class Profile(Protocol):
    """A solid seen along an axis w, in the plane of the two axes u and v across it, metres."""

    def at(self, u: Single, v: Single) -> tuple[Single, Single]:
        """Return the first and last matter along w at places (u, v): inf and -inf where there is none."""

    def cell_of(self, u: Single, v: Single) -> NDArray[np.int64]:
        """Return numbers that are the same for places that the profile does not tell apart."""

    def aside(self, u: Single, v: Single) -> Array:
        """Return how far places are from those where there is matter, metres."""


@dataclass(frozen=True, slots=True)
class BoxProfile:
    """The profile of a box along one of its own axes: half extents along u, v and w, metres."""

    u: float
    v: float
    w: float

    def at(self, u: Single, v: Single) -> tuple[Single, Single]:
        """Return the two faces, within the cross-section."""
        inside = (np.abs(u) <= self.u) & (np.abs(v) <= self.v)
        last = np.where(inside, np.float32(self.w), np.float32(-np.inf))
        return np.where(inside, np.float32(-self.w), np.float32(np.inf)), last

    def cell_of(self, u: Single, v: Single) -> NDArray[np.int64]:  # noqa: ARG002
        """Return zeros: a box is one cell."""
        return np.zeros(len(u), dtype=np.int64)

    def aside(self, u: Single, v: Single) -> Array:
        """Return distances from the cross-section."""
        return np.hypot(np.maximum(np.abs(u) - self.u, 0.0), np.maximum(np.abs(v) - self.v, 0.0))


@dataclass(frozen=True, slots=True)
class OutlineProfile:
    """The profile of a flat polygon along its normal: its border, and half its thickness, metres."""

    border: Any
    w: float

    def at(self, u: Single, v: Single) -> tuple[Single, Single]:
        """Return the two sides, within the border."""
        import shapely

        inside = shapely.intersects_xy(self.border, u, v)
        last = np.where(inside, np.float32(self.w), np.float32(-np.inf))
        return np.where(inside, np.float32(-self.w), np.float32(np.inf)), last

    def cell_of(self, u: Single, v: Single) -> NDArray[np.int64]:  # noqa: ARG002
        """Return zeros: a flat polygon is one cell."""
        return np.zeros(len(u), dtype=np.int64)

    def aside(self, u: Single, v: Single) -> Array:
        """Return distances from the polygon."""
        import shapely

        return np.asarray(shapely.distance(self.border, shapely.points(u, v)), dtype=np.float64)


@dataclass(eq=False)
class CellProfile:
    """The profile of points, in square cells.

    Attributes
    ----------
    low : (float, float)
        The least u and v, metres.
    cell : float
        Width of a cell, metres.
    first, last : (nu + 2, nv + 2) float32
        Where matter begins and ends along w in each cell, metres; the border of cells is empty.
    """

    low: tuple[float, float]
    cell: float
    first: Single
    last: Single

    @classmethod
    def of(cls, u: Single, v: Single, w: Single, cell: float) -> CellProfile:
        """Return the profile of points at (u, v, w), metres.

        >>> one, two = np.float32([0.0, 0.0]), np.float32([1.0, 3.0])
        >>> first, last = CellProfile.of(one, one, two, 0.1).at(np.float32([0, 5]), np.float32([0, 0]))
        >>> first.tolist(), last.tolist()
        ([1.0, inf], [3.0, -inf])
        """
        low = float(u.min()), float(v.min())
        shape = int((u.max() - low[0]) / cell) + 3, int((v.max() - low[1]) / cell) + 3
        first, last = np.full(shape, np.inf, dtype=np.float32), np.full(shape, -np.inf, dtype=np.float32)
        profile = cls(low, cell, first, last)
        at = profile.cell_of(u, v)
        np.minimum.at(first.reshape(-1), at, w)
        np.maximum.at(last.reshape(-1), at, w)
        return profile

    def cell_of(self, u: Single, v: Single) -> NDArray[np.int64]:
        """Return the number of the cell that each place is in; one of the border where it is outside."""
        rows, columns = self.first.shape
        scale = np.float32(1.0 / self.cell)
        # One is added before the fraction is cut off, so that what is just outside stays outside.
        i = ((u - np.float32(self.low[0])) * scale + np.float32(1.0)).astype(np.int32)
        j = ((v - np.float32(self.low[1])) * scale + np.float32(1.0)).astype(np.int32)
        return np.asarray(np.clip(i, 0, rows - 1).astype(np.int64) * columns + np.clip(j, 0, columns - 1))

    def at(self, u: Single, v: Single) -> tuple[Single, Single]:
        """Return the first and last matter in the cells of places."""
        cell = self.cell_of(u, v)
        return self.first.reshape(-1)[cell], self.last.reshape(-1)[cell]

    @cached_property
    def _clear(self) -> Array:
        from scipy.ndimage import distance_transform_edt

        return np.asarray(distance_transform_edt(~np.isfinite(self.first)) * self.cell)

    def aside(self, u: Single, v: Single) -> Array:
        """Return distances from the nearest cell with matter, up to a cell."""
        rows, columns = self.first.shape
        i, j = (u - self.low[0]) / self.cell + 1.0, (v - self.low[1]) / self.cell + 1.0
        near_i, near_j = np.clip(i, 0, rows - 1), np.clip(j, 0, columns - 1)
        beyond = np.hypot(i - near_i, j - near_j) * self.cell
        return np.asarray(beyond + self._clear[near_i.astype(np.int64), near_j.astype(np.int64)])


def cell_width(solid: Solid) -> float:
    """Return how wide a solid's cells are, metres: the diagonal is D, or twice the spacing of the samples."""
    return DIAGONAL * max(0.5 * solid.granularity, solid.samples.spacing)
