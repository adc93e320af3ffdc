"""The facade: a scene, its facts and the rules over them, with one method for each kind of question."""

from __future__ import annotations

import os
import threading
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from functools import cached_property, partial
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self

from deixis._files import datalog_files, theory_files
from deixis.errors import QueryError
from deixis.facts import Facts, RegionModel, SolidModel, region_model
from deixis.frames import WORLD
from deixis.grounding import ground
from deixis.hints import hint
from deixis.regions import BoxRegion
from deixis.relations import Relation, Withheld, in_order, rounded
from deixis.scene import Scene
from deixis.vocabulary import RELATIONS

if TYPE_CHECKING:
    from deixis.counterfactual import Change
    from deixis.engines import Engine, Found
    from deixis.explain import Answer, Proof, Refusal
    from deixis.inspection import Inspection
    from deixis.prolog import Answers, PrologEngine
    from deixis.ruleset import Indicator, Ruleset
    from deixis.sql import SqlExecutor


class KnowledgeBase:
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

    Examples
    --------
    >>> from deixis._files import kb_dir
    >>> with KnowledgeBase.from_scene(kb_dir() / "scenes" / "hans.json") as kb:
    ...     [found.reference for found in kb.relations(relation=["on_top_of"]) if found.figure == "sweater"]
    ['heater']
    """

    def __init__(
        self, scene: Scene, *, rules: Sequence[str | os.PathLike[str]] = (), region: RegionModel = "box"
    ) -> None:
        self.scene = scene
        self.region = region_model(region)
        self._rules = tuple(rules)
        self._engine: PrologEngine | None = None
        self._starting = threading.Lock()

    @classmethod
    def from_scene(
        cls,
        scene: Scene | str | os.PathLike[str],
        *,
        rules: Sequence[str | os.PathLike[str]] = (),
        region: RegionModel = "box",
    ) -> KnowledgeBase:
        """Return the knowledge base of a scene, or of the scene file at a path, if it is well formed."""
        return cls(scene if isinstance(scene, Scene) else Scene.load(scene), rules=rules, region=region)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """Stop the logic engines, if they were started."""
        sql: SqlExecutor | None = self.__dict__.pop("_sql", None)
        if sql is not None:
            sql.close()
        if self._engine is not None:
            self._engine.close()
            self._engine = None

    @cached_property
    def facts(self) -> Facts:
        """Return the grounded scene."""
        return ground(self.scene, region=self.region)

    @property
    def measured_as(self) -> dict[str, SolidModel]:
        """Return what each thing was measured as, by its id: a thing that has only a box is that box."""
        return dict(zip(self.facts.ids, self.facts.models, strict=True))

    @property
    def box_only(self) -> tuple[str, ...]:
        """Return the ids of things that have nothing but a box, where more was asked for."""
        if self.region == "box":
            return ()
        return tuple(thing.id for thing in self.scene.objects if isinstance(thing.region, BoxRegion))

    @property
    def withheld(self) -> tuple[Withheld, ...]:
        """Return which references have no front and sides in which views, with the reasons."""
        return tuple(
            Withheld(view.view, self.facts.ids[index], reason)
            for view in self.facts.views
            for index, reason in view.withheld
        )

    def facts_text(self, *, readable: bool = True) -> str:
        """Return the base facts, by the contract of ``rules/facts.pl``: as clauses, or faster as one list."""
        from deixis.prolog.text import facts_text

        views = [(view.id, view.label) for view in self.scene.views]
        return facts_text(self.facts, views, readable=readable)

    @cached_property
    def ruleset(self) -> Ruleset:
        """Return the rules, read and checked.

        Raises
        ------
        RuleError
            A rule file does not exist, or something is wrong with it.
        """
        from deixis.ruleset import load

        return load(datalog_files(), self.rule_files)

    @cached_property
    def rule_files(self) -> tuple[Path, ...]:
        """Return the user's rule files, each after those it imports; one that is not there is an error."""
        from deixis.ruleset import locate

        return locate(self._rules, datalog_files()) if self._rules else ()

    @property
    def tabled(self) -> list[Indicator]:
        """Return the user's predicates that need tables in Prolog, since they are recursive."""
        return sorted(self.ruleset.graph.recursive) if self._rules else []

    @property
    def engine(self) -> PrologEngine:
        """Return the logic engine with rules and facts loaded, started if need be."""
        with self._starting:
            if self._engine is None:
                from deixis.prolog import PrologEngine

                # Starting does not wait: Prolog comes up while the geometry is grounded.
                engine = PrologEngine([*theory_files(), *self.rule_files], tabled=self.tabled)
                try:
                    engine.load(self.facts_text(readable=False))
                except BaseException:
                    engine.close()
                    raise
                self._engine = engine
            return self._engine

    def relations(
        self,
        *,
        view: str | None = None,
        relation: Iterable[str] | None = None,
        timeout: float = 60.0,
        engine: Engine = "duckdb",
    ) -> tuple[Relation, ...]:
        """Return the relations that hold, in the order of the vocabulary, then by ids.

        Parameters
        ----------
        view : str, optional
            Only this view's horizontal relations; those that depend on no view are always included.
        relation : iterable of str, optional
            Only these relations; by default all that people speak in. Base relations (``touches``,
            ``east_r`` ...) and predicates of the user's rule files with two or three names for arguments
            are given when named; a third argument is taken for the view.
        timeout : float
            Seconds.
        engine : {"duckdb", "prolog", "sparql"}
            What derives them; the answer is the same.

        Raises
        ------
        QueryError
            Unknown view or relation.
        QueryTimeout
            It took longer than ``timeout``.
        RuleError
            Something is wrong with a rule file.
        """
        names = [term.name for term in RELATIONS] if relation is None else list(dict.fromkeys(relation))
        wanted = [predicate for name in names for predicate in self._predicates(name)]
        if view is not None:
            self.check_view(view)
        found = [
            Relation(name, row[0], row[1], row[2] if arity == 3 else None, rounded(margin))
            for (name, arity), row, margin in self._derive(engine, wanted, timeout)
            if view is None or arity == 2 or row[2] == view
        ]
        return in_order(found)

    def _derive(self, engine: Engine, wanted: Sequence[Indicator], timeout: float) -> Iterable[Found]:
        from deixis import engines

        if engine == "prolog":
            return engines.by_prolog(self.engine, wanted, timeout)
        derived = engines.by_sparql if engine == "sparql" else engines.by_sql
        labels = [(one.id, one.label) for one in self.scene.views]
        return derived(self._sql, self.facts, labels, wanted, timeout)

    @cached_property
    def _sql(self) -> SqlExecutor:
        from deixis.sql import SqlExecutor

        return SqlExecutor(self.ruleset)

    def _predicates(self, name: str) -> list[Indicator]:
        """Return the predicates that a relation's name stands for."""
        from deixis.engines import predicates

        return predicates(name, self.ruleset if self._rules else None)

    def ask(self, goal: str, *, limit: int | None = None, timeout: float = 10.0) -> Answers:
        """Return the answers to a Prolog goal such as ``on_top_of(X, table)``.

        Raises
        ------
        QueryError
            The goal is not well formed, not allowed, or names an unknown predicate.
        QueryTimeout
            It took longer than ``timeout`` seconds.
        """
        return self.engine.ask(goal, limit=limit, timeout=timeout)

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
        variant = KnowledgeBase(scene, rules=self._rules or ("safety",), region=self.region)
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
        return smallest_change(self.scene, self.facts, self._sql, fact)

    def what_if(self, moves: Mapping[str, Sequence[float]]) -> KnowledgeBase:
        """Return the knowledge base of the scene in which some things are moved by x, y, z metres."""
        from deixis.counterfactual import moved
        from deixis.regrounding import reground

        after = KnowledgeBase(moved(self.scene, moves), rules=self._rules, region=self.region)
        after.__dict__["facts"] = reground(self.scene, self.facts, after.scene)
        return after

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

    def check_view(self, view: str) -> None:
        """Raise :class:`QueryError` unless the scene has this view."""
        known = [one.id for one in self.scene.views]
        if view not in known:
            raise QueryError(f"no view {view!r} in scene {self.scene.id!r}{hint(view, known)}")
