"""``deixis perceive``: frames to a scene."""

from __future__ import annotations

import sys
from functools import partial
from pathlib import Path
from typing import Annotated

import typer

from deixis.cli.output import counted, printable, progress_bar


def perceive(
    frames: Annotated[
        list[Path],
        typer.Argument(metavar="FRAME...", help="Frame files; `deixis schema frame` says what is in them."),
    ],
    target: Annotated[
        Path, typer.Option("-o", "--output", metavar="SCENE", help="Where to write the scene.")
    ],
    name: Annotated[
        str | None, typer.Option(help="Id of the scene; by default the name of its file.")
    ] = None,
    strict: Annotated[
        bool, typer.Option("--strict", help="Exit with 1 when anything that was seen is left out.")
    ] = False,
) -> None:
    """Turn depth images or point clouds with labelled regions into a scene, one map of all frames.

    Exit codes: 0 done, 1 nothing was found (or, with --strict, something was left out), 2 a file is not as it
    should be: nothing is written then.
    """
    from deixis.perception import CloudFrame, Map, load_frame

    growing = Map(name or target.stem)
    with progress_bar() as progress:
        # Looked at first, so that a mistake in the last is not found after the work of the others.
        loaded = sorted((load_frame(path).stamp, path) for path in frames)
        whole = progress.add_task("frames", total=len(loaded))
        for _, path in loaded:
            frame = load_frame(path)
            if isinstance(frame, CloudFrame):
                bar = progress.add_task(printable(path.name), total=frame.cloud.size)
                growing.add(frame, partial(progress.advance, bar))
                progress.remove_task(bar)
            else:
                growing.add(frame)
            progress.advance(whole)
        scene = growing.scene()
    for note in scene.diagnostics:
        print(f"deixis: {printable(note)}", file=sys.stderr)
    scene.save(target)
    things = sum(one.kind == "object" for one in scene.objects)
    surfaces = len(scene.objects) - things
    told = counted(things, "object"), counted(surfaces, "surface"), counted(len(scene.views), "view")
    print(f"{target}: {', '.join(told)}", file=sys.stderr)
    if not scene.objects or (strict and scene.diagnostics):
        raise typer.Exit(1)
