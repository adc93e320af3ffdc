"""The numbers of the theory: each with its unit, its default, where it comes from, and its range."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Final

from deixis.errors import ThresholdError

MAX_COORDINATE: Final = 1.0e7
"""Largest coordinate accepted, metres: up to it float64 resolves two nanometres."""

SNAP: Final = 1.0e-9
"""Measured lengths are rounded to this, metres, so that rounding noise never decides a closed bound."""

SNAP_DECIMALS: Final = 9
"""Decimals that :data:`SNAP` keeps."""


@dataclass(frozen=True, slots=True)
class Thresholds:
    """The thresholds a scene is read with (decisions 0001, 0004, 0009, 0015).

    Parameters
    ----------
    granularity : float
        The paper's D (axiom 5), metres: no region is thinner, and a gap up to D is contact.
    penetration : float
        P, metres: an overlap up to P deep is still contact, since sensor boxes over-approximate.
    closeness : float
        The paper's T (axiom 15), metres: at most this distance is near.
    halfspace_scale : float
        The paper's s (axiom 20), dimensionless: a halfspace is s times the full extent deep.
    pose_noise : float
        Metres: an answer whose margin is smaller is marked uncertain.
    piece_gap : float
        Metres: points of a cloud further apart than this, and than D, are in one piece (axiom 3) only by
        way of others between them.

    Raises
    ------
    ThresholdError
        A value is not finite and positive, or ``granularity <= penetration`` or
        ``granularity <= closeness`` does not hold.

    Examples
    --------
    >>> Thresholds().granularity
    0.02
    >>> Thresholds.of({"closeness": 1.5}).closeness
    1.5
    """

    granularity: float = 0.02
    penetration: float = 0.04
    closeness: float = 1.0
    halfspace_scale: float = 1.2
    pose_noise: float = 0.01
    piece_gap: float = 0.1

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
                raise ThresholdError(f"threshold {field.name!r} is {value!r}: give a finite number")
            if value <= 0.0 and not (field.name == "pose_noise" and value == 0.0):
                raise ThresholdError(f"threshold {field.name!r} is {value!r}: give a number above zero")
            object.__setattr__(self, field.name, float(value))
        for larger in ("penetration", "closeness"):
            if getattr(self, larger) < self.granularity:
                raise ThresholdError(
                    f"threshold {larger!r} is {getattr(self, larger)!r}, below the granularity "
                    f"{self.granularity!r}: raise it or lower the granularity"
                )

    @classmethod
    def of(cls, overrides: Mapping[str, float]) -> Thresholds:
        """Return the defaults with some values replaced; unknown names raise :class:`ThresholdError`."""
        known = {field.name for field in fields(cls)}
        unknown = sorted(set(overrides) - known)
        if unknown:
            raise ThresholdError(f"unknown threshold {unknown[0]!r}: known are {', '.join(sorted(known))}")
        return cls(**overrides)

    def items(self) -> tuple[tuple[str, float], ...]:
        """Return the thresholds as (name, value) pairs, in declaration order."""
        return tuple((field.name, getattr(self, field.name)) for field in fields(self))
