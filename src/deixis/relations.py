"""Relations as values: what holds of which things, and what is withheld."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from deixis.frames import Array
from deixis.thresholds import SNAP_DECIMALS
from deixis.vocabulary import BASE, RELATIONS


@dataclass(frozen=True, slots=True)
class Relation:
    """A relation that holds in a scene.

    Attributes
    ----------
    relation : str
        Name of the predicate, as in :mod:`deixis.vocabulary`.
    figure, reference : str
        Ids of the two things, in the order of the predicate's arguments: of ``compl_cont`` the container
        comes first.
    view : str or None
        Id of the view, where it matters.
    margin : float or None
        Metres by which a measured length would have to change for the relation to cease.
    """

    relation: str
    figure: str
    reference: str
    view: str | None
    margin: float | None

    def to_prolog(self) -> str:
        """Return the relation as a Prolog fact without its full stop; ids are quoted."""
        from deixis.prolog.quote import atom

        ids = [self.figure, self.reference] + ([] if self.view is None else [self.view])
        return f"{self.relation}({','.join(map(atom, ids))})"

    def to_dict(self) -> dict[str, str | float | None]:
        """Return the relation as a dict, ready for JSON."""
        return {
            "relation": self.relation,
            "figure": self.figure,
            "reference": self.reference,
            "view": self.view,
            "margin": self.margin,
        }


@dataclass(frozen=True, slots=True)
class Withheld:
    """A view that says nothing of what is beside, behind or in front of a reference, and why."""

    view: str
    reference: str
    reason: str

    def to_dict(self) -> dict[str, str]:
        """Return the notice as a dict, ready for JSON."""
        return {"view": self.view, "reference": self.reference, "reason": self.reason}


def rounded(margin: float | None) -> float | None:
    """Return a margin to a nanometre, as lengths are measured: differences carry rounding noise."""
    return None if margin is None else round(margin, SNAP_DECIMALS)


def rounded_all(margins: Array) -> Array:
    """Return margins to a nanometre, each as :func:`rounded` has it.

    Examples
    --------
    >>> rounded_all(np.array([0.1234567891, 2.0, np.inf])).tolist()
    [0.123456789, 2.0, inf]
    """
    plain = np.abs(margins) < _PLAIN
    scaled = np.where(plain, margins, 0.0) * 10.0**SNAP_DECIMALS
    # A product of doubles is a little off, which matters next to a half and for large numbers.
    sure = plain & (np.abs(np.abs(scaled - np.trunc(scaled)) - 0.5) > _CLEAR)
    found = np.where(sure, np.rint(scaled) / 10.0**SNAP_DECIMALS, margins)
    for at in np.flatnonzero(~sure & np.isfinite(margins)).tolist():
        found[at] = round(float(margins[at]), SNAP_DECIMALS)
    return found


_PLAIN = 1.0e4
_CLEAR = 0.01


def in_order(found: Iterable[Relation]) -> tuple[Relation, ...]:
    """Return relations in the order of the vocabulary, one's own after it, then by ids."""
    return tuple(
        sorted(
            found,
            key=lambda one: (*place_in_order(one.relation), one.figure, one.reference, one.view or ""),
        )
    )


def place_in_order(relation: str) -> tuple[int, str]:
    """Return what relations are sorted by first: the vocabulary's order, one's own after it by name."""
    return _ORDER.get(relation, len(_ORDER)), relation


_ORDER = {term.name: position for position, term in enumerate((*BASE, *RELATIONS))}
