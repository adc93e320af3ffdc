"""``deixis batch``: the relations of many scenes."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from deixis.cli.commands import Region, RegionOption, RelationOption, RuleFiles, ViewOption, app
from deixis.cli.output import progress_bar, warn


class BatchEngine(StrEnum):
    """What the scenes are shared among."""

    PROCESSES = "processes"
    RAY = "ray"


@app.command()
def batch(
    scenes: Annotated[
        list[Path],
        typer.Argument(metavar="SCENES...", help="Scene files, JSON lines, Parquet, or folders of them."),
    ],
    target: Annotated[
        Path, typer.Option("-o", "--output", metavar="FOLDER", help="Where the Parquet files are written.")
    ],
    view: ViewOption = None,
    relation: RelationOption = None,
    region: RegionOption = Region.BOX,
    rules: RuleFiles = None,
    limit: Annotated[float, typer.Option(min=0.001, help="Seconds that a scene may take.")] = 60.0,
    shard: Annotated[int, typer.Option(min=1, help="Scenes in a Parquet file.")] = 128,
    workers: Annotated[
        int | None, typer.Option(min=1, help="Processes; by default one for each processor.")
    ] = None,
    engine: Annotated[
        BatchEngine, typer.Option(help="What shares the work: processes of this machine, or a Ray cluster.")
    ] = BatchEngine.PROCESSES,
) -> None:
    """Write the relations of many scenes as Parquet; what is refused goes to FOLDER/_errors with the reason.

    A run that was stopped goes on where it was. Exit codes: 0 done, 1 done, and some scenes were refused,
    2 nothing can be done.
    """
    from rich.progress import MofNCompleteColumn

    from deixis.batch.relate import Relate
    from deixis.batch.run import run
    from deixis.parallel import WORKERS

    relate = Relate(tuple(relation or ()), tuple(map(str, rules or ())), region.value, view)
    with progress_bar(MofNCompleteColumn()) as bar:
        task = bar.add_task("scenes", total=None)
        done = run(
            scenes, target, relate, limit=limit, shard=shard, workers=workers or WORKERS, engine=engine.value,
            progress=lambda counts, total: bar.update(task, completed=counts.scenes, total=total),
        )  # fmt: skip
    refused = f", {done.refused:,} refused: see {target / '_errors'}" if done.refused else ""
    warn([f"{target}: {done.scenes:,} scenes, {done.relations:,} relations{refused}"])
    if done.refused:
        raise typer.Exit(1)
