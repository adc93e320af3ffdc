"""Smoothing: the depth noise of a thing's pixels averaged away, never across a depth edge.

The inverse depth of a plane is linear in pixel coordinates, whatever way the plane faces. So around each
pixel a linear function is fitted to the inverse depths of its neighbours, by moments from running sums:
only of those in the same mask and about as deep. Layers of depth that overlap by half take the place of
one such choice for each pixel. What the fit says replaces what was measured, with a standard error; a
pixel with few neighbours as deep as itself, or far from their fit, is no part of the thing.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from deixis.frames import Array, Index, Mask

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

_RIDGE: Final = 0.05
"""Square pixels added to a window's spread: a line of pixels has no slope across it."""


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
    value = depth[mask]
    low, high = float(value.min()), float(value.max())
    if high - low <= 2.0 * reach:
        middles = [0.5 * (low + high)]
        half = np.inf
    else:
        middles = (low + reach * np.arange(int((high - low) / reach) + 1)).tolist()
        half = 0.5 * reach
    fitted, error = np.full(depth.shape, np.nan), np.full(depth.shape, np.nan)
    crowd = _window_sums(mask.astype(np.float64), radius)
    sure = _inner(mask)
    for middle in middles:
        own = mask & (depth >= middle - half) & (depth < middle + half)
        if not own.any():
            continue
        rows, columns = np.flatnonzero(own.any(axis=1)), np.flatnonzero(own.any(axis=0))
        part = (
            slice(max(rows[0] - radius, 0), rows[-1] + radius + 1),
            slice(max(columns[0] - radius, 0), columns[-1] + radius + 1),
        )
        near = mask[part] & (np.abs(depth[part] - middle) <= reach)
        _fit_layer(
            depth[part],
            near,
            sure[part],
            own[part],
            crowd[part],
            (noise, rough),
            radius,
            fitted[part],
            error[part],
        )
    good = mask & np.isfinite(fitted)
    v, u = np.nonzero(good)
    return Smoothed(
        u,
        v,
        fitted[good],
        error[good],
        int(np.count_nonzero(mask) - len(u)),
    )


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
    """Return the pixels of a mask without its border, whose depths may be half those of what is beside it."""
    from scipy.ndimage import minimum_filter

    return np.asarray(minimum_filter(mask, 3, mode="constant", cval=False))


def _fit_layer(
    depth: Array,
    near: Mask,
    sure: Mask,
    own: Mask,
    crowd: Array,
    noises: tuple[float, float],
    radius: int,
    fitted: Array,
    error: Array,
) -> None:
    """Write the fits of a layer's own pixels into the last two arrays; leave out what is not supported.

    Pixels of the border have a part in a fit only where they agree with one without them. The noises are
    that of the depths, and that with what a plane cannot follow.
    """
    noise, floor = noises
    support = _window_sums(near.astype(np.float64), radius)
    inner = near & sure
    fit, spread, count = _plane_fit(depth, inner, radius)
    # What flies drags its neighbours' fits along: once more without it, and with what fits of the border.
    known = count >= FEWEST
    likely = np.abs(depth - fit) <= STRAY * np.sqrt(floor * floor + noise * noise * spread)
    use = near & np.where(known, likely, inner | ~_grown(inner, radius))
    fit, spread, count = _plane_fit(depth, use, radius)
    good = own & (np.abs(depth - fit) <= FAR_OFF * floor) & (count >= FEWEST) & (support >= SUPPORT * crowd)
    fitted[good] = fit[good]
    error[good] = noise * np.sqrt(spread[good])


def _grown(mask: Mask, radius: int) -> Mask:
    from scipy.ndimage import maximum_filter

    return np.asarray(maximum_filter(mask, 2 * radius + 1, mode="constant", cval=False))


def _window_sums(images: Array, radius: int) -> Array:
    """Return the sums over square windows around each pixel of some images; beyond the border is nothing."""
    *many, rows, columns = images.shape
    size = 2 * radius + 1
    # Down the columns row is added to row, for as many rows as a window has; along them by running sums.
    padded = np.zeros((*many, rows + 2 * radius, columns + size))
    padded[..., radius : radius + rows, radius + 1 : radius + 1 + columns] = images
    tall = padded[..., :rows, :].copy()
    for down in range(1, size):
        tall += padded[..., down : down + rows, :]
    np.cumsum(tall, axis=-1, out=tall)
    return np.asarray(tall[..., size:] - tall[..., :columns])


def _plane_fit(depth: Array, near: Mask, radius: int) -> tuple[Array, Array, Array]:
    """Return the fitted depth, its variance in units of the noise's, and the number of pixels used."""
    rows, columns = depth.shape
    x = np.arange(columns) - 0.5 * (columns - 1)
    y = (np.arange(rows) - 0.5 * (rows - 1))[:, None]
    weight = near.astype(np.float64)
    inverse = np.divide(1.0, depth, out=np.zeros_like(depth), where=near)
    level = float(inverse.sum() / max(np.count_nonzero(near), 1))
    # Less its mean, so that sums of squares lose no digits.
    inverse -= level * weight
    wx, wy = weight * x, weight * y
    sums = _window_sums(
        np.stack([weight, wx, wy, wx * x, wx * y, wy * y, inverse, inverse * x, inverse * y]), radius
    )
    count = np.rint(sums[0])
    with np.errstate(divide="ignore", invalid="ignore"):
        mx, my, xx, xy, yy, mq, xq, yq = (one / count for one in sums[1:])
        xx += _RIDGE - mx * mx
        yy += _RIDGE - my * my
        xy -= mx * my
        xq -= mx * mq
        yq -= my * mq
        dx, dy = x - mx, y - my
        scale = xx * yy - xy * xy
        # Row of the inverse of the spread times where the pixel is off the window's middle.
        px, py = (yy * dx - xy * dy) / scale, (xx * dy - xy * dx) / scale
        fit = 1.0 / (level + mq + px * xq + py * yq)
        spread = (1.0 + px * dx + py * dy) / count
    return fit, spread, count
