"""Explaining: why something holds or does not, and what things are called, asked of SWI-Prolog."""

from __future__ import annotations

from collections.abc import Iterable
from functools import cached_property
from typing import TYPE_CHECKING, Any

from deixis.errors import QueryError
from deixis.inference import Inference
from deixis.vocabulary import asked_for
from deixis.wording import ENGLISH, Words

if TYPE_CHECKING:
    from deixis.explain import Answer, Contrast, Proof, Proofs, Refusal
    from deixis.leaves import Explained, Gathering


class Explaining(Inference):
    """The reasons of what follows from a scene; parameters as of :class:`~deixis.knowledge.KnowledgeBase`."""

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
        >>> from deixis.knowledge import KnowledgeBase
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

    def evidence(self, found: Explained) -> Explained:
        """Return an answer, a refusal, an inspection or a proof with the evidence of its leaves.

        That is what was measured and compared, by name, and what is to be seen of it: see
        :class:`deixis.evidence.Evidence`.

        Examples
        --------
        >>> from deixis._files import kb_dir
        >>> from deixis.knowledge import KnowledgeBase
        >>> with KnowledgeBase.from_scene(kb_dir() / "scenes" / "hans.json") as kb:
        ...     proof = kb.evidence(kb.why("on_top_of(sweater, heater)")).proof
        >>> proof.children[1].children[0].evidence.witness.points
        ((1.6, 1.9, 0.6), (1.6, 1.9, 0.6))
        """
        from deixis.leaves import with_evidence

        return with_evidence(self._gathering, found)

    @cached_property
    def _gathering(self) -> Gathering:
        from deixis.leaves import Gathering

        return Gathering(self.scene, self.facts)

    def contrast(self, goal: str, rather_than: str, *, timeout: float = 10.0) -> Contrast:
        """Return why a goal holds rather than another; raises as :meth:`why` does.

        Examples
        --------
        >>> from deixis._files import kb_dir
        >>> from deixis.knowledge import KnowledgeBase
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
        >>> from deixis.knowledge import KnowledgeBase
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
            raise QueryError(self.unknown_name(reply["unknown"]))
        return dict(reply)

    def proofs(
        self, *, relation: Iterable[str] | None = None, evidence: bool = False, timeout: float = 300.0
    ) -> dict[tuple[str, ...], Proof]:
        """Return the shortest proof of all that holds, by the relation's name and its arguments.

        With ``evidence`` the leaves have theirs, as :meth:`evidence` gives it. What is asked for, and what is
        raised, is as for :meth:`relations`.

        Examples
        --------
        >>> from deixis._files import kb_dir
        >>> from deixis.knowledge import KnowledgeBase
        >>> with KnowledgeBase.from_scene(kb_dir() / "scenes" / "hans.json") as kb:
        ...     kb.proofs(relation=["leans_on"])["leans_on", "extinguisher2", "wall"].axiom
        37
        """
        from deixis.explain import Proof
        from deixis.prolog import Atom

        names = asked_for(relation)
        wanted: list[Any] = [[Atom(name), arity] for one in names for name, arity in self._predicates(one)]
        found: Any = self.engine.call("proofs", *wanted, timeout=timeout)
        proofs = [Proof.from_dict(one, self.words) for one in found]
        if evidence:
            proofs = self._gathering.gather(proofs)
        return {(one.predicate, *map(str, one.args)): one for one in proofs}
