"""The facts of boxes, whatever scene they are from."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from deixis.boxes import Boxes, align_with_world
from deixis.broadphase import candidate_rows
from deixis.facts import Facts, ViewFacts
from deixis.frames import WORLD
from deixis.grounding import frame, measure_pairs, meets_halfspaces, view_facts
from deixis.scene import Scene

MAX_PAIRS: Final = 20_000_000
"""Ordered pairs within reach in a tile and around it: some 4 GiB of facts."""

Labels = tuple[tuple[tuple[str, float], ...], ...]


def box_facts(head: Scene, ids: Sequence[str], labels: Labels, boxes: Boxes) -> Facts:
    """Return what :func:`deixis.grounding.ground` finds of things that are only boxes.

    Parameters
    ----------
    head : Scene
        Views and thresholds.
    ids : sequence of str
    labels : tuple
        Of each thing; empty where no rule looks at labels.
    boxes : Boxes

    Examples
    --------
    >>> from deixis._files import kb_dir
    >>> from deixis.grounding import ground
    >>> scene = Scene.load(kb_dir() / "scenes" / "hans.json")
    >>> found = box_facts(scene, [thing.id for thing in scene.objects], (), scene.boxes)
    >>> np.array_equal(found.separation, ground(scene).separation)
    True
    """
    limits = head.thresholds
    facts = Facts(
        scene=head.id,
        ids=tuple(ids),
        labels=labels,
        surface=boxes.surface,
        volume=boxes.volume(limits.granularity),
        thresholds=limits,
        pairs=measure_pairs(boxes, *candidate_rows(boxes, limits, MAX_PAIRS), limits),
        views=(),
        region="box",
        models=tuple("box" for _ in ids),
    )
    framed, tie = align_with_world(boxes)
    rows = np.flatnonzero(facts.ordered)
    margins = meets_halfspaces(boxes, framed, facts, rows)
    views = [ViewFacts(WORLD, rows, *margins, (), tuple(np.flatnonzero(tie).tolist()))]
    for view in head.views:
        framed, seen, tie = frame(boxes, view)
        rows = np.flatnonzero(facts.ordered & seen[facts.reference])
        margins = meets_halfspaces(boxes, framed, facts, rows)
        views.append(view_facts(view.id, boxes, rows, *margins, seen, tie))
    return replace(facts, views=tuple(views))
