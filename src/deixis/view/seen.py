"""What is to be seen of a proof: the points a distance lies between, and the planes that decide a side.

Only of things that were measured as boxes: of others the points would not be those that were measured.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, Final

import numpy as np

from deixis.bounds import BOUNDS, planes
from deixis.boxes import Boxes, align_with_world, contextualise
from deixis.facts import Facts
from deixis.frames import AXES, WORLD, Array, Index
from deixis.scene import Scene
from deixis.witnesses import segments

_DECIMALS: Final = 4
"""Of what is drawn, metres: a tenth of a millimetre."""


def segments_of(scene: Scene, facts: Facts, pairs: Iterable[tuple[str, str]]) -> list[list[float]]:
    """Return for each pair of things their positions, and the two points their separation is measured by."""
    boxed = _boxed(facts)
    known = sorted({(boxed[a], boxed[b]) for a, b in pairs if a in boxed and b in boxed and a != b})
    if not known:
        return []
    figure, reference = np.array(known, dtype=np.int64).T
    found = segments(scene.boxes, figure, reference, scene.thresholds.granularity)
    return [[i, j, *short(ends)] for (i, j), ends in zip(known, found.reshape(-1, 6), strict=True)]


def planes_of(
    scene: Scene, facts: Facts, spaces: Iterable[tuple[str, str, str, str]]
) -> dict[str, list[Any]]:
    """Return the planes that decide which figures meet which halfspaces.

    Parameters
    ----------
    scene : Scene
    facts : Facts
        Of the scene.
    spaces : iterable of (figure, reference, axis, view)

    Returns
    -------
    dict
        By positions, axis and number of the frame ("3 0 Z+ 0", the world's being 0): a point of the plane,
        its normal, the figure's point that decides, and which bound it is.
    """
    boxed = _boxed(facts)
    frames = {WORLD: 0} | {view.id: number for number, view in enumerate(scene.views, 1)}
    groups: dict[tuple[str, str], list[tuple[int, int]]] = {}
    for figure, reference, axis, view in spaces:
        if figure in boxed and reference in boxed and view in frames:
            groups.setdefault((axis, view), []).append((boxed[figure], boxed[reference]))
    found: dict[str, list[Any]] = {}
    for (axis, view), pairs in groups.items():
        rows = _rows(facts, pairs)
        measured = [(pair, row) for pair, row in zip(pairs, rows.tolist(), strict=True) if row >= 0]
        if not measured:
            continue
        figure_at, reference_at = np.array([pair for pair, _ in measured], dtype=np.int64).T
        separation = facts.separation[[row for _, row in measured]]
        framed = scene.boxes if axis in AXES[4:] else _framed(scene, view)
        decided = planes(
            scene.boxes.take(figure_at), framed.take(reference_at), separation, axis, scene.thresholds
        )
        for number, ((i, j), _) in enumerate(measured):
            of = (decided.point, decided.normal, decided.witness)
            drawn = [value for one in of for value in short(one[number])]
            found[f"{i} {j} {axis} {frames[view]}"] = [*drawn, BOUNDS.index(decided.bound[number])]
    return found


def short(values: Array) -> list[float]:
    """Return metres as they are drawn.

    >>> short(np.array([0.12345, -0.00001]))
    [0.1234, 0.0]
    """
    return [float(value) + 0.0 for value in np.round(values, _DECIMALS)]


def _boxed(facts: Facts) -> dict[str, int]:
    """Return the positions of the things that were measured as boxes, by their ids."""
    both = enumerate(zip(facts.ids, facts.models, strict=True))
    return {name: index for index, (name, model) in both if model == "box"}


def _rows(facts: Facts, pairs: list[tuple[int, int]]) -> Index:
    """Return the rows of pairs in the table of facts, which is in order; -1 where there is none."""
    n = len(facts.ids)
    keys = facts.figure.astype(np.int64) * n + facts.reference
    wanted = np.array([i * n + j for i, j in pairs], dtype=np.int64)
    at = np.minimum(np.searchsorted(keys, wanted), max(len(keys) - 1, 0))
    there = keys[at] == wanted if len(keys) else np.zeros(len(wanted), dtype=np.bool_)
    return np.where(there, at, -1).astype(np.int64)


def _framed(scene: Scene, view: str) -> Boxes:
    """Return the boxes turned to a view, or to the world's axes."""
    if view == WORLD:
        return align_with_world(scene.boxes)[0]
    position = next(one.position for one in scene.views if one.id == view)
    return contextualise(scene.boxes, position)[0]
