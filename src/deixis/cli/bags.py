"""``deixis bag``: what holds over time in a recording of a robot."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterable
from contextlib import ExitStack
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from deixis.cli.commands import Region, RegionOption, RelationOption, RuleFiles, app
from deixis.cli.output import warn, write_csv, write_table

if TYPE_CHECKING:
    from deixis.knowledge import KnowledgeBase
    from deixis.logs import Report
    from deixis.logs.intervals import Interval
    from deixis.relations import Relation
    from deixis.updates import Changes


class LogFormat(StrEnum):
    """How what holds over time is printed."""

    CHANGES = "changes"
    INTERVALS = "intervals"
    TABLE = "table"
    CSV = "csv"


class TracksName(StrEnum):
    """As :data:`deixis.logs.tracks.Tracking`."""

    AUTO = "auto"
    OVERLAP = "overlap"


_COLUMNS = ("relation", "figure", "reference", "view", "since", "until", "margin")


@app.command()
def bag(
    path: Annotated[
        Path,
        typer.Argument(
            metavar="BAG", help="A bag of ROS 2, its folder or an .mcap or .db3 file, or of ROS 1."
        ),
    ],
    topic: Annotated[
        str | None, typer.Option(help="The Detection3DArray topic; by default the only one.")
    ] = None,
    frame: Annotated[str, typer.Option(help="The fixed frame, Z up, in which all is placed by tf.")] = "map",
    robot: Annotated[
        str | None, typer.Option(help="Who looks: a frame such as base_link, or a topic of poses.")
    ] = None,
    target: Annotated[
        Path | None, typer.Option("-o", "--output", metavar="FILE", help="Write a Foxglove scene: out.mcap.")
    ] = None,
    output: Annotated[
        LogFormat | None,
        typer.Option("--format", help="How to print them; by default changes, or with -o nothing."),
    ] = None,
    relation: RelationOption = None,
    scene: Annotated[
        Path | None, typer.Option("--scene", help="A scene of what is always there: walls, furniture.")
    ] = None,
    labels: Annotated[
        Path | None, typer.Option("--labels", help='Names of classes, as JSON: {"47": "cup"}.')
    ] = None,
    rules: RuleFiles = None,
    region: RegionOption = Region.BOX,
    forget: Annotated[
        float,
        typer.Option(min=0.0, help="Seconds after which what nothing shows any more is gone; inf: never."),
    ] = 5.0,
    tracks: Annotated[
        TracksName, typer.Option(help="Things by their ids and overlap, or by overlap alone.")
    ] = TracksName.AUTO,
    level: Annotated[
        float, typer.Option(min=0.0, help="Degrees: boxes tilted by no more are stood upright.")
    ] = 0.0,
    hold: Annotated[
        float, typer.Option(min=0.0, help="Seconds beyond what tf tells for which the nearest pose counts.")
    ] = 0.0,
    tf: Annotated[str, typer.Option(help="The topic of tf; static frames are on TOPIC_static.")] = "/tf",
) -> None:
    """Print what holds over time in a recording of a robot, or write it as a scene for Foxglove.

    Changes are lines of JSON as of `deixis live`, with the stamp in seconds and, exactly, in nanoseconds;
    the last line says what was read and what was left out and why. Intervals are from when to when something
    held. Lengths are metres. Exit codes: 0 done, 1 nothing was found, 2 the bag is not as it should be.
    """
    from deixis.knowledge import KnowledgeBase
    from deixis.logs import read_bag
    from deixis.logs.foxglove import FoxgloveFile
    from deixis.scene import Scene

    around = None if scene is None else Scene.load(scene)
    with ExitStack() as stack:
        log = stack.enter_context(
            read_bag(
                path, topic=topic, frame=frame, robot=robot, forget=forget, tracking=tracks.value,
                level=level, hold=hold, tf=tf, names=_names(labels), around=around,
            )
        )  # fmt: skip
        kb = stack.enter_context(KnowledgeBase(log.start, rules=rules or (), region=region.value))
        wanted = _wanted(kb, relation)
        drawn = None if target is None else stack.enter_context(FoxgloveFile(target, log.frame))
        if output is None and drawn is None:
            output = LogFormat.CHANGES
        shown = _Shown(output, wanted)
        try:
            for stamp, update in log.updates():
                shown.take(stamp, kb.update(update))
                if drawn is not None:
                    drawn.write(stamp, kb.scene, _only(kb.kept, wanted))
        finally:
            shown.end(log.report)
            warn(log.report.lines())
    if target is not None and drawn is not None:
        print(f"{target}: {log.report.frames} moments, {drawn.entities} entities", file=sys.stderr)
    if not log.report.detections:
        raise typer.Exit(1)


def export_mcap(kb: KnowledgeBase, target: Path, *, proofs: bool, view: str | None) -> str:
    """Write a scene for Foxglove as one moment, that of its latest view; return what was written."""
    from deixis.frames import WORLD
    from deixis.logs.foxglove import FoxgloveFile
    from deixis.logs.telling import Teller

    found = kb.relations(view=view)
    plain, reasons = Teller(kb.scene), kb.proofs() if proofs else {}

    def say(one: Relation) -> str:
        ends = (one.figure, one.reference) if one.view is None else (one.figure, one.reference, one.view)
        proof = reasons.get((one.relation, *ends))
        return plain(one) if proof is None else proof.sentence()

    stamp = max((one.stamp for one in kb.scene.views if one.stamp is not None), default=0.0)
    with FoxgloveFile(target, WORLD) as drawn:
        drawn.write(round(stamp * 1.0e9), kb.scene, found, say)
    return f"{drawn.entities} entities"


class _Shown:
    """Prints changes as they come, or intervals as they end."""

    def __init__(self, form: LogFormat | None, wanted: frozenset[str] | None) -> None:
        from deixis.logs.intervals import Intervals

        self._form, self._wanted = form, wanted
        self._intervals = Intervals()
        self._rows: list[Interval] = []

    def take(self, stamp: int, changes: Changes) -> None:
        """Take in what a moment changed."""
        from deixis.updates import Changes

        told = Changes(changes.stamp, _only(changes.gained, self._wanted), _only(changes.lost, self._wanted))
        if self._form is LogFormat.CHANGES:
            if told:
                _line({"stamp": told.stamp, "ns": stamp, **told.to_dict()})
        elif self._form is not None:
            self._ended(self._intervals.take(stamp, told))

    def end(self, report: Report) -> None:
        """Print what holds to the end, and what was read."""
        self._ended(self._intervals.rest())
        if self._form in (LogFormat.CHANGES, LogFormat.INTERVALS):
            _line(report.to_dict())
        elif self._form is LogFormat.CSV:
            write_csv(_COLUMNS, [self._row(one, lambda stamp: stamp) for one in self._rows])
        elif self._form is LogFormat.TABLE:
            start = report.first or 0
            write_table(
                _COLUMNS, [self._row(one, lambda stamp: (stamp - start) / 1.0e9) for one in self._rows]
            )

    def _ended(self, found: Iterable[Interval]) -> None:
        for one in found:
            if self._form is LogFormat.INTERVALS:
                _line(one.to_dict())
            else:
                self._rows.append(one)

    @staticmethod
    def _row(one: Interval, when: Any) -> list[Any]:
        told = one.relation
        ends = None if one.until is None else when(one.until)
        return [told.relation, told.figure, told.reference, told.view, when(one.since), ends, told.margin]


def _only(found: Iterable[Relation], wanted: frozenset[str] | None) -> tuple[Relation, ...]:
    return tuple(one for one in found if wanted is None or one.relation in wanted)


def _wanted(kb: KnowledgeBase, relation: list[str] | None) -> frozenset[str] | None:
    """Return the relations asked for, of those that are followed."""
    from deixis.errors import QueryError
    from deixis.hints import hint
    from deixis.vocabulary import RELATIONS

    if relation is None:
        return None
    known = [term.name for term in RELATIONS] + sorted({name for name, _ in kb.ruleset.user})
    for one in relation:
        if one not in known:
            raise QueryError(f"no relation {one!r} is followed over time{hint(one, known)}")
    return frozenset(relation)


def _names(labels: Path | None) -> dict[str, str]:
    """Return the names of classes in a file."""
    from deixis.errors import ReaderError
    from deixis.strict_json import parse, quoted, read_bytes

    if labels is None:
        return {}
    what = quoted(labels.name, 200)
    found = parse(read_bytes(labels, ReaderError), ReaderError, what)
    if not isinstance(found, dict) or not all(isinstance(one, str) for one in found.values()):
        raise ReaderError(f'{what}: names of classes are a JSON object such as {{"47": "cup"}}')
    return found


def _line(told: dict[str, Any]) -> None:
    print(json.dumps(told, ensure_ascii=False, allow_nan=False), flush=True)
