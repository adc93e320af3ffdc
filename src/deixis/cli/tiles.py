"""``deixis tiles``: maps larger than memory."""

from __future__ import annotations

import sys
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from deixis.cli.commands import RelationOption, RuleFiles, app
from deixis.cli.output import counted, progress_bar

if TYPE_CHECKING:
    from deixis.tiles import Summary


class Scheduler(StrEnum):
    """What tiles are done by, as :data:`deixis.tiles.run.EngineName`."""

    LOCAL = "local"
    RAY = "ray"


@app.command()
def tiles(
    places: Annotated[
        list[Path],
        typer.Argument(
            metavar="MAP...",
            help="Tables of things (.parquet, .arrow), JSON lines of objects (.jsonl), folders of them, and "
            "scene files, which also tell the views and thresholds.",
        ),
    ],
    target: Annotated[
        Path, typer.Option("-o", "--output", metavar="FOLDER", help="Where to write; a stopped run goes on.")
    ],
    size: Annotated[
        float | None,
        typer.Option(metavar="METRES", help="Side of a tile; by default for some 20,000 things at most."),
    ] = None,
    relation: RelationOption = None,
    rules: RuleFiles = None,
    workers: Annotated[
        int | None, typer.Option(min=1, help="Processes; by default as many as there are processors.")
    ] = None,
    engine: Annotated[Scheduler, typer.Option(help="What the tiles are done by.")] = Scheduler.LOCAL,
    memory: Annotated[
        int, typer.Option(min=128, help="MiB for sorting, and for deriving from all tiles together.")
    ] = 2048,
) -> None:
    """Derive the relations of a map of any size, tile by tile, into Parquet files partitioned by tile.

    What is found is what `deixis relations` finds, to the last bit of every margin. Each process takes memory
    for one tile at a time, some hundred MiB.
    """
    from deixis.errors import MissingDependency

    try:
        from deixis.tiles import run
    except ModuleNotFoundError as error:
        missing = (error.name or "").partition(".")[0]
        if missing != "pyarrow":
            raise
        raise MissingDependency("deixis tiles needs pyarrow: pip install 'deixis[batch]'") from None
    with progress_bar() as progress:
        bar = progress.add_task("tiles", total=None)

        def shown(now: Summary) -> None:
            progress.update(bar, total=now.tiles, completed=now.before + now.done)

        found = run(
            places,
            target,
            size=size,
            relations=relation or (),
            rules=rules or (),
            workers=workers,
            engine=engine.value,
            memory=memory << 20,
            progress=shown,
        )
    kept = f", {found.before} of them done before" if found.before else ""
    things, relations = counted(found.things, "thing"), counted(found.relations, "relation")
    print(f"{target}: {counted(found.tiles, 'tile')}{kept}, {things}, {relations}", file=sys.stderr)
