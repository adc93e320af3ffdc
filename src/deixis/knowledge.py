"""The facade: a scene, its facts and the rules over them, with one method for each kind of question."""

from __future__ import annotations

import difflib
import os
import threading
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self

from deixis._files import rules_dir
from deixis.errors import QueryError
from deixis.facts import Facts, RegionModel, SolidModel, region_model
from deixis.grounding import ground
from deixis.regions import BoxRegion
from deixis.scene import Scene
from deixis.thresholds import SNAP_DECIMALS
from deixis.vocabulary import BASE, RELATIONS

if TYPE_CHECKING:
    from deixis.engines import Engine, Found
    from deixis.explain import Answer, Proof
    from deixis.prolog import Answers, PrologEngine
    from deixis.ruleset import Indicator, Ruleset

_ORDER = {term.name: position for position, term in enumerate((*BASE, *RELATIONS))}


@dataclass(frozen=True, slots=True)
class Relation:
    """A relation that holds in a scene.

    Attributes
    ----------
    relation : str
        Name of the predicate, as in :mod:`deixis.vocabulary`.
    figure, reference : str
        Ids of the two things, in the order of the predicate's arguments: of ``compl_cont`` the container
        comes first.
    view : str or None
        Id of the view, where it matters.
    margin : float or None
        Metres by which a measured length would have to change for the relation to cease.
    """

    relation: str
    figure: str
    reference: str
    view: str | None
    margin: float | None

    def to_prolog(self) -> str:
        """Return the relation as a Prolog fact without its full stop; ids are quoted."""
        from deixis.prolog.quote import atom

        ids = [self.figure, self.reference] + ([] if self.view is None else [self.view])
        return f"{self.relation}({','.join(map(atom, ids))})"

    def to_dict(self) -> dict[str, str | float | None]:
        """Return the relation as a dict, ready for JSON."""
        return {
            "relation": self.relation,
            "figure": self.figure,
            "reference": self.reference,
            "view": self.view,
            "margin": self.margin,
        }


@dataclass(frozen=True, slots=True)
class Withheld:
    """A view that says nothing of what is beside, behind or in front of a reference, and why."""

    view: str
    reference: str
    reason: str

    def to_dict(self) -> dict[str, str]:
        """Return the notice as a dict, ready for JSON."""
        return {"view": self.view, "reference": self.reference, "reason": self.reason}


class KnowledgeBase:
    """A scene with everything that follows from it.

    The geometry is grounded on first use; SWI-Prolog is started, in a process of its own, with the first
    question that needs it, and stopped by :meth:`close` or at the end of a ``with`` block.

    Parameters
    ----------
    scene : Scene
    rules : sequence of path
        Rule files of the user's own, in the subset that ``deixis rules check`` checks, loaded after the
        theory's. They are checked before any engine sees them.
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
        self._rules = tuple(Path(path) for path in rules)
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
        """Return the knowledge base of a scene, or of the scene file at a path.

        Raises
        ------
        SceneError
            The file is not a well-formed scene.
        """
        return cls(scene if isinstance(scene, Scene) else Scene.load(scene), rules=rules, region=region)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """Stop the logic engine, if it was started."""
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

    @property
    def rule_files(self) -> tuple[Path, ...]:
        """Return the user's rule files."""
        return self._rules

    @cached_property
    def ruleset(self) -> Ruleset:
        """Return the rules, read and checked.

        Raises
        ------
        RuleError
            A rule file does not exist, or something is wrong with it.
        """
        from deixis.ruleset import load

        return load(datalog_files(), self._rules)

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
                engine = PrologEngine([*theory_files(), *self._rules], tabled=self.tabled)
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
            Relation(name, row[0], row[1], row[2] if arity == 3 else None, _rounded(margin))
            for (name, arity), row, margin in self._derive(engine, wanted, timeout)
            if view is None or arity == 2 or row[2] == view
        ]
        last = len(_ORDER)
        found.sort(
            key=lambda one: (
                _ORDER.get(one.relation, last),
                one.relation,
                one.figure,
                one.reference,
                one.view or "",
            )
        )
        return tuple(found)

    def _derive(self, engine: Engine, wanted: Sequence[Indicator], timeout: float) -> Iterable[Found]:
        from deixis import engines

        if engine == "prolog":
            return engines.by_prolog(self.engine, wanted, timeout)
        derived = engines.by_sparql if engine == "sparql" else engines.by_sql
        labels = [(one.id, one.label) for one in self.scene.views]
        return derived(self.ruleset, self.facts, labels, wanted, timeout)

    def _predicates(self, name: str) -> list[Indicator]:
        """Return the predicates that a relation's name stands for."""
        known = {term.name: term.arity for term in (*BASE, *RELATIONS)}
        if name in known:
            return [(name, known[name])]
        own = self.ruleset.user if self._rules else frozenset()
        listed = {one: self.ruleset.kinds[one] for one in own if one[1] in (2, 3)}
        found = [one for one in sorted(listed) if one[0] == name]
        if not found:
            raise QueryError(f"no relation {name!r}{_hint(name, [*known, *sorted(n for n, _ in listed)])}")
        for predicate in found:
            if set(listed[predicate]) != {"name"}:
                raise QueryError(
                    f"{name}/{predicate[1]} is no relation of things: one of its arguments is no name; "
                    f"ask for it as a goal"
                )
        return found

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
        from deixis.prolog.engine import question_text

        reply: Any = self.engine.call("why", question_text(goal), timeout=timeout)
        if "unknown" in reply:
            known = [*self.facts.ids, *(view.id for view in self.scene.views)]
            name = reply["unknown"]
            raise QueryError(f"nothing is called {name!r} in scene {self.scene.id!r}{_hint(name, known)}")
        return Answer.from_dict({**reply, "measured_as": self.measured_as})

    def proofs(
        self, *, relation: Iterable[str] | None = None, timeout: float = 300.0
    ) -> dict[tuple[str, ...], Proof]:
        """Return the shortest proof of all that holds, by the relation's name and its arguments.

        Parameters
        ----------
        relation : iterable of str, optional
            As for :meth:`relations`.
        timeout : float
            Seconds.

        Raises
        ------
        QueryError, QueryTimeout, RuleError
            As :meth:`relations`.

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
            raise QueryError(f"no view {view!r} in scene {self.scene.id!r}{_hint(view, known)}")


def theory_files() -> tuple[Path, ...]:
    """Return the rule files of the theory, in loading order."""
    rules = rules_dir()
    names = ("facts", "topology", "direction", "commonsense", "axioms", "verbalise", "explain")
    return tuple(rules / f"{name}.pl" for name in names)


def datalog_files() -> tuple[Path, ...]:
    """Return the rule files of the theory that are in the subset every engine runs, in loading order."""
    return tuple(rules_dir() / f"{name}.pl" for name in ("facts", "topology", "direction", "commonsense"))


def _rounded(margin: float | None) -> float | None:
    """Return a margin to a nanometre, as lengths are measured: differences carry rounding noise."""
    return None if margin is None else round(margin, SNAP_DECIMALS)


def _hint(name: str, known: Sequence[str]) -> str:
    """Say what may have been meant."""
    if not known:
        return ": there are none"
    close = difflib.get_close_matches(name, known, n=1)
    return f": did you mean {close[0]!r}?" if close else f": known are {', '.join(known)}"
