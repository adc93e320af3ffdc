"""Grounding: from a scene's boxes to Facts. The only place where geometry becomes truth values."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np

from deixis import halfspaces, measures
from deixis.boxes import Boxes, align_with_world, contextualise
from deixis.broadphase import MAX_PAIRS, candidate_rows, reach
from deixis.facts import (
    Facts,
    PairColumns,
    RegionModel,
    SolidModel,
    ViewFacts,
    region_model,
    withheld_reason,
)
from deixis.frames import WORLD, Array, Index, Mask
from deixis.locality import Neighbourhood, Rows
from deixis.scene import Scene, View
from deixis.thresholds import SNAP, SNAP_DECIMALS, Thresholds

ORDER_TOLERANCE: Final = 1.0e-6
"""Relative difference of volume below which two things are equally large, each a reference of the other."""


def ground(scene: Scene, *, region: RegionModel = "box", max_pairs: int = MAX_PAIRS) -> Facts:
    """Return the facts of a scene: every ordered pair within reach, measured, for all its views.

    A pair is within reach iff its distance is at most T or the reference's halfspaces may extend to the
    figure. View-independent columns stand for both orders of a pair; the horizontal halfspaces only for
    pairs in figure-reference order, since nothing is concluded from the others.

    Parameters
    ----------
    scene : Scene
        Objects, surfaces and views, metres, world frame.
    region : "box", "hull" or "mesh"
        What things are measured as: their boxes, convex hulls, or meshes where they have one (decision 0017).
    max_pairs : int
        The most ordered pairs allowed; about 200 bytes each.

    Returns
    -------
    Facts
        Lengths rounded to a nanometre, so that rounding noise decides no closed bound.

    Raises
    ------
    GeometryError
        More than ``max_pairs`` ordered pairs are within reach.
    MissingDependency
        Hulls or meshes are asked for and there are some, but python-fcl is not installed.
    QueryError
        There is no such region model.

    Examples
    --------
    >>> from deixis.scene import Scene
    >>> ground(Scene.from_dict({"deixis": 1, "id": "empty", "objects": [], "views": []})).ids
    ()
    """
    region = region_model(region)
    boxes, limits = scene.boxes, scene.thresholds
    facts = Facts(
        scene=scene.id,
        ids=tuple(thing.id for thing in scene.objects),
        labels=labels_of(scene),
        surface=boxes.surface,
        volume=boxes.volume(limits.granularity),
        thresholds=limits,
        pairs=measure_scene_pairs(scene, *candidate_rows(boxes, limits, max_pairs), region),
        views=(),
        region=region,
        models=solid_models(scene, region),
    )
    views = [_world(scene, facts), *(look(scene, facts, view) for view in scene.views)]
    return replace(facts, views=tuple(views))


def labels_of(scene: Scene) -> tuple[tuple[tuple[str, float], ...], ...]:
    """Return the ranked labels of a scene's things, with their scores."""
    return tuple(tuple((label.name, label.score) for label in thing.labels) for thing in scene.objects)


def solid_models(scene: Scene, region: RegionModel) -> tuple[SolidModel, ...]:
    """Return what each thing of a scene is measured as."""
    if region == "box":
        box: SolidModel = "box"
        return (box,) * len(scene.objects)
    from deixis.solids import Solids

    return Solids.of(scene, region).models


def measure_scene_pairs(scene: Scene, figure: Index, reference: Index, region: RegionModel) -> PairColumns:
    """Measure the candidates as what the region model says, and keep those within reach."""
    pairs = measure_pairs(scene.boxes, figure, reference, scene.thresholds)
    if region == "box":
        return pairs
    from deixis.solids import measure_regions

    return measure_regions(scene, pairs, region)


def look(scene: Scene, facts: Facts, view: View) -> ViewFacts:
    """Return the halfspaces in the contextualised frames of one view of a grounded scene (axioms 30-34).

    All that a new pose of the robot changes; the pairs are not measured again.

    Parameters
    ----------
    scene : Scene
        The scene whose facts these are.
    facts : Facts
        Of the scene, whatever its views.
    view : View
        Any pose.
    """
    framed, seen, tie = frame(scene.boxes, view)
    rows = np.flatnonzero(facts.ordered & seen[facts.reference])
    relaxed, strict = scene_meets_halfspaces(scene, framed, facts, rows)
    return view_facts(view.id, scene.boxes, rows, relaxed, strict, seen, tie)


def frame(boxes: Boxes, view: View) -> tuple[Boxes, Mask, Mask]:
    """Return the contextualised boxes of a view, which of them it can speak of, and which were a tie."""
    framed, clearance, tie = contextualise(boxes, view.position)
    return framed, clearance > SNAP, tie


def view_facts(
    name: str, boxes: Boxes, rows: Index, relaxed: Array, strict: Array, seen: Mask, tie: Mask
) -> ViewFacts:
    """Return the facts of a view, with the reasons for what it does not speak of."""
    wall = np.isin(boxes.normal, (0, 1))
    withheld = tuple((int(index), withheld_reason(bool(wall[index]))) for index in np.flatnonzero(~seen))
    return ViewFacts(name, rows, relaxed, strict, withheld, tuple(np.flatnonzero(tie).tolist()))


