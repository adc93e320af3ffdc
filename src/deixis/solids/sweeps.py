"""Sweeps: halfspaces of solids (axioms 20-34), made as the paper makes them, by sweeping the region itself.

A figure meets the sweep of a reference along an axis iff some matter of the figure lies beyond matter of the
reference in the same cell of the cross-section. What is in contact, or overlaps, is judged as boxes are
(decisions 0001, 0004, 0009). Margins are metres; their sign is the answer, their size an estimate.
"""

from __future__ import annotations

from functools import cached_property
from typing import Any, Final, Literal
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from deixis.frames import Array
from deixis.solids.profiles import BoxProfile, CellProfile, OutlineProfile, Profile, cell_width
from deixis.solids.sampling import Single
from deixis.solids.solid import Pose, Solid
from deixis.thresholds import Thresholds

Axes = tuple[int, int, int]
"""The two axes across, and the one along which things are swept."""

Span = tuple[float, float]

State = Literal["apart", "contact", "deep"]
"""How two things lie: further apart than D, in contact, or overlapping by more than contact."""

_BESIDE: Final = 1.0e-3
"""Metres: what is in no cell of the other's is at least so far from being in one."""

_KEPT: Final = 8
"""Level profiles kept for one solid: of the world's axes, and of the latest views of it."""

_LEVEL: WeakKeyDictionary[Solid, dict[tuple[float, float, int], Profile]] = WeakKeyDictionary()
_STANDING: WeakKeyDictionary[Solid, Profile] = WeakKeyDictionary()


def state_of(separation: float, limits: Thresholds) -> State:
    """Return how two things with a signed separation lie."""
    if separation < -limits.penetration:
        return "deep"
    return "contact" if separation <= limits.granularity else "apart"


def standing_profile(solid: Solid) -> Profile:
    """Return the profile of a solid along Z, in its own frame."""
    found = _STANDING.get(solid)
    if found is None:
        if solid.model == "box":
            found = BoxProfile(float(solid.half[0]), float(solid.half[1]), float(solid.half[2]))
        elif solid.normal == 2 and solid.outline is not None:
            found = OutlineProfile(solid.outline, float(solid.half[2]))
        else:
            x, y, z = solid.samples.points.T
            found = CellProfile.of(x, y, z, cell_width(solid))
        _STANDING[solid] = found
    return found


def level_profile(solid: Solid, turn: Pose, half: Array, normal: int, axis: int) -> Profile:
    """Return the profile of a solid along X or Y of a frame that it is turned in.

    Parameters
    ----------
    solid : Solid
    turn : Pose
        From its own frame to the other; the origin stays.
    half : (3,) float
        Half extents of its contextualised box, metres: what is measured as its box turns as that does.
    normal : int
        Of a surface, the axis of the normal in the frame.
    axis : int
        0 or 1.
    """
    if solid.model == "box":
        return BoxProfile(float(half[1 - axis]), float(half[2]), float(half[axis]))
    if solid.outline is not None and axis == normal:
        return OutlineProfile(_turned(solid, turn, axis), float(half[axis]))
    kept = _LEVEL.setdefault(solid, {})
    key = (turn.cos, turn.sin, axis)
    if key not in kept:
        if len(kept) >= _KEPT:
            del kept[next(iter(kept))]
        points = turn.place(solid.samples.points)
        kept[key] = CellProfile.of(points[:, 1 - axis], points[:, 2], points[:, axis], cell_width(solid))
    return kept[key]


def _turned(solid: Solid, turn: Pose, axis: int) -> Any:
    """Return the outline of an upright surface, in the other level axis of the frame and Z."""
    import shapely

    def plan(border: Array) -> Array:
        corners = np.zeros((len(border), 3))
        corners[:, 1 - solid.normal], corners[:, 2] = border.T
        return np.asarray(turn.place(corners)[:, [1 - axis, 2]])

    turned = shapely.transform(solid.outline, plan)
    shapely.prepare(turned)
    return turned


class Placed:
    """A figure's points in the frame of a reference, each set placed when it is first asked for."""

    def __init__(self, figure: Solid, pose: Pose) -> None:
        self._figure, self._pose = figure, pose
        self.low, self.high = pose.around(figure.hull, 0.0)

    @property
    def area(self) -> Single:
        """Return the area that each of the probes stands for, square metres, (q,)."""
        return self._figure.probes.area

    @cached_property
    def scouts(self) -> Single:
        """Return few points, (3, q)."""
        return self._pose.place(self._figure.scouts.points).T

    @cached_property
    def probes(self) -> Single:
        """Return points all over the surface, (3, q)."""
        return self._pose.place(self._figure.probes.points).T


def beyond(
    profile: Profile, figure: Placed, axes: Axes, state: State, faces: Span, limits: Thresholds
) -> Span:
    """Return by how much some of a figure lies beyond a reference, along an axis and against it.

    Parameters
    ----------
    profile : Profile
        Of the reference, along the axis.
    figure : Placed
    axes : (int, int, int)
    state : State
        Of the two.
    faces : (float, float)
        Where the reference begins and ends along the axis, metres: what overlaps it is beyond it only where
        it reaches beyond its face.
    limits : Thresholds

    Returns
    -------
    plus, minus : float
        Metres, towards greater and smaller coordinates; how far they are aside where no cell is shared.
    """
    along = axes[2]
    # What of the figure begins before all of the reference is beyond none of it.
    most = float(figure.high[along]) - faces[0], faces[1] - float(figure.low[along])
    if max(most) < 0.0:
        return most
    if state == "apart":
        found = _beyond(profile, figure.scouts, axes, most, limits)
        if all(one >= 0.0 or at_most < 0.0 for one, at_most in zip(found, most, strict=True)):
            return found
        return _beyond(profile, figure.probes, axes, most, limits)
    u, v, w = (figure.probes[axis] for axis in axes)
    first, last = profile.at(u, v)
    met = first <= last
    if not met.any():
        return _aside(profile, u, v)
    first, last, w = first[met], last[met], w[met]
    if state == "deep":
        plus, minus = float(w.max()) - faces[1], faces[0] - float(w.min())
        return plus - limits.granularity, minus - limits.granularity
    first, last, near, far = _cells(profile.cell_of(u[met], v[met]), first, last, w)
    return _flush(near, far, first, last, limits), _flush(-far, -near, -last, -first, limits)


