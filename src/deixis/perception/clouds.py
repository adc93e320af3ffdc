"""Clouds: labelled points from PLY, PCD and NPZ files, part by part, however many there are.

Binary files are looked at where they lie: their header is compared with their length first, and then some
hundred thousand points are taken at a time. Files that must be unfolded whole (text, compressed PCD) may
not be longer than a stated limit.
"""

from __future__ import annotations

import struct
import tokenize
import warnings
import zipfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np

from deixis.errors import MissingDependency, SceneError
from deixis.frames import Array, Index
from deixis.strict_json import quoted

KINDS: Final = (".ply", ".pcd", ".npz")

CHUNK: Final = 1 << 19
"""Points taken at a time."""

MAX_POINTS: Final = 500_000_000
"""Most points of a file."""

MAX_WHOLE: Final = 256 * 1024 * 1024
"""Bytes of what must be unfolded whole."""

HEADER: Final = 1 << 16
"""Bytes in which a header must end."""

INSTANCE_FIELDS: Final = ("instance", "instance_id", "instances", "object_id", "objectId", "label")
"""What the field with the instances may be called, the first there is."""

Rows = np.ndarray[Any, np.dtype[Any]]
Part = tuple[Array, Index]

_PLY_TYPES: Final = {
    "char": "i1", "int8": "i1", "uchar": "u1", "uint8": "u1", "short": "i2", "int16": "i2",
    "ushort": "u2", "uint16": "u2", "int": "i4", "int32": "i4", "uint": "u4", "uint32": "u4",
    "float": "f4", "float32": "f4", "double": "f8", "float64": "f8",
}  # fmt: skip

