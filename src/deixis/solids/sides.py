"""Sides: the horizontal halfspaces of a view or of the world, where things are more than their box."""

from __future__ import annotations

import numpy as np

from deixis import measures
from deixis.boxes import Boxes
from deixis.facts import Facts
from deixis.frames import Array, Index, Mask
from deixis.scene import Scene
from deixis.solids.profiles import Profile
from deixis.solids.solid import Pose, Solid, Solids
from deixis.solids.sweeps import Placed, State, beyond, ends, level_profile, lies_in, state_of
from deixis.thresholds import SNAP_DECIMALS, Thresholds


def meet_regions(
    scene: Scene, framed: Boxes, facts: Facts, rows: Index, relaxed: Array, strict: Array
) -> None:
    """Measure those horizontal halfspaces again in which a thing is more than its box.

    Parameters
    ----------
    scene : Scene
    framed : Boxes
        The contextualised boxes of the references.
    facts : Facts
    rows : (q,) int
        Rows of the facts.
    relaxed, strict : (q, 4) float
        Margins along X+, X-, Y+, Y- of the boxes, metres; changed in place.
    """
    things, boxes, limits = Solids.of(scene, facts.region), scene.boxes, facts.thresholds
    more = things.more
    figure, reference = facts.figure[rows], facts.reference[rows]
    todo = np.flatnonzero(more[figure] | more[reference])
    if not len(todo):
        return
    figure, reference = figure[todo], reference[todo]
    a, b = boxes.take(figure), framed.take(reference)
    there = measures.place(a, b)
    around = _around(boxes, framed, more)
    bounds = _bounds(there, a, b, around[reference], limits)
    relaxed[todo], strict[todo] = bounds, bounds
    open_rows = np.flatnonzero((bounds >= 0.0).any(axis=1))
    if not len(open_rows):
        return
    shifts = np.stack([there.x, there.y, there.z], axis=1)
    order = open_rows[np.argsort(reference[open_rows], kind="stable")]
    _, starts = np.unique(reference[order], return_index=True)
    for group in np.split(order, starts[1:]):
        j = int(reference[group[0]])
        seen = _Seen(things[j], boxes, framed, j, limits)
        for k in group.tolist():
            pose = Pose(float(there.cos[k]), float(there.sin[k]), shifts[k])
            row = todo[k]
            state = state_of(float(facts.separation[rows[row]]), limits)
            relaxed[row], strict[row] = seen.margins(things[int(figure[k])], pose, state, bounds[k])


def _around(boxes: Boxes, framed: Boxes, more: Mask) -> Array:
    """Return half extents of the references along the axes of their frames, metres, (n, 3).

    A box turns with its frame (axiom 12); what is more than its box stays as it lies.
    """
    half = framed.half.copy()
    along_x, along_y = measures.extent(measures.place(boxes, framed), boxes.half)
    half[more, 0], half[more, 1] = along_x[more], along_y[more]
    return half


def _bounds(there: measures.Placement, a: Boxes, b: Boxes, around: Array, limits: Thresholds) -> Array:
    """Return what the margins along X+, X-, Y+, Y- are at most, from boxes that hold the things, (q, 4)."""
    d = limits.granularity
    thick_a, thick_b = a.effective_half(d), np.maximum(around, 0.5 * d)
    reach = measures.extent(there, thick_a)
    center = there.x, there.y
    slack_z = thick_a[:, 2] + thick_b[:, 2] - 0.5 * d - np.abs(there.z)
    result = np.empty((len(there.x), 4))
    for axis in (0, 1):
        across = 1 - axis
        slack = thick_b[:, across] + reach[across] - 0.5 * d - np.abs(center[across])
        depth = np.where(b.normal == axis, np.inf, 2.0 * limits.halfspace_scale * thick_b[:, axis])
        for column, middle in enumerate((center[axis], -center[axis])):
            beyond = middle + reach[axis] + thick_b[:, axis]
            ends = thick_b[:, axis] + depth - (middle - reach[axis])
            result[:, 2 * axis + column] = np.minimum(np.minimum(slack, slack_z), np.minimum(beyond, ends))
    return result


class _Seen:
    """A reference in the frame of a view, to be swept along its axes."""

    def __init__(self, solid: Solid, boxes: Boxes, framed: Boxes, position: int, limits: Thresholds) -> None:
        angle = float(boxes.yaw[position] - framed.yaw[position])
        self.solid, self.limits, self.half = solid, limits, framed.half[position]
        self.turn = Pose(float(np.cos(angle)), float(np.sin(angle)), np.zeros(3))
        self.normal = int(framed.normal[position])
        self.profiles: dict[int, Profile] = {}
        if solid.model == "box":
            self.low, self.high = -self.half, self.half
        else:
            corners = self.turn.place(solid.hull.corners)
            self.low, self.high = corners.min(axis=0), corners.max(axis=0)

    def margins(self, figure: Solid, pose: Pose, state: State, bound: Array) -> tuple[Array, Array]:
        """Return the relaxed and strict margins of a figure along X+, X-, Y+, Y-, each (4,), metres.

        Parameters
        ----------
        figure : Solid
        pose : Pose
            Of the figure in the frame.
        state : State
        bound : (4,) float
            What they are at most; where that is negative nothing more is measured.
        """
        relaxed, strict = bound.copy(), bound.copy()
        limits, seen = self.limits, Placed(figure, pose)
        d = limits.granularity
        thick = np.maximum(self.high - self.low, d) + np.maximum(seen.high - seen.low, d)
        slack = 0.5 * (thick - d - np.abs(seen.high + seen.low - self.high - self.low))
        for axis in (0, 1):
            sides = slice(2 * axis, 2 * axis + 2)
            if bound[sides].max() < 0.0:
                continue
            if axis not in self.profiles:
                self.profiles[axis] = level_profile(self.solid, self.turn, self.half, self.normal, axis)
            profile, axes = self.profiles[axis], (1 - axis, 2, axis)
            span = float(seen.low[axis]), float(seen.high[axis])
            faces = float(self.low[axis]), float(self.high[axis])
            depth = limits.halfspace_scale * max(faces[1] - faces[0], d)
            depth = np.inf if self.normal == axis else depth
            found = np.minimum(beyond(profile, seen, axes, state, faces, limits), ends(span, faces, depth))
            found = np.minimum(found, min(float(slack[1 - axis]), float(slack[2])))
            relaxed[sides] = strict[sides] = found
            if found.max() >= 0.0:
                within = lies_in(profile, seen, axes, state, (self.low, self.high), depth, limits)
                strict[sides] = np.minimum(found, within)
        return np.round(relaxed, SNAP_DECIMALS) + 0.0, np.round(strict, SNAP_DECIMALS) + 0.0
