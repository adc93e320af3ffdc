"""``deixis live``: updates in, changes out, a line of JSON each."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator
from typing import TYPE_CHECKING, Annotated, Any, BinaryIO, Final

import typer

from deixis.cli.commands import Region as RegionName
from deixis.cli.commands import RegionOption, RuleFiles, ScenePath, app, open_scene
from deixis.errors import DeixisError, QueryTimeout, SceneError

if TYPE_CHECKING:
    from deixis.updates import Changes

_PATIENCE: Final = 10.0
"""Seconds for each reason."""

_PIECE: Final = 1 << 16
"""Bytes of a line that is too long that are passed over at once."""


@app.command()
def live(
    scene: ScenePath,
    rules: RuleFiles = None,
    region: RegionOption = RegionName.BOX,
    brief: Annotated[bool, typer.Option("--brief", help="Without reasons: needs no SWI-Prolog.")] = False,
) -> None:
    """Read updates of a scene as lines of JSON; write which relations each makes hold, or cease to.

    An update has objects and views as in a scene file, moves ({"cup": [0, 0, 0.1]}), removed, removed_views
    and stamp, all optional. What is written has gained and lost: relations with their margins, each with
    because, the reason in a sentence, or null where that takes too long. An update that is refused changes
    nothing, and its line says why.
    Exit codes: 0 all were made, 2 some were refused.
    """
    from deixis.strict_json import MAX_FILE_BYTES, parse
    from deixis.updates import Update

    refused = False
    with open_scene(scene, region, rules) as kb:
        for number, (line, whole) in enumerate(_lines(sys.stdin.buffer, MAX_FILE_BYTES), start=1):
            try:
                if not whole:
                    most = f"{MAX_FILE_BYTES:,} bytes"
                    raise SceneError(f"update {number}: the line is longer than {most}: send less at once")
                update = Update.from_dict(parse(line, SceneError, f"update {number}"), kb.scene)
                changes = kb.update(update)
            except DeixisError as error:
                refused = True
                _write({"update": number, "error": str(error)})
            else:
                _write({"update": number, **(changes.to_dict() if brief else _with_reasons(changes))})
    if refused:
        raise typer.Exit(2)


def _with_reasons(changes: Changes) -> dict[str, Any]:
    """Return the changes with the reason of each: why it holds now, or why not any more; null if late."""
    told = changes.to_dict()
    try:
        reasons = changes.explained(timeout=_PATIENCE).to_dict()
    except QueryTimeout:
        # The scene has changed all the same, and the next update may be told why.
        return told | {key: [{**one, "because": None} for one in told[key]] for key in ("gained", "lost")}
    return {**told, "gained": reasons["gained"], "lost": reasons["lost"]}


def _lines(stream: BinaryIO, limit: int) -> Iterator[tuple[bytes, bool]]:
    """Yield lines that are not empty, each with whether it is whole; of a longer one its beginning."""
    while line := stream.readline(limit + 1):
        whole = len(line) <= limit or line.endswith(b"\n")
        rest = b"" if whole else line
        while rest and not rest.endswith(b"\n"):
            rest = stream.readline(_PIECE)
        if line.strip():
            yield line, whole


def _write(told: dict[str, Any]) -> None:
    print(json.dumps(told, ensure_ascii=False, allow_nan=False), flush=True)
