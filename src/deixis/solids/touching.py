"""Touching: the points of hulls and meshes between which their separation was measured."""

from __future__ import annotations

from itertools import product
from typing import Final

import numpy as np

from deixis import measures
from deixis.facts import Facts
from deixis.frames import Array, Index
from deixis.scene import Scene
from deixis.solids.contact import nearest
from deixis.solids.solid import Pose, Solid, Solids

_LIFT: Final = 1.0e-3
"""Metres by which solids that touch are parted, to ask where they are nearest."""

_GOOD: Final = 1.0e-6
"""Metres: nearest points that differ by less from what was measured are right."""


def touching_points(scene: Scene, facts: Facts, rows: Index) -> Array:
    """Return the figure's point and the reference's for rows of the facts, (k, 2, 3), metres, world frame.

    From the second to the first it is the separation along its normal, as the facts have them. The figure's
    point is on its surface: nearest to the reference where they are apart, else where it would touch last
    if it were moved out along the normal.
    """
    things, boxes = Solids.of(scene, facts.region), scene.boxes
    figure, reference = facts.figure[rows].astype(np.int64), facts.reference[rows].astype(np.int64)
    a, b = boxes.take(figure), boxes.take(reference)
    there = measures.place(a, b)
    shifts = np.stack([there.x, there.y, there.z], axis=1)
    normal = facts.normal[rows].astype(np.float64)
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    separation = facts.separation[rows]
    found = np.empty((len(rows), 3))
    for k, (i, j) in enumerate(zip(figure.tolist(), reference.tolist(), strict=True)):
        turn = Pose(float(b.cos[k]), float(b.sin[k]), b.center[k])
        pose = Pose(float(there.cos[k]), float(there.sin[k]), shifts[k])
        local = Pose(turn.cos, -turn.sin, np.zeros(3)).place(normal[k][None])[0]
        point = _point(things[i], things[j], pose, float(separation[k]), local, facts.thresholds.closeness)
        found[k] = turn.place(point[None])[0]
    return np.stack([found, found - separation[:, None] * normal], axis=1)


def _point(a: Solid, b: Solid, pose: Pose, separation: float, normal: Array, far: float) -> Array:
    """Return the point of a that decides its separation from b, in b's frame."""
    # Beyond T what was measured are the hulls (decision 0017).
    hulls = separation > far
    away = np.zeros(3) if separation > _LIFT else (_LIFT - separation) * normal
    parted = Pose(pose.cos, pose.sin, pose.shift + away)
    wanted = separation * normal + away
    best, misfit, met = np.zeros(3), np.inf, False
    # FCL's points are not always as good as its distances: those are taken that say what was measured.
    for of_hulls, turned in product((hulls, True), (False, True)):
        if turned:
            distance, at_b, at_a = nearest(b, a, parted.back, hulls=of_hulls)
            at_a, at_b = parted.place(np.stack([at_a, at_b]))
        else:
            distance, at_a, at_b = nearest(a, b, parted, hulls=of_hulls)
        error = float(np.linalg.norm(at_a - at_b - wanted))
        if distance > 0.0 and error < misfit:
            best, misfit, met = at_a, error, True
        if misfit < _GOOD:
            break
    if met:
        return np.asarray(best - away)
    # The depth of meshes is an estimate from below: moved out by it, they may still meet.
    corners = pose.place(a.hull.corners)
    return np.asarray(corners[(corners @ normal).argmin()])
