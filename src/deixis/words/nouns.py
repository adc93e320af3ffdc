"""Nouns: which things of a scene are meant by what a person calls them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from difflib import get_close_matches
from typing import TYPE_CHECKING, Final

from deixis.errors import QueryError
from deixis.words.phrases import plural, short, singulars

if TYPE_CHECKING:
    from deixis.scene import Scene
    from deixis.words.questions import Noun

ANYTHING: Final = frozenset({"thing", "object", "item", "anything", "something"})
"""What any thing may be called, walls and floors apart."""

_SOME: Final = 8
"""Names in a message."""


@dataclass(frozen=True, slots=True)
class Meant:
    """The things that a noun may mean, and whether it means all of them."""

    things: tuple[str, ...]
    all: bool


class Nouns:
    """The things of a scene by what they are called.

    Parameters
    ----------
    scene : Scene
    names : mapping
        What each thing is called in sentences, by its id.
    """

    def __init__(self, scene: Scene, names: Mapping[str, str]) -> None:
        self._ids = [thing.id for thing in scene.objects]
        self._things = tuple(thing.id for thing in scene.objects if thing.kind != "surface")
        self._scene = scene.id
        self._names: dict[str, list[str]] = {}
        self._labels: dict[str, list[str]] = {}
        self._heads: dict[str, list[str]] = {}
        for thing in scene.objects:
            _add(self._names, _plain(names[thing.id]), thing.id)
            for label in thing.labels[:1]:
                name = _key(label.name)
                _add(self._labels, name, thing.id)
                words = name.split()
                for at in range(1, len(words)):
                    _add(self._heads, " ".join(words[at:]), thing.id)

    def meant(self, noun: Noun) -> Meant:
        """Return the things that a noun may mean: an id, a name as in our sentences, a label or its head.

        Raises
        ------
        QueryError
            Nothing is called so; the message says where the noun stands, and what may have been meant.
        """
        if noun.text in self._ids:
            return Meant((noun.text,), all=False)
        text = _key(noun.text)
        if not noun.quoted and (text in ANYTHING or any(one in ANYTHING for one in singulars(text))):
            return Meant(self._things, all=True)
        for known in (self._names, self._labels):
            if text in known:
                return Meant(tuple(known[text]), all=not noun.definite)
        for known in (self._labels, self._heads):
            for one in singulars(text):
                if one in known:
                    return Meant(tuple(known[one]), all=True)
        if text in self._heads:
            return Meant(tuple(self._heads[text]), all=not noun.definite)
        raise QueryError(
            f"character {noun.start + 1}: nothing here is called {short(noun.text)!r}{self._hint(text)}"
        )

    def _hint(self, text: str) -> str:
        known = {name: name for names in (self._labels, self._heads) for name in names}
        known |= {plural(name): name for name in self._labels}
        known |= {_key(one): one for one in self._ids}
        close = get_close_matches(text[:100], known, n=1)
        if close:
            return f": did you mean {short(close[0])!r}?"
        some = sorted(filter(None, self._labels))
        more = f" and {len(some) - _SOME} more" if len(some) > _SOME else ""
        return f": there are {', '.join(map(short, some[:_SOME]))}{more}" if some else ""


def plain_names(scene: Scene) -> dict[str, str]:
    """Return things by their labels, or their ids: two may be called the same."""
    return {thing.id: f"the {thing.label}" if thing.label else thing.id for thing in scene.objects}


def _add(known: dict[str, list[str]], name: str, thing: str) -> None:
    known.setdefault(name, []).append(thing)


def _key(text: str) -> str:
    return " ".join(text.casefold().split())


def _plain(name: str) -> str:
    return _key(name).removeprefix("the ")


def named(things: Iterable[str], names: Mapping[str, str]) -> list[str]:
    """Return what things are called, each on one line."""
    return [short(names[thing]) for thing in things]
