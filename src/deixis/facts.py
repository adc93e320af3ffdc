"""Facts: a scene after geometry and before logic, one columnar table of ordered pairs.

Everything measured is a number; a truth value is that number against a threshold, and the distance to
the threshold is its margin. Nothing right of this table computes geometry, nothing left of it knows a rule.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from deixis.frames import Array, Index, Mask
from deixis.thresholds import Thresholds


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


@dataclass(frozen=True)
class Facts:
    """The grounded scene: p ordered pairs (figure, reference) within reach, in lexicographic order.

    Lengths are metres, areas square metres, volumes cubic metres, all in the world frame.

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
        Of the minimum bounding boxes, no side thinner than D.
    thresholds : Thresholds
        The numbers every truth value below was decided with.
    figure, reference : (p,) int
    distance : (p,) float
        Least distance of the two regions (axiom 14); 0 where they overlap.
    separation : (p,) float
        The distance, or minus the least translation that separates overlapping regions.
    normal : (p, 3) float
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
    views : tuple of ViewFacts
        The world's cardinal directions first, then one per view of the scene.
    """

    scene: str
    ids: tuple[str, ...]
    labels: tuple[tuple[tuple[str, float], ...], ...]
    surface: Mask
    volume: Array
    thresholds: Thresholds
    figure: Index
    reference: Index
    distance: Array
    separation: Array
    normal: Array
    intersection: Array
    protrusion: Array
    frontier: Array
    vertical: Array
    vertical_strict: Array
    ordered: Mask
    views: tuple[ViewFacts, ...]

    def __len__(self) -> int:
        return len(self.figure)

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
            "normal": self.normal.tolist(),
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
