"""Scene format v1, the library's own."""

from __future__ import annotations

import os
import re
from typing import Final

from deixis.scene import Scene

_VERSION: Final = re.compile(rb'"deixis"\s*:\s*\d')


def read(path: str | os.PathLike[str]) -> Scene:
    """Return the scene in a file of scene format v1."""
    return Scene.load(path)


def sniff(head: bytes) -> bool:
    """Return whether a file begins like a scene of this format.

    >>> sniff(b'{"deixis": 1, "id": "room"')
    True
    """
    return head.lstrip(b"\xef\xbb\xbf \t\r\n").startswith(b"{") and _VERSION.search(head) is not None
