"""Grounding: from a scene's boxes to Facts. The only place where geometry becomes truth values."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from deixis import halfspaces, measures
from deixis.boxes import Boxes, align_with_world, contextualise
from deixis.facts import Facts, ViewFacts
from deixis.frames import WORLD, Array, Index
from deixis.scene import Scene, View
from deixis.thresholds import SNAP, SNAP_DECIMALS, Thresholds

ORDER_TOLERANCE = 1.0e-6
"""Relative difference of volume below which two things are equally large, each a reference of the other."""


def ground(scene: Scene) -> Facts:
    """Return the facts of a scene: every ordered pair within reach, measured, for all its views.

    A pair is within reach iff its distance is at most T or the reference's halfspaces may extend to the
    figure. View-independent columns stand for both orders of a pair; the horizontal halfspaces only for
    pairs in figure-reference order, since nothing is concluded from the others.

    Parameters
    ----------
    scene : Scene
        Objects, surfaces and views, metres, world frame.

    Returns
    -------
    Facts
        Lengths rounded to a nanometre, so that rounding noise decides no closed bound.

    Examples
    --------
    >>> from deixis.scene import Scene
    >>> ground(Scene.from_dict({"deixis": 1, "id": "empty", "objects": [], "views": []})).ids
    ()
    """
    boxes, limits = scene.boxes, scene.thresholds
    volume = boxes.volume(limits.granularity)
    first, second = candidate_pairs(boxes, limits)
    base = _measure(boxes, first, second, volume, limits)
    views = [_world(boxes, base, limits)]
    views += [_view(boxes, base, limits, view) for view in scene.views]
    return Facts(
        scene=scene.id,
        ids=tuple(thing.id for thing in scene.objects),
        labels=tuple(tuple((label.name, label.score) for label in thing.labels) for thing in scene.objects),
        surface=boxes.surface,
        volume=volume,
        thresholds=limits,
        views=tuple(views),
        **base,
    )


def candidate_pairs(boxes: Boxes, limits: Thresholds) -> tuple[Index, Index]:
    """Return the unordered pairs (i < j) that may be within reach, by axis-aligned boxes and reaches."""
    n = len(boxes)
    half = boxes.effective_half(limits.granularity)
    cos, sin = np.abs(np.cos(boxes.yaw)), np.abs(np.sin(boxes.yaw))
    around = np.stack(
        [half[:, 0] * cos + half[:, 1] * sin, half[:, 0] * sin + half[:, 1] * cos, half[:, 2]], axis=1
    )
    reach = _reach(boxes, limits)
    i, j = np.triu_indices(n, 1)
    gap = np.maximum(np.abs(boxes.center[i] - boxes.center[j]) - around[i] - around[j], 0.0)
    near = (gap * gap).sum(axis=1) <= np.maximum(reach[i], reach[j]) ** 2
    return i[near], j[near]


def _reach(boxes: Boxes, limits: Thresholds) -> Array:
    """Return how far from each thing, as a reference, a figure may lie and still be spoken of, metres."""
    half = boxes.effective_half(limits.granularity)
    # A contextualised box turns about the centre: its corners leave the minimum box by at most the diagonal.
    plan = 2.0 * limits.halfspace_scale * half[:, :2].max(axis=1) + np.hypot(half[:, 0], half[:, 1])
    sweep = np.maximum(plan, 2.0 * limits.halfspace_scale * half[:, 2])
    return np.where(boxes.surface, np.inf, np.maximum(sweep, limits.closeness))


def _snap(values: Array) -> Array:
    """Round to a nanometre, without negative zeros."""
    return np.round(values, SNAP_DECIMALS) + 0.0


def _measure(boxes: Boxes, i: Index, j: Index, volume: Array, limits: Thresholds) -> dict[str, np.ndarray]:
    """Measure unordered pairs once; return them in both orders, pruned to what is within reach."""
    a, b = boxes.take(i), boxes.take(j)
    there = measures.place(a, b)
    back = there.reversed()
    up, down = measures.vertical_escapes(there, a.half, b.half, a.surface, b.surface, limits.granularity)
    signed, local = measures.separation(there, a.half, b.half, up, down)
    signed = _snap(signed)
    cos, sin = np.cos(b.yaw), np.sin(b.yaw)
    normal = np.stack(
        [cos * local[:, 0] - sin * local[:, 1], sin * local[:, 0] + cos * local[:, 1], local[:, 2]], axis=1
    )
    k = len(i)
    shared, frontier_a, frontier_b = np.zeros(k), np.zeros(k), np.zeros(k)
    deep = np.flatnonzero(signed < 0.0)
    if len(deep):
        d = limits.granularity
        pair, rev = there.take(deep), back.take(deep)
        half_a, half_b = a.half[deep], b.half[deep]
        thick_a, thick_b = np.maximum(half_a, 0.5 * d), np.maximum(half_b, 0.5 * d)
        shared[deep] = measures.intersection_volume(pair, half_a, half_b)
        # Points of a adjacent to inter: D times the area of b's surface inside a; and the other way round.
        frontier_a[deep] = d * measures.surface_inside(rev, thick_b, thick_a, d)
        frontier_b[deep] = d * measures.surface_inside(pair, thick_a, thick_b, d)
    vertical_a, strict_a = halfspaces.meets_vertical(
        there, a.half, b.half, b.normal, signed, up, down, limits
    )
    vertical_b, strict_b = halfspaces.meets_vertical(back, b.half, a.half, a.normal, signed, down, up, limits)
    figure, reference = np.concatenate([i, j]), np.concatenate([j, i])
    ordered = ~boxes.surface[figure] & (
        boxes.surface[reference] | (volume[reference] >= volume[figure] * (1.0 - ORDER_TOLERANCE))
    )
    separation = np.concatenate([signed, signed])
    reach = _reach(boxes, limits)[reference]
    keep = (separation <= limits.closeness) | (ordered & (separation <= reach))
    order = np.flatnonzero(keep)
    order = order[np.lexsort((reference[order], figure[order]))]

    def both(one: Array, other: Array) -> Array:
        return np.concatenate([one, other])[order]

    separation = separation[order]
    return {
        "figure": figure[order],
        "reference": reference[order],
        "distance": np.maximum(separation, 0.0),
        "separation": separation,
        "normal": both(normal, -normal),
        "intersection": np.round(both(shared, shared), 12),
        "protrusion": _snap(
            both(measures.protrusion(there, a.half, b.half), measures.protrusion(back, b.half, a.half))
        ),
        "frontier": np.round(both(frontier_a, frontier_b), 12),
        "vertical": _snap(both(vertical_a, vertical_b)),
        "vertical_strict": _snap(both(strict_a, strict_b)),
        "ordered": ordered[order],
    }


def _world(boxes: Boxes, base: dict[str, np.ndarray], limits: Thresholds) -> ViewFacts:
    """Return the cardinal halfspaces (axioms 21-25): the boxes aligned with the world's axes."""
    rows = np.flatnonzero(base["ordered"])
    relaxed, strict = _horizontal(boxes, align_with_world(boxes), base, rows, limits)
    return ViewFacts(WORLD, rows, relaxed, strict)


