"""Phrases: how many, lists with "and", plurals, whose view."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Final

LONGEST_NAME: Final = 60
"""Characters of a name in a sentence; a longer one is cut, which its dots say."""

_NUMBERS: Final = (
    "no", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten", "eleven", "twelve"
)  # fmt: skip
_IRREGULAR: Final = {"person": "people", "man": "men", "woman": "women", "child": "children", "foot": "feet",
                     "mouse": "mice", "tooth": "teeth", "shelf": "shelves", "knife": "knives",
                     "loaf": "loaves", "leaf": "leaves", "scarf": "scarves", "half": "halves"}  # fmt: skip
_SINGLE: Final = frozenset({"lens", "gas", "atlas", "canvas", "christmas"})
_SINGULAR: Final = {plural: one for one, plural in _IRREGULAR.items()}


def number(count: int) -> str:
    """Return a number as people write it.

    Examples
    --------
    >>> number(2), number(43)
    ('two', '43')
    """
    return _NUMBERS[count] if 0 <= count < len(_NUMBERS) else str(count)


def plural(noun: str) -> str:
    """Return the plural of a noun or of the last word of several.

    Examples
    --------
    >>> plural("fire extinguisher"), plural("box"), plural("shelf"), plural("berry")
    ('fire extinguishers', 'boxes', 'shelves', 'berries')
    """
    front, space, last = noun.rpartition(" ")
    return noun if is_plural(noun) else front + space + _plural_word(last)


def _plural_word(word: str) -> str:
    low = word.casefold()
    if low in _IRREGULAR:
        return word[0] + _IRREGULAR[low][1:]
    if low.endswith(("s", "x", "z", "ch", "sh")):
        return f"{word}es"
    if low.endswith("y") and low[-2:-1] not in "aeiou":
        return f"{word[:-1]}ies"
    return f"{word}s"


def is_plural(noun: str) -> bool:
    """Return whether a noun looks like a plural already: boots, curtains, scissors.

    Examples
    --------
    >>> is_plural("boots"), is_plural("glass"), is_plural("cactus")
    (True, False, False)
    """
    last = noun.rpartition(" ")[2].casefold()
    return last in _SINGULAR or (
        last.endswith("s") and not last.endswith(("ss", "us", "is")) and last not in _SINGLE
    )


def singulars(noun: str) -> tuple[str, ...]:
    """Return what a noun, in lower case, may be the plural of.

    Examples
    --------
    >>> singulars("coffee mugs"), singulars("boxes")
    (('coffee mug',), ('boxe', 'box'))
    """
    front, space, last = noun.rpartition(" ")
    if last in _SINGULAR:
        return (front + space + _SINGULAR[last],)
    found = []
    if last.endswith("ies") and len(last) > len("pies"):
        found.append(f"{last[:-3]}y")
    if last.endswith("s") and not last.endswith("ss"):
        found.append(last[:-1])
    if last.endswith("es"):
        found.append(last[:-2])
    return tuple(front + space + one for one in found)


def joined(parts: Sequence[str], last: str = "and") -> str:
    """Return some phrases as a list.

    Examples
    --------
    >>> joined(["a cup", "a plate", "a book"])
    'a cup, a plate and a book'
    """
    return f" {last} ".join(filter(None, [", ".join(parts[:-1]), parts[-1]])) if parts else ""


def sentence(text: str) -> str:
    """Return a text with a capital and a full stop."""
    return f"{text[:1].upper()}{text[1:]}."


def short(name: str) -> str:
    r"""Return a name on one line and of no more than :data:`LONGEST_NAME` characters.

    Examples
    --------
    >>> short("tea\n cup")
    'tea cup'
    """
    line = " ".join(name.split())
    return line if len(line) <= LONGEST_NAME else f"{line[: LONGEST_NAME - 3]}..."


def perspective(label: str) -> str:
    """Return whose view is spoken from, by the view's label.

    Examples
    --------
    >>> perspective("robot"), perspective("you")
    ('as seen from the robot', 'from where you stand')
    """
    return "from where you stand" if label == "you" else f"as seen from the {short(label)}"


def called(names: Mapping[str, str], labels: Mapping[str, str], thing: str, ground: str) -> str:
    """Return what a thing is called in a sentence that says where it is, and so need not say it twice.

    Examples
    --------
    >>> names = {"c": "the cup on the table", "t": "the table"}
    >>> called(names, {"c": "cup"}, "c", "t"), called(names | {"t": "the desk"}, {"c": "cup"}, "c", "t")
    ('a cup', 'the cup on the table')
    """
    label = labels[thing]
    if label and names[thing].startswith(f"the {label} ") and names[thing].endswith(f" {names[ground]}"):
        return indefinite(label)
    return names[thing]


def indefinite(label: str) -> str:
    """Return a noun with its indefinite article, if it takes one.

    Examples
    --------
    >>> indefinite("apple"), indefinite("cup"), indefinite("scissors")
    ('an apple', 'a cup', 'scissors')
    """
    return label if is_plural(label) else f"{'an' if label[:1].casefold() in 'aeiou' else 'a'} {label}"
