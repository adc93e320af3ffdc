"""The contract of ``rules/facts.pl`` with kinds: what each argument of a base fact is."""

from __future__ import annotations

from typing import Final, Literal

from deixis.ruleset.model import Indicator

Column = Literal["name", "length", "number"]
"""A name; a length in metres, which gives margins; a number that is none."""

_REACH: Final[tuple[Column, ...]] = ("length", "length", "length", "number", "number", "length", "length")

BASE_FACTS: Final[dict[Indicator, tuple[Column, ...]]] = {
    ("spatial_obj", 1): ("name",),
    ("surface", 1): ("name",),
    ("label", 3): ("name", "name", "number"),
    ("measured_as", 2): ("name", "name"),
    ("viewpoint", 1): ("name",),
    ("view_label", 2): ("name", "name"),
    ("threshold", 2): ("name", "length"),
    ("figure_reference", 2): ("name", "name"),
    ("pair", 9): ("name", "name", *_REACH),
    ("aspect", 7): ("name", "name", "name", "length", "length", "length", "length"),
    ("strict", 5): ("name", "name", "name", "name", "length"),
    ("withheld", 3): ("name", "name", "name"),
}
"""By predicate, in the order of the file; a test holds the two together."""

NO_LENGTH: Final = frozenset({"halfspace_scale"})
"""Thresholds that are no lengths."""
