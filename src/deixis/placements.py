"""Placements: the moves that put a thing on, under, beside, within or near another, to be tried out.

A move along one of a few lines from where a thing stands rarely ends on top of something else: it has to go
up and over. Here such moves are composed of what each axis of the other thing's box asks for by itself.
"""

from __future__ import annotations

import numpy as np

from deixis.boxes import Boxes
from deixis.frames import Array, Index
from deixis.thresholds import Thresholds


def placements(boxes: Boxes, thing: int, others: Index, limits: Thresholds, furthest: float) -> Array:
    """Return moves of a thing that place it by others, (m, 3) metres, the shortest first.

    Along each axis of the other's box the thing may stay where it is, or go by the shortest way to where it
    overlaps the other, lies within its sides, or is close to it; or to its middle, or to either end of it.

    Parameters
    ----------
    boxes : Boxes
        Of all things.
    thing : int
        What is moved, by its position.
    others : (k,) int
        What it is placed by.
    limits : Thresholds
    furthest : float
        Metres: no move is longer.

    Examples
    --------
    >>> from deixis.scene import Scene
    >>> cup = {"id": "cup", "box": {"center": [2, 0, 0.05], "size": [0.1, 0.1, 0.1]}}
    >>> table = {"id": "table", "box": {"center": [0, 0, 0.4], "size": [1, 1, 0.8]}}
    >>> scene = Scene.from_dict({"deixis": 1, "id": "s", "objects": [cup, table], "views": []})
    >>> found = placements(scene.boxes, 0, np.array([1]), scene.thresholds, 3.0)
    >>> bool((np.abs(found - [-2.0, 0.0, 0.8]).max(axis=1) < 1e-9).any())
    True
    """
    half = boxes.effective_half(limits.granularity)
    found = [np.empty((0, 3))]
    for other in others.tolist():
        turn, lean = float(boxes.yaw[other]), float(boxes.yaw[thing] - boxes.yaw[other])
        frame = np.array(
            [[np.cos(turn), np.sin(turn), 0.0], [-np.sin(turn), np.cos(turn), 0.0], [0.0, 0.0, 1.0]]
        )
        cos, sin = abs(np.cos(lean)), abs(np.sin(lean))
        a, b, c = half[thing]
        own = np.array([cos * a + sin * b, sin * a + cos * b, c])
        now = frame @ (boxes.center[thing] - boxes.center[other])
        ends = own + half[other]
        overlap = np.maximum(ends - limits.granularity - limits.penetration, 0.0)
        inside = np.maximum(half[other] - own, 0.0)
        close = ends + 0.9 * limits.closeness
        goals = [now, 0.0 * now, ends, -ends, *(np.clip(now, -far, far) for far in (overlap, inside, close))]
        # One column for each axis; what each asks for is combined with what the others do.
        grid = np.stack(np.meshgrid(*np.array(goals).T, indexing="ij"), axis=-1).reshape(-1, 3)
        found.append((grid - now) @ frame)
    moves = np.unique(np.round(np.concatenate(found), 9), axis=0)
    length = np.linalg.norm(moves, axis=1)
    order = np.argsort(length, kind="stable")
    return np.asarray(moves[order[(length[order] > 0.0) & (length[order] <= furthest)]])
