"""Inference: a scene, its facts and the rules over them, and the engines that derive what follows."""

from __future__ import annotations

import os
import threading
from collections.abc import Iterable, Sequence
from functools import cache, cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Self

from deixis._files import datalog_files, theory_files
from deixis.errors import QueryError
from deixis.facts import Facts, RegionModel, SolidModel, region_model
from deixis.frames import WORLD
from deixis.grounding import ground
from deixis.hints import hint
from deixis.regions import BoxRegion
from deixis.relations import Relation, Withheld, in_order, rounded
from deixis.scene import Scene
from deixis.vocabulary import asked_for

if TYPE_CHECKING:
    from deixis.engines import AutoExecutor, Engine, Found
    from deixis.prolog import Answers, PrologEngine
    from deixis.ruleset import Indicator, Ruleset
    from deixis.ruleset.tables import Executor


class Inference:
    """What follows from a scene, found by whichever engine is asked.

    Facts are grounded and engines started on first use. Parameters are those of
    :class:`~deixis.knowledge.KnowledgeBase`, which adds the questions that people ask.
    """

    def __init__(
        self,
        scene: Scene,
        *,
        rules: Sequence[str | os.PathLike[str]] | os.PathLike[str] = (),
        region: RegionModel = "box",
        language: str = "en",
        facts: Facts | None = None,
    ) -> None:
        self.scene = scene
        self.region = region_model(region)
        self.language = language
        self._theory = theory_files(language)
        if facts is not None:
            self.region = facts.region
            self.facts = _of_scene(facts, scene)
        self._rules = (rules,) if isinstance(rules, (str, os.PathLike)) else tuple(rules)
        self._engine: PrologEngine | None = None
        self._loaded: Facts | None = None
        self._starting = threading.Lock()

    @classmethod
    def from_scene(
        cls,
        scene: Scene | str | os.PathLike[str],
        *,
        rules: Sequence[str | os.PathLike[str]] | os.PathLike[str] = (),
        region: RegionModel = "box",
        language: str = "en",
    ) -> Self:
        """Return the knowledge base of a scene, or of the scene file at a path, if it is well formed."""
        loaded = scene if isinstance(scene, Scene) else Scene.load(scene)
        return cls(loaded, rules=rules, region=region, language=language)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Stop the logic engines, if they were started."""
        executor: AutoExecutor | None = self.__dict__.pop("_executor", None)
        if executor is not None:
            executor.close()
        if self._engine is not None:
            self._engine.close()
            self._engine = None

    @cached_property
    def facts(self) -> Facts:
        """Return the grounded scene: the facts given, or else measured here."""
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

        return load(datalog_files(), self.rule_files) if self._rules else _theory()

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
                engine = PrologEngine([*self._theory, *self.rule_files], tabled=self.tabled)
                try:
                    loaded = self._load(engine)
                except BaseException:
                    engine.close()
                    raise
                self._engine, self._loaded = engine, loaded
            elif self._loaded is not self.facts:
                self._loaded = self._load(self._engine)
            return self._engine

    def _load(self, engine: PrologEngine) -> Facts:
        """Load the facts; return those of before: if the scene changes meanwhile, they are loaded again."""
        from deixis.prolog.text import facts_parts

        facts = self.facts
        engine.load(facts_parts(facts, [(view.id, view.label) for view in self.scene.views]))
        return facts

    def relations(
        self,
        *,
        view: str | None = None,
        relation: Iterable[str] | None = None,
        timeout: float = 60.0,
        engine: Engine = "auto",
    ) -> tuple[Relation, ...]:
        """Return the relations that hold, in the order of the vocabulary, then by ids.

        Parameters
        ----------
        view : str, optional
            Only this view's horizontal relations; those that depend on no view are always included.
        relation : str or iterable of str, optional
            Only this relation or these; by default all that people speak in. Base relations (``touches``,
            ``east_r`` ...) and predicates of the user's rule files with two or three names for arguments
            are given when named; a third argument is taken for the view.
        timeout : float
            Seconds.
        engine : {"auto", "arrays", "duckdb", "prolog", "sparql"}
            What derives them; the answer is the same. By default arrays, or DuckDB for maps.

        Raises
        ------
        QueryError
            Unknown view or relation.
        QueryTimeout
            It took longer than ``timeout``.
        RuleError
            Something is wrong with a rule file.
        """
        names = asked_for(relation)
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
        labels = [(one.id, one.label) for one in self.scene.views]
        if engine == "sparql":
            return engines.by_sparql(self._executor, self.facts, labels, wanted, timeout)
        executor: Executor = self._executor
        if engine == "arrays":
            executor = self._executor.arrays
        elif engine == "duckdb":
            executor = self._executor.sql
        return engines.by_tables(executor, self.facts, labels, wanted, timeout)

    @cached_property
    def _executor(self) -> AutoExecutor:
        from deixis.engines import AutoExecutor

        return AutoExecutor(self.ruleset)

    def _predicates(self, name: str) -> list[Indicator]:
        """Return the predicates that a relation's name stands for."""
        from deixis.engines import predicates

        return predicates(name, self.ruleset if self._rules else None)

    def ask(self, goal: str, *, limit: int | None = None, timeout: float = 10.0) -> Answers:
        """Return the answers to a Prolog goal such as ``on_top_of(X, table)``.

        A relation of what is not there does not hold; ``unknown`` of the answers has the names of such.

        Raises
        ------
        QueryError
            The goal is not well formed, not allowed, or names an unknown predicate.
        QueryTimeout
            It took longer than ``timeout`` seconds.
        """
        return self.engine.ask(goal, limit=limit, timeout=timeout)

    def unknown_name(self, name: str) -> str:
        """Return that nothing in the scene has a name, and what may have been meant."""
        known = [*self.facts.ids, *(view.id for view in self.scene.views)]
        return f"nothing is called {name!r} in scene {self.scene.id!r}{hint(name, known)}"

    def variables_like_names(self, *goals: str) -> list[str]:
        """Return a note on each variable of some relations that is an id of the scene but for its capitals.

        A goal that cannot be read has none: whoever asks it is told what is wrong.
        """
        from deixis.ruleset import read_text
        from deixis.ruleset.model import variables

        known = [*(one.id for one in self.scene.objects), *(one.id for one in self.scene.views)]
        meant = {one.lower(): one for one in known}
        read = [read_text(f"{goal.strip().removesuffix('.')} .", Path("goal"))[0] for goal in goals]
        named = [one.name for file in read for rule in file.rules for one in variables(rule.head)]
        return [
            f"{name} is a variable, which stands for anything: did you mean {meant[name.lower()]!r}?"
            for name in dict.fromkeys(named)
            if name.lower() in meant
        ]

    def check_view(self, view: str) -> None:
        """Raise :class:`QueryError` unless the scene has this view."""
        known = [one.id for one in self.scene.views]
        if view not in known:
            called = next((one.id for one in self.scene.views if one.label == view), None)
            meant = hint(view, known) if called is None else f": it is called {called!r}"
            raise QueryError(f"no view {view!r} in scene {self.scene.id!r}{meant}")


def _of_scene(facts: Facts, scene: Scene) -> Facts:
    """Return facts, unless they are of other things or seen from other views than a scene's."""
    told = (facts.ids, tuple(view.view for view in facts.views))
    if told != (tuple(thing.id for thing in scene.objects), (WORLD, *(view.id for view in scene.views))):
        raise QueryError(
            f"the facts given are not those of scene {scene.id!r}: ground it, its things and its views, anew"
        )
    return facts


@cache
def _theory() -> Ruleset:
    """Return the theory's rules, read once in a process: reading takes longer than a scene's relations."""
    from deixis.ruleset import load

    return load(datalog_files())