def _view(boxes: Boxes, base: dict[str, np.ndarray], limits: Thresholds, view: View) -> ViewFacts:
    """Return the halfspaces in the contextualised frames of one view (axioms 30-34)."""
    framed, clearance, tie = contextualise(boxes, view.position)
    seen = clearance > SNAP
    rows = np.flatnonzero(base["ordered"])
    rows = rows[seen[base["reference"][rows]]]
    relaxed, strict = _horizontal(boxes, framed, base, rows, limits)
    withheld = tuple(
        (int(index), _withheld_reason(bool(boxes.normal[index] in (0, 1)))) for index in np.flatnonzero(~seen)
    )
    return ViewFacts(view.id, rows, relaxed, strict, withheld, tuple(np.flatnonzero(tie).tolist()))


def _withheld_reason(wall: bool) -> str:
    """Say why a reference has no front and sides in a view."""
    if wall:
        return "the view stands in the plane of this surface, so neither side is its front"
    return "the view stands within the footprint of this reference, so it has no front and sides"


def _horizontal(
    boxes: Boxes, framed: Boxes, base: dict[str, np.ndarray], rows: Index, limits: Thresholds
) -> tuple[Array, Array]:
    figure, reference = boxes.take(base["figure"][rows]), framed.take(base["reference"][rows])
    relaxed, strict = halfspaces.meets_horizontal(
        measures.place(figure, reference),
        figure.half,
        reference.half,
        reference.normal,
        limits,
    )
    return _snap(relaxed), _snap(strict)


__all__: Sequence[str] = ["candidate_pairs", "ground"]
