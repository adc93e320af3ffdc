"""Regrounding: the facts of a scene in which some things or views have moved, from those of before."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from deixis.boxes import Boxes, align_with_world
from deixis.broadphase import candidates_of
from deixis.facts import Facts, PairColumns, ViewFacts
from deixis.frames import WORLD, Index, Mask
from deixis.grounding import (
    frame,
    ground,
    look,
    measure_scene_pairs,
    scene_meets_halfspaces,
    solid_models,
    view_facts,
)
from deixis.regions import BoxRegion, MeshRegion, PointRegion, Region, SurfaceRegion
from deixis.scene import Scene

_MANY = 4
"""With more than one in so many things moved, a full run costs no more."""


def reground(before: Scene, facts: Facts, after: Scene) -> Facts:
    """Return the facts of a changed scene; the same as :func:`deixis.grounding.ground` would find.

    Only the pairs of things that moved or are new are measured, and only the views that moved are looked from
    again. A scene with other thresholds is grounded from the start.

    Parameters
    ----------
    before : Scene
    facts : Facts
        Of ``before``.
    after : Scene

    Examples
    --------
    >>> from deixis._files import kb_dir
    >>> scene = Scene.load(kb_dir() / "scenes" / "hans.json")
    >>> facts = ground(scene)
    >>> len(reground(scene, facts, scene)) == len(facts)
    True
    """
    if before.thresholds != after.thresholds:
        return ground(after, region=facts.region)
    names = tuple(thing.id for thing in after.objects)
    boxes = after.boxes
    place = _places(facts.ids, names)
    moved = np.ones(len(names), dtype=np.bool_)
    stayed = np.flatnonzero(place >= 0)
    same = place[stayed]
    moved[same] = boxes.take(same).differs(before.boxes.take(stayed))
    if facts.region != "box":
        # Within one and the same box a mesh may be another, or turned over.
        for old, new in zip(stayed.tolist(), same.tolist(), strict=True):
            moved[new] |= not _alike(before.objects[old].region, after.objects[new].region)
    if _MANY * int(moved.sum()) > len(moved):
        return ground(after, region=facts.region)
    changed = moved.any() or facts.ids != names
    pairs, origin = _pairs(facts, after, moved, place) if changed else (facts.pairs, None)
    base = replace(
        facts,
        scene=after.id,
        ids=names,
        labels=tuple(tuple((label.name, label.score) for label in thing.labels) for thing in after.objects),
        surface=boxes.surface,
        volume=boxes.volume(after.thresholds.granularity),
        pairs=pairs,
        views=(),
        models=solid_models(after, facts.region),
    )
    known = {view.view: view for view in facts.views}
    poses = {view.id: view.position for view in before.views}
    views = []
    if origin is None:
        views.append(known[WORLD])
    else:
        framed, tie = align_with_world(boxes)
        seen = np.ones(len(boxes), dtype=bool)
        views.append(_again(known[WORLD], after, framed, seen, tie, base, origin))
    for view in after.views:
        if view.id not in poses or not np.array_equal(poses[view.id], view.position):
            views.append(look(after, base, view))
        elif origin is None:
            views.append(known[view.id])
        else:
            views.append(_again(known[view.id], after, *frame(boxes, view), base, origin))
    return replace(base, views=tuple(views))


def _alike(one: Region, other: Region) -> bool:
    """Return whether two regions are certainly the same."""
    if one is other:
        return True
    if isinstance(one, MeshRegion) and isinstance(other, MeshRegion):
        same = np.array_equal(one.vertices, other.vertices)
        return same and np.array_equal(one.faces, other.faces)
    if isinstance(one, PointRegion) and isinstance(other, PointRegion):
        return np.array_equal(one.points, other.points)
    if isinstance(one, SurfaceRegion) and isinstance(other, SurfaceRegion):
        return np.array_equal(one.polygon, other.polygon)
    # Of boxes the boxes tell.
    return isinstance(one, BoxRegion) and isinstance(other, BoxRegion)


def _places(before: tuple[str, ...], after: tuple[str, ...]) -> Index:
    """Return where each thing of before is now, -1 where it is gone."""
    if before == after:
        return np.arange(len(before))
    positions = {name: at for at, name in enumerate(after)}
    return np.array([positions.get(name, -1) for name in before], dtype=np.int64)


def _pairs(facts: Facts, after: Scene, moved: Mask, place: Index) -> tuple[PairColumns, Index]:
    """Return the pair table of now, and for each row the row it was before, -1 for those measured anew."""
    old, boxes, limits = facts.pairs, after.boxes, after.thresholds
    figure, reference = place[old.figure], place[old.reference]
    # What is gone is as good as moved: the last place says so.
    fresh = np.append(moved, True)
    kept = np.flatnonzero(~(fresh[figure] | fresh[reference]))
    candidates = candidates_of(boxes, limits, np.flatnonzero(moved))
    new = measure_scene_pairs(after, *candidates, facts.region)
    n = max(len(boxes), 1)
    figure, reference = figure[kept], reference[kept]
    keys = np.concatenate([figure * n + reference, new.figure * n + new.reference])
    order = np.argsort(keys, kind="stable")
    origin = np.concatenate([kept, np.full(len(new.figure), -1)])[order]
    known = replace(old.at(kept), figure=figure, reference=reference)
    return known.joined(new).at(order), origin


def _again(
    old: ViewFacts, after: Scene, framed: Boxes, seen: Mask, tie: Mask, base: Facts, origin: Index
) -> ViewFacts:
    """Return a view's facts where only things moved: known margins are kept, the others measured."""
    rows = np.flatnonzero(base.ordered & seen[base.reference])
    place = np.full(int(max(origin.max(initial=-1), old.rows.max(initial=-1))) + 2, -1)
    place[old.rows] = np.arange(len(old.rows))
    # An origin of -1 reads the last place, which is -1 too.
    source = place[origin[rows]]
    known = np.flatnonzero(source >= 0)
    fresh = np.flatnonzero(source < 0)
    relaxed, strict = np.empty((len(rows), 4)), np.empty((len(rows), 4))
    relaxed[known], strict[known] = old.int_hs[source[known]], old.cont_hs[source[known]]
    relaxed[fresh], strict[fresh] = scene_meets_halfspaces(after, framed, base, rows[fresh])
    return view_facts(old.view, after.boxes, rows, relaxed, strict, seen, tie)
