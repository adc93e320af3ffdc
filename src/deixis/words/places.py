"""Places: of all that is true of where a thing is, the one relation a person would say."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from deixis.words.accepted import Accepted, accepted

if TYPE_CHECKING:
    from deixis.inference import Inference
    from deixis.relations import Relation


@dataclass(frozen=True, slots=True)
class Kind:
    """A kind of place.

    Attributes
    ----------
    name : str
    relations : tuple of str
        Predicates, any of which makes it.
    word : str
        The word that must fit too.
    verb : str
        What is said before the word where that is not "is".
    """

    name: str
    relations: tuple[str, ...]
    word: str
    verb: str = "be"


KINDS: Final = (
    Kind("in", ("inside", "part_in"), "in"),
    Kind("on", ("on_top_of",), "on"),
    Kind("leaning", ("leans_on",), "leaning on", "lean"),
    Kind("fixed", ("affixed_on",), "on"),
    Kind("under", ("below",), "under"),
    Kind("above", ("above",), "above"),
)
"""The most specific first. What is near is said only of things that have no other place, from a view."""

SIDES: Final = tuple(
    Kind(name, (name,), word)
    for name, word in (
        ("left_of", "left of"),
        ("right_of", "right of"),
        ("in_front_of", "in front of"),
        ("behind", "behind"),
    )
)

NEAR: Final = Kind("near", ("near",), "near")


@dataclass(frozen=True, slots=True)
class Place:
    """Where a figure is, in one relation that holds."""

    kind: Kind
    relation: Relation
    rank: int

    @property
    def figure(self) -> str:
        """Return what is placed."""
        return self.relation.figure

    @property
    def ground(self) -> str:
        """Return what it is placed by."""
        return self.relation.reference


class Places:
    """The places of all things of a scene.

    Parameters
    ----------
    kb : Inference
    view : str or None
        The view that left and right are said from; None for no such words.
    timeout : float
        Seconds for each engine.
    """

    def __init__(self, kb: Inference, view: str | None, timeout: float) -> None:
        self.kb, self.view = kb, view
        self._models = kb.measured_as
        self.fitting: Accepted = accepted(kb, timeout)
        self.found: dict[str, list[Relation]] = {}
        for one in kb.relations(timeout=timeout):
            if one.view is None or one.view == view:
                self.found.setdefault(one.figure, []).append(one)

    @cached_property
    def volume(self) -> dict[str, float]:
        """Return how large each thing is."""
        return dict(zip(self.kb.facts.ids, self.kb.facts.volume.tolist(), strict=True))

    @cached_property
    def surfaces(self) -> frozenset[str]:
        """Return the walls, floors and ceilings."""
        facts = self.kb.facts
        return frozenset(facts.ids[index] for index in np.flatnonzero(facts.surface))

    @cached_property
    def by_size(self) -> list[str]:
        """Return all things, the largest first."""
        return sorted(self.volume, key=lambda thing: (-self.volume[thing], thing))

    def of(self, figure: str) -> Place | None:
        """Return the best place of a thing, of those that no view matters for."""
        return min(self._of(figure), key=self._order, default=None)

    def aside(self, figure: str, grounds: Iterable[str] | None = None) -> Place | None:
        """Return where a thing is by something larger that is near, as seen from the view."""
        allowed = None if grounds is None else set(grounds)
        sides = {kind.name: kind for kind in SIDES}
        close = {one.reference for one in self.found.get(figure, ()) if one.relation == "near"}
        best: tuple[tuple[Any, ...], Place] | None = None
        for one in self.found.get(figure, ()):
            kind = sides.get(one.relation)
            if kind is None or one.reference not in close or one.reference in self.surfaces:
                continue
            if allowed is not None and one.reference not in allowed:
                continue
            if not self.fitting.fits(kind.word, one.figure, one.reference, one.view):
                continue
            key = (self._gap(one), -(one.margin or 0.0), one.reference, one.relation)
            if best is None or key < best[0]:
                best = key, Place(kind, one, len(KINDS))
        return None if best is None else best[1]

    def near(self, figure: str) -> Place | None:
        """Return what larger thing a thing is closest to."""
        found = [
            one
            for one in self.found.get(figure, ())
            if one.relation == "near"
            and one.reference not in self.surfaces
            and self.fitting.fits("near", one.figure, one.reference)
        ]
        one = min(found, key=lambda each: (self._gap(each), each.reference), default=None)
        return None if one is None else Place(NEAR, one, len(KINDS) + 1)

    def _gap(self, one: Relation) -> float:
        return self._distances.get((one.figure, one.reference), float("inf"))

    @cached_property
    def _distances(self) -> Mapping[tuple[str, str], float]:
        facts = self.kb.facts
        names = facts.ids
        pairs = zip(facts.figure.tolist(), facts.reference.tolist(), facts.distance.tolist(), strict=True)
        return {(names[i], names[j]): gap for i, j, gap in pairs}

    def _of(self, figure: str) -> Iterator[Place]:
        close = {one.reference for one in self.found.get(figure, ()) if one.relation == "near"}
        for one in self.found.get(figure, ()):
            for rank, kind in enumerate(KINDS):
                if one.relation not in kind.relations or (kind.name == "in" and self._beside_it(one)):
                    continue
                if not self.fitting.fits(kind.word, one.figure, one.reference):
                    continue
                # What hangs in mid-air is above everything: only what is close by tells where it is.
                landmark = one.reference in close and one.reference not in self.surfaces
                if kind.name in ("under", "above") and not landmark:
                    continue
                yield Place(kind, one, rank)

    def _beside_it(self, one: Relation) -> bool:
        """Return whether a thing is in another only by its box: both stand on the floor."""
        return self._models[one.reference] == "box" and bool(
            self._stands_on(one.figure) & self._stands_on(one.reference)
        )

    def _stands_on(self, thing: str) -> set[str]:
        """Return the floors that a thing stands on."""
        return {
            one.reference
            for one in self.found.get(thing, ())
            if one.relation == "on_top_of" and one.reference in self.surfaces
        }

    def _order(self, place: Place) -> tuple[Any, ...]:
        ground = place.ground
        plain = place.kind.name == "on" and ground in self.surfaces
        tight = 0.0 if place.kind.name in ("in", "on") else self._gap(place.relation)
        return (plain, place.rank, ground in self.surfaces, tight, self.volume[ground], ground)
