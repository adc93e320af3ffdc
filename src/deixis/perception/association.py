"""Association: which things of one frame are things of the map already, by overlap and label."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from deixis.boxes import NO_NORMAL, Boxes, min_bound_box
from deixis.frames import Array
from deixis.measures import intersection_volume, place
from deixis.scene import Label

SHARED: Final = 0.3
"""Share of the smaller box inside the other from which two sightings of one name are of one thing."""

SAME_PLACE: Final = 0.6
"""Intersection over union from which two sightings are of one thing whatever it was taken for."""

TOP: Final = 5
"""Labels that are kept."""


def boxes_of(clouds: Sequence[Array]) -> Boxes:
    """Return the minimum boxes of clouds."""
    rows = [min_bound_box(cloud) for cloud in clouds]
    return Boxes(
        np.array([row[0] for row in rows]).reshape(-1, 3),
        np.array([row[1] for row in rows]).reshape(-1, 3),
        np.array([row[2] for row in rows], dtype=np.float64),
        np.full(len(rows), NO_NORMAL),
        np.array([row[3] for row in rows], dtype=np.bool_),
    )


Labels = Sequence[Sequence[Label]]


def associate(
    known: Boxes, known_labels: Labels, seen: Boxes, seen_labels: Labels, granularity: float
) -> dict[int, int]:
    """Return for sightings of one frame which known thing each is of; those that are left out are new.

    No two sightings of one frame are of one thing; where several could be, the best fit over all counts.

    Parameters
    ----------
    known, seen : Boxes
        Of the map's things and of the frame's.
    known_labels, seen_labels : sequence of labels
    granularity : float
        Metres: no thing is thinner.
    """
    from scipy.optimize import linear_sum_assignment

    score = _fit(seen, seen_labels, known, known_labels, granularity)
    rows, columns = linear_sum_assignment(score, maximize=True)
    return {int(row): int(column) for row, column in zip(rows, columns, strict=True) if score[row, column]}


def doubles(boxes: Boxes, labels: Labels, views: Sequence[set[str]], granularity: float) -> dict[int, int]:
    """Return which things of a map are of earlier ones after all, none of a frame that shows both.

    Seen from two sides a thing may have little in common with itself, until a third view joins the two.
    """
    score = _fit(boxes, labels, boxes, labels, granularity)
    result: dict[int, int] = {}
    for one, other in np.argwhere(np.tril(score, -1) > 0.0).tolist():
        taken = one in result or other in result or other in result.values() or one in result.values()
        if not taken and not views[one] & views[other]:
            result[one] = other
    return result


def _fit(one: Boxes, one_labels: Labels, other: Boxes, other_labels: Labels, granularity: float) -> Array:
    """Return how well each of some things fits each of others, (n, m); 0 where they are not of one thing."""
    rows, columns = (axis.ravel() for axis in np.indices((len(one), len(other))))
    shape = len(one), len(other)
    if not len(rows):
        return np.zeros(shape)
    reach = np.linalg.norm(one.effective_half(granularity), axis=1)[rows]
    reach += np.linalg.norm(other.effective_half(granularity), axis=1)[columns]
    near = np.flatnonzero(np.linalg.norm(one.center[rows] - other.center[columns], axis=1) < reach)
    a, b = one.take(rows[near]), other.take(columns[near])
    common = intersection_volume(place(a, b), a.effective_half(granularity), b.effective_half(granularity))
    volume_a, volume_b = a.volume(granularity), b.volume(granularity)
    shared = common / np.minimum(volume_a, volume_b)
    union = common / (volume_a + volume_b - common)
    pairs = zip(rows[near].tolist(), columns[near].tolist(), strict=True)
    alike = np.array([likeness(one_labels[i], other_labels[j]) for i, j in pairs])
    possible = ((shared >= SHARED) & (alike > 0.0)) | (union >= SAME_PLACE)
    score = np.zeros(shape)
    score[rows[near], columns[near]] = np.where(possible, shared + union + alike, 0.0)
    return score


def likeness(one: Sequence[Label], other: Sequence[Label]) -> float:
    """Return how much two rankings agree: what their scores have in common, as a share of the lesser sum.

    Things without any label agree a little with everything.

    >>> likeness([Label("cup", 0.5), Label("jar", 0.5)], [Label("cup", 1.0)])
    0.5
    """
    if not one or not other:
        return 0.1
    scores = {label.name: label.score for label in other}
    common = sum(min(label.score, scores.get(label.name, 0.0)) for label in one)
    least = min(sum(label.score for label in one), sum(scores.values()))
    return common / least if least > 0.0 else 0.0


def fused(rankings: Sequence[tuple[Sequence[Label], float]]) -> tuple[Label, ...]:
    """Return the ranking of several views together: the mean of the scores, weighted by what each saw.

    Parameters
    ----------
    rankings : sequence of (labels, weight)
        A name that a view does not give has the score 0 there.

    Examples
    --------
    >>> fused([([Label("cup", 0.8)], 3.0), ([Label("jar", 0.8)], 1.0)])
    (Label(name='cup', score=0.6), Label(name='jar', score=0.2))
    """
    total: dict[str, float] = {}
    weights = sum(weight for labels, weight in rankings if labels)
    for labels, weight in rankings:
        for label in labels:
            total[label.name] = total.get(label.name, 0.0) + label.score * weight
    ranked = sorted(
        ((score / weights, name) for name, score in total.items()), key=lambda one: (-one[0], one[1])
    )
    return tuple(Label(name, round(score, 6)) for score, name in ranked[:TOP])
