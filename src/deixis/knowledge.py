"""The facade: a scene, its facts and the rules over them, with one method for each kind of question."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any, Final

from deixis.following import Following
from deixis.frames import WORLD
from deixis.vocabulary import RELATIONS

if TYPE_CHECKING:
    from deixis.consequences import Consequences
    from deixis.counterfactual import Change
    from deixis.engines import Engine
    from deixis.inspection import Inspection
    from deixis.words import Description, Reply

MOST_IN_A_NOTEBOOK: Final = 200
"""Things of a scene that a notebook shows unasked; `deixis view` shows any."""


class KnowledgeBase(Following):
    """A scene with everything that follows from it.

    The geometry is grounded on first use; SWI-Prolog is started, in a process of its own, with the first
    question that needs it, and stopped by :meth:`close` or at the end of a ``with`` block.

    Parameters
    ----------
    scene : Scene
    rules : path or sequence of path
        Rule files of the user's own, in the subset that ``deixis rules check`` checks, loaded after the
        theory's, or names of shipped ones: ``support``, ``background``, ``safety``. What they import with
        ``use_module`` is loaded too. They are checked before any engine sees them.
    region : "box", "hull" or "mesh"
        What things are measured as: their boxes, convex hulls, or meshes where they have one (decision 0017).
    language : str
        What sentences are in: a file of ``rules/lang``, ``en`` or ``de``.
    facts : Facts, optional
        The scene as grounded elsewhere, such as by :func:`deixis.postgis.ground`.

    Examples
    --------
    >>> from deixis._files import kb_dir
    >>> with KnowledgeBase.from_scene(kb_dir() / "scenes" / "hans.json") as kb:
    ...     [found.reference for found in kb.relations(relation=["on_top_of"]) if found.figure == "sweater"]
    ['heater']
    """

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
        return KnowledgeBase(scene, rules=rules, language=self.language, facts=facts)

    def change(self, goal: str) -> Change | None:
        """Return the smallest translation found of a goal's figure that makes it true or, if it is, false.

        It is verified: after the move the answer is another, and at nine tenths of the way not yet. None
        where no such move within three metres is found.

        Raises
        ------
        QueryError, GeometryError
            The goal is not one relation of known things, or its figure is a surface; nothing is found, and
            rules of one's own name the figure; the region model is not ``box``.

        Examples
        --------
        >>> from deixis._files import kb_dir
        >>> with KnowledgeBase.from_scene(kb_dir() / "scenes" / "hans.json") as kb:
        ...     found = kb.change("on_top_of(sweater, heater)")
        >>> found.thing, [round(metres, 3) for metres in found.offset], found.holds
        ('sweater', [0.0, 0.0, 0.02], False)
        """
        from deixis.counterfactual import named_fact, names_in_rules, smallest_change

        known = [*self.facts.ids, *(view.id for view in self.scene.views)]
        fact = named_fact(goal, known, self._predicates)
        named = names_in_rules(self.ruleset, (fact[0], len(fact) - 1))
        return smallest_change(self.scene, self.facts, self._executor, fact, named)

    def what_if(self, moves: Mapping[str, Sequence[float]]) -> KnowledgeBase:
        """Return the knowledge base of the scene in which some things are moved by x, y, z metres."""
        from deixis.counterfactual import moved
        from deixis.regrounding import reground

        then = moved(self.scene, moves)
        facts = reground(self.scene, self.facts, then)
        return KnowledgeBase(then, rules=self._rules, language=self.language, facts=facts)

    def page(self, *, timeout: float = 300.0) -> str:
        """Return a page, one file of HTML, that shows the scene, its relations and their reasons.

        It needs nothing else: no server and no network.

        Raises
        ------
        MissingDependency
            The script of the page is not part of this installation.
        QueryTimeout
            The proofs of all relations took longer than ``timeout`` seconds.

        Examples
        --------
        >>> from deixis._files import kb_dir
        >>> from deixis.view import available
        >>> with KnowledgeBase.from_scene(kb_dir() / "scenes" / "hans.json") as kb:
        ...     "leans on the wall" in kb.page() if available() else True
        True
        """
        from deixis.view import page_html

        return page_html(f"{self.scene.id}: Deixis", *self.page_data(timeout=timeout))

    def page_data(self, *, timeout: float = 300.0) -> tuple[dict[str, Any], dict[str, Any]]:
        """Return the data of the page: what it needs at once, and what when something is selected."""
        from deixis.view import Shown, page_data

        names = [term.name for term in RELATIONS]
        if self._rules:
            kinds = self.ruleset.kinds
            own = [one for one in sorted(self.ruleset.user) if one[1] in (2, 3)]
            odd = {name for name, arity in own if set(kinds[name, arity]) != {"name"}}
            names += dict.fromkeys(name for name, _ in own if name not in odd)
        # The margin of a relation is that of its widest proof, which need not be the shortest.
        margins = {
            (one.relation, one.figure, one.reference, *([] if one.view is None else [one.view])): one.margin
            for one in self.relations(relation=names, timeout=timeout)
        }
        proofs = self.proofs(relation=names, evidence=True, timeout=timeout)
        # In lists and on labels without the article.
        called = {thing: name.removeprefix("the ") for thing, name in self.names(timeout=timeout).items()}
        found = [Shown(proof, margins[key]) for key, proof in proofs.items()]
        return page_data(self.scene, self.facts, found, called)

    def _repr_html_(self) -> str | None:
        """Return the page in a frame of its own, for notebooks; None where it is not there, or too large."""
        from deixis.view import available, framed

        if not available() or len(self.scene.objects) > MOST_IN_A_NOTEBOOK:
            return None
        return framed(self.page())

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