# What numpy, pypcd4 and zipfile were seen to raise on damaged files.
_DAMAGED: Final = (
    OSError, ValueError, LookupError, TypeError, EOFError, RuntimeError, ArithmeticError, SyntaxError,
    AttributeError, NotImplementedError, MemoryError, struct.error, zipfile.BadZipFile, tokenize.TokenError,
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class CloudFile:
    """A file of points that may be read part by part.

    Attributes
    ----------
    name : str
        Quoted, for messages.
    size : int
        Points.
    parts : function
        Returns an iterator over (points (m, 3) float, instances (m,) int); numbers are all checked.
    """

    name: str
    size: int
    parts: Callable[[], Iterator[Part]]


def open_cloud(path: Path) -> CloudFile:
    """Return a cloud file, its header compared with its length.

    Raises
    ------
    SceneError
        The file is missing, damaged, of another kind, says more than it holds, or has no instances.
    """
    name = quoted(path.name)
    if not path.is_file():
        raise SceneError(f"{name} is not a file: give the path of one")
    try:
        size, raw = _OPEN[path.suffix.lower()](path)
    except SceneError as cause:
        raise SceneError(f"the file {name}: {cause}") from cause
    except _DAMAGED as cause:
        raise SceneError(f"the file {name} is no sound {path.suffix.lower()} file: {cause}") from cause
    if not 0 < size <= MAX_POINTS:
        raise SceneError(f"the file {name} holds {size:,} points: give 1 to {MAX_POINTS:,}")

    def parts() -> Iterator[Part]:
        count = 0
        try:
            for points, instances in raw():
                count += len(points)
                yield _checked(np.asarray(points, dtype=np.float64), np.asarray(instances))
        except SceneError as cause:
            raise SceneError(f"the file {name}: {cause}") from cause
        except _DAMAGED as cause:
            raise SceneError(f"the file {name} is damaged after {count:,} points: {cause}") from cause
        if count != size:
            raise SceneError(f"the file {name} holds {count:,} points, not {size:,}: repair it")

    return CloudFile(name, size, parts)


def _checked(points: Array, instances: Rows) -> Part:
    if not np.isfinite(points).all():
        # Sensors write what they did not see as NaN.
        good = np.isfinite(points).all(axis=1)
        points, instances = points[good], instances[good]
    if instances.dtype.kind == "f" and not (
        np.isfinite(instances).all() and (instances == np.rint(instances)).all()
    ):
        raise SceneError("an instance is no whole number: give 0 for none, and 1 or more")
    numbers = instances.astype(np.int64)
    if len(numbers) and (numbers.min() < 0 or numbers.max() > 2**31 - 1):
        raise SceneError("an instance is negative or beyond 31 bits: give 0 for none, and 1 or more")
    return points, numbers


def _instance_field(names: tuple[str, ...]) -> str:
    found = [name for name in INSTANCE_FIELDS if name in names]
    if not found or not {"x", "y", "z"} <= set(names):
        raise SceneError(f"its fields are {', '.join(names)}: give x, y, z and instance")
    return found[0]


def _records(rows: Rows) -> Iterator[tuple[Rows, Rows]]:
    """Yield the parts of an array of records."""
    field = _instance_field(rows.dtype.names or ())
    for start in range(0, len(rows), CHUNK):
        part = rows[start : start + CHUNK]
        yield np.stack([part["x"], part["y"], part["z"]], axis=1).astype(np.float64), part[field]


def _binary(
    path: Path, kind: np.dtype[Any], offset: int, size: int
) -> tuple[int, Callable[[], Iterator[tuple[Rows, Rows]]]]:
    """Return the number of records in a file from an offset on, and an iterator over them."""
    if size < 1 or offset + size * kind.itemsize > path.stat().st_size:
        raise ValueError(f"it declares {size:,} points of {kind.itemsize} bytes, and is shorter")

    def raw() -> Iterator[tuple[Rows, Rows]]:
        with path.open("rb") as file:
            file.seek(offset)
            for start in range(0, size, CHUNK):
                yield from _records(np.fromfile(file, kind, min(CHUNK, size - start)))

    return size, raw


def _open_ply(path: Path) -> tuple[int, Callable[[], Iterator[tuple[Rows, Rows]]]]:
    with path.open("rb") as file:
        head = file.read(HEADER)
    end = head.find(b"end_header")
    after = head.find(b"\n", end) + 1
    if not head.startswith(b"ply") or end < 0 or after == 0:
        raise ValueError("its header is missing")
    form, element, size, fields = "", "", -1, list[tuple[str, str]]()
    for line in head[:end].decode("ascii").splitlines():
        match line.split():
            case ["format", form, _]:
                pass
            case ["element", element, number]:
                if size < 0 and element != "vertex":
                    raise ValueError("its vertices do not come first")
                size = int(number) if element == "vertex" else size
            case ["property", "list", *_] if element == "vertex":
                raise ValueError("its vertices have lists")
            case ["property", kind, name] if element == "vertex":
                fields.append((name, _PLY_TYPES[kind]))
    _instance_field(tuple(name for name, _ in fields))
    if form == "ascii":
        return size, lambda: _text(path, after, size, fields)
    order = {"binary_little_endian": "<", "binary_big_endian": ">"}[form]
    return _binary(path, np.dtype([(name, order + kind) for name, kind in fields]), after, size)


def _text(path: Path, after: int, size: int, fields: list[tuple[str, str]]) -> Iterator[tuple[Rows, Rows]]:
    """Yield the points of a text, some lines at a time."""
    left = size
    with path.open("rb") as file:
        file.seek(after)
        while left > 0:
            some = min(left, CHUNK)
            with warnings.catch_warnings():
                # That there is nothing more is said below.
                warnings.simplefilter("ignore", UserWarning)
                part = np.atleast_1d(np.loadtxt(file, np.dtype(fields), max_rows=some, comments=None))
            if len(part) == 0:
                return
            left -= len(part)
            yield from _records(part)


def _open_pcd(path: Path) -> tuple[int, Callable[[], Iterator[tuple[Rows, Rows]]]]:
    try:
        from pypcd4.pypcd4 import Encoding, MetaData, PointCloud
    except ImportError as cause:
        raise MissingDependency("PCD files need pypcd4: pip install 'deixis[perception]'") from cause
    with path.open("rb") as file:
        head = file.read(HEADER)
    data = head.find(b"\nDATA ")
    after = head.find(b"\n", data + 1) + 1
    if data < 0 or after == 0:
        raise ValueError("its header is missing")
    told = MetaData.parse_header(head[:after].decode("ascii").splitlines())
    kind = told.build_dtype()
    _instance_field(kind.names or ())
    if told.data == Encoding.BINARY:
        return _binary(path, kind, after, told.points)
    length = path.stat().st_size
    unfolded = length
    if told.data == Encoding.BINARY_COMPRESSED:
        packed, unfolded = struct.unpack_from("<II", head, after)
        if after + 8 + packed > length or unfolded != told.points * kind.itemsize:
            raise ValueError("its lengths are not those of its points")
    if max(length, unfolded, told.points * kind.itemsize) > MAX_WHOLE:
        raise SceneError(f"it unfolds to more than {MAX_WHOLE:,} bytes: save it as binary")
    if told.data == Encoding.ASCII and 2 * told.points > length:
        raise ValueError("it declares more than it is long")
    return told.points, lambda: _records(PointCloud.from_path(path).pc_data)


def _open_npz(path: Path) -> tuple[int, Callable[[], Iterator[tuple[Rows, Rows]]]]:
    with zipfile.ZipFile(path) as archive:
        points, instances = (_member(archive, name) for name in ("points", "instances"))
    if len(points[0]) != 2 or points[0][1] != 3 or points[1].kind != "f":
        raise SceneError(f"its points have the shape {points[0]} of {points[1]}: give (n, 3) floats")
    if instances[0] != points[0][:1] or instances[1].kind not in "iu":
        raise SceneError(
            f"its instances have the shape {instances[0]} of {instances[1]}: give (n,) whole numbers"
        )
    size = int(points[0][0])

    def raw() -> Iterator[tuple[Rows, Rows]]:
        with (
            zipfile.ZipFile(path) as archive,
            archive.open("points.npy") as one,
            archive.open("instances.npy") as other,
        ):
            _header(one), _header(other)
            for start in range(0, size, CHUNK):
                count = min(CHUNK, size - start)
                yield (
                    _taken(one, points[1], 3 * count).reshape(count, 3),
                    _taken(other, instances[1], count),
                )

    return size, raw


def _header(file: Any) -> tuple[tuple[int, ...], bool, np.dtype[Any]]:
    version = np.lib.format.read_magic(file)
    read = {(1, 0): np.lib.format.read_array_header_1_0, (2, 0): np.lib.format.read_array_header_2_0}[version]
    found: tuple[tuple[int, ...], bool, np.dtype[Any]] = read(file)
    return found


def _member(archive: zipfile.ZipFile, name: str) -> tuple[tuple[int, ...], np.dtype[Any]]:
    """Return the shape and the type of an array in an archive, once it is as long as both say."""
    if f"{name}.npy" not in archive.namelist():
        raise SceneError(f"it has no array {name!r}: give points and instances")
    with archive.open(f"{name}.npy") as file:
        shape, by_column, kind = _header(file)
        start = file.tell()
    if kind.hasobject:
        raise SceneError(f"its {name} are Python objects, which are not read: give numbers")
    if by_column and len(shape) > 1:
        raise SceneError(f"its {name} lie column by column: save numpy.ascontiguousarray of them")
    if archive.getinfo(f"{name}.npy").file_size != start + kind.itemsize * int(np.prod(shape, dtype=object)):
        raise ValueError(f"its {name} are not as long as they say")
    return shape, kind


def _taken(file: Any, kind: np.dtype[Any], count: int) -> Rows:
    data = file.read(count * kind.itemsize)
    if len(data) != count * kind.itemsize:
        raise ValueError("it ends too early")
    return np.frombuffer(data, kind)


_OPEN: Final = {".ply": _open_ply, ".pcd": _open_pcd, ".npz": _open_npz}
