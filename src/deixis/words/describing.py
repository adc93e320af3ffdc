"""Descriptions: a scene, or one thing of it, in a few sentences."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

from deixis.errors import QueryError
from deixis.hints import hint
from deixis.words.phrases import joined, number, perspective, plural, sentence, short
from deixis.words.places import FLOOR, Place, Places

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
        said = [one.text for one in self.sentences]
        return " ".join([*said, self.rest] if self.rest else said)

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
    """Things that are in one place."""

    places: tuple[Place, ...]

    @property
    def ground(self) -> str:
        return self.places[0].ground


def describe(
    kb: Inference,
    names: Mapping[str, str],
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
    names : mapping
        What each thing is called, by its id.
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
    writer = _Writer(places, names)
    groups = _of_scene(places) if about is None else _of_thing(places, about)
    sentences, mentioned, listed = [], set(places.surfaces), set[frozenset[str]]()
    for group in groups[:most]:
        said = writer.sentence(group, about)
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
    for thing in places.kb.facts.ids:
        if thing not in places.surfaces and (place := places.of(thing)) is not None:
            chosen[thing] = place
    told = {place.ground for place in chosen.values()}
    for thing in places.kb.facts.ids:
        if thing in places.surfaces or (thing in chosen and not _on_floor(places, chosen[thing])):
            continue
        # What only stands on the floor, or nowhere at all, is placed by something larger beside it.
        landmark = places.aside(thing) or places.near(thing)
        if landmark is not None and chosen.get(landmark.ground, landmark).ground != thing:
            chosen[thing] = landmark
    groups = _grouped(place for thing, place in chosen.items() if not _idle(places, place, told))
    return sorted(groups, key=lambda group: _telling(places, group))


def _idle(places: Places, place: Place, told: set[str]) -> bool:
    """Return whether a sentence would only say that something stands on the floor that others speak of."""
    return _on_floor(places, place) and place.figure in told


def _on_floor(places: Places, place: Place) -> bool:
    return place.kind.name == "on" and place.ground in places.surfaces


def _grouped(chosen: Iterable[Place]) -> list[_Group]:
    groups: dict[tuple[str, str], list[Place]] = {}
    for place in chosen:
        groups.setdefault((place.kind.name, place.ground), []).append(place)
    return [_Group(tuple(sorted(some, key=lambda one: one.figure))) for some in groups.values()]


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
    if own is not None:
        groups.append(_Group((own,)))
    aside = None if about in places.surfaces else places.aside(about) or places.near(about)
    if aside is not None and (own is None or aside.ground != own.ground):
        groups.append(_Group((aside,)))
    held = [
        place
        for thing in places.kb.facts.ids
        if thing not in (about, *places.surfaces)
        and (place := places.of(thing)) is not None
        and place.ground == about
    ]
    taken = {place.figure for place in held} | {group.ground for group in groups}
    around = [
        place
        for thing in places.kb.facts.ids
        if thing not in (about, *taken, *places.surfaces)
        and (place := places.aside(thing, [about])) is not None
    ]
    groups += sorted(_grouped(held), key=lambda group: _telling(places, group))
    groups += sorted(_grouped(around), key=lambda group: _telling(places, group))
    return groups


class _Writer:
    """Writes groups as sentences."""

    def __init__(self, places: Places, names: Mapping[str, str]) -> None:
        self._names = {thing: short(name) for thing, name in names.items()}
        self._labels = {thing.id: short(thing.label) for thing in places.kb.scene.objects}
        self._views = {view.id: view.label or view.id for view in places.kb.scene.views}

    def sentence(self, group: _Group, about: str | None) -> Sentence:
        """Return the sentence of a group."""
        first = group.places[0]
        facts = tuple(Stated(place.kind.word, place.relation) for place in group.places)
        figures = [place.figure for place in group.places]
        listed, several = self._listed(figures)
        ground = self._names[first.ground]
        where = f"{_said(first)} {ground}"
        view = first.relation.view
        tail = "" if view is None else f" {perspective(self._views[view])}"
        if several and first.kind.verb == "be" and view is None:
            return Sentence(sentence(f"{where} are {listed}"), facts)
        verb = _verb(first, several)
        return Sentence(sentence(f"{listed} {verb} {where}{tail}"), facts)

    def _listed(self, figures: Sequence[str]) -> tuple[str, bool]:
        """Return things as a list, those with one label together, and whether they are several."""
        counts = Counter(self._labels[figure] for figure in figures)
        alike = {label for label, count in counts.items() if count > 1 and label}
        parts: list[tuple[str, int]] = []
        for figure in figures:
            label = self._labels[figure]
            if label not in alike:
                parts.append((self._names[figure], 1))
            elif counts[label]:
                parts.append((f"{number(counts[label])} {plural(label)}", counts[label]))
                counts[label] = 0
        shown, rest = parts[:LISTED], sum(count for _, count in parts[LISTED:])
        texts = [text for text, _ in shown]
        if rest:
            texts.append(f"{number(rest)} more {'thing' if rest == 1 else 'things'}")
        return joined(texts), len(figures) > 1


def _said(place: Place) -> str:
    return "against" if place.kind.name == "leaning" else place.kind.word


def _verb(place: Place, several: bool) -> str:
    if place.kind.verb == "be":
        return "are" if several else "is"
    return place.kind.verb if several else f"{place.kind.verb}s"