def ends(figure: Span, reference: Span, depth: float) -> Span:
    """Return by how much a figure begins before a sweep ends, towards greater and smaller w, metres."""
    return depth - (figure[0] - reference[1]), depth - (reference[0] - figure[1])


def _aside(profile: Profile, u: Single, v: Single) -> Span:
    """Return how far places are from the cells of a profile, as two equal margins."""
    beside = -max(float(profile.aside(u, v).min()), _BESIDE)
    return beside, beside


def _beyond(profile: Profile, points: Single, axes: Axes, most: Span, limits: Thresholds) -> Span:
    """Return by how much points of a figure that is apart lie beyond matter of the reference."""
    u, v, w = (points[axis] for axis in axes)
    first, last = profile.at(u, v)
    met = first <= last
    if not met.any():
        return _aside(profile, u, v)
    first, last, w = first[met], last[met], w[met]
    results = list(most)
    for side, (begin, end, at) in enumerate(((first, last, w), (-last, -first, -w))):
        if most[side] >= 0.0:
            beyond_all = np.maximum(at - end - limits.granularity, 0.0)
            # Between two layers of the reference it is beyond one of them, by so much at least.
            beyond_one = np.minimum(at - begin, limits.granularity)
            results[side] = float(np.where(at > end, beyond_all, beyond_one).max())
    return results[0], results[1]


def clear_of(profile: Profile, figure: Placed, axes: Axes, limits: Thresholds) -> Span:
    """Return by how much a good part of a figure lies clear of a reference, along an axis and against it.

    A good part is one with a larger surface than four times what contact may be deep, squared: about a
    hand's breadth. Metres; not a number where there is no such part.
    """
    u, v, w = (figure.probes[axis] for axis in axes)
    first, last = profile.at(u, v)
    results = []
    for gap in (w - last, first - w):
        clear = (first <= last) & (gap > limits.granularity)
        good = float(figure.area[clear].sum()) > 4.0 * limits.penetration**2
        results.append(float(gap[clear].max()) - limits.granularity if good else np.nan)
    return results[0], results[1]


def _flush(near: Single, far: Single, first: Single, last: Single, limits: Thresholds) -> float:
    """Return by how much a figure that is in contact lies beyond the reference: cell by cell, as boxes."""
    flush = np.minimum(near - last + limits.granularity, 0.5 * (near + far - first - last))
    return float(np.maximum(flush, far - last - limits.granularity).max())


def _cells(
    cell: NDArray[np.int64], first: Single, last: Single, w: Single
) -> tuple[Single, Single, Single, Single]:
    """Return for each cell where the reference begins and ends in it, and where the figure does."""
    _, one, place = np.unique(cell, return_index=True, return_inverse=True)
    near, far = np.full(len(one), np.inf, dtype=np.float32), np.full(len(one), -np.inf, dtype=np.float32)
    np.minimum.at(near, place, w)
    np.maximum.at(far, place, w)
    return first[one], last[one], near, far


def lies_in(
    profile: Profile,
    figure: Placed,
    axes: Axes,
    state: State,
    reference: tuple[Array, Array],
    depth: float,
    limits: Thresholds,
) -> Span:
    """Return the margins of "all of the figure lies in the sweep", up to D, along an axis and against it.

    Parameters
    ----------
    profile, figure, axes, state, limits
        As for :func:`beyond`.
    reference : ((3,) float, (3,) float)
        The least and the greatest coordinates of the reference, metres.
    depth : float
        How deep the sweep is, metres.
    """
    low, high = reference
    aside = limits.granularity - float(
        max(max(figure.high[axis] - high[axis], low[axis] - figure.low[axis]) for axis in axes[:2])
    )
    if aside < 0.0:
        return aside, aside
    plus, minus = _lying(profile, figure.scouts, axes, state, reference, depth, limits)
    if max(plus, minus) >= 0.0:
        plus, minus = _lying(profile, figure.probes, axes, state, reference, depth, limits)
    return min(plus, aside), min(minus, aside)


def _lying(
    profile: Profile,
    points: Single,
    axes: Axes,
    state: State,
    reference: tuple[Array, Array],
    depth: float,
    limits: Thresholds,
) -> Span:
    """Return the margins of "all these points lie in the sweep", up to D, along an axis and against it."""
    d, (low, high) = limits.granularity, reference
    u, v, w = (points[axis] for axis in axes)
    first, last = profile.at(u, v)
    met = first <= last
    if not met.any():
        return _aside(profile, u, v)
    aside = d - float(profile.aside(u[~met], v[~met]).max(initial=0.0))
    first, last, w = first[met], last[met], w[met]
    if state == "deep":
        first, last = np.full_like(w, low[axes[2]]), np.full_like(w, high[axes[2]])
    results = []
    for start, stop, at in ((first, last, w), (-last, -first, -w)):
        starts = at - (stop - d)
        if state == "apart":
            starts = np.maximum(starts, at - start)
        results.append(float(min(aside, np.minimum(starts, depth + d - (at - stop)).min())))
    return results[0], results[1]
