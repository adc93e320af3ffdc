"""Descriptions: a scene, or one thing of it, in a few sentences."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

from deixis.errors import QueryError
from deixis.hints import hint
from deixis.words.phrases import (
    called,
    indefinite,
    is_plural,
    joined,
    number,
    perspective,
    plural,
    sentence,
    short,
)
from deixis.words.places import Place, Places

if TYPE_CHECKING:
    from deixis.inference import Inference
    from deixis.relations import Relation

SENTENCES: Final = 6
"""Of a description, unless more are asked for."""

LISTED: Final = 6
"""Things named in one sentence; the others are counted."""


@dataclass(frozen=True, slots=True)
class Stated:
    """A relation that a sentence rests on, and the word that says it."""

    word: str
    relation: Relation

    def to_dict(self) -> dict[str, Any]:
        """Return it as a dict, ready for JSON."""
        return {"word": self.word, **self.relation.to_dict()}


@dataclass(frozen=True, slots=True)
class Sentence:
    """A sentence and all that makes it true."""

    text: str
    facts: tuple[Stated, ...]

    def to_dict(self) -> dict[str, Any]:
        """Return it as nested dicts, ready for JSON."""
        return {"text": self.text, "facts": [one.to_dict() for one in self.facts]}


@dataclass(frozen=True, slots=True)
class Description:
    """A scene in a few sentences.

    Attributes
    ----------
    scene : str
    about : str or None
        The one thing it is about; None for the scene.
    view : str or None
        Whose left and right are spoken of.
    sentences : tuple of Sentence
    left_out : int
        How many things, walls and floors apart, no sentence speaks of.
    """

    scene: str
    about: str | None
    view: str | None
    sentences: tuple[Sentence, ...]
    left_out: int

    @property
    def rest(self) -> str:
        """Return what is left unsaid, in words; the empty text where nothing is."""
        if not self.left_out or self.about is not None:
            return ""
        more = "more " if self.sentences else ""
        things = "thing" if self.left_out == 1 else "things"
        return sentence(f"{'and ' if more else ''}{number(self.left_out)} {more}{things}")

    def text(self) -> str:
        """Return all sentences, with what was left out."""
        return " ".join(self.lines())

    def lines(self) -> list[str]:
        """Return the same sentence by sentence; where there is none, that there is nothing."""
        said = [one.text for one in self.sentences] + ([self.rest] if self.rest else [])
        if said:
            return said
        return [
            "There is nothing to describe here." if self.about is None else "There is nothing to say of it."
        ]

    def to_dict(self) -> dict[str, Any]:
        """Return the description as nested dicts, ready for JSON."""
        return {
            "scene": self.scene,
            "about": self.about,
            "view": self.view,
            "text": self.text(),
            "sentences": [one.to_dict() for one in self.sentences],
            "left_out": self.left_out,
        }


@dataclass(frozen=True, slots=True)
class _Group:
    """Things that are in one place; of one thing also what it is beside."""

    places: tuple[Place, ...]
    beside: Place | None = None

    @property
    def ground(self) -> str:
        return self.places[0].ground


def describe(
    kb: Inference,
    names: Callable[[str | None], Mapping[str, str]],
    *,
    about: str | None = None,
    view: str | None = None,
    most: int = SENTENCES,
    timeout: float = 60.0,
) -> Description:
    """Return a scene, or one thing of it, in a few sentences.

    Parameters
    ----------
    kb : Inference
    names : callable
        From a view, or None, to what each thing is called, by its id.
    about : str, optional
        Id of the one thing to speak of.
    view : str, optional
        Whose left and right; by default the first view's.
    most : int
        Sentences.
    timeout : float
        Seconds.

    Raises
    ------
    QueryError
        Unknown thing or view.
    """
    known = [thing.id for thing in kb.scene.objects]
    if about is not None and about not in known:
        raise QueryError(f"nothing is called {about!r} in scene {kb.scene.id!r}{hint(about, known)}")
    if view is not None:
        kb.check_view(view)
    elif kb.scene.views:
        view = kb.scene.views[0].id
    places = Places(kb, view, timeout)
    writer = _Writer(places, names(view), about)
    groups = _of_scene(places) if about is None else _of_thing(places, about)
    sentences, mentioned, listed = [], set(places.surfaces), set[frozenset[str]]()
    for group in groups[:most]:
        said = writer.sentence(group)
        new = [one for one in said.facts if frozenset(_pair(one)) not in listed]
        if len(new) < len(said.facts):
            continue
        listed |= {frozenset(_pair(one)) for one in new}
        mentioned |= {thing for one in said.facts for thing in _pair(one)}
        sentences.append(said)
    return Description(kb.scene.id, about, view, tuple(sentences), len(set(known) - mentioned))


def _pair(one: Stated) -> tuple[str, str]:
    return one.relation.figure, one.relation.reference


def _of_scene(places: Places) -> list[_Group]:
    """Return what to say of a scene, the most telling first."""
    chosen: dict[str, Place] = {}
    for thing in places.by_size:
        if thing not in places.surfaces and (place := places.of(thing)) is not None:
            chosen[thing] = place
    for thing in places.by_size:
        if thing in places.surfaces or (thing in chosen and not _on_floor(places, chosen[thing])):
            continue
        # What only stands on the floor, or nowhere at all, is placed by something larger beside it.
        landmark = places.aside(thing) or places.near(thing)
        if landmark is not None and chosen.get(landmark.ground, landmark).ground != thing:
            chosen[thing] = landmark
    told = {place.ground for place in chosen.values()}
    groups = _grouped(place for place in chosen.values() if not _idle(places, place, told))
    groups = [_with_landmark(places, group) for group in groups]
    return sorted(groups, key=lambda group: _telling(places, group))


def _with_landmark(places: Places, group: _Group) -> _Group:
    """Return a group with what its thing is beside, where it is alone on a wall: walls are long."""
    if len(group.places) > 1 or group.ground not in places.surfaces:
        return group
    return _Group(group.places, places.aside(group.places[0].figure))


def _idle(places: Places, place: Place, told: set[str]) -> bool:
    """Return whether a sentence would only say that something stands on the floor that others speak of."""
    return _on_floor(places, place) and place.figure in told


def _on_floor(places: Places, place: Place) -> bool:
    return place.kind.name == "on" and place.ground in places.surfaces


def _grouped(chosen: Iterable[Place]) -> list[_Group]:
    groups: dict[tuple[str, str], list[Place]] = {}
    for place in chosen:
        groups.setdefault((place.kind.name, place.ground), []).append(place)
    return [_Group(tuple(some)) for some in groups.values()]


def _telling(places: Places, group: _Group) -> tuple[Any, ...]:
    first = group.places[0]
    on_floor = _on_floor(places, first)
    count = min(len(group.places), LISTED)
    largest = max(places.volume[place.figure] for place in group.places)
    contact = first.rank <= 3
    return (on_floor, not contact, -count, -largest, first.kind.name, first.ground)


def _of_thing(places: Places, about: str) -> list[_Group]:
    """Return what to say of one thing: where it is, what is on and in it, what is around it."""
    groups: list[_Group] = []
    own = None if about in places.surfaces else places.of(about)
    aside = None if about in places.surfaces else places.aside(about) or places.near(about)
    if own is not None:
        groups.append(_Group((own,), aside if aside is not None and _helps(places, own, aside) else None))
    elif aside is not None:
        groups.append(_Group((aside,)))
    held = [
        place
        for thing in places.by_size
        if thing not in (about, *places.surfaces)
        and (place := places.of(thing)) is not None
        and place.ground == about
    ]
    taken = {place.figure for place in held} | {group.ground for group in groups}
    taken |= {group.beside.ground for group in groups if group.beside is not None}
    around = [
        place
        for thing in places.by_size
        if thing not in (about, *taken, *places.surfaces)
        and (place := places.aside(thing, [about])) is not None
    ]
    groups += sorted(_grouped(held), key=lambda group: _telling(places, group))
    groups += sorted(_grouped(around), key=lambda group: _telling(places, group))
    return groups


def _helps(places: Places, own: Place, aside: Place) -> bool:
    """Return whether what a thing is beside tells more: on a wall, or with something on the same table."""
    other = places.of(aside.ground)
    return own.ground != aside.ground and (
        own.ground in places.surfaces or (other is not None and other.ground == own.ground)
    )


class _Writer:
    """Writes groups as sentences."""

    def __init__(self, places: Places, names: Mapping[str, str], about: str | None) -> None:
        self._about = about
        self._names = {thing: short(name) for thing, name in names.items()}
        self._labels = {thing.id: short(thing.label) for thing in places.kb.scene.objects}
        self._views = {view.id: view.label or view.id for view in places.kb.scene.views}

    def sentence(self, group: _Group) -> Sentence:
        """Return the sentence of a group."""
        first = group.places[0]
        told = group.places if group.beside is None else (*group.places, group.beside)
        facts = tuple(Stated(place.kind.word, place.relation) for place in told)
        listed = self._listed(group.places)
        several = len(group.places) > 1 or is_plural(self._labels[first.figure])
        where = self._where(first)
        if len(group.places) > 1 and first.kind.verb == "be" and first.relation.view is None:
            return Sentence(sentence(f"{where} are {listed}"), facts)
        also = "" if group.beside is None else f", {self._where(group.beside)}"
        return Sentence(sentence(f"{listed} {_verb(first, several)} {where}{also}"), facts)

    def _where(self, place: Place) -> str:
        view = place.relation.view
        tail = "" if view is None else f" {perspective(self._views[view])}"
        word = "against" if place.kind.name == "leaning" else place.kind.word
        return f"{word} {self._names[place.ground]}{tail}"

    def _listed(self, group: Sequence[Place]) -> str:
        """Return the things of a group as a list, those with one label together."""
        counts = Counter(self._labels[place.figure] for place in group)
        parts: list[tuple[str, int]] = []
        for place in group:
            label = self._labels[place.figure]
            if not label or counts[label] == 1:
                parts.append((self._called(place), 1))
            elif counts[label]:
                parts.append((f"{number(counts[label])} {plural(label)}", counts[label]))
                counts[label] = 0
        shown, rest = parts[:LISTED], sum(count for _, count in parts[LISTED:])
        texts = [text for text, _ in shown]
        if rest:
            texts.append(f"{number(rest)} more {'thing' if rest == 1 else 'things'}")
        return joined(texts)

    def _called(self, place: Place) -> str:
        """Return what the figure of a place is called: an id says nothing to people who only want to know."""
        label, name = self._labels[place.figure], self._names[place.figure]
        if label and place.figure != self._about and name == short(f"the {label} ({place.figure})"):
            return indefinite(label)
        return called(self._names, self._labels, place.figure, place.ground)


def _verb(place: Place, several: bool) -> str:
    if place.kind.verb == "be":
        return "are" if several else "is"
    return place.kind.verb if several else f"{place.kind.verb}s"
