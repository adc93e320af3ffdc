"""Point and mesh files: a short list of formats, each checked against its own header before it is trusted.

A loader that believes a header may answer an empty scene, a cloud of one point, or ask for 20 GB. So
declared counts are compared with the size of the file first, and with what was loaded afterwards.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Collection
from io import BytesIO
from pathlib import Path, PurePosixPath, PureWindowsPath
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from deixis.errors import SceneError
from deixis.frames import Array
from deixis.strict_json import parse, quoted, read_bytes

MAX_FILE_BYTES: Final = 256 * 1024 * 1024
"""Largest point or mesh file that is read."""

MAX_VERTICES: Final = 20_000_000
"""Most vertices a file may unfold to (a glTF mesh may stand in many places)."""

_PLY_BYTES: Final = {
    **dict.fromkeys(("char", "uchar", "int8", "uint8"), 1),
    **dict.fromkeys(("short", "ushort", "int16", "uint16"), 2),
    **dict.fromkeys(("int", "uint", "float", "int32", "uint32", "float32"), 4),
    **dict.fromkeys(("double", "float64"), 8),
}

_GLTF_BYTES: Final = {5120: 1, 5121: 1, 5122: 2, 5123: 2, 5125: 4, 5126: 4}
_GLTF_WIDTH: Final = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}

# What trimesh was seen to raise on damaged files, from arithmetic to its own parsers.
_LOADER_ERRORS: Final = (
    ValueError, LookupError, TypeError, AttributeError, NameError, ArithmeticError, AssertionError,
    NotImplementedError, RuntimeError, EOFError, ImportError, MemoryError, struct.error,
)  # fmt: skip


def locate(name: str, folder: Path | None, kinds: Collection[str] = (), what: str = "scene") -> Path:
    """Return the path of a file named in a scene: relative, and inside the scene's folder.

    Parameters
    ----------
    name : str
    folder : Path or None
    kinds : collection of str
        Extensions that are read; without any, those of point and mesh files.
    what : str
        What the file is named in.

    Raises
    ------
    SceneError
        The name is absolute, a URL, leaves the folder, or has an extension that is not read.
    """
    if folder is None:
        raise SceneError(f"the file {quoted(name)} has no folder to be in: give base, or load a {what} file")
    posix, windows = PurePosixPath(name), PureWindowsPath(name)
    foreign = "://" in name or "\\" in name or "\0" in name or windows.drive
    if foreign or posix.is_absolute() or ".." in posix.parts:
        raise SceneError(f"the file {quoted(name)} is not a path inside the {what}'s folder: put it there")
    kinds = kinds or _CHECKS
    if posix.suffix.lower() not in kinds:
        raise SceneError(f"the file {quoted(name)} is of no kind that is read: use {', '.join(kinds)}")
    try:
        root = folder.resolve()
        path = (root / posix).resolve()
    except (OSError, RuntimeError) as cause:
        raise SceneError(f"the file {quoted(name)} cannot be found: check its links") from cause
    if not path.is_relative_to(root):
        raise SceneError(f"the file {quoted(name)} links out of the {what}'s folder: put it there")
    return path


def read_geometry(path: Path) -> tuple[Array, NDArray[np.int64]]:
    """Return the vertices, metres as they are in the file, and the triangles of a point or mesh file.

    Parameters
    ----------
    path : Path
        A .ply, .obj, .stl, .glb or .off file.

    Returns
    -------
    vertices : (m, 3) float
        At least one, all finite.
    faces : (k, 3) int
        None for a point cloud.

    Raises
    ------
    SceneError
        The file is missing, too long, empty, damaged, or says something else than it holds.
    """
    data = read_bytes(path, SceneError, MAX_FILE_BYTES, path.name)
    name = quoted(path.name)
    kind = path.suffix.lower()
    try:
        declared = _CHECKS[kind](data)
    except (SceneError, ValueError, LookupError, TypeError, AttributeError, struct.error) as cause:
        raise SceneError(f"the file {name} is no sound {kind} file: {cause}") from cause
    if declared > MAX_VERTICES:
        raise SceneError(f"the file {name} holds {declared:,} vertices, above {MAX_VERTICES:,}: thin it out")
    import trimesh

    try:
        scene = trimesh.load_scene(BytesIO(data), file_type=kind[1:], process=False, skip_materials=True)
        vertices, faces = _gathered(scene)
    except _LOADER_ERRORS as cause:
        raise SceneError(f"the file {name} is no sound {kind} file: {cause}") from cause
    if len(vertices) == 0:
        raise SceneError(f"the file {name} holds no point: give one that does, or drop the object")
    if not np.isfinite(vertices).all():
        raise SceneError(f"the file {name} holds a coordinate that is not finite: drop such points")
    if len(vertices) < declared:
        raise SceneError(f"the file {name} declares {declared:,} vertices, has {len(vertices):,}: repair it")
    return vertices, faces


def _gathered(scene: Any) -> tuple[Array, NDArray[np.int64]]:
    """Return all vertices and faces of a loaded scene, every part where it stands."""
    points, triangles, offset = [np.empty((0, 3))], [np.empty((0, 3), dtype=np.int64)], 0
    for node in scene.graph.nodes_geometry:
        matrix, geometry = scene.graph[node]
        part = scene.geometry[geometry]
        vertices = np.asarray(part.vertices, dtype=np.float64)
        points.append(vertices @ matrix[:3, :3].T + matrix[:3, 3])
        faces = getattr(part, "faces", None)
        if faces is not None:
            triangles.append(np.asarray(faces, dtype=np.int64) + offset)
        offset += len(vertices)
    return np.concatenate(points), np.concatenate(triangles)


def _check_ply(data: bytes) -> int:
    """Return the number of vertices a PLY header declares, once the body is long enough for all of it."""
    end = data.find(b"end_header", 0, 1 << 16)
    if not data.startswith((b"ply\n", b"ply\r")) or end < 0:
        raise ValueError("its header is missing")
    lines = data[:end].decode("ascii").splitlines()
    text = "format ascii 1.0" in lines
    names: list[str] = []
    counts: list[int] = []
    widths: list[int] = []
    for line in lines:
        match line.split():
            case ["element", name, number]:
                names.append(name)
                counts.append(int(number))
                widths.append(0)
            case ["property", "list", kind, _, _] | ["property", kind, _]:
                # At least the length of a list, or one digit and a blank: a lower bound is enough.
                widths[-1] += 2 if text else _PLY_BYTES[kind]
    if min(counts, default=0) < 0:
        raise ValueError("a declared count is negative")
    needed = sum(count * width for count, width in zip(counts, widths, strict=True))
    # A last text row may end without its newline.
    if needed > len(data) - end - len("end_header") + 1:
        raise ValueError("it declares more than it is long")
    return sum(count for name, count in zip(names, counts, strict=True) if name == "vertex")


def _check_stl(data: bytes) -> int:
    if len(data) >= 84 and len(data) == 84 + 50 * int(struct.unpack_from("<I", data, 80)[0]):
        return 3 * int(struct.unpack_from("<I", data, 80)[0])
    if data.lstrip()[:5].lower() != b"solid":
        raise ValueError("its length is not that of the triangles it declares")
    lower = data.lower()
    corners = lower.count(b"vertex")
    if b"endsolid" not in lower or corners != 3 * lower.count(b"endfacet"):
        raise ValueError("its triangles are not complete")
    return corners


def _check_obj(data: bytes) -> int:
    if b"\0" in data:
        raise ValueError("it is not a text")
    # Vertices that no face uses may be dropped and others doubled: only emptiness can be told from outside.
    return 1


def _check_off(data: bytes) -> int:
    text = data.decode("utf-8")
    words = [word for line in text.splitlines() for word in line.split("#")[0].split()[:3]][:4]
    if not words or not words[0].upper().endswith("OFF"):
        raise ValueError("it does not begin with OFF")
    vertices, faces = int(words[1]), int(words[2])
    if min(vertices, faces) < 0 or 6 * vertices + 8 * faces > len(data):
        raise ValueError("it declares more than it is long")
    return vertices


def _check_glb(data: bytes) -> int:
    """Return the number of vertices a GLB unfolds to, once all it declares lies within the file."""
    magic, version, length, size, chunk = struct.unpack_from("<4sIII4s", data)
    if magic != b"glTF" or version != 2 or length != len(data) or chunk != b"JSON" or 20 + size > length:
        raise ValueError("its header does not fit a GLB 2.0 of this length")
    head = parse(data[20 : 20 + size], SceneError, "its JSON chunk")
    binary = len(data) - 20 - size
    views, accessors = head.get("bufferViews", []), head.get("accessors", [])
    if any("uri" in part for part in (*head.get("buffers", []), *head.get("images", []))):
        raise ValueError("it refers to other files; export it as one file")
    spans = [(view.get("byteOffset", 0), view["byteLength"]) for view in views]
    if any(start < 0 or count < 0 or start + count > binary for start, count in spans):
        raise ValueError("a buffer view lies outside the file")
    for accessor in accessors:
        width = _GLTF_BYTES[accessor["componentType"]] * _GLTF_WIDTH[accessor["type"]]
        if "sparse" in accessor or "bufferView" not in accessor:
            raise ValueError("it has sparse accessors, which are not read")
        if accessor["count"] < 0 or accessor["count"] * width > views[accessor["bufferView"]]["byteLength"]:
            raise ValueError("an accessor is longer than its buffer view")
    nodes = head.get("nodes", [])
    children = [child for node in nodes for child in node.get("children", [])]
    if len(set(children)) != len(children) or any(not 0 <= child < len(nodes) for child in children):
        raise ValueError("its nodes are not a tree")
    points = [
        sum(accessors[part["attributes"]["POSITION"]]["count"] for part in mesh["primitives"])
        for mesh in head.get("meshes", [])
    ]
    total = sum(points[node["mesh"]] for node in nodes if "mesh" in node)
    if total > MAX_VERTICES:
        return int(total)
    # Nodes outside the default scene are not loaded, so no count can be insisted on.
    return 1


_CHECKS: Final[dict[str, Callable[[bytes], int]]] = {
    ".ply": _check_ply,
    ".obj": _check_obj,
    ".stl": _check_stl,
    ".glb": _check_glb,
    ".off": _check_off,
}
