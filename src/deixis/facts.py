"""Facts: a scene after geometry and before logic, one columnar table of ordered pairs.

Everything measured is a number; a truth value is that number against a threshold, and the distance to
the threshold is its margin. Nothing right of this table computes geometry, nothing left of it knows a rule.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Final, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from deixis.errors import QueryError
from deixis.frames import Array, Index, Mask
from deixis.parallel import share
from deixis.thresholds import Thresholds

_CHUNK: Final = 32_768
"""Rows moved at once."""

RegionModel = Literal["box", "hull", "mesh"]
"""What regions are measured as: boxes, convex hulls, or meshes where there are any (decision 0017)."""

REGION_MODELS: Final[tuple[RegionModel, ...]] = get_args(RegionModel)

SolidModel = Literal["box", "outline", "hull", "mesh"]
"""What one thing is measured as; an outline is a flat surface with its polygon's own border."""


def region_model(name: str) -> RegionModel:
    """Return the region model of that name.

    Raises
    ------
    QueryError
        There is none.
    """
    for model in REGION_MODELS:
        if name == model:
            return model
    raise QueryError(f"no region model {name!r}: known are {', '.join(REGION_MODELS)}")


def withheld_reason(wall: bool) -> str:
    """Say why a reference, a wall or not, has no front and sides in a view (decision 0014)."""
    if wall:
        return "the view stands in the plane of this surface, so neither side is its front"
    return "the view stands within the footprint of this reference, so it has no front and sides"


@dataclass(frozen=True)
class ViewFacts:
    """What depends on where one stands: halfspace margins in the contextualised frames of one view.

    Attributes
    ----------
    view : str
        The view's id, or ``world`` for the cardinal directions.
    rows : (q,) int
        Rows of the pair table (figure before reference) that these columns stand beside.
    int_hs : (q, 4) float
        Margins, metres, of "the figure meets the reference's halfspace" along X+, X-, Y+, Y- (axioms
        20, 30-34): not negative where it holds.
    cont_hs : (q, 4) float
        The same for "lies completely in the halfspace" (axiom 21).
    withheld : tuple of (int, str)
        References with no horizontal relation in this view, each with the reason.
    ambiguous : tuple of int
        References whose contextualised box was a choice between two equally small turns.
    """

    view: str
    rows: Index
    int_hs: Array
    cont_hs: Array
    withheld: tuple[tuple[int, str], ...] = ()
    ambiguous: tuple[int, ...] = ()


@dataclass(frozen=True, slots=True)
class PairColumns:
    """What was measured of p ordered pairs (figure, reference), whatever the view, in lexicographic order.

    Lengths are metres, volumes cubic metres, in the world frame.

    Attributes
    ----------
    figure, reference : (p,) int
        Positions in the scene.
    separation : (p,) float
        The distance of the two regions, or minus the least translation that parts overlapping ones.
    normal : (p, 3) float32
        Unit vector from reference to figure along which the separation is measured.
    intersection : (p,) float
        Volume of inter (axiom 18).
    protrusion : (p,) float
        How far the figure sticks out of the reference; not positive when it is within.
    frontier : (p,) float
        Measure, as a volume, of the points of the figure that are adjacent to inter (axiom 39).
    vertical : (p, 2) float
        Margins of "the figure meets the reference's halfspace" along Z+ and Z- (axioms 26, 27).
    vertical_strict : (p, 2) float
        The same for "lies completely in" it.
    ordered : (p,) bool
        Whether the pair stands in figure-reference order: the reference is a surface or not the smaller.
    """

    figure: Index
    reference: Index
    separation: Array
    normal: NDArray[np.float32]
    intersection: Array
    protrusion: Array
    frontier: Array
    vertical: Array
    vertical_strict: Array
    ordered: Mask

    @classmethod
    def empty(cls, figure: Index, reference: Index) -> PairColumns:
        """Return columns for these pairs, to be filled in; the volumes are 0 already."""
        p = len(figure)
        return cls(
            figure,
            reference,
            np.empty(p),
            np.empty((p, 3), dtype=np.float32),
            np.zeros(p),
            np.empty(p),
            np.zeros(p),
            np.empty((p, 2)),
            np.empty((p, 2)),
            np.empty(p, dtype=np.bool_),
        )

    def squeezed(self, keep: Mask) -> PairColumns:
        """Return the rows to keep, in the memory of these columns, which must not be used any more.

        Only the figures and references are copied: they belong to whoever asked.
        """
        if keep.all():
            return self
        if len(keep) <= _CHUNK:
            return self.at(np.flatnonzero(keep))
        columns = {name: getattr(self, name) for name in self.__slots__}

        def squeeze(name: str) -> None:
            column = columns[name]
            if name in ("figure", "reference"):
                columns[name] = column[keep]
                return
            end = 0
            for start in range(0, len(keep), _CHUNK):
                some = column[start : start + _CHUNK][keep[start : start + _CHUNK]]
                column[end : end + len(some)] = some
                end += len(some)
            columns[name] = column[:end]

        share(squeeze, columns)
        return PairColumns(**columns)

    def at(self, rows: Index) -> PairColumns:
        """Return the rows at the given positions."""
        return PairColumns(*(getattr(self, name).take(rows, axis=0) for name in self.__slots__))


