"""The narrow phase: what was measured of boxes is measured again of hulls and meshes (decision 0017).

Only pairs in which a thing is more than its box are looked at, and of their halfspaces only those that the
boxes do not rule out. The columns stay what they are; only how they are measured changes.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from deixis import measures
from deixis.boxes import Boxes
from deixis.broadphase import reach
from deixis.facts import PairColumns, RegionModel
from deixis.frames import Array, Index, Mask
from deixis.scene import Scene
from deixis.solids.cavity import dip, is_hollow, matter_depth
from deixis.solids.contact import STEEP, Separation, protrusion, separate
from deixis.solids.solid import Pose, Solid, Solids
from deixis.solids.sweeps import (
    Axes,
    Placed,
    Span,
    beyond,
    clear_of,
    ends,
    lies_in,
    standing_profile,
    state_of,
)
from deixis.thresholds import SNAP_DECIMALS, Thresholds

_UPRIGHT: Final[Axes] = (0, 1, 2)

_LATTICE: Final = 10
"""Points along each side of the box in which a common volume is counted."""


@dataclass(frozen=True, slots=True)
class _Measures:
    """What was measured of u pairs a, b, each in both orders.

    ``normal`` points from b to a, in the world. Of two columns the first has a for its figure. ``vertical``
    holds margins of a above b, a below b, b above a and b below a, not a number where the contact is on
    another side; ``strict`` holds those of a lying wholly in the sweep of b, up and down.
    """

    separation: Array
    normal: Array
    shared: Array
    protrusion: Array
    frontier: Array
    vertical: Array
    strict: Array

    @classmethod
    def empty(cls, u: int) -> _Measures:
        return cls(
            np.empty(u), np.empty((u, 3)), np.zeros(u), np.empty((u, 2)), np.zeros((u, 2)), np.empty((u, 4)),
            np.empty((u, 2)),
        )  # fmt: skip


@dataclass(frozen=True, slots=True)
class _Lie:
    """How two solids a, b lie: separation, direction from b to a in b's frame, and whose hollow counts.

    ``hulls`` is the separation of their convex hulls, where only the sign and small values count.
    """

    separation: float
    normal: Array
    hollow: str
    hulls: float


def measure_regions(scene: Scene, pairs: PairColumns, region: RegionModel) -> PairColumns:
    """Return the pairs with those measured again in which a thing is more than its box.

    Parameters
    ----------
    scene : Scene
    pairs : PairColumns
        Of the scene's boxes; changed in place. Those that turn out to be beyond reach are left out.
    region : RegionModel
    """
    things, boxes, limits = Solids.of(scene, region), scene.boxes, scene.thresholds
    more = things.more
    rows = np.flatnonzero(more[pairs.figure] | more[pairs.reference])
    if not len(rows):
        return pairs
    n = len(boxes)
    figure, reference = pairs.figure[rows].astype(np.int64), pairs.reference[rows].astype(np.int64)
    keys, place = np.unique(
        np.minimum(figure, reference) * n + np.maximum(figure, reference), return_inverse=True
    )
    # Both orders of a pair are measured at once, the thing with the larger plan view as b.
    one, other = keys // n, keys % n
    plan = np.prod(boxes.half[:, :2], axis=1)
    swap = plan[one] > plan[other]
    a, b = np.where(swap, other, one), np.where(swap, one, other)
    lateral = _lateral(boxes, a, b, limits)
    # How far apart they may be and still be spoken of, one way or the other.
    far = np.full(len(keys), limits.closeness)
    np.maximum.at(far, place, np.where(pairs.ordered[rows], reach(boxes, limits)[reference], 0.0))
    found = _measured(things, boxes, a, b, lateral, far, limits)
    _fill(pairs, rows, found, place, figure == a[place], lateral - 0.5 * limits.granularity, limits)
    apart = pairs.separation
    near = pairs.ordered & (apart <= reach(boxes, limits)[pairs.reference])
    keep = (apart <= limits.closeness) | near
    return pairs if keep.all() else pairs.at(np.flatnonzero(keep))


def _lateral(boxes: Boxes, a: Index, b: Index, limits: Thresholds) -> Array:
    """Return by how much the plan views of boxes overlap, metres."""
    figures, references = boxes.take(a), boxes.take(b)
    there = measures.place(figures, references)
    d = limits.granularity
    overlaps = measures.plan_overlaps(there, figures.effective_half(d), references.effective_half(d))
    return np.asarray(overlaps.min(axis=0))


def _measured(
    things: Solids, boxes: Boxes, a: Index, b: Index, lateral: Array, far: Array, limits: Thresholds
) -> _Measures:
    """Measure pairs one by one."""
    found = _Measures.empty(len(a))
    there = measures.place(boxes.take(a), boxes.take(b))
    shifts = np.stack([there.x, there.y, there.z], axis=1)
    depth = 2.0 * limits.halfspace_scale * boxes.effective_half(limits.granularity)[:, 2]
    depth = np.where(boxes.normal == 2, np.inf, depth)
    for k, (i, j) in enumerate(zip(a.tolist(), b.tolist(), strict=True)):
        one, other = things[i], things[j]
        pose = Pose(float(there.cos[k]), float(there.sin[k]), shifts[k])
        # Beyond T nothing is decided by the distance: that of the hulls will do (decision 0017).
        apart = separate(one, other, pose, limits, limits.closeness)
        lie = _lie(one, other, pose, apart, limits)
        found.separation[k], found.normal[k] = lie.separation, lie.normal
        if apart.hulls > far[k]:
            # Out of reach: nothing more will be asked of it.
            found.protrusion[k], found.vertical[k], found.strict[k] = np.nan, np.nan, np.nan
            continue
        if apart.hulls > 0.0:
            found.protrusion[k] = np.nan
        else:
            found.protrusion[k] = protrusion(one, other, pose), protrusion(other, one, pose.back)
        if lie.separation < -limits.penetration:
            found.shared[k], found.frontier[k] = _common(one, other, pose, lie.hollow, limits)
        if lateral[k] >= 0.5 * limits.granularity:
            spans = float(depth[j]), float(depth[i])
            found.vertical[k], found.strict[k] = _vertical(
                one, other, pose, lie, float(lateral[k]), spans, limits
            )
    # From b's frames to the world's.
    x, y = found.normal[:, 0].copy(), found.normal[:, 1].copy()
    found.normal[:, 0] = boxes.cos[b] * x - boxes.sin[b] * y
    found.normal[:, 1] = boxes.sin[b] * x + boxes.cos[b] * y
    return found


def _lie(a: Solid, b: Solid, pose: Pose, apart: Separation, limits: Thresholds) -> _Lie:
    """Return how two solids lie once the hollows of either are considered."""
    separation, normal, hollow = apart.distance, apart.normal, ""
    if apart.hulls > limits.granularity or (a.convex and b.convex):
        return _Lie(separation, normal, hollow, apart.hulls)
    for name, sign, content, container, there in (("b", 1.0, a, b, pose), ("a", -1.0, b, a, pose.back)):
        if container.convex:
            # All its hull is matter, so only what is well within it needs a way out.
            if apart.hulls >= -limits.granularity:
                continue
        elif not is_hollow(container):
            continue
        depth, up = dip(content, container, there, limits)
        # What is at the brim rests on it as on a lid; at a side it has the matter there to touch.
        if depth > limits.penetration or (up and depth >= -limits.granularity):
            normal = np.array([0.0, 0.0, sign])
            if -depth < separation:
                separation, hollow = -depth, "" if container.convex else name
    return _Lie(separation, normal, hollow, apart.hulls)


def _vertical(
    a: Solid, b: Solid, pose: Pose, lie: _Lie, lateral: float, depths: Span, limits: Thresholds
) -> tuple[Array, Span]:
    """Return the margins of a above b, a below b, b above a, b below a, and of a wholly above and below b."""
    state = state_of(lie.separation, limits)
    span_b = float(b.hull.low[2]), float(b.hull.high[2])
    span_a = float(pose.shift[2] + a.hull.low[2]), float(pose.shift[2] + a.hull.high[2])
    figure, profile = Placed(a, pose), standing_profile(b)
    if state == "contact":
        # The side of the contact is the side of the figure (decision 0004).
        holds = max(min(lateral, limits.penetration) + lie.separation, 0.0)
        steep = float(lie.normal[2])
        margins = np.where(np.array([steep, -steep, -steep, steep]) >= STEEP, holds, np.nan)
        if abs(steep) < STEEP and lie.hulls < -0.5 * limits.granularity:
            # What touches at a side that does not part the two, may be under the other for all that: a chair
            # pushed to a table. Not above it: it would be on top of what it only touches aside.
            over, under = clear_of(profile, figure, _UPRIGHT, limits)
            margins[1], margins[3] = under, over
    elif state == "deep":
        # What lies in a hollow is in it, and not above or below.
        out = span_a[1] - span_b[1], span_b[0] - span_a[0]
        margins = np.array([*out, *(-one for one in out)]) - limits.granularity
        margins[{"": [], "b": [0, 1], "a": [2, 3]}[lie.hollow]] = lie.separation
    else:
        above, below = beyond(profile, figure, _UPRIGHT, state, span_b, limits)
        margins = np.array([above, below, below, above])
    margins = np.minimum(margins, [*ends(span_a, span_b, depths[0]), *ends(span_b, span_a, depths[1])])
    if not (margins[:2] >= 0.0).any():
        return margins, (float(margins[0]), float(margins[1]))
    strict = lies_in(profile, figure, _UPRIGHT, state, (b.hull.low, b.hull.high), depths[0], limits)
    return margins, (min(strict[0], float(margins[0])), min(strict[1], float(margins[1])))


def _common(a: Solid, b: Solid, pose: Pose, hollow: str, limits: Thresholds) -> tuple[float, Array]:
    """Return the volume that overlapping solids share, and how much of either is adjacent to it.

    Where one lies in the hollow of the other it counts as in its hull. The volume is counted on a lattice.
    """
    depth_a = a.hull.depth if hollow else lambda points: matter_depth(a, points)
    depth_b = b.hull.depth if hollow else lambda points: matter_depth(b, points)
    corners = pose.place(a.hull.corners)
    low = np.maximum(corners.min(axis=0), b.hull.low)
    high = np.minimum(corners.max(axis=0), b.hull.high)
    steps = (np.arange(_LATTICE) + 0.5) / _LATTICE
    lattice = np.stack(np.meshgrid(steps, steps, steps), axis=-1).reshape(-1, 3) * (high - low) + low
    lattice = lattice.astype(np.float32)
    within = (depth_a(pose.back.place(lattice)) > 0.0) & (depth_b(lattice) > 0.0)
    shared = float(within.mean() * np.prod(np.maximum(high - low, 0.0)))
    half = 0.5 * limits.granularity
    adjacent = []
    for one, other, there, depth, own in (
        (b, a, pose.back, depth_a, hollow == "b"),
        (a, b, pose, depth_b, hollow == "a"),
    ):
        probes = (one.hull_probes if own else one.probes).within(*there.back.around(other.hull, 0.0))
        inside = depth(there.place(probes.points)) >= half
        adjacent.append(float(probes.area[inside].sum()))
    return shared, limits.granularity * np.array(adjacent)


def _fill(
    pairs: PairColumns,
    rows: Index,
    found: _Measures,
    place: Index,
    forward: Mask,
    slack: Array,
    limits: Thresholds,
) -> None:
    """Write what was measured of pairs into the rows of both their orders."""
    separation = np.round(found.separation, SNAP_DECIMALS) + 0.0
    slack = slack[place]
    pairs.separation[rows] = separation[place]
    pairs.normal[rows] = np.where(forward[:, None], 1.0, -1.0) * found.normal[place]
    pairs.intersection[rows] = np.round(found.shared[place], 12)
    side = np.where(forward, 0, 1)
    pairs.frontier[rows] = np.round(found.frontier[place, side], 12)
    out = found.protrusion[place, side]
    # Hulls that are apart: a box may still lie in the other's.
    out = np.where(np.isnan(out), np.maximum(pairs.protrusion[rows], separation[place]), out)
    pairs.protrusion[rows] = np.round(out, SNAP_DECIMALS) + 0.0
    looked = slack >= 0.0
    rows, place, forward, slack = rows[looked], place[looked], forward[looked], slack[looked, None]
    margins = np.where(forward[:, None], found.vertical[place, :2], found.vertical[place, 2:])
    elsewhere = np.minimum(pairs.vertical[rows], -0.5 * limits.granularity)
    margins = np.minimum(np.where(np.isnan(margins), elsewhere, margins), slack)
    strict = np.where(forward[:, None], found.strict[place], pairs.vertical_strict[rows])
    strict = np.fmin(strict, margins)
    pairs.vertical[rows] = np.round(margins, SNAP_DECIMALS) + 0.0
    pairs.vertical_strict[rows] = np.round(strict, SNAP_DECIMALS) + 0.0
