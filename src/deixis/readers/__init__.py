"""Readers: other people's formats to scenes, behind one registry.

A reader is a module with

``read(path, **options) -> Scene | Iterable[Scene]``
    its docstring's first line says what it reads, its keyword-only parameters are its options;
``sniff(head) -> bool`` (may be missing)
    whether a file that begins with these bytes looks like its format.

Another package adds its own by naming such a module as an entry point in the group ``deixis.readers``;
the name of the entry point is the name of the format. The formats that come with Deixis cannot be replaced.
"""

from __future__ import annotations

import difflib
import inspect
import os
from collections.abc import Iterator
from importlib import import_module
from importlib.metadata import EntryPoint, entry_points
from itertools import chain
from pathlib import Path
from types import ModuleType
from typing import Any, Final

from deixis.errors import ReaderError
from deixis.scene import Scene
from deixis.strict_json import quoted

GROUP: Final = "deixis.readers"

BUILT_IN: Final = {
    "deixis": "deixis.readers.native",
    "ithor": "deixis.readers.ithor",
    "virtualhome": "deixis.readers.virtualhome",
    "rdf": "deixis.rdf.reader",
}
"""Where they are; that of RDF stands above this layer, with all else of RDF."""

HEAD: Final = 65_536
"""Bytes of a file that a reader sees when asked whether it knows the format."""


def _found() -> dict[str, EntryPoint]:
    return {point.name: point for point in entry_points(group=GROUP) if point.name not in BUILT_IN}


def formats() -> tuple[str, ...]:
    """Return the names of all formats, those that come with Deixis first.

    >>> formats()[:3]
    ('deixis', 'ithor', 'virtualhome')
    """
    return (*BUILT_IN, *_added())


def _added() -> Iterator[str]:
    yield from sorted(_found())


def reader(name: str) -> ModuleType:
    """Return the module that reads a format, or raise :class:`ReaderError` with near misses."""
    if name in BUILT_IN:
        return import_module(BUILT_IN[name])
    point = _found().get(name)
    if point is None:
        near = difflib.get_close_matches(name, formats(), n=1)
        hint = f"did you mean {near[0]!r}?" if near else f"known are {', '.join(formats())}"
        raise ReaderError(f"unknown format {quoted(name)}: {hint}")
    try:
        module = point.load()
    except (ImportError, AttributeError) as cause:
        raise ReaderError(
            f"the reader of {quoted(name)}, {point.value}, cannot be loaded: {cause}"
        ) from cause
    if not callable(getattr(module, "read", None)):
        raise ReaderError(
            f"the reader of {quoted(name)}, {point.value}, has no function read: report it there"
        )
    return module  # type: ignore[no-any-return]


def read(name: str, path: str | os.PathLike[str], **options: Any) -> tuple[Scene, ...]:
    """Return the scenes in a file of the given format.

    Parameters
    ----------
    name : str
        One of :func:`formats`.
    path : path
        Of the file; some formats take ``file#part``.
    **options
        Of that reader.

    Returns
    -------
    tuple of Scene
        At least one.

    Raises
    ------
    ReaderError
        The format or an option is unknown, or the file is not of that format.
    SceneError
        The file says something that no scene may say; the message names the object.
    """
    module = reader(name)
    known = [
        option
        for option, parameter in inspect.signature(module.read).parameters.items()
        if parameter.kind is inspect.Parameter.KEYWORD_ONLY
    ]
    unknown = sorted(set(options) - set(known))
    if unknown:
        has = f"it has {', '.join(known)}" if known else "it has none"
        raise ReaderError(f"the reader of {quoted(name)} has no option {quoted(unknown[0])}: {has}")
    result = module.read(path, **options)
    scenes = (result,) if isinstance(result, Scene) else tuple(result)
    if not scenes:
        raise ReaderError(f"{quoted(str(path), 200)} holds no scene: give a file that does")
    return scenes


def read_one(name: str, path: str | os.PathLike[str], **options: Any) -> Scene:
    """Return the one scene in a file, or raise :class:`ReaderError` naming the choices."""
    scenes = read(name, path, **options)
    if len(scenes) > 1:
        ids = ", ".join(scene.id for scene in scenes)
        raise ReaderError(f"{quoted(str(path), 200)} holds {len(scenes)} scenes: add # and one of {ids}")
    return scenes[0]


def sniff(path: str | os.PathLike[str]) -> str | None:
    """Return the name of the first format that knows the file's beginning, or None.

    Raises
    ------
    ReaderError
        The file cannot be read.
    """
    try:
        with Path(path).open("rb") as file:
            head = file.read(HEAD)
    except OSError as cause:
        raise ReaderError(f"{quoted(str(path), 200)} cannot be read: {cause.strerror}") from cause
    # Looking for those of other packages takes longer than reading a room.
    for name in chain(BUILT_IN, _added()):
        knows = getattr(reader(name), "sniff", None)
        if knows is not None and knows(head):
            return name
    return None
