"""What can be asked of a semantic map over time: since when, how long, and what changed."""

from __future__ import annotations

import difflib
import math
import os
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any, Final

from deixis._files import datalog_files
from deixis.engines import predicates
from deixis.errors import MapError, QueryError
from deixis.facts import RegionModel, region_model
from deixis.hints import hint
from deixis.moments import spoken
from deixis.semantic_map.deriving import KEPT, HistoryStore, theory
from deixis.semantic_map.intervals import Between, Interval, rank
from deixis.semantic_map.records import Row
from deixis.vocabulary import BY_NAME, asked_for

if TYPE_CHECKING:
    from deixis.ruleset import Ruleset

Rules = Sequence[str | os.PathLike[str]]

_NAMED: Final = 5
"""Views named in a message."""

_LASTING: Final = """
SELECT relation, figure, reference, view, since, until FROM lasting
WHERE relation = ANY($1::varchar[])
  AND ($2::varchar IS NULL OR figure = $2::varchar)
  AND ($3::varchar IS NULL OR reference = $3::varchar)
  AND ($4::varchar IS NULL OR view IS NULL OR view = $4::varchar)
  AND since <= $5 AND (until IS NULL OR until > $6)
"""

_LABELS: Final = """
SELECT DISTINCT ON (thing.id) thing.id, label FROM thing JOIN frame ON frame.seq = thing.frame
WHERE NOT gone ORDER BY thing.id, stamp DESC, seq DESC
"""


