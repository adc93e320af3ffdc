"""What one frame shows: a cloud for each thing, and the rest, thinned out."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np

from deixis.frames import Array
from deixis.perception.frame import CloudFrame, Frame
from deixis.perception.smoothing import noise_of, smooth
from deixis.perception.thinning import thinned
from deixis.scene import Label

FEWEST: Final = 25
"""Pixels that a thing needs to be measured."""

REST: Final = 20_000
"""Pixels of what is no thing that are kept."""

EYE: Final = 1.0
"""Metres above the robot's position that a cloud is taken to be seen from."""

FARTHEST: Final = 100.0
"""Metres: no depth camera sees further."""


@dataclass(frozen=True, eq=False)
class Sighting:
    """A thing as one frame shows it.

    Attributes
    ----------
    number : int
        In the instance image.
    labels : tuple of Label
    points : (n, 3) float
        Metres, world frame, with as little noise as can be.
    wobble : (n, 3) float
        One standard error of each point along its ray, metres.
    """

    number: int
    labels: tuple[Label, ...]
    points: Array
    wobble: Array


@dataclass(frozen=True, eq=False)
class Shown:
    """What one frame shows.

    Attributes
    ----------
    things : list of Sighting
    rest : (m, 3) float
        Points that no thing covers.
    eye : (3,) float
        Where the camera was.
    noise : float
        Standard deviation of the depths, metres.
    notes : list of str
        What was left out.
    """

    things: list[Sighting]
    rest: Array
    eye: Array
    noise: float
    notes: list[str]


def show(frame: Frame) -> Shown:
    """Return what a frame shows."""
    from scipy.ndimage import find_objects

    valid = (frame.depth > 0.0) & (frame.depth < FARTHEST)
    ids = frame.instances
    noise = noise_of(frame.depth, valid) if frame.noise is None else frame.noise
    things, notes = [], []
    known, dense = np.unique(ids, return_inverse=True)
    dense = dense.reshape(ids.shape) + (0 if 0 in known else 1)
    numbers = known[known != 0]
    for number, part in zip(numbers.tolist(), find_objects(dense), strict=True):
        mask = (ids[part] == number) & valid[part]
        count = int(np.count_nonzero(mask))
        labels = frame.labels.get(number, ())
        name = _name(number, labels)
        if count < FEWEST:
            notes.append(f"{name}: {count} pixels with a depth, fewer than {FEWEST}: left out")
            continue
        rows, columns = part
        found = smooth(frame.depth[part], mask, noise, (columns.start, rows.start))
        if len(found.u) < FEWEST:
            notes.append(f"{name}: its depths are all noise: left out")
            continue
        rays = frame.camera.rays(found.u, found.v)
        points = found.depth[:, None] * rays + frame.camera.position
        things.append(Sighting(number, labels, points, found.error[:, None] * rays))
    v, u = np.nonzero(valid & (ids == 0))
    stride = max(1, len(u) // REST)
    u, v = u[::stride], v[::stride]
    rest = frame.camera.points(u, v, frame.depth[v, u])
    return Shown(things, rest, frame.camera.position, noise, notes)


def show_cloud(frame: CloudFrame, advance: Callable[[int], None] | None = None) -> Shown:
    """Return what a cloud shows; ``advance`` is told how many points were read, again and again."""
    clouds, rest = thinned(frame.cloud, advance)
    things, notes = [], []
    for number, points in clouds.items():
        labels = frame.labels.get(number, ())
        if len(points) < FEWEST:
            notes.append(f"{_name(number, labels)}: {len(points)} points, fewer than {FEWEST}: left out")
        else:
            things.append(Sighting(number, labels, points, np.zeros_like(points)))
    # Seen from where the robot is, above its floor.
    eye = frame.position + [0.0, 0.0, EYE]
    stride = max(1, len(rest) // (10 * REST))
    return Shown(things, rest[::stride], eye, frame.noise or 0.0, notes)


def _name(number: int, labels: tuple[Label, ...]) -> str:
    return f"{labels[0].name if labels else 'thing'} (instance {number})"
