"""The facade: a scene, its facts and the rules over them, with one method for each kind of question."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any

from deixis.errors import QueryError
from deixis.frames import WORLD
from deixis.hints import hint
from deixis.inference import Inference
from deixis.vocabulary import RELATIONS

if TYPE_CHECKING:
    from deixis.counterfactual import Change
    from deixis.engines import Engine
    from deixis.explain import Answer, Proof, Refusal
    from deixis.inspection import Inspection


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
    facts : Facts, optional
        The scene as grounded elsewhere, such as by :func:`deixis.postgis.ground`.

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

        return Answer.from_dict({**self._explained("why", goal, timeout), "measured_as": self.measured_as})

    def why_not(self, goal: str, *, timeout: float = 10.0) -> Refusal:
        """Return what keeps each rule from concluding a goal, nearest first; raises as :meth:`why` does."""
        from deixis.explain import Refusal

        return Refusal.from_dict(self._explained("why_not", goal, timeout))

    def _explained(self, operation: str, goal: str, timeout: float) -> dict[str, Any]:
        from deixis.prolog.engine import question_text

        reply: Any = self.engine.call(operation, question_text(goal), timeout=timeout)
        if "unknown" in reply:
            known = [*self.facts.ids, *(view.id for view in self.scene.views)]
            name = reply["unknown"]
            raise QueryError(f"nothing is called {name!r} in scene {self.scene.id!r}{hint(name, known)}")
        return dict(reply)

    def check(
        self,
        *,
        view: str | None = None,
        engine: Engine = "duckdb",
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
        engine : {"duckdb", "prolog", "sparql"}
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
        return KnowledgeBase(scene, rules=self._rules or ("safety",), facts=facts)

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
        return smallest_change(self.scene, self.facts, self._sql, fact)

    def what_if(self, moves: Mapping[str, Sequence[float]]) -> KnowledgeBase:
        """Return the knowledge base of the scene in which some things are moved by x, y, z metres."""
        from deixis.counterfactual import moved
        from deixis.regrounding import reground

        scene = moved(self.scene, moves)
        return KnowledgeBase(scene, rules=self._rules, facts=reground(self.scene, self.facts, scene))

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
        proofs = map(Proof.from_dict, found)
        return {(one.predicate, *map(str, one.args)): one for one in proofs}
