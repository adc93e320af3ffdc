"""The facade: a scene, its facts and the rules over them, with one method for each kind of question."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any

from deixis.errors import QueryError
from deixis.frames import WORLD
from deixis.hints import hint
from deixis.inference import Inference
from deixis.vocabulary import RELATIONS
from deixis.wording import ENGLISH, Words

if TYPE_CHECKING:
    from deixis.consequences import Consequences
    from deixis.counterfactual import Change
    from deixis.engines import Engine
    from deixis.explain import Answer, Contrast, Proof, Proofs, Refusal
    from deixis.inspection import Inspection
    from deixis.words import Description, Reply


class KnowledgeBase(Inference):
    """A scene with everything that follows from it.

    The geometry is grounded on first use; SWI-Prolog is started, in a process of its own, with the first
    question that needs it, and stopped by :meth:`close` or at the end of a ``with`` block.

    Parameters
    ----------
    scene : Scene
    rules : sequence of path
        Rule files of the user's own, in the subset that ``deixis rules check`` checks, loaded after the
        theory's, or names of shipped ones: ``support``, ``background``, ``safety``. What they import with
        ``use_module`` is loaded too. They are checked before any engine sees them.
    region : "box", "hull" or "mesh"
        What things are measured as: their boxes, convex hulls, or meshes where they have one (decision 0017).
    language : str
        What sentences are in: a file of ``rules/lang``, ``en`` or ``de``.

    Examples
    --------
    >>> from deixis._files import kb_dir
    >>> with KnowledgeBase.from_scene(kb_dir() / "scenes" / "hans.json") as kb:
    ...     [found.reference for found in kb.relations(relation=["on_top_of"]) if found.figure == "sweater"]
    ['heater']
    """

    def why(self, goal: str, *, timeout: float = 10.0) -> Answer:
        """Return the shortest proof of a goal such as ``leans_on(ladder, wall)``, or how far it is from one.

        Raises
        ------
        QueryError
            The goal is not one relation of known things.
        QueryTimeout
            It took longer than ``timeout`` seconds.
        """
        from deixis.explain import Answer

        reply = {**self._explained("why", goal, timeout=timeout), "measured_as": self.measured_as}
        return Answer.from_dict(reply, self.words)

    def why_all(self, goal: str, *, limit: int = 20, timeout: float = 10.0) -> Proofs:
        """Return all proofs of a goal, the best first, at most ``limit``; raises as :meth:`why` does.

        Examples
        --------
        >>> from deixis._files import kb_dir
        >>> with KnowledgeBase.from_scene(kb_dir() / "scenes" / "hans.json") as kb:
        ...     found = kb.why_all("on_top_of(Thing, floor)")
        >>> [one.args[0] for one in found.proofs], found.truncated
        (['heater', 'extinguisher2'], False)
        """
        from deixis.explain import Proofs

        if limit < 1:
            raise QueryError(f"the limit is {limit}: ask for one proof at least")
        return Proofs.from_dict(self._explained("why_all", goal, limit, timeout=timeout), self.words)

    def why_not(self, goal: str, *, timeout: float = 10.0) -> Refusal:
        """Return what keeps each rule from concluding a goal, nearest first; raises as :meth:`why` does."""
        from deixis.explain import Refusal

        return Refusal.from_dict(self._explained("why_not", goal, timeout=timeout), self.words)

    def contrast(self, goal: str, rather_than: str, *, timeout: float = 10.0) -> Contrast:
        """Return why a goal holds rather than another; raises as :meth:`why` does.

        Examples
        --------
        >>> from deixis._files import kb_dir
        >>> with KnowledgeBase.from_scene(kb_dir() / "scenes" / "hans.json") as kb:
        ...     told = kb.contrast("on_top_of(sweater, heater)", "on_top_of(sweater, floor)")
        >>> bool(told), [one.derivation.predicate for one in told.other.misses]
        (True, ['on_top_of'])
        """
        from deixis.explain import Answer, Contrast, Refusal
        from deixis.prolog.engine import question_text

        told = self._explained("contrast", goal, question_text(rather_than), timeout=timeout)
        fact = {**told["fact"], "measured_as": self.measured_as}
        words = self.words
        return Contrast(Answer.from_dict(fact, words), Refusal.from_dict(told["other"], words), told["text"])

    @cached_property
    def words(self) -> Words:
        """Return the small words that join sentences, in the language that is spoken."""
        if self.language == "en":
            return ENGLISH
        told = self.engine.call("words")
        return Words(**{"and_" if name == "and" else name: text for name, text in told.items()})

    def names(self, *, view: str | None = None, timeout: float = 60.0) -> dict[str, str]:
        """Return what each thing is called: a phrase that picks out it and no other (decision 0033).

        That is its label, where it alone bears it; else what tells it from others by relations that hold;
        else label and id; and the id where there is no label. All sentences use these names.

        Parameters
        ----------
        view : str, optional
            Whoever hears the names knows that they are spoken from this view: left and right come first.
            Without it they do not, and only the one view of a scene with one is used, and named.
        timeout : float
            Seconds.

        Raises
        ------
        QueryError
            Unknown view.
        QueryTimeout
            It took longer than ``timeout`` seconds.

        Examples
        --------
        >>> from deixis._files import kb_dir
        >>> with KnowledgeBase.from_scene(kb_dir() / "scenes" / "hans.json") as kb:
        ...     names = kb.names()
        >>> names["heater"], names["extinguisher2"]
        ('the electric heater', 'the fire extinguisher on the floor')
        """
        from deixis.prolog import Atom

        if view is not None:
            self.check_view(view)
        given = [] if view is None else [Atom(view)]
        return dict(self.engine.call("names", *given, timeout=timeout))

    def _explained(self, operation: str, goal: str, *more: str | int, timeout: float) -> dict[str, Any]:
        from deixis.prolog.engine import question_text

        reply: Any = self.engine.call(operation, question_text(goal), *more, timeout=timeout)
        if "unknown" in reply:
            known = [*self.facts.ids, *(view.id for view in self.scene.views)]
            name = reply["unknown"]
            raise QueryError(f"nothing is called {name!r} in scene {self.scene.id!r}{hint(name, known)}")
        return dict(reply)

    def check(
        self,
        *,
        view: str | None = None,
        engine: Engine = "auto",
        reasons: bool = True,
        timeout: float = 60.0,
    ) -> Inspection:
        """Return which rules the scene breaks, by the rule files given, else by those of safety.

        A rule file states a breach as ``violation(name_of_the_rule, Thing) :- ...`` or with a third argument
        for another thing that is needed to see why; see ``rules/safety.pl``.

        Parameters
        ----------
        view : str, optional
            Look from this view only.
        engine : {"auto", "arrays", "duckdb", "prolog", "sparql"}
            What derives the breaches; the answer is the same.
        reasons : bool
            Whether to give each breach a sentence and a proof, which needs SWI-Prolog.
        timeout : float
            Seconds, for deriving the breaches and again for the reasons of each.

        Raises
        ------
        RuleError
            Something is wrong with a rule file, or none states a violation.

        Examples
        --------
        >>> from deixis._files import kb_dir
        >>> with KnowledgeBase.from_scene(kb_dir() / "scenes" / "hans.json") as kb:
        ...     print(kb.check().violations[-1].text)
        the sweater is a fire hazard on or against the electric heater
        """
        from deixis.inspection import inspect
        from deixis.ruleset import VIOLATIONS

        if view is not None or not self._rules:
            with self._variant(view) as variant:
                found = variant.check(engine=engine, reasons=reasons, timeout=timeout)
            return replace(found, view=view)
        breaches = self._derive(engine, sorted(VIOLATIONS & self.ruleset.user), timeout)
        why = partial(self.why, timeout=timeout) if reasons else None
        return inspect(self.scene, self.ruleset, breaches, why)

    def _variant(self, view: str | None) -> KnowledgeBase:
        """Return the same scene as seen from one view or all, with the rules given or those of safety."""
        scene, facts = self.scene, self.facts
        if view is not None:
            self.check_view(view)
            scene = replace(scene, views=tuple(one for one in scene.views if one.id == view))
            facts = replace(facts, views=tuple(one for one in facts.views if one.view in (WORLD, view)))
        rules = self._rules or ("safety",)
        variant = KnowledgeBase(scene, rules=rules, region=self.region, language=self.language)
        variant.facts = facts
        return variant

    def change(self, goal: str) -> Change | None:
        """Return the smallest translation found of a goal's figure that makes it true or, if it is, false.

        It is verified: after the move the answer is another, and at nine tenths of the way not yet. None
        where nothing within three metres changes it.

        Raises
        ------
        QueryError, GeometryError
            The goal is not one relation of known things, or its figure is a surface; the region model is
            not ``box``.

        Examples
        --------
        >>> from deixis._files import kb_dir
        >>> with KnowledgeBase.from_scene(kb_dir() / "scenes" / "hans.json") as kb:
        ...     found = kb.change("on_top_of(sweater, heater)")
        >>> found.thing, [round(metres, 3) for metres in found.offset], found.holds
        ('sweater', [0.0, 0.0, 0.02], False)
        """
        from deixis.counterfactual import named_fact, smallest_change

        known = [*self.facts.ids, *(view.id for view in self.scene.views)]
        fact = named_fact(goal, known, self._predicates)
        return smallest_change(self.scene, self.facts, self._executor, fact)

    def what_if(self, moves: Mapping[str, Sequence[float]]) -> KnowledgeBase:
        """Return the knowledge base of the scene in which some things are moved by x, y, z metres."""
        from deixis.counterfactual import moved
        from deixis.regrounding import reground

        then = moved(self.scene, moves)
        after = KnowledgeBase(then, rules=self._rules, region=self.region, language=self.language)
        after.facts = reground(self.scene, self.facts, after.scene)
        return after

    def consequences(
        self, moves: Mapping[str, Sequence[float]], *, limit: int | None = None, timeout: float = 60.0
    ) -> Consequences:
        """Return the relations gained and lost if some things are moved by x, y, z metres, with reasons.

        Examples
        --------
        >>> from deixis._files import kb_dir
        >>> with KnowledgeBase.from_scene(kb_dir() / "scenes" / "hans.json") as kb:
        ...     found = kb.consequences({"sweater": (0.0, 0.0, 0.1)})
        >>> len(found.gained), [one.because for one in found.lost]
        (0, ['The sweater is not on top of the electric heater (short by 8 cm).'])
        """
        from deixis.consequences import compared

        with self.what_if(moves) as then:
            before, after = self.relations(timeout=timeout), then.relations(timeout=timeout)
            return compared(before, after, partial(then.why, timeout=timeout), limit)

    def describe(
        self,
        *,
        about: str | None = None,
        view: str | None = None,
        most: int = 6,
        timeout: float = 60.0,
    ) -> Description:
        """Return the scene, or one thing of it, in a few sentences, with the relations each rests on.

        Parameters
        ----------
        about : str, optional
            Id of the one thing to speak of.
        view : str, optional
            Whose left and right; by default the first view's.
        most : int
            Sentences.
        timeout : float
            Seconds, for each engine.

        Raises
        ------
        QueryError
            Unknown thing or view.
        QueryTimeout
            It took longer than ``timeout`` seconds.

        Examples
        --------
        >>> from deixis._files import kb_dir
        >>> with KnowledgeBase.from_scene(kb_dir() / "scenes" / "hans.json") as kb:
        ...     print(kb.describe(about="sweater").text())
        The sweater is on the electric heater.
        """
        from deixis.words import describe

        names = partial(self._called, timeout=timeout)
        return describe(self, names, about=about, view=view, most=most, timeout=timeout)

    def say(self, question: str, *, view: str | None = None, timeout: float = 60.0) -> Reply:
        """Return the answer to a question in plain English, such as ``what is on the table?``.

        Parameters
        ----------
        question : str
            One of the kinds in :data:`deixis.words.questions.PATTERNS`.
        view : str, optional
            Whose left and right, where the question does not say; by default the first view's.
        timeout : float
            Seconds, for each engine.

        Raises
        ------
        QueryError
            The question is none of the known kinds, or names what is not there.
        QueryTimeout
            It took longer than ``timeout`` seconds.

        Examples
        --------
        >>> from deixis._files import kb_dir
        >>> with KnowledgeBase.from_scene(kb_dir() / "scenes" / "hans.json") as kb:
        ...     print(kb.say("What is on the heater?").text)
        The sweater is on the electric heater.
        """
        from deixis.words import say

        names = partial(self._called, timeout=timeout)
        why, why_not = partial(self.why, timeout=timeout), partial(self.why_not, timeout=timeout)
        return say(self, question, names, why, why_not, view=view, timeout=timeout)

    def _called(self, view: str | None, timeout: float) -> Mapping[str, str]:
        """Return what each thing is called in English; Prolog is asked only where a label does not tell."""
        from deixis.words.nouns import plain_names

        plain = plain_names(self.scene)
        if self.language != "en" or len(set(plain.values())) == len(plain):
            return plain
        return self.names(view=view, timeout=timeout)

    def proofs(
        self, *, relation: Iterable[str] | None = None, timeout: float = 300.0
    ) -> dict[tuple[str, ...], Proof]:
        """Return the shortest proof of all that holds, by the relation's name and its arguments.

        What is asked for, and what is raised, is as for :meth:`relations`.

        Examples
        --------
        >>> from deixis._files import kb_dir
        >>> with KnowledgeBase.from_scene(kb_dir() / "scenes" / "hans.json") as kb:
        ...     kb.proofs(relation=["leans_on"])["leans_on", "extinguisher2", "wall"].axiom
        37
        """
        from deixis.explain import Proof
        from deixis.prolog import Atom

        names = [term.name for term in RELATIONS] if relation is None else list(dict.fromkeys(relation))
        wanted: list[Any] = [[Atom(name), arity] for one in names for name, arity in self._predicates(one)]
        found: Any = self.engine.call("proofs", *wanted, timeout=timeout)
        proofs = (Proof.from_dict(one, self.words) for one in found)
        return {(one.predicate, *map(str, one.args)): one for one in proofs}
