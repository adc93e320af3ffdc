"""``deixis map``: frames kept in a database, and the scene and relations of any time."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import asdict, replace
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from deixis.cli.commands import Region, RegionOption, RelationOption, RuleFiles, Seconds, ViewOption
from deixis.cli.commands import app as whole_app
from deixis.cli.measuring import Grounding, GroundingOption, measured
from deixis.cli.output import RelationFormat, counted, records, warn, write_csv, write_json, write_table
from deixis.cli.shown import show_relations
from deixis.errors import MapError
from deixis.moments import moment, seconds
from deixis.strict_json import quoted

if TYPE_CHECKING:
    from deixis.scene import Scene
    from deixis.semantic_map import Frame, SemanticMap, Sighting

app = typer.Typer(
    help="Keep frames of a place in a database, and ask for any time.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
)
whole_app.add_typer(app, name="map")

Database = Annotated[
    str,
    typer.Option("--db", metavar="DB", help="A DuckDB file, or postgresql://... that several robots share."),
]
At = Annotated[
    str | None,
    typer.Option(
        "--at",
        metavar="TIME",
        help="As it was then: 2026-11-22T10:42:00Z, 10:42 of the map's last day (in UTC, or 10:42+01:00), "
        "or seconds since the epoch.",
    ),
]


class ListFormat(StrEnum):
    """Output formats of lists."""

    TABLE = "table"
    JSON = "json"
    CSV = "csv"


_THING_COLUMNS = ("id", "label", "kind", "x", "y", "z", "seen")
_FRAME_COLUMNS = ("seq", "stamp", "source", "whole", "things", "gone")
_SIGHTING_COLUMNS = ("stamp", "frame", "label", "x", "y", "z", "gone")


@app.command()
def init(
    database: Database,
    like: Annotated[
        Path | None,
        typer.Option(metavar="SCENE", help="Take id, thresholds and treatment of strays from this scene."),
    ] = None,
    name: Annotated[str | None, typer.Option("--id", help="What the map is called in answers.")] = None,
) -> None:
    """Make an empty map."""
    from deixis.scene import Scene
    from deixis.semantic_map import create_map

    scene = Scene("map") if like is None else Scene.load(like)
    with create_map(database, scene if name is None else replace(scene, id=name)) as kept:
        warn([f"{kept.address} holds the map {quoted(kept.id)}, empty so far"])


@app.command()
def add(
    database: Database,
    scenes: Annotated[list[Path], typer.Argument(metavar="SCENE...", help="Scene files, one frame each.")],
    stamp: Annotated[
        str | None,
        typer.Option(metavar="TIME", help="When it was so; by default the views' latest stamp, else now."),
    ] = None,
    whole: Annotated[
        bool, typer.Option("--whole", help="They show all there is: what they do not name is gone.")
    ] = False,
    gone: Annotated[
        list[str] | None, typer.Option(metavar="ID", help="A thing that is there no more; may be repeated.")
    ] = None,
) -> None:
    """Add scenes as frames. What is reported as added outlives a crash."""
    from deixis.scene import Scene
    from deixis.semantic_map import open_map

    time = None if stamp is None else seconds(stamp)
    with open_map(database) as kept:
        for path in scenes:
            scene = Scene.load(path)
            warn(scene.diagnostics)
            frame = kept.add(scene, stamp=time, whole=whole, gone=gone or ())
            print(f"{frame.seq}\t{moment(frame.stamp)}\t{counted(frame.things, 'thing')}", flush=True)


@app.command(name="list")
def list_(
    database: Database,
    at: At = None,
    frames: Annotated[bool, typer.Option("--frames", help="List the frames instead of the things.")] = False,
    thing: Annotated[
        str | None, typer.Option(metavar="ID", help="List where this thing was, frame by frame.")
    ] = None,
    output: Annotated[ListFormat, typer.Option("--format", help="How to print them.")] = ListFormat.TABLE,
) -> None:
    """List what is in the map: things, frames, or where one thing was. Exit code 1 where there is none."""
    from deixis.semantic_map import open_map

    columns: tuple[str, ...]
    with open_map(database) as kept:
        if frames:
            columns, rows = _FRAME_COLUMNS, [_frame(one) for one in kept.frames()]
        elif thing is not None:
            columns, rows = _SIGHTING_COLUMNS, [_sighting(one) for one in kept.sightings(thing)]
        else:
            time = at_of(kept, at)
            columns, rows = _THING_COLUMNS, _things(kept.scene(at=time), kept.seen(at=time))
    if output is ListFormat.JSON:
        write_json(rows)
    else:
        (write_csv if output is ListFormat.CSV else write_table)(columns, records(columns, rows))
    if not rows:
        raise typer.Exit(1)


@app.command()
def relations(
    database: Database,
    at: At = None,
    view: ViewOption = None,
    relation: RelationOption = None,
    region: RegionOption = Region.BOX,
    output: Annotated[
        RelationFormat, typer.Option("--format", help="How to print them.")
    ] = RelationFormat.TABLE,
    timeout: Seconds = 60.0,
    rules: RuleFiles = None,
    grounding: GroundingOption = Grounding.KERNEL,
) -> None:
    """Print the relations that held at a time, by default the last known; exit code 1 where none did."""
    from deixis.knowledge import KnowledgeBase

    then = _at(database, at)
    warn(then.diagnostics)
    facts = measured(then, grounding, region.value, database)
    with KnowledgeBase(then, rules=rules or (), region=region.value, facts=facts) as kb:
        found = show_relations(kb, output, view=view, relation=relation, timeout=timeout, engine="auto")
    if not found:
        raise typer.Exit(1)


@app.command()
def scene(
    database: Database,
    target: Annotated[
        Path, typer.Option("-o", "--output", metavar="SCENE", help="Where to write the scene.")
    ],
    at: At = None,
) -> None:
    """Write the scene of a time to a file, for all other commands."""
    found = _at(database, at)
    found.save(target)
    print(f"{target}: {len(found.objects)} objects, {len(found.views)} views", file=sys.stderr)


def time_of(kept: SemanticMap, text: str) -> float:
    """Return a time that a user wrote; a time of day is that of the map's last day."""
    try:
        return seconds(text)
    except MapError:
        return seconds(text, day=kept.span()[1])


def at_of(kept: SemanticMap, text: str | None) -> float | None:
    """Return a time that a user may have written."""
    return None if text is None else time_of(kept, text)


def _at(database: str, at: str | None) -> Scene:
    from deixis.semantic_map import open_map

    with open_map(database) as kept:
        return kept.scene(at=at_of(kept, at))


def _frame(frame: Frame) -> dict[str, Any]:
    return {**asdict(frame), "stamp": moment(frame.stamp)}


def _sighting(one: Sighting) -> dict[str, Any]:
    return {
        "stamp": moment(one.stamp),
        "frame": one.frame,
        "label": one.label,
        **_place(one.center),
        "gone": one.gone,
    }


def _things(shown: Scene, seen: dict[str, float]) -> list[dict[str, Any]]:
    return [
        {
            "id": thing.id,
            "label": thing.label,
            "kind": thing.kind,
            **_place(center),
            "seen": moment(seen[thing.id]),
        }
        for thing, center in zip(shown.objects, shown.boxes.center.tolist(), strict=True)
    ]


def _place(center: Sequence[float] | None) -> dict[str, float | None]:
    return dict(zip("xyz", center or (None, None, None), strict=True))
