"""Answers to plain questions: what is on the table, where is the cup, why is it there."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from functools import cached_property
from typing import TYPE_CHECKING, Any, Final

from deixis.errors import QueryError
from deixis.relations import Relation
from deixis.words.accepted import Accepted, accepted
from deixis.words.describing import describe
from deixis.words.lexicon import Entry, entry_of
from deixis.words.nouns import Nouns, named
from deixis.words.phrases import called, is_plural, joined, number, perspective, sentence, short
from deixis.words.questions import Noun, Question, read

if TYPE_CHECKING:
    from deixis.explain import Answer, Refusal
    from deixis.inference import Inference

LISTED: Final = 12
"""Things named in an answer; the others are counted, and all are in ``things``."""

BASES: Final = {
    "above": "above_r",
    "over": "above_r",
    "below": "below_r",
    "under": "below_r",
    "near": "is_close",
    "touching": "touches",
    "against": "touches",
}
"""What explains a word of a pair that is not in the order of the theory's conclusions."""


@dataclass(frozen=True, slots=True)
class Fitting:
    """That a word fits a figure and a ground, as seen from a view where that matters."""

    word: str
    figure: str
    ground: str
    view: str | None

    def to_dict(self) -> dict[str, str | None]:
        """Return it as a dict, ready for JSON."""
        return {"word": self.word, "figure": self.figure, "ground": self.ground, "view": self.view}


@dataclass(frozen=True, slots=True)
class Reply:
    """An answer to a question.

    Attributes
    ----------
    question : str
    asks : str
        The kind of question: ``what``, ``ground``, ``which``, ``where``, ``whether``, ``why``, ``why_not`` or
        ``count``.
    text : str
        The answer in a sentence or two.
    holds : bool
        Whether what is asked for is so, or there is any.
    things : tuple of str
        Ids of the things that answer it.
    facts : tuple of Fitting
        What the answer rests on.
    choices : tuple of str
        Where a noun means several things: their ids; the text asks which is meant.
    """

    question: str
    asks: str
    text: str
    holds: bool
    things: tuple[str, ...] = ()
    facts: tuple[Fitting, ...] = ()
    choices: tuple[str, ...] = ()

    def to_dict(self) -> dict[str, Any]:
        """Return the answer as nested dicts, ready for JSON."""
        return {
            "question": self.question,
            "asks": self.asks,
            "text": self.text,
            "holds": self.holds,
            "things": list(self.things),
            "facts": [one.to_dict() for one in self.facts],
            "choices": list(self.choices),
        }


class _Several(Exception):
    """A noun means several things, and the question is about one."""

    def __init__(self, noun: Noun, things: Sequence[str]) -> None:
        super().__init__(noun.text)
        self.noun, self.things = noun, tuple(things)


def say(
    kb: Inference,
    question: str,
    names: Callable[[str | None], Mapping[str, str]],
    why: Callable[[str], Answer],
    why_not: Callable[[str], Refusal],
    *,
    view: str | None = None,
    timeout: float = 60.0,
) -> Reply:
    """Return the answer to a question in plain English, of the kinds in ``questions.PATTERNS``.

    Parameters
    ----------
    kb : Inference
    question : str
    names : callable
        From a view, or None, to what each thing is called, by its id.
    why, why_not : callable
        From a goal to its proof, or to what keeps it from holding.
    view : str, optional
        Whose left and right, where the question does not say; by default the first view's.
    timeout : float
        Seconds.

    Raises
    ------
    QueryError
        The question is none of the known kinds, or names what is not there.
    """
    asked = read(question)
    if view is not None:
        kb.check_view(view)
    answerer = _Answerer(kb, asked, names, view, timeout)
    try:
        holds, text, facts, things = answerer.answer(why, why_not)
    except _Several as found:
        options = joined(answerer.named(found.things[:LISTED]), "or")
        rest = len(found.things) - LISTED
        more = f" (there are {number(rest)} more)" if rest > 0 else ""
        which = sentence(f"which {short(found.noun.text)} do you mean: {options}{more}")[:-1]
        return Reply(question, asked.asks, f"{which}?", False, choices=found.things)
    return Reply(question, asked.asks, text, holds, tuple(things), tuple(facts))


_Found = tuple[bool, str, Sequence[Fitting], Sequence[str]]


