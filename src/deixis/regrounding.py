"""Regrounding: the facts of a scene in which some things or views have moved, from those of before."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import compress
from operator import is_not
from typing import Any

import numpy as np
from numpy.typing import NDArray

from deixis.boxes import Boxes, align_with_world
from deixis.broadphase import candidates_of
from deixis.facts import Facts, PairColumns, ViewFacts
from deixis.frames import WORLD, Index, Mask
from deixis.grounding import (
    frame,
    ground,
    labels_of,
    look,
    measure_scene_pairs,
    scene_meets_halfspaces,
    solid_models,
    view_facts,
)
from deixis.regions import BoxRegion, MeshRegion, PointRegion, Region, SurfaceRegion
from deixis.scene import Scene

Labels = tuple[tuple[tuple[str, float], ...], ...]
"""Of each thing its names, each with its score."""

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
    boxes = after.boxes
    change = _Change.between(before, after, facts)
    if _MANY * int(change.moved.sum()) > len(boxes):
        return ground(after, region=facts.region)
    if change.any:
        pairs, source = _pairs(facts, after, change)
    else:
        pairs, source = facts.pairs, np.arange(len(facts))
    base = replace(
        facts,
        scene=after.id,
        ids=change.names,
        labels=change.labels(after, facts),
        surface=boxes.surface,
        volume=boxes.volume(after.thresholds.granularity),
        pairs=pairs,
        views=(),
        models=solid_models(after, facts.region),
    )
    known = {view.view: view for view in facts.views}
    poses = {view.id: view.position for view in before.views}
    views = []
    if change.any:
        framed, tie = align_with_world(boxes)
        views.append(_again(known[WORLD], after, framed, None, tie, base, source))
    else:
        views.append(known[WORLD])
    for view in after.views:
        if view.id not in poses or not np.array_equal(poses[view.id], view.position):
            views.append(look(after, base, view))
        elif change.any:
            views.append(_again(known[view.id], after, *frame(boxes, view), base, source))
        else:
            views.append(known[view.id])
    return replace(base, views=tuple(views))


@dataclass(frozen=True, slots=True)
class _Change:
    """What is otherwise in a scene.

    Attributes
    ----------
    names : tuple of str
        Of the things of now.
    told : list of int, optional
        Positions of the things told of anew, where each thing is where it was in the list; else None.
    place : (m,) int
        Where each thing of before is now, -1 where it is gone.
    moved : (n,) bool
        Which things of now are new, or measure otherwise.
    """

    names: tuple[str, ...]
    told: list[int] | None
    place: Index
    moved: Mask

    @property
    def any(self) -> bool:
        """Return whether there is anything to measure again."""
        return self.told is None or bool(self.moved.any())

    @classmethod
    def between(cls, before: Scene, after: Scene, facts: Facts) -> _Change:
        """Return what is otherwise between two scenes."""
        old, new = before.objects, after.objects
        told = None
        if len(old) == len(new):
            # Most things are the very same ones, which need not be looked at.
            told = list(compress(range(len(new)), map(is_not, old, new)))
            told = told if all(old[at].id == new[at].id for at in told) else None
        if told is not None:
            names, place = facts.ids, np.arange(len(new))
            moved = after.boxes.differs(before.boxes)
        else:
            names = tuple([thing.id for thing in new])
            positions = {name: at for at, name in enumerate(names)}
            place = np.array([positions.get(name, -1) for name in facts.ids], dtype=np.int64)
            stayed = np.flatnonzero(place >= 0)
            moved = np.ones(len(names), dtype=np.bool_)
            moved[place[stayed]] = after.boxes.take(place[stayed]).differs(before.boxes.take(stayed))
        if facts.region != "box":
            # Within one and the same box a mesh may be another, or turned over.
            for at, position in enumerate(place.tolist()):
                if position >= 0:
                    moved[position] |= not _alike(old[at].region, new[position].region)
        return cls(names, told, place, moved)

    def labels(self, after: Scene, facts: Facts) -> Labels:
        """Return the labels of now, made anew only where a thing is told of anew."""
        if self.told is None:
            return labels_of(after)
        found = list(facts.labels)
        for at in self.told:
            found[at] = tuple((label.name, label.score) for label in after.objects[at].labels)
        return tuple(found)


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


def _pairs(facts: Facts, after: Scene, change: _Change) -> tuple[PairColumns, Index]:
    """Return the pair table of now, and the row each was before, -1 for those measured anew."""
    old, boxes, limits = facts.pairs, after.boxes, after.thresholds
    figure, reference = old.figure, old.reference
    if change.told is None:
        figure, reference = change.place[figure], change.place[reference]
    # What is gone is as good as moved: the last place says so.
    fresh = np.append(change.moved, True)
    kept = np.flatnonzero(~(fresh[figure] | fresh[reference]))
    candidates = candidates_of(boxes, limits, np.flatnonzero(change.moved))
    new = measure_scene_pairs(after, *candidates, facts.region)
    n = max(len(boxes), 1)
    keys = np.concatenate([(figure * n + reference)[kept], new.figure * n + new.reference])
    source = np.concatenate([kept, np.full(len(new.figure), -1)])[np.argsort(keys, kind="stable")]
    known = replace(old, figure=figure, reference=reference)
    at = np.flatnonzero(source < 0)
    columns = (_patched(getattr(known, name), source, at, getattr(new, name)) for name in known.__slots__)
    return PairColumns(*columns), source


def _patched(old: NDArray[Any], source: Index, at: Index, new: NDArray[Any]) -> NDArray[Any]:
    """Return rows of old, one for each source, but at some places the new ones: each row is copied once."""
    if not len(old):
        return new
    result = old.take(source, axis=0, mode="clip")
    result[at] = new
    return result


def _again(
    old: ViewFacts, after: Scene, framed: Boxes, seen: Mask | None, tie: Mask, base: Facts, source: Index
) -> ViewFacts:
    """Return a view's facts where only things moved: known margins are kept, the others measured.

    Parameters
    ----------
    old : ViewFacts
    after : Scene
    framed : Boxes
        Of this view, in the scene of now.
    seen : (n,) bool, optional
        What the view can speak of; by default all.
    tie : (n,) bool
    base : Facts
        Of now, without views.
    source : (p,) int
        Of :func:`_pairs`.
    """
    rows = np.flatnonzero(base.ordered if seen is None else base.ordered & seen[base.reference])
    # A source of -1 reads the last place, which is -1 too.
    place = np.full(int(max(source.max(initial=-1), old.rows.max(initial=-1))) + 2, -1)
    place[old.rows] = np.arange(len(old.rows))
    where = place[source[rows]]
    fresh = np.flatnonzero(where < 0)
    relaxed, strict = scene_meets_halfspaces(after, framed, base, rows[fresh])
    relaxed = _patched(old.int_hs, where, fresh, relaxed)
    strict = _patched(old.cont_hs, where, fresh, strict)
    every = np.ones(len(after.objects), dtype=np.bool_) if seen is None else seen
    return view_facts(old.view, after.boxes, rows, relaxed, strict, every, tie)
