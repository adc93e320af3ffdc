"""What one frame shows: a cloud for each thing, and the rest, thinned out."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from deixis.frames import Array
from deixis.perception.frame import CloudFrame, Frame
from deixis.perception.smoothing import noise_of, smooth
from deixis.perception.thinning import thinned
from deixis.scene import Label

FEWEST: Final = 25
"""Pixels that a thing needs to be measured."""

MANY: Final = 3_000
"""Pixels of a thing that are about enough."""

COARSEST: Final = 3
"""Pixels from one that is looked at to the next, at most: what lies between at an edge is lost."""

REST: Final = 10_000
"""Pixels of what is no thing that are kept."""

DENSE: Final = 1 << 14
"""Numbers below this are few enough to look for each."""

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
    valid = (frame.depth > 0.0) & (frame.depth < FARTHEST)
    ids = frame.instances
    noise = noise_of(frame.depth, valid) if frame.noise is None else frame.noise
    things, notes = [], []
    for number, part in _crops(ids):
        mask = (ids[part] == number) & valid[part]
        count = int(np.count_nonzero(mask))
        labels = frame.labels.get(number, ())
        name = _name(number, labels)
        if count < FEWEST:
            notes.append(f"{name}: {count} pixels with a depth, fewer than {FEWEST}: left out")
            continue
        rows, columns = part
        # Of what fills the image every other pixel or so is enough.
        step = min(int(np.ceil(np.sqrt(count / MANY))), COARSEST)
        found = smooth(frame.depth[part][::step, ::step], mask[::step, ::step], noise)
        u, v = columns.start + step * found.u, rows.start + step * found.v
        if len(u) < FEWEST:
            notes.append(f"{name}: its depths are all noise: left out")
            continue
        rays = frame.camera.rays(u, v)
        points = found.depth[:, None] * rays + frame.camera.position
        things.append(Sighting(number, labels, points, found.error[:, None] * rays))
    flat = np.flatnonzero(valid & (ids == 0))
    v, u = np.divmod(flat[:: max(1, len(flat) // REST)].astype(np.int64), frame.camera.width)
    rest = frame.camera.points(u, v, frame.depth[v, u])
    return Shown(things, rest, frame.camera.position, noise, notes)


def _crops(ids: NDArray[np.integer]) -> list[tuple[int, tuple[slice, slice]]]:
    """Return the numbers in an image, 0 left out, each with the rows and columns it is in."""
    from scipy.ndimage import find_objects

    if int(ids.max(initial=0)) < DENSE:
        return [(number, part) for number, part in enumerate(find_objects(ids), 1) if part is not None]
    known, dense = np.unique(ids, return_inverse=True)
    numbers = known[known > 0].tolist()
    parts = find_objects(dense.reshape(ids.shape) + int(known[0] != 0))
    return list(zip(numbers, parts, strict=True))


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
    eye = frame.position + np.array([0.0, 0.0, EYE])
    stride = max(1, len(rest) // (10 * REST))
    return Shown(things, rest[::stride], eye, frame.noise or 0.0, notes)


def _name(number: int, labels: tuple[Label, ...]) -> str:
    return f"{labels[0].name if labels else 'thing'} (instance {number})"