@dataclass(frozen=True)
class Facts:
    """The grounded scene: p ordered pairs (figure, reference) within reach, and its views.

    Attributes
    ----------
    scene : str
        The scene's id.
    ids : tuple of str
        Object ids; the integer columns index this.
    labels : tuple of tuple of (str, float)
        Ranked labels with scores, per object.
    surface : (n,) bool
        Walls, floors, ceilings.
    volume : (n,) float
        Of the minimum bounding boxes, no side thinner than D, cubic metres.
    thresholds : Thresholds
        The numbers every truth value was decided with.
    pairs : PairColumns
        Also reachable column by column: ``facts.separation``.
    views : tuple of ViewFacts
        The world's cardinal directions first, then one per view of the scene.
    region : "box", "hull" or "mesh"
        The region model asked for (decision 0017).
    models : tuple of str
        What each thing was measured as: ``box``, ``outline``, ``hull`` or ``mesh``.
    """

    scene: str
    ids: tuple[str, ...]
    labels: tuple[tuple[tuple[str, float], ...], ...]
    surface: Mask
    volume: Array
    thresholds: Thresholds
    pairs: PairColumns
    views: tuple[ViewFacts, ...]
    region: RegionModel
    models: tuple[SolidModel, ...]

    def __len__(self) -> int:
        return len(self.pairs.figure)

    @property
    def figure(self) -> Index:
        """Return the figures' positions in ``ids``, (p,)."""
        return self.pairs.figure

    @property
    def reference(self) -> Index:
        """Return the references' positions in ``ids``, (p,)."""
        return self.pairs.reference

    @property
    def separation(self) -> Array:
        """Return the signed separations, metres, (p,)."""
        return self.pairs.separation

    @cached_property
    def distance(self) -> Array:
        """Return the least distances (axiom 14), metres, 0 where the two overlap, (p,)."""
        return np.maximum(self.pairs.separation, 0.0)

    @property
    def normal(self) -> NDArray[np.float32]:
        """Return the directions of the separations, (p, 3)."""
        return self.pairs.normal

    @property
    def intersection(self) -> Array:
        """Return the volumes of inter (axiom 18), cubic metres, (p,)."""
        return self.pairs.intersection

    @property
    def protrusion(self) -> Array:
        """Return how far the figures stick out of the references, metres, (p,)."""
        return self.pairs.protrusion

    @property
    def frontier(self) -> Array:
        """Return the measures of the figures' points adjacent to inter (axiom 39), cubic metres, (p,)."""
        return self.pairs.frontier

    @property
    def vertical(self) -> Array:
        """Return the relaxed margins along Z+ and Z-, metres, (p, 2)."""
        return self.pairs.vertical

    @property
    def vertical_strict(self) -> Array:
        """Return the strict margins along Z+ and Z-, metres, (p, 2)."""
        return self.pairs.vertical_strict

    @property
    def ordered(self) -> Mask:
        """Return which pairs stand in figure-reference order, (p,)."""
        return self.pairs.ordered

    @cached_property
    def is_close(self) -> Mask:
        """Return where distance <= T (axiom 15), shape (p,)."""
        return np.asarray(self.distance <= self.thresholds.closeness)

    @cached_property
    def touches(self) -> Mask:
        """Return where -P <= separation <= D (axiom 16, decision 0004), shape (p,)."""
        limits = self.thresholds
        return np.asarray((self.separation >= -limits.penetration) & (self.separation <= limits.granularity))

    @cached_property
    def intersects(self) -> Mask:
        """Return where separation < -P (axiom 17), shape (p,)."""
        return np.asarray(self.separation < -self.thresholds.penetration)

    @cached_property
    def compl_cont(self) -> Mask:
        """Return where the reference completely contains the figure (axiom 19), shape (p,)."""
        return np.asarray(self.intersects & (self.protrusion <= self.thresholds.granularity))

    def among(self, inside: Mask) -> Facts:
        """Return the facts of some things, (n,), alone: as if there were no others."""
        things = np.flatnonzero(inside).tolist()
        now = np.cumsum(inside) - 1
        keep = inside[self.figure] & inside[self.reference]
        place = np.cumsum(keep) - 1
        pairs = self.pairs.at(np.flatnonzero(keep))
        views = []
        for view in self.views:
            some = np.flatnonzero(keep[view.rows])
            views.append(
                ViewFacts(
                    view.view,
                    place[view.rows[some]],
                    view.int_hs[some],
                    view.cont_hs[some],
                    tuple((int(now[at]), reason) for at, reason in view.withheld if inside[at]),
                    tuple(int(now[at]) for at in view.ambiguous if inside[at]),
                )
            )
        return replace(
            self,
            ids=tuple([self.ids[at] for at in things]),
            labels=tuple([self.labels[at] for at in things]),
            surface=self.surface[inside],
            volume=self.volume[inside],
            pairs=replace(pairs, figure=now[pairs.figure], reference=now[pairs.reference]),
            views=tuple(views),
            models=tuple([self.models[at] for at in things]),
        )

    def row(self, figure: str, reference: str) -> int | None:
        """Return the row of an ordered pair of ids, or None where the two are beyond reach."""
        try:
            i, j = self.ids.index(figure), self.ids.index(reference)
        except ValueError:
            return None
        found = np.flatnonzero((self.figure == i) & (self.reference == j))
        return int(found[0]) if len(found) else None

    def columns(self) -> dict[str, list[object]]:
        """Return the pair table as named columns of plain values: ids, numbers, truth values."""
        name = self.ids
        return {
            "figure": [name[index] for index in self.figure.tolist()],
            "reference": [name[index] for index in self.reference.tolist()],
            "distance": self.distance.tolist(),
            "separation": self.separation.tolist(),
            "normal_x": self.normal[:, 0].tolist(),
            "normal_y": self.normal[:, 1].tolist(),
            "normal_z": self.normal[:, 2].tolist(),
            "intersection": self.intersection.tolist(),
            "protrusion": self.protrusion.tolist(),
            "frontier": self.frontier.tolist(),
            "above": self.vertical[:, 0].tolist(),
            "below": self.vertical[:, 1].tolist(),
            "is_close": self.is_close.tolist(),
            "touches": self.touches.tolist(),
            "intersects": self.intersects.tolist(),
            "compl_cont": self.compl_cont.tolist(),
            "ordered": self.ordered.tolist(),
        }

    def rows(self) -> list[dict[str, object]]:
        """Return the pair table as one dict a row, ready for JSON."""
        columns = self.columns()
        return [dict(zip(columns, values, strict=True)) for values in zip(*columns.values(), strict=True)]
