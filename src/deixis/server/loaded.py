"""A scene as it is served, and what stays the same of it while it changes."""

from __future__ import annotations

import asyncio
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Self

from deixis.server.children import Answer
from deixis.server.events import Events


@dataclass(slots=True, eq=False)
class Loaded:
    """A scene from one event to the next.

    Attributes
    ----------
    told : dict
        What is said of it in lists.
    text : bytes
        It, as JSON.
    graphs : dict
        The names of its graphs.
    quads : bytes or None
        What is in them; None until it is asked for.
    event : str
        The id of the event that made it what it is.
    failed : tuple of float and str, or None
        When its graphs could not be made, and why.
    page : asyncio.Task or None
        What makes the data of its page, or has made them: all pages that are open ask at the same time.
    """

    told: dict[str, Any]
    text: bytes
    graphs: dict[str, str]
    quads: bytes | None = None
    event: str = ""
    failed: tuple[float, str] | None = None
    page: asyncio.Task[Answer] | None = None

    @classmethod
    def of(cls, header: Mapping[str, Any], text: bytes, quads: bytes | None = None) -> Self:
        """Return what a process told of a scene."""
        told = {key: header[key] for key in ("id", "objects", "views", "notes")}
        return cls(told, text, header["graphs"], quads)


class Life:
    """What belongs to a scene for as long as it is served, whatever becomes of it.

    Parameters
    ----------
    kept : int
        Bytes of events that are kept.

    Attributes
    ----------
    events : Events
    turn : asyncio.Lock
        Updates come one after the other.
    """

    def __init__(self, kept: int) -> None:
        self.events, self.turn = Events(kept), asyncio.Lock()
