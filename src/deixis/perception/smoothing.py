"""Smoothing: the depth noise of a thing's pixels averaged away, never across a depth edge.

Around each pixel a plane is fitted to its neighbours in the same mask and about as deep, and once more to
those of them that do not fly. Layers of depth that overlap by half take the place of one such choice for each
pixel. What the fit says replaces what was measured, with a standard error. A pixel with few neighbours as
deep as itself, or far from their fit, is no part of the thing.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import Final

import numpy as np

from deixis.frames import Array, Index, Mask
from deixis.perception.strips import Strip

LAYER: Final = 8.0
"""Standard deviations of noise from the middle of a layer of depth to its ends."""

THINNEST: Final = 0.06
"""Metres: no layer is thinner, however little noise there is."""

WINDOW: Final = (2, 6)
"""The least and the greatest radius of a window, pixels: smaller things need smaller ones."""

SLOPE: Final = 1.5
"""Window radii that a layer reaches along ground as steep as most of the thing."""

SUPPORT: Final = 0.25
"""Share of the mask around a pixel that must be about as deep as the pixel."""

FEWEST: Final = 5
"""Pixels that a fit needs."""

FAR_OFF: Final = 4.0
"""Standard deviations from the fit beyond which a depth was not measured on the thing."""

STRAY: Final = 2.5
"""Standard deviations from the first fit beyond which a depth has no part in the second."""

CURVED: Final = 0.004
"""Metres: as far from a plane as a curved thing is within a window, if there were no noise."""

TOGETHER: Final = 1 << 13
"""Pixels of strips of layers that are worked on at once, about: what is made of them stays in the cache."""

_OUTWARDS: Final = np.array([-1, 1, -1, 1])


@dataclass(frozen=True, slots=True)
class Smoothed:
    """The pixels of a thing with their depths.

    Attributes
    ----------
    u, v : (n,) int
        Columns and rows of the crop.
    depth : (n,) float
        Metres, from the fit.
    error : (n,) float
        Its standard error, metres.
    dropped : int
        Pixels of the mask with a depth that is not the thing's.
    """

    u: Index
    v: Index
    depth: Array
    error: Array
    dropped: int


def noise_of(depth: Array, mask: Mask) -> float:
    """Return the standard deviation of depth noise, metres, from second differences along rows.

    Half of those are on smooth ground in any picture of things, and their median is not moved by edges.

    >>> noise_of(np.array([[1.0, 1.0, 1.0, 1.0]]), np.ones((1, 4), dtype=bool))
    0.0
    """
    inside = mask[:, :-2] & mask[:, 1:-1] & mask[:, 2:]
    if not inside.any():
        return 0.0
    bent = (depth[:, :-2] - 2.0 * depth[:, 1:-1] + depth[:, 2:])[inside]
    return float(np.median(np.abs(bent)) / (0.6745 * np.sqrt(6.0)))


def smooth(depth: Array, mask: Mask, noise: float) -> Smoothed:
    """Return a thing's pixels with the noise of their depths averaged away.

    Parameters
    ----------
    depth : (h, w) float
        Metres; of a crop of the image around the thing.
    mask : (h, w) bool
        The thing's pixels that have a depth.
    noise : float
        Standard deviation of the depths, metres.
    """
    radius = int(np.clip(np.sqrt(np.count_nonzero(mask)) / 6.0, *WINDOW))
    step = _step(depth, mask, noise)
    reach = max(LAYER * noise, THINNEST, SLOPE * radius * step)
    # Where two faces meet no plane fits better than to half a pixel's step.
    rough = max(noise, CURVED, 0.5 * step)
    v, u = np.nonzero(mask)
    value = depth[v, u]
    everywhere = np.arange(len(u))
    crowd = Strip.of(u, v, np.zeros_like(u), _frames(u, v, everywhere[:1]), radius).crowd(everywhere)
    inner = _inner(mask)[v, u]
    fitted, error = np.full(len(u), np.nan), np.full(len(u), np.nan)
    for layers in _layers(u, v, value, reach, radius):
        pixel, own = layers.pixel, layers.own
        strip = Strip.of(u[pixel], v[pixel], layers.layer, layers.frames, radius)
        near, sure = value[pixel], inner[pixel]
        fit, spread, count = strip.fit(near, sure, np.arange(len(near)))
        # What flies drags its neighbours' fits along: once more without it, and with what fits of the border,
        # whose depths may be half those of what is beside it. Where all is border it has to do.
        likely = np.abs(near - fit) <= STRAY * np.sqrt(rough * rough + noise * noise * spread)
        use = np.where(count >= FEWEST, likely, sure | (count == 0.0))
        fit, spread, count = strip.fit(near, use, own)
        mine = pixel[own]
        good = (np.abs(value[mine] - fit) <= FAR_OFF * rough) & (count >= FEWEST)
        good &= strip.crowd(own) >= SUPPORT * crowd[mine]
        fitted[mine[good]] = fit[good]
        error[mine[good]] = noise * np.sqrt(spread[good])
    found = np.isfinite(fitted)
    return Smoothed(u[found], v[found], fitted[found], error[found], int(np.count_nonzero(~found)))


@dataclass(frozen=True, slots=True)
class _Layers:
    """Some layers of depth.

    Attributes
    ----------
    pixel, layer : (n,) int
        A pixel, by its position, and a layer that it is in, counted from 0, in rising order.
    own : (m,) int
        Where in these lists a pixel is in the layer whose middle it is nearest to, which decides on it.
    frames : (k, 4) int
        The first and last column and the first and last row of what the windows of each layer hold.
    """

    pixel: Index
    layer: Index
    own: Index
    frames: Index


def _layers(u: Index, v: Index, depth: Array, reach: float, radius: int) -> Iterator[_Layers]:
    """Yield layers of depth, which reach so far from their middles and overlap by half, some at a time."""
    low, high = float(depth.min()), float(depth.max())
    every = np.arange(len(u))
    crop = _frames(u, v, every[:1])
    if high - low <= 2.0 * reach:
        yield _Layers(every, np.zeros_like(u), every, crop)
        return
    level = (depth - low) / reach
    below, last = np.floor(level).astype(np.int64), int(level.max())
    nearest = np.minimum(np.floor(level + 0.5).astype(np.int64), last)
    pixel, layer = np.r_[every, every], np.r_[below, below + 1]
    order = np.argsort(layer, kind="stable")
    pixel, layer = pixel[order], layer[order]
    own = layer == nearest[pixel]
    known, start = np.unique(layer[own], return_index=True)
    frames = _frames(u[pixel[own]], v[pixel[own]], start)
    # As far as windows reach, and no further than there is anything.
    frames = np.clip(frames + radius * _OUTWARDS, crop[:, [0, 0, 2, 2]], crop[:, [1, 1, 3, 3]])
    rank = np.full(int(layer[-1]) + 1, -1)
    rank[known] = np.arange(len(known))
    layer = rank[layer]
    left, right, top, bottom = frames[layer].T
    keep = (layer >= 0) & (u[pixel] >= left) & (u[pixel] <= right) & (v[pixel] >= top) & (v[pixel] <= bottom)
    pixel, layer, own = pixel[keep], layer[keep], own[keep]
    size = (frames[:, 1] - frames[:, 0] + radius) * (frames[:, 3] - frames[:, 2] + 2 * radius)
    bounds = np.flatnonzero(np.diff(np.cumsum(size) // TOGETHER, prepend=-1))
    for first, last in pairwise([*bounds.tolist(), len(frames)]):
        part = slice(*np.searchsorted(layer, [first, last]))
        yield _Layers(pixel[part], layer[part] - first, np.flatnonzero(own[part]), frames[first:last])


def _frames(u: Index, v: Index, start: Index) -> Index:
    """Return the first and last column and row of some runs of pixels, (k, 4), by where each run starts."""
    ends = [ufunc.reduceat(one, start) for one in (u, v) for ufunc in (np.minimum, np.maximum)]
    return np.stack(ends, axis=1)


def _step(depth: Array, mask: Mask, noise: float) -> float:
    """Return by how much depth changes from one pixel to the next where it changes much, without noise."""
    steps = [0.0]
    for a, b, both in (
        (depth[1:], depth[:-1], mask[1:] & mask[:-1]),
        (depth[:, 1:], depth[:, :-1], mask[:, 1:] & mask[:, :-1]),
    ):
        if both.any():
            # Three quarters of the differences of two noises are below this.
            steps.append(float(np.quantile(np.abs(a - b)[both], 0.75)) - 1.63 * noise)
    return max(steps)


def _inner(mask: Mask) -> Mask:
    """Return the pixels of a mask without its border."""
    from scipy.ndimage import minimum_filter

    return np.asarray(minimum_filter(mask, 3, mode="constant", cval=False))