def _snap(values: Array) -> Array:
    """Round to a nanometre, without negative zeros."""
    return np.round(values, SNAP_DECIMALS) + 0.0


def measure_pairs(boxes: Boxes, figure: Index, reference: Index, limits: Thresholds) -> PairColumns:
    """Measure the candidates and keep those within reach."""
    columns = PairColumns.empty(figure, reference)
    keep = np.empty(len(figure), dtype=np.bool_)
    furthest, volume = reach(boxes, limits), boxes.volume(limits.granularity)
    neighbourhood = Neighbourhood(boxes)
    table = neighbourhood.table(boxes)

    def work(block: Rows) -> None:
        i, j = figure[block], reference[block]
        a, b = table(i), table(j)
        _measure_block(a, b, limits, columns, block)
        ordered = ~a.surface & (b.surface | (volume[j] >= volume[i] * (1.0 - ORDER_TOLERANCE)))
        columns.ordered[block] = ordered
        apart = columns.separation[block]
        keep[block] = (apart <= limits.closeness) | (ordered & (apart <= furthest[j]))

    neighbourhood.for_blocks(figure, work)
    # Few overlap: what only they have is measured of them together.
    deep = np.flatnonzero(columns.separation < 0.0)
    figures = figure[deep]

    def overlap(block: Rows) -> None:
        rows = deep[block]
        _overlap_block(table(figures[block]), table(reference[rows]), limits.granularity, columns, rows)

    neighbourhood.for_blocks(figures, overlap)
    return columns.squeezed(keep)


def _measure_block(a: Boxes, b: Boxes, limits: Thresholds, columns: PairColumns, block: Rows) -> None:
    """Fill in the view-independent columns of some rows, but for overlaps, with figures a, references b."""
    there = measures.place(a, b)
    up, down = measures.vertical_escapes(there, a.half, b.half, a.surface, b.surface, limits.granularity)
    signed, local = measures.separation(there, a.half, b.half, up, down)
    signed = _snap(signed)
    columns.separation[block] = signed
    columns.normal[block, 0] = b.cos * local[:, 0] - b.sin * local[:, 1]
    columns.normal[block, 1] = b.sin * local[:, 0] + b.cos * local[:, 1]
    columns.normal[block, 2] = local[:, 2]
    columns.protrusion[block] = _snap(measures.protrusion(there, a.half, b.half))
    relaxed, strict = halfspaces.meets_vertical(there, a.half, b.half, b.normal, signed, up, down, limits)
    columns.vertical[block] = _snap(relaxed)
    columns.vertical_strict[block] = _snap(strict)


def _overlap_block(a: Boxes, b: Boxes, d: float, columns: PairColumns, rows: Index) -> None:
    """Fill in what there is to measure of rows that overlap, with figures a, references b, granularity d."""
    there = measures.place(a, b)
    thick_a, thick_b = np.maximum(a.half, 0.5 * d), np.maximum(b.half, 0.5 * d)
    columns.intersection[rows] = np.round(measures.intersection_volume(there, a.half, b.half), 12)
    # Points of a adjacent to inter: D times the area of b's surface inside a.
    frontier = d * measures.surface_inside(there.reversed(), thick_b, thick_a, d)
    columns.frontier[rows] = np.round(frontier, 12)


def _world(scene: Scene, facts: Facts) -> ViewFacts:
    """Return the cardinal halfspaces (axioms 21-25): the boxes aligned with the world's axes."""
    rows = np.flatnonzero(facts.ordered)
    framed, tie = align_with_world(scene.boxes)
    relaxed, strict = scene_meets_halfspaces(scene, framed, facts, rows)
    return ViewFacts(WORLD, rows, relaxed, strict, (), tuple(np.flatnonzero(tie).tolist()))


def scene_meets_halfspaces(scene: Scene, framed: Boxes, facts: Facts, rows: Index) -> tuple[Array, Array]:
    """Return the margins along X+, X-, Y+, Y- with the region model of the facts, (q, 4) each."""
    relaxed, strict = meets_halfspaces(scene.boxes, framed, facts, rows)
    if facts.region != "box":
        from deixis.solids import meet_regions

        meet_regions(scene, framed, facts, rows, relaxed, strict)
    return relaxed, strict


def meets_halfspaces(boxes: Boxes, framed: Boxes, facts: Facts, rows: Index) -> tuple[Array, Array]:
    """Return the margins along X+, X-, Y+, Y- of references in their frames, (q, 4) each."""
    figure = facts.figure[rows]
    relaxed, strict = np.empty((len(rows), 4)), np.empty((len(rows), 4))
    neighbourhood = Neighbourhood(boxes)
    figures, references = neighbourhood.table(boxes), neighbourhood.table(framed)

    def work(block: Rows) -> None:
        some = rows[block]
        a, b = figures(figure[block]), references(facts.reference[some])
        meets, within = halfspaces.meets_horizontal(
            measures.place(a, b), a.half, b.half, b.normal, facts.separation[some], facts.thresholds
        )
        relaxed[block], strict[block] = _snap(meets), _snap(within)

    neighbourhood.for_blocks(figure, work)
    return relaxed, strict
