"""Strips: planes fitted to the inverse depths around pixels, for many layers of depth at once.

The inverse depth of a plane is linear in pixel coordinates, whatever way the plane faces. So around a pixel a
linear function is fitted to the pixels of a window, by sums of their moments. A window holds pixels of one
layer only. Layers are many and small: they are laid side by side on one strip and summed together.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from deixis.frames import Array, Index, Mask

_RIDGE: Final = 0.05
"""Square pixels added to a window's spread: a line of pixels has no slope across it."""


@dataclass(frozen=True, slots=True)
class Strip:
    """Pixels of some layers, each layer an image beside the others, a window's radius from the next.

    Attributes
    ----------
    layer : (n,) int
        Which layer each pixel is in, counted from 0.
    row, column : (n,) int
        Where it lies on the strip.
    x, y : (n,) int
        Pixels from the middle of its layer.
    across : (w,) float32
        ``x`` of each column of the strip.
    height : int
        Rows of the strip.
    radius : int
        Of windows, pixels.
    """

    layer: Index
    row: Index
    column: Index
    x: Index
    y: Index
    across: NDArray[np.float32]
    height: int
    radius: int

    @classmethod
    def of(cls, u: Index, v: Index, layer: Index, frames: Index, radius: int) -> Strip:
        """Return the strip of pixels with these columns, rows and layers.

        Parameters
        ----------
        u, v, layer : (n,) int
        frames : (k, 4) int
            The first and last column and the first and last row of each layer.
        radius : int
        """
        left, right, top, bottom = frames.T
        width = right - left + 1 + radius
        start = np.cumsum(width) - width
        # Whole numbers: sums of their products are exact.
        middle = (right - left) // 2
        across = np.zeros(radius + int(width.sum()), dtype=np.float32)
        across[radius:] = np.arange(int(width.sum())) - np.repeat(start + middle, width)
        x, row = u - left[layer], v - top[layer]
        return cls(
            layer,
            row + radius,
            x + start[layer] + radius,
            x - middle[layer],
            row - (bottom - top)[layer] // 2,
            across,
            int((bottom - top).max()) + 1,
            radius,
        )

    def fit(self, depth: Array, use: Mask, at: Index) -> tuple[Array, Array, Array]:
        """Return the depth fitted at some pixels, its variance in units of the noise's, and the pixels used.

        Parameters
        ----------
        depth : (n,) float
            Metres.
        use : (n,) bool
            Pixels that have a part in fits.
        at : (m,) int
            Pixels that are fitted, by their positions.
        """
        weight = use.astype(np.float64)
        inverse = np.divide(1.0, depth, out=np.zeros_like(depth), where=use)
        level = np.bincount(self.layer, inverse) / np.maximum(np.bincount(self.layer, weight), 1.0)
        level = level[self.layer]
        # Less its mean, so that sums lose no digits.
        inverse -= level * weight
        y = self.y
        # Down a column x is the same: what it multiplies is summed before.
        w, wy, wyy, q, qy = self._columns(weight, weight * y, weight * y * y, inverse, inverse * y)
        x = self.across
        wx = w * x
        sums = self._windows(np.stack([w, wx, wy, wx * x, wy * x, wyy, q, q * x, qy]), at)
        count = sums[0]
        with np.errstate(divide="ignore", invalid="ignore"):
            mx, my, xx, xy, yy, mq, xq, yq = sums[1:] / count
            xx += _RIDGE - mx * mx
            yy += _RIDGE - my * my
            xy -= mx * my
            xq -= mx * mq
            yq -= my * mq
            dx, dy = self.x[at] - mx, self.y[at] - my
            scale = xx * yy - xy * xy
            # Row of the inverse of the spread times where the pixel is off the window's middle.
            px, py = (yy * dx - xy * dy) / scale, (xx * dy - xy * dx) / scale
            fit = 1.0 / (level[at] + mq + px * xq + py * yq)
            spread = (1.0 + px * dx + py * dy) / count
        return fit, spread, count

    def crowd(self, at: Index) -> Array:
        """Return how many pixels there are in the windows around some."""
        return np.asarray(self._windows(self._columns(np.ones(len(self.row))), at)[0])

    def _columns(self, *values: Array) -> NDArray[np.float32]:
        """Return sums of pixels' values down the columns of windows, (k, height, w)."""
        images = np.zeros((len(values), self.height + 2 * self.radius, len(self.across)), dtype=np.float32)
        for image, value in zip(images, values, strict=True):
            image[self.row, self.column] = value
        return _added(images, 2 * self.radius + 1)

    def _windows(self, tall: NDArray[np.float32], at: Index) -> Array:
        """Return sums over windows around some pixels, of images that are sums down their columns."""
        sums = _added(tall.swapaxes(1, 2), 2 * self.radius + 1).swapaxes(1, 2)
        return sums[:, self.row[at] - self.radius, self.column[at] - self.radius].astype(np.float64)


def _added(images: NDArray[np.float32], size: int) -> NDArray[np.float32]:
    """Return sums of so many rows each, of images one after the other: by sums of two, four and eight.

    >>> _added(np.arange(6, dtype=np.float32).reshape(1, 6, 1), 3).ravel().tolist()
    [3.0, 6.0, 9.0, 12.0]
    """
    rows = images.shape[1] - size + 1
    total = images[:, :rows].copy(order="K") if size & 1 else np.zeros_like(images[:, :rows])
    start, span, part = size & 1, 1, images
    while 2 * span <= size:
        part = part[:, :-span] + part[:, span:]
        span *= 2
        if size & span:
            total += part[:, start : start + rows]
            start += span
    return total
