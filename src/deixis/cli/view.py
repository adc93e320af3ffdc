"""``deixis view``: a scene as a page."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer

from deixis.cli.commands import Region, RegionOption, RuleFiles, ScenePath, app, open_scene
from deixis.errors import SceneError
from deixis.strict_json import quoted


@app.command()
def view(
    scene: ScenePath,
    target: Annotated[
        Path,
        typer.Option("-o", "--output", metavar="FILE", help="Where to write the page, such as scene.html."),
    ],
    region: RegionOption = Region.BOX,
    rules: RuleFiles = None,
    timeout: Annotated[float, typer.Option("--timeout", min=0.001, help="Seconds before giving up.")] = 300.0,
) -> None:
    """Write a page that shows a scene, its relations and their reasons: one file, which works offline."""
    from deixis._files import write_whole
    from deixis.view import ready

    # First: proofs take longer than a look for the bundle.
    ready()
    with open_scene(scene, region, rules) as kb:
        page = kb.page(timeout=timeout).encode()
    try:
        write_whole(target, page)
    except OSError as cause:
        raise SceneError(f"{quoted(str(target), 200)} cannot be written: {cause.strerror}") from cause
    print(f"{target}: {len(page) / 1e6:.1f} MB", file=sys.stderr)
