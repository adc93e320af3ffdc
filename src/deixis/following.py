"""Following: a scene that changes, and those who are told what each change made hold."""

from __future__ import annotations

import math
import os
import threading
from collections import deque
from collections.abc import Callable, Sequence
from functools import cached_property
from typing import TYPE_CHECKING

from deixis.explaining import Explaining
from deixis.facts import Facts, RegionModel
from deixis.relations import Relation, in_order, rounded
from deixis.scene import Scene
from deixis.vocabulary import RELATIONS

if TYPE_CHECKING:
    from deixis.living import Known, Living
    from deixis.updates import Changes, Update


class Following(Explaining):
    """What follows from a scene that changes; parameters as of :class:`~deixis.knowledge.KnowledgeBase`."""

    def __init__(
        self,
        scene: Scene,
        *,
        rules: Sequence[str | os.PathLike[str]] = (),
        region: RegionModel = "box",
        language: str = "en",
        facts: Facts | None = None,
    ) -> None:
        super().__init__(scene, rules=rules, region=region, language=language, facts=facts)
        self._updating = threading.Lock()
        self._subscribers: dict[object, Callable[[Changes], object]] = {}
        self._untold: deque[Changes] = deque()
        self._telling = False

    def update(self, update: Update) -> Changes:
        """Change the scene; return which relations hold now and did not, and the reverse.

        Facts and relations are kept up at the cost of what can have changed; they are always those of a full
        run. The relations are all that people speak in, and those that rules of one's own state. An update
        that is refused leaves everything as it was. All subscribers are told, then the error of one that
        failed is raised, or of several an ``ExceptionGroup``; the scene has changed by then.

        Raises
        ------
        SceneError
            Something in the update is not there, or told twice.

        Examples
        --------
        >>> from deixis._files import kb_dir
        >>> from deixis.knowledge import KnowledgeBase
        >>> from deixis.updates import Update
        >>> with KnowledgeBase.from_scene(kb_dir() / "scenes" / "hans.json") as kb:
        ...     lifted = Update.from_dict({"moves": {"sweater": [0, 0, 0.1]}}, kb.scene)
        ...     changes = kb.update(lifted)
        ...     [one.to_prolog() for one in changes.lost], changes.because(changes.lost[0])
        (["on_top_of('sweater','heater')"],
         'The sweater is not on top of the electric heater (short by 8 cm).')
        """
        from deixis.regrounding import reground
        from deixis.updates import Changes

        with self._updating:
            living = self._living
            after = update.applied(self.scene)
            facts = reground(self.scene, self.facts, after)
            labels = [(view.id, view.label) for view in after.views]
            looked = bool(update.views or update.removed_views)
            found = living.advance(facts, labels, update.things, looked=looked)
            self.scene, self.facts = after, facts
            # What was made of the facts of before is made anew when it is asked for.
            self.__dict__.pop("_gathering", None)
            gained, lost = (in_order(map(_relation, some.items())) for some in (found.gained, found.lost))
            changes = Changes(update.stamp, gained, lost, _Reasons(self, after, update))
            if self._subscribers:
                self._untold.append(changes)
        self._tell()
        return changes

    @property
    def kept(self) -> tuple[Relation, ...]:
        """Return the relations that :meth:`update` keeps up, with their margins as they are now."""
        with self._updating:
            return in_order(map(_relation, self._living.holds.items()))

    def subscribe(self, subscriber: Callable[[Changes], object]) -> Callable[[], None]:
        """Call a function with the changes of each update from now on; return how to end that.

        Changes are told in the order of the updates, one after the other, as a rule in the thread that made
        the update. Where one is told already, an update that is made meanwhile, by a function that is called
        or in another thread, is told after it in the same thread.
        """
        key = object()
        self._subscribers[key] = subscriber

        def end() -> None:
            self._subscribers.pop(key, None)

        return end

    def _tell(self) -> None:
        """Tell all that is not told yet, unless someone does; what is raised is raised when all is told."""
        with self._updating:
            if self._telling:
                return
            self._telling = True
        errors: list[Exception] = []
        try:
            while (changes := self._next()) is not None:
                for subscriber in tuple(self._subscribers.values()):
                    try:
                        subscriber(changes)
                    except Exception as error:  # noqa: BLE001 - raised below
                        errors.append(error)
        except BaseException:
            self._telling = False
            raise
        if len(errors) == 1:
            raise errors[0]
        if errors:
            raise ExceptionGroup(f"{len(errors)} subscribers failed", errors)

    def _next(self) -> Changes | None:
        """Return what is to be told next; None at the end of telling."""
        with self._updating:
            if self._untold:
                return self._untold.popleft()
            self._telling = False
            return None

    @cached_property
    def _living(self) -> Living:
        from deixis.living import Living

        labels = [(view.id, view.label) for view in self.scene.views]
        names = [term.name for term in RELATIONS]
        wanted = [one for name in names for one in self._predicates(name)]
        kinds = self.ruleset.kinds
        wanted += [
            one
            for one in sorted(self.ruleset.user)
            if len(kinds[one]) in (2, 3) and set(kinds[one]) == {"name"}
        ]
        return Living(self.ruleset, self._executor, wanted, self.facts, labels)


class _Reasons:
    """Why relations hold, or not, just after an update: asked of the scene as it was then.

    Changes may be kept for long, so only the list of things is kept with them; most things are those of all
    the other scenes.
    """

    def __init__(self, kb: Following, then: Scene, update: Update) -> None:
        self._kb, self._objects, self._views = kb, then.objects, then.views
        gone = {*update.removed, *update.removed_views}
        # A thing and a view may have one id: what is there still is not gone.
        if gone:
            gone -= {one.id for one in then.objects} | {one.id for one in then.views}
        self._gone = gone

    def __call__(self, some: Sequence[Relation], timeout: float) -> list[str]:
        kb = self._kb
        with kb._updating:
            if kb.scene.objects is self._objects and kb.scene.views is self._views:
                return [self._because(kb, one, timeout) for one in some]
        scene = Scene(kb.scene.id, self._objects, self._views, kb.scene.thresholds, strays=kb.scene.strays)
        with Following(scene, rules=kb._rules, region=kb.region, language=kb.language) as then:
            return [self._because(then, one, timeout) for one in some]

    def _because(self, kb: Following, one: Relation, timeout: float) -> str:
        from deixis.consequences import because

        gone = [name for name in (one.figure, one.reference, one.view) if name in self._gone]
        return f"{' and '.join(gone)} gone" if gone else because(kb.why(one.to_prolog(), timeout=timeout))


def _relation(known: tuple[Known, float]) -> Relation:
    """Return a conclusion as a relation; a third argument is taken for the view."""
    ((name, arity), row), margin = known
    told = rounded(margin if math.isfinite(margin) else None)
    return Relation(name, row[0], row[1], row[2] if arity == 3 else None, told)
