"""The lexicon: English spatial prepositions, what they mean here, and those that mean nothing here yet.

The prepositions are those of Landau and Jackendoff, "What and where in spatial language and spatial
cognition" (1993), with the phrases that Visual Genome and SpatialSense use. ``kb/lexicon.ttl`` is written
from this table by ``tests/lexicon.py``; a test holds it to :mod:`deixis.vocabulary` and to the rules.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from deixis.errors import QueryError
from deixis.hints import hint


@dataclass(frozen=True, slots=True)
class Sense:
    """One meaning of a word: what it says of a figure and a ground, and the predicate that says it."""

    gloss: str
    predicate: str


@dataclass(frozen=True, slots=True)
class Entry:
    """A preposition.

    Attributes
    ----------
    word : str
        As ``fits`` of ``rules/prepositions.pl`` has it.
    forms : tuple of str
        All that is taken for it in a question, the word itself first.
    senses : tuple of Sense
        The most specific first.
    view : bool
        Whether it depends on where one stands.
    verbs : tuple of str
        Verbs that say it without "to be": "the ladder leans on the wall".
    visual_genome, spatial_sense : tuple of str
        Predicate names of these two data sets that mean it.
    """

    word: str
    forms: tuple[str, ...]
    senses: tuple[Sense, ...]
    view: bool = False
    verbs: tuple[str, ...] = ()
    visual_genome: tuple[str, ...] = ()
    spatial_sense: tuple[str, ...] = ()


_TOP: Final = Sense("the ground holds it up from below", "on_top_of")
_FIXED: Final = Sense("it is fixed to the ground, which alone holds it", "affixed_on")
_LEANS: Final = Sense(
    "it leans or hangs against the ground's side and something else holds it up", "leans_on"
)
_WITHIN: Final = Sense("all of it is within the ground", "inside")
_PARTLY: Final = Sense("it is partly within the ground", "part_in")
_ABOVE: Final = Sense("it is over the ground and does not rest on it", "above")
_BELOW: Final = Sense("it is in the space under the ground", "below")
_NEAR: Final = Sense("it is close to the ground and apart from it", "near")
_BESIDE: Final = Sense("it is left or right of the ground", "beside")

ENTRIES: Final = (
    Entry(
        "on",
        ("on", "upon"),
        (_TOP, _FIXED, _LEANS),
        verbs=("stand", "sit", "lie", "rest"),
        visual_genome=("on", "sitting on", "standing on", "laying on", "lying on", "mounted on"),
        spatial_sense=("on",),
    ),
    Entry("on top of", ("on top of", "atop"), (_TOP,), visual_genome=("on top of",)),
    Entry(
        "leaning on",
        ("leaning on", "leaning against", "propped against"),
        (_LEANS,),
        verbs=("lean",),
        visual_genome=("leaning on", "leaning against"),
    ),
    Entry(
        "affixed to",
        ("affixed to", "affixed on", "fixed to", "attached to", "mounted on", "hanging on", "hanging from"),
        (_FIXED,),
        verbs=("hang",),
        visual_genome=("attached to", "hanging on", "hanging from"),
    ),
    Entry(
        "against",
        ("against", "up against"),
        (_LEANS, Sense("it touches the ground's side", "touches")),
        visual_genome=("against",),
    ),
    Entry(
        "touching",
        ("touching", "in contact with"),
        (Sense("it touches the ground", "touches"),),
        visual_genome=("touching",),
    ),
    Entry("in", ("in", "within"), (_WITHIN, _PARTLY), visual_genome=("in",), spatial_sense=("in",)),
    Entry("inside", ("inside", "inside of"), (_WITHIN, _PARTLY), visual_genome=("inside", "inside of")),
    Entry("above", ("above",), (_ABOVE,), visual_genome=("above",), spatial_sense=("above",)),
    Entry("over", ("over",), (_ABOVE,), visual_genome=("over",)),
    Entry("below", ("below",), (_BELOW,), visual_genome=("below",)),
    Entry(
        "under",
        ("under", "underneath", "beneath"),
        (_BELOW,),
        visual_genome=("under", "underneath", "beneath"),
        spatial_sense=("under",),
    ),
    Entry(
        "near",
        ("near", "close to", "nearby", "by", "around"),
        (_NEAR, Sense("it is at most the closeness threshold away", "is_close")),
        visual_genome=("near", "close to", "by", "around"),
    ),
    Entry(
        "beside",
        ("beside", "next to", "alongside", "to the side of"),
        (_BESIDE,),
        view=True,
        visual_genome=("beside", "next to"),
        spatial_sense=("next to",),
    ),
    Entry(
        "left of",
        ("left of", "to the left of", "on the left of", "left"),
        (Sense("it reaches into the space on the ground's left", "left_of"),),
        view=True,
        visual_genome=("left of", "to the left of"),
        spatial_sense=("to the left of",),
    ),
    Entry(
        "right of",
        ("right of", "to the right of", "on the right of", "right"),
        (Sense("it reaches into the space on the ground's right", "right_of"),),
        view=True,
        visual_genome=("right of", "to the right of"),
        spatial_sense=("to the right of",),
    ),
    Entry(
        "in front of",
        ("in front of", "before"),
        (Sense("it reaches into the space between the ground and the viewer", "in_front_of"),),
        view=True,
        visual_genome=("in front of",),
        spatial_sense=("in front of",),
    ),
    Entry(
        "behind",
        ("behind", "in back of", "beyond"),
        (Sense("it reaches into the space on the ground's far side", "behind"),),
        view=True,
        visual_genome=("behind",),
        spatial_sense=("behind",),
    ),
    *(
        Entry(
            f"{side} of",
            (f"{side} of", f"to the {side} of", side),
            (Sense(f"a part of it lies {side} of the ground, by the axes of the world", f"{side}_r"),),
        )
        for side in ("north", "south", "east", "west")
    ),
)
"""Every preposition that can be grounded."""

_PATH: Final = "says a way, not a place: nothing here moves"
_MANY: Final = "needs a ground of several things; relations here have one"
_SHAPE: Final = "needs the ground's long axis, which is not measured"
_AWAY: Final = "says where something is not: ask whether it is in or on, and for no as an answer"
_SPEAKER: Final = "names no ground but the speaker's place or the context"

NOT_GROUNDED: Final = {
    **dict.fromkeys(
        ("down", "from", "into", "onto", "past", "through", "throughout", "to", "toward", "up", "via", "back",
         "backward", "forward", "inward", "outward", "upward", "downward", "sideways", "homeward", "away"),
        _PATH,
    ),
    **dict.fromkeys(("between", "betwixt", "among", "amongst", "amid", "amidst", "in between"), _MANY),
    **dict.fromkeys(("across", "along", "in line with"), _SHAPE),
    **dict.fromkeys(("off", "out", "out of", "outside", "without", "apart", "far from"), _AWAY),
    **dict.fromkeys(("here", "there", "upstairs", "downstairs", "indoors", "outdoors"), _SPEAKER),
    "at": "says that someone uses the ground (at the desk): no relation of shapes",
    "with": "says that things belong together: no relation of shapes",
    "together": "says that things belong together: no relation of shapes",
    "about": "says nearness of no certain kind: ask with near",
    "after": "says an order in a row or in time",
    "opposite": "needs the ground's own front, which is not known",
}  # fmt: skip
"""Prepositions without a predicate, each with the reason."""

_BY_FORM: Final = {form: entry for entry in ENTRIES for form in entry.forms}


def entry_of(word: str) -> Entry:
    """Return the entry of a preposition in any of its forms.

    Raises
    ------
    QueryError
        It is not known, or known and not grounded; the message says why.

    Examples
    --------
    >>> entry_of("to the left of").word
    'left of'
    """
    form = " ".join(word.casefold().split())
    if form in _BY_FORM:
        return _BY_FORM[form]
    if form in NOT_GROUNDED:
        raise QueryError(f"{form!r} {NOT_GROUNDED[form]}")
    raise QueryError(f"{form[:60]!r} is no preposition I know{hint(form, sorted(_BY_FORM))}")


def predicates_in(word: str) -> tuple[str, ...]:
    """Return the predicates that a preposition stands for, the most specific first.

    Examples
    --------
    >>> predicates_in("on")
    ('on_top_of', 'affixed_on', 'leans_on')
    """
    return tuple(sense.predicate for sense in entry_of(word).senses)


def words_for(predicate: str) -> tuple[str, ...]:
    """Return the prepositions that a predicate may be said with.

    Examples
    --------
    >>> words_for("leans_on")
    ('on', 'leaning on', 'against')
    """
    return tuple(
        entry.word for entry in ENTRIES if any(sense.predicate == predicate for sense in entry.senses)
    )