class _Answerer:
    """Answers one question."""

    def __init__(
        self,
        kb: Inference,
        asked: Question,
        names: Callable[[str | None], Mapping[str, str]],
        view: str | None,
        timeout: float,
    ) -> None:
        self._kb, self._asked, self._timeout = kb, asked, timeout
        self._entry: Entry | None = entry_of(asked.word) if asked.word else None
        views = kb.scene.views
        self._looking = self._seen_from(asked.view) or view or (views[0].id if views else None)
        if self._entry is not None and self._entry.view and self._looking is None:
            raise QueryError(f"scene {kb.scene.id!r} has no view, so nothing is {self._entry.word} anything")
        self._view = self._looking if self._entry is not None and self._entry.view else None
        self._call, self._names = names, names(self._view)
        self._labels = {thing.id: thing.label for thing in kb.scene.objects}
        self._nouns = Nouns(kb.scene, self._names)

    def named(self, things: Iterable[str]) -> list[str]:
        return named(things, self._names)

    def answer(self, why: Callable[[str], Answer], why_not: Callable[[str], Refusal]) -> _Found:
        match self._asked.asks:
            case "where":
                return self._where()
            case "whether":
                return self._whether()
            case "why":
                return self._why(why)
            case "why_not":
                return self._why_not(why_not)
            case "count":
                return self._count()
            case "ground":
                return self._ground()
            case _:
                return self._which()

    @cached_property
    def _fitting(self) -> Accepted:
        return accepted(self._kb, self._timeout)

    @property
    def _word(self) -> str:
        return self._asked.word

    @property
    def _tail(self) -> str:
        if self._view is None:
            return ""
        (view,) = (one for one in self._kb.scene.views if one.id == self._view)
        return f" {perspective(view.label or view.id)}"

    def _seen_from(self, words: str | None) -> str | None:
        """Return the view that somebody's name means."""
        if words is None:
            return None
        text = " ".join(words.casefold().split()).removeprefix("the ")
        views = self._kb.scene.views
        for one in views:
            said = {one.id.casefold(), one.label.casefold()}
            if one.label == "you":
                said |= {"where you stand", "where i stand", "me", "here"}
            if text in said - {""}:
                return one.id
        known = sorted({one.label or one.id for one in views})
        close = get_close_matches(text[:100], known, n=1)
        hint = f"did you mean {close[0]!r}?" if close else f"there are {', '.join(map(short, known))}"
        raise QueryError(f"no view is called {short(words)!r}: {hint if known else 'the scene has none'}")

    def _all(self, noun: Noun | None) -> tuple[str, ...]:
        """Return the things that a noun means, be they one or many."""
        assert noun is not None  # noqa: S101 - the grammar has one here
        meant = self._nouns.meant(noun)
        if not meant.all and len(meant.things) > 1:
            raise _Several(noun, meant.things)
        return meant.things

    def _pairs(self, figures: Iterable[str] | None, grounds: Iterable[str] | None) -> list[Fitting]:
        """Return what fits, of some figures and some grounds; None for any."""
        wanted = [None if one is None else set(one) for one in (figures, grounds)]
        return [
            Fitting(self._word, figure, ground, self._view)
            for figure, ground in self._fitting.of(self._word, self._view)
            if (wanted[0] is None or figure in wanted[0]) and (wanted[1] is None or ground in wanted[1])
        ]

    def _verb(self, things: Sequence[str]) -> str:
        return "are" if len(things) > 1 or is_plural(self._labels[things[0]]) else "is"

    def _listed(self, things: Sequence[str], grounds: Sequence[str] = ()) -> str:
        """Return things as a list; where the sentence names their one ground, their names need not."""
        shown = things[:LISTED]
        if len(grounds) == 1:
            texts = [called(self._names, self._labels, thing, grounds[0]) for thing in shown]
        else:
            texts = self.named(shown)
        rest = len(things) - LISTED
        if rest > 0:
            texts.append(f"{number(rest)} more {'thing' if rest == 1 else 'things'}")
        return joined([short(one) for one in texts])

    def _which(self) -> _Found:
        asked = self._asked
        grounds = self._all(asked.ground)
        figures = None if asked.figure is None else self._nouns.meant(asked.figure).things
        facts = self._pairs(figures, grounds)
        things = list(dict.fromkeys(one.figure for one in facts))
        where = f"{self._word} {joined(self.named(grounds), 'or')}{self._tail}"
        if not things:
            kind = "nothing" if asked.figure is None else f"none of the {short(asked.figure.text)}"
            return False, sentence(f"{kind} is {where}"), facts, things
        verb = self._verb(things)
        return True, sentence(f"{self._listed(things, grounds)} {verb} {where}"), facts, things

    def _ground(self) -> _Found:
        figures = self._all(self._asked.figure)
        facts = self._pairs(figures, None)
        things = list(dict.fromkeys(one.ground for one in facts))
        subject = joined(self.named(figures))
        verb = self._verb(figures)
        if not things:
            return False, sentence(f"{subject} {verb} {self._word} nothing{self._tail}"), facts, things
        return (
            True,
            sentence(f"{subject} {verb} {self._word} {self._listed(things)}{self._tail}"),
            facts,
            things,
        )

    def _count(self) -> _Found:
        assert self._asked.figure is not None  # noqa: S101 - the grammar has one here
        grounds = self._all(self._asked.ground)
        facts = self._pairs(self._nouns.meant(self._asked.figure).things, grounds)
        things = list(dict.fromkeys(one.figure for one in facts))
        where = f"{self._word} {joined(self.named(grounds), 'or')}{self._tail}"
        if not things:
            return False, sentence(f"none is {where}"), facts, things
        verb = self._verb(things)
        text = sentence(f"{number(len(things))} {verb} {where}: {self._listed(things, grounds)}")
        return True, text, facts, things

    def _where(self) -> _Found:
        things = self._all(self._asked.figure)
        texts, facts = [], []
        for thing in things[:LISTED]:
            told = describe(self._kb, self._call, about=thing, view=self._looking, timeout=self._timeout)
            own = [one for one in told.sentences if one.facts[0].relation.figure == thing]
            texts += [one.text for one in own]
            facts += [
                Fitting(one.word, one.relation.figure, one.relation.reference, one.relation.view)
                for said in own
                for one in said.facts
            ]
        if not texts:
            return False, sentence(f"nothing tells where {joined(self.named(things))} is"), (), ()
        return True, " ".join(texts), facts, list(dict.fromkeys(one.ground for one in facts))

    def _statement(self, figures: Sequence[str], grounds: Sequence[str], negation: str = "") -> str:
        verb = self._verb(figures)
        figure, ground = joined(self.named(figures), "or"), joined(self.named(grounds), "or")
        return f"{figure} {verb}{negation} {self._word} {ground}{self._tail}"

    def _whether(self) -> _Found:
        figures, grounds = self._all(self._asked.figure), self._all(self._asked.ground)
        facts = self._pairs(figures, grounds)
        if not facts:
            return False, f"No, {self._statement(figures[:LISTED], grounds[:LISTED], ' not')}.", (), ()
        things = list(dict.fromkeys(one.figure for one in facts))
        held = list(dict.fromkeys(one.ground for one in facts))
        verb = self._verb(things)
        where = f"{self._word} {joined(self.named(held))}{self._tail}"
        return True, f"Yes, {self._listed(things, held)} {verb} {where}.", facts, things

    def _one_pair(self) -> tuple[str, str]:
        """Return the one figure and the one ground that a question for reasons is about."""
        pair = []
        for noun in (self._asked.figure, self._asked.ground):
            assert noun is not None  # noqa: S101 - the grammar has both here
            things = self._all(noun)
            if len(things) != 1:
                raise _Several(noun, things)
            pair.append(things[0])
        return pair[0], pair[1]

    def _why(self, why: Callable[[str], Answer]) -> _Found:
        figure, ground = self._one_pair()
        facts = self._pairs([figure], [ground])
        if not facts:
            return False, f"But {self._statement([figure], [ground], ' not')}.", (), ()
        for relation in self._senses(figure, ground):
            proof = why(relation.to_prolog()).proof
            if proof is not None:
                return True, proof.sentence(), facts, [figure]
        return True, sentence(self._statement([figure], [ground])), facts, [figure]

    def _why_not(self, why_not: Callable[[str], Refusal]) -> _Found:
        figure, ground = self._one_pair()
        facts = self._pairs([figure], [ground])
        if facts:
            return False, f"But {self._statement([figure], [ground])}.", facts, [figure]
        refusals = [why_not(one.to_prolog()) for one in self._senses(figure, ground, bases=False)]
        refusals = [one for one in refusals if not one.holds]
        # Of several senses, the one that is closest to being so.
        nearest = max(refusals, key=_closeness, default=None)
        if nearest is None:
            return True, f"{sentence(self._statement([figure], [ground], ' not'))}", (), ()
        return True, nearest.sentence(), (), ()

    def _senses(self, figure: str, ground: str, *, bases: bool = True) -> list[Relation]:
        """Return the relations that the word may stand for, of one pair, the most specific first."""
        assert self._entry is not None  # noqa: S101 - a question for reasons has a preposition
        found = [Relation(one.predicate, figure, ground, self._view, None) for one in self._entry.senses]
        if bases and self._word in BASES:
            found.append(Relation(BASES[self._word], figure, ground, None, None))
        return found


def _closeness(refusal: Refusal) -> tuple[bool, float]:
    """Return how close something is to being so: whether anything was measured, and by how much it fails."""
    margins = [one.derivation.margin for one in refusal.misses if one.derivation.margin is not None]
    return refusal.hindrance is None and bool(margins), max(margins, default=float("-inf"))