class SemanticMap(HistoryStore):
    """A database of frames, each a scene as it was at some time, and of what followed from them, since when.

    Between two frames holds what was told last; a relation holds from the stamp of the frame that makes it
    hold, and no more at the stamp of the one that ends it. The relations people speak in are derived once,
    from boxes, and kept; others, and rules of one's own, are derived when asked for (decision 0052).

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> from dataclasses import replace
    >>> from deixis._files import kb_dir
    >>> from deixis.scene import Scene
    >>> from deixis.semantic_map import create_map
    >>> scene = Scene.load(kb_dir() / "scenes" / "hans.json")
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     with create_map(Path(folder, "map.duckdb"), scene) as kept:
    ...         frame = kept.add(scene, stamp=100.0)
    ...         frame.things, kept.scene(at=99.0).objects, len(kept.scene(at=100.0).objects)
    ...         kept.since("on_top_of", "sweater", "heater").since
    ...         _ = kept.add(replace(scene, objects=()), stamp=160.0, gone=["sweater"])
    ...         kept.since("on_top_of", "sweater", "heater")
    (8, (), 8)
    100.0
    """

    def since(
        self,
        relation: str,
        figure: str,
        reference: str,
        view: str | None = None,
        *,
        at: float | None = None,
        rules: Rules = (),
        region: RegionModel = "box",
        timeout: float = 600.0,
    ) -> Interval | None:
        """Return the interval in which a relation holds at a time, or None where it does not.

        Parameters
        ----------
        relation, figure, reference : str
        view : str, optional
            Of a relation that depends on where one stands: from where.
        at : float, optional
            Seconds since the epoch; by default the last known.
        rules, region, timeout
            As of :meth:`intervals`.

        Raises
        ------
        MapError
            The time is before the first frame, or there is none; the map was never told of a thing.
        QueryError
            Unknown relation or view, or one too many or too few.
        QueryTimeout
            It took longer than ``timeout`` seconds.
        """
        self._check_view(relation, view)
        at = self._time(at)
        found = self.intervals(
            [relation], figure=figure, reference=reference, view=view, start=at, end=at,
            rules=rules, region=region, timeout=timeout,
        )  # fmt: skip
        return next((one for one in found if one.view == view), None)

    def relations(
        self, *, at: float | None = None, view: str | None = None, **how: Any
    ) -> tuple[Interval, ...]:
        """Return what holds at a time, each since when; parameters as of :meth:`intervals`."""
        at = self._time(at)
        return self.intervals(view=view, start=at, end=at, **how)

    def intervals(
        self,
        relation: Iterable[str] | None = None,
        *,
        figure: str | None = None,
        reference: str | None = None,
        view: str | None = None,
        start: float | None = None,
        end: float | None = None,
        rules: Rules = (),
        region: RegionModel = "box",
        timeout: float = 600.0,
    ) -> tuple[Interval, ...]:
        """Return when relations held, by the beginning of each.

        Parameters
        ----------
        relation : str or iterable of str, optional
            Only this or these; by default all that people speak in. Base relations and predicates of the rule
            files are given when named.
        figure, reference : str, optional
            Only of these things.
        view : str, optional
            Only this view's horizontal relations; those that depend on no view are always included.
        start, end : float, optional
            Only what held at some time from start to end, both included. Intervals are given whole.
        rules : sequence of path
            Rule files of the user's own; see :class:`~deixis.knowledge.KnowledgeBase`.
        region : "box", "hull" or "mesh"
            What things are measured as. With other than boxes, and with rules, everything is derived anew.
        timeout : float
            Seconds to derive what is not known yet.

        Raises
        ------
        MapError
            The map was never told of a thing, or the start is after the end.
        QueryError
            Unknown relation or view.
        QueryTimeout
            It took longer than ``timeout`` seconds.
        """
        first, last = _number(start, -math.inf), _number(end, math.inf)
        if first > last:
            raise MapError(
                f"the time from {spoken(first)} to {spoken(last)} runs backwards: exchange the two"
            )
        ruleset = ruleset_of(rules) if rules else None
        names = asked_for(relation)
        wanted = [one for name in names for one in predicates(name, ruleset)]
        # What one's own rules are about need be no thing, nor the third a view.
        if not rules:
            with self._transaction():
                self._check_told([name for name in (figure, reference) if name is not None])
                if view is not None:
                    self._check_known_view(view)
        if not rules and region_model(region) == "box" and set(wanted) <= set(KEPT):
            self.catch_up(timeout=timeout)
            with self._transaction():
                rows = self._rows(_LASTING, [names, figure, reference, view, last, first])
        else:
            rows = [
                row
                for row in self._replayed(ruleset or theory(), wanted, region, timeout)
                if _fits(row, figure, reference, view, first, last)
            ]
        found = [Interval(*row) for row in rows]
        return tuple(sorted(found, key=lambda one: (one.since, rank(one))))

    def changes(
        self,
        start: float,
        end: float,
        *,
        relation: Iterable[str] | None = None,
        view: str | None = None,
        **how: Any,
    ) -> Between:
        """Return what differs between two times, each with when it changed.

        Parameters
        ----------
        start, end : float
            Seconds since the epoch.
        relation : str or iterable of str, optional
            As of :meth:`intervals`.
        view : str, optional
            Whose left and right count; without it none does: they change with every step of who looks.
        **how
            As of :meth:`intervals`.

        Raises
        ------
        MapError
            The start is before the first frame, or after the end.
        """
        start, end = self._time(start), self._time(end)
        found = self.intervals(relation, view=view, start=start, end=end, **how)
        return Between.of(start, end, tuple(one for one in found if one.view == view or one.view is None))

    def span(self) -> tuple[float, float]:
        """Return the stamps of the first and the last frame.

        Raises
        ------
        MapError
            There are no frames.
        """
        with self._transaction():
            ((first, last),) = self._rows("SELECT min(stamp), max(stamp) FROM frame")
        if first is None:
            raise MapError(f"{self.address} has no frames yet: add some with `deixis map add`")
        return first, last

    def labels(self) -> dict[str, str]:
        """Return what each thing that the map was ever told of was called last, by its id."""
        with self._transaction():
            return dict(self._rows(_LABELS))

    def views(self) -> dict[str, str]:
        """Return the views that the map was ever told of: ids and labels, in the order of the frames."""
        with self._transaction():
            return dict(
                self._rows(
                    "SELECT viewpoint.id, label FROM viewpoint JOIN frame ON frame.seq = viewpoint.frame "
                    "ORDER BY frame.stamp, frame.seq, position"
                )
            )

    def _time(self, at: float | None) -> float:
        first, last = self.span()
        time = _number(at, last)
        if time < first:
            raise MapError(f"nothing is known of {spoken(time)}: the first frame is of {spoken(first)}")
        return time

    def _check_view(self, relation: str, view: str | None) -> None:
        term = BY_NAME.get(relation)
        if term is None:
            return
        if term.view and view is None:
            raise QueryError(
                f"{relation} depends on where one stands: name a view{hint('', list(self.views())[-_NAMED:])}"
            )
        if not term.view and view is not None:
            raise QueryError(f"{relation} depends on no view: leave out {view!r}")

    def _check_known_view(self, view: str) -> None:
        if not self._rows("SELECT 1 FROM viewpoint WHERE id = $1 LIMIT 1", [view]):
            known = [name for (name,) in self._rows("SELECT DISTINCT id FROM viewpoint ORDER BY id")]
            close = difflib.get_close_matches(view, known, n=1)
            raise QueryError(
                f"the map was never told of a view {view!r}{hint(view, close or known[-_NAMED:])}"
            )


def _number(time: float | None, default: float) -> float:
    number = default if time is None else float(time)
    if math.isnan(number):
        raise MapError("the time is not a number: give seconds since the epoch")
    return number


def _fits(
    row: Row, figure: str | None, reference: str | None, view: str | None, first: float, last: float
) -> bool:
    _, one, other, by, since, until = row
    return (
        figure in (None, one)
        and reference in (None, other)
        and (view is None or by in (None, view))
        and since <= last
        and (until is None or until > first)
    )


def ruleset_of(rules: Rules) -> Ruleset:
    """Return the theory's rules with some of the user's own."""
    from deixis.ruleset import load, locate

    files = datalog_files()
    return load(files, locate(rules, files))
