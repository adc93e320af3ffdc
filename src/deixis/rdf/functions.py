"""Functions on things in three dimensions, for use in queries: GeoSPARQL's are of the plane.

Each takes IRIs of things, or of their boxes, of one scene. What has no box, or is in another scene, has no
value: a FILTER leaves it out. Lengths are metres and volumes cubic metres, of the minimum bounding boxes.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, Final

import numpy as np

from deixis.boxes import Boxes
from deixis.measures import place, separation
from deixis.rdf.layout import DOUBLE, TERM
from deixis.rdf.oxigraph import ox
from deixis.thresholds import SNAP_DECIMALS

_BOX: Final = ox.NamedNode(TERM + "minBoundBox")
_NUMBERS: Final = ("centerX", "centerY", "centerZ", "sizeX", "sizeY", "sizeZ", "yaw")
_PLACES: Final = {ox.NamedNode(TERM + name): at for at, name in enumerate(_NUMBERS)}
_BOOLEAN: Final = ox.NamedNode("http://www.w3.org/2001/XMLSchema#boolean")
_REAL: Final = ox.NamedNode(DOUBLE)

_MOST_KNOWN: Final = 1 << 16
"""Pairs whose measure is kept: a join asks again and again."""


@dataclass(frozen=True)
class Documented:
    """A function, and what is said of it where functions are listed."""

    name: str
    text: str
    example: str

    @property
    def iri(self) -> str:
        """Return what it is called in queries."""
        return TERM + self.name


DOCUMENTED: Final = (
    Documented("distance3D", "The least distance of two things, metres; 0 where they meet.",
               "FILTER(deixis:distance3D(?a, ?b) < 0.5)"),
    Documented("separation3D", "The least distance of two things, metres; minus the least way that "
               "parts them where they overlap.", "BIND(deixis:separation3D(?a, ?b) AS ?gap)"),
    Documented("intersects3D", "Whether two things have a point in common.",
               "FILTER(deixis:intersects3D(?a, ?b))"),
    Documented("volume", "The volume of a thing's box, cubic metres.", "ORDER BY DESC(deixis:volume(?a))"),
)  # fmt: skip
"""All functions, in the order they are listed."""


class Functions:
    """The functions over the boxes of one dataset.

    Parameters
    ----------
    store : pyoxigraph.Store
        Read when a function is first used, and not changed from then on.

    Examples
    --------
    >>> sorted(Functions(ox.Store()).by_name, key=str)[0]
    <NamedNode value=urn:deixis:term:distance3D>
    """

    def __init__(self, store: Any) -> None:
        self._store = store
        self._boxes: dict[Any, tuple[Any, tuple[float, ...]]] | None = None
        self._gap = lru_cache(_MOST_KNOWN)(self._separation)
        calls: dict[str, Callable[..., Any]] = {
            "distance3D": lambda a, b: self._number(self._gap(a, b), lambda gap: max(gap, 0.0)),
            "separation3D": lambda a, b: self._number(self._gap(a, b), float),
            "intersects3D": self._intersects,
            "volume": self._volume,
        }
        self.by_name = {ox.NamedNode(one.iri): calls[one.name] for one in DOCUMENTED}

    def _number(self, value: float | None, change: Callable[[float], float]) -> Any:
        return (
            None
            if value is None
            else ox.Literal(repr(round(change(value), SNAP_DECIMALS) + 0.0), datatype=_REAL)
        )

    def _intersects(self, a: Any, b: Any) -> Any:
        gap = self._gap(a, b)
        return None if gap is None else ox.Literal("true" if gap <= 0.0 else "false", datatype=_BOOLEAN)

    def _volume(self, thing: Any) -> Any:
        found = self._known().get(thing)
        return self._number(None if found is None else float(np.prod(found[1][3:6])), float)

    def _separation(self, a: Any, b: Any) -> float | None:
        known = self._known()
        one, other = known.get(a), known.get(b)
        if one is None or other is None or one[0] != other[0]:
            return None
        figure, reference = _boxes(one[1]), _boxes(other[1])
        placement = place(figure, reference)
        tall = figure.half[:, 2] + reference.half[:, 2]
        up, down = tall - placement.z, tall + placement.z
        return float(separation(placement, figure.half, reference.half, up, down)[0][0])

    def _known(self) -> dict[Any, tuple[Any, tuple[float, ...]]]:
        """Return graph and numbers of each box, by its own IRI and by its thing's."""
        if self._boxes is None:
            numbers: dict[tuple[Any, Any], dict[int, float]] = {}
            for name, at in _PLACES.items():
                for quad in self._store.quads_for_pattern(None, name, None):
                    numbers.setdefault((quad.subject, quad.graph_name), {})[at] = float(quad.object.value)
            whole = {
                key: tuple(found[at] for at in range(len(_NUMBERS)))
                for key, found in numbers.items()
                if len(found) == len(_NUMBERS)
            }
            self._boxes = {box: (graph, row) for (box, graph), row in whole.items()}
            for quad in self._store.quads_for_pattern(None, _BOX, None):
                if quad.object in self._boxes:
                    self._boxes[quad.subject] = self._boxes[quad.object]
        return self._boxes


def _boxes(row: tuple[float, ...]) -> Boxes:
    center, size, yaw = row[:3], row[3:6], row[6]
    return Boxes(
        np.array([center]), np.array([size]) / 2.0, np.array([yaw]), np.array([-1]), np.array([False])
    )
