"""Images: depths and instances from PNG and NPY files, of the size that was promised, or not at all."""

from __future__ import annotations

import tokenize
import warnings
from pathlib import Path
from typing import Any, Final

import numpy as np

from deixis.errors import MissingDependency, SceneError
from deixis.frames import Array, Index
from deixis.strict_json import quoted, read_bytes

KINDS: Final = (".png", ".npy")

MAX_PIXELS: Final = 32_000_000
"""Largest image that is decoded."""

MAX_FILE_BYTES: Final = 256 * 1024 * 1024
"""Longest image file that is read."""

# What numpy and Pillow were seen to raise on damaged files.
_DAMAGED: Final = (
    OSError,
    ValueError,
    EOFError,
    TypeError,
    SyntaxError,
    LookupError,
    ArithmeticError,
    MemoryError,
)

_DEEP: Final = ("I;16", "I;16B", "I")
_NUMBERED: Final = ("L", "P", *_DEEP)


def read_depth(path: Path, size: tuple[int, int], scale: float) -> Array:
    """Return a depth image in metres, (h, w); 0 where there is none.

    Parameters
    ----------
    path : Path
        A .png of 16 bits, or a .npy with metres.
    size : (int, int)
        Width and height that the camera has.
    scale : float
        Metres for each step of a .png.

    Raises
    ------
    SceneError
        The file is missing, damaged, of another size, or holds something else.
    """
    if path.suffix.lower() == ".png":
        return np.asarray(_png(path, size, _DEEP, "a depth image of 16 bits"), dtype=np.float64) * scale
    image = _npy(path, size)
    if image.dtype.kind != "f":
        raise SceneError(f"the file {quoted(path.name)} holds {image.dtype}: give depths as float metres")
    depth = np.array(image, dtype=np.float64)
    return np.where(np.isfinite(depth) & (depth > 0.0), depth, 0.0)


def read_instances(path: Path, size: tuple[int, int]) -> Index:
    """Return the number of the thing that each pixel shows, (h, w); raises as :func:`read_depth` does."""
    if path.suffix.lower() == ".png":
        numbers = _png(path, size, _NUMBERED, "an image of one number for each pixel")
        return np.asarray(numbers, dtype=np.int64)
    image = _npy(path, size)
    if image.dtype.kind not in "iu" or image.dtype.itemsize > 4:
        raise SceneError(
            f"the file {quoted(path.name)} holds {image.dtype}: give instances as whole numbers of 32 bits"
        )
    if image.size and image.min() < 0:
        raise SceneError(f"the file {quoted(path.name)} holds a negative instance: use 0 for none")
    return np.array(image, dtype=np.int64)


def _check_size(path: Path, found: tuple[int, ...], size: tuple[int, int]) -> None:
    if size[0] * size[1] > MAX_PIXELS:
        raise SceneError(
            f"an image of {size[0]} x {size[1]} is too large: the limit is {MAX_PIXELS:,} pixels"
        )
    if tuple(found) != size:
        has = " x ".join(map(str, found))
        raise SceneError(
            f"the file {quoted(path.name)} is {has}, the camera {size[0]} x {size[1]} pixels: give its own"
        )


def _png(path: Path, size: tuple[int, int], modes: tuple[str, ...], wanted: str) -> Any:
    try:
        from PIL import Image
    except ImportError as cause:
        raise MissingDependency("images need Pillow: pip install 'deixis[perception]'") from cause
    from io import BytesIO

    data = read_bytes(path, SceneError, MAX_FILE_BYTES, path.name)
    try:
        with warnings.catch_warnings():
            # The size is looked at below, before anything is decoded.
            warnings.simplefilter("ignore", Image.DecompressionBombWarning)
            image = Image.open(BytesIO(data), formats=["PNG"])
        _check_size(path, image.size, size)
        mode = image.mode
        pixels = np.asarray(image) if mode in modes else None
    except SceneError:
        raise
    except Image.DecompressionBombError as cause:
        raise SceneError(
            f"the file {quoted(path.name)} unfolds to too many pixels: give the camera's"
        ) from cause
    except _DAMAGED as cause:
        raise SceneError(f"the file {quoted(path.name)} is no sound PNG: {cause}") from cause
    if pixels is None:
        raise SceneError(f"the file {quoted(path.name)} is an image of the kind {mode}: give {wanted}")
    return pixels


def _npy(path: Path, size: tuple[int, int]) -> np.ndarray[Any, np.dtype[Any]]:
    if not path.is_file():
        raise SceneError(f"{quoted(path.name)} is not a file: give the path of one")
    try:
        # Mapped, not read: what the header promises costs nothing yet, and pickles are refused.
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", UserWarning)
            image = np.lib.format.open_memmap(path, mode="r")
    except (*_DAMAGED, tokenize.TokenError) as cause:
        raise SceneError(f"the file {quoted(path.name)} is no sound NPY: {cause}") from cause
    _check_size(path, image.shape[::-1], size)
    return image
