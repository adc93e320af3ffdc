"""``deixis live``: updates in, changes out, a line of JSON each."""

from __future__ import annotations

import json
import sys
from typing import TYPE_CHECKING, Annotated, Any, Final

import typer

from deixis.cli.commands import Region as RegionName
from deixis.cli.commands import RegionOption, RuleFiles, ScenePath, app, open_scene
from deixis.errors import DeixisError, SceneError

if TYPE_CHECKING:
    from deixis.knowledge import KnowledgeBase
    from deixis.relations import Relation
    from deixis.updates import Changes

_PATIENCE: Final = 10.0
"""Seconds for each reason."""


@app.command()
def live(
    scene: ScenePath,
    rules: RuleFiles = None,
    region: RegionOption = RegionName.BOX,
    brief: Annotated[bool, typer.Option("--brief", help="Without reasons: needs no SWI-Prolog.")] = False,
) -> None:
    """Read updates of a scene as lines of JSON; write which relations each makes hold, or cease to.

    An update has objects and views as in a scene file, moves ({"cup": [0, 0, 0.1]}), removed, removed_views
    and stamp, all optional. One that is refused changes nothing, and its line says why. Exit codes: 0 all
    were made, 2 some were refused.
    """
    from deixis.strict_json import parse
    from deixis.updates import Update

    refused = False
    with open_scene(scene, region, rules) as kb:
        for number, line in enumerate((one for one in sys.stdin.buffer if one.strip()), start=1):
            try:
                update = Update.from_dict(parse(line, SceneError, f"update {number}"), kb.scene)
                changes = kb.update(update)
            except DeixisError as error:
                refused = True
                _write({"update": number, "error": str(error)})
            else:
                _write({"update": number, **(changes.to_dict() if brief else _with_reasons(changes, kb))})
    if refused:
        raise typer.Exit(2)


def _with_reasons(changes: Changes, kb: KnowledgeBase) -> dict[str, Any]:
    """Return the changes with the reason of each: why it holds now, or why not any more."""
    from deixis.consequences import because

    there = {one.id for one in kb.scene.objects} | {view.id for view in kb.scene.views}

    def told(one: Relation) -> dict[str, object]:
        gone = [name for name in (one.figure, one.reference, one.view) if name and name not in there]
        reason = f"{' and '.join(gone)} gone" if gone else because(kb.why(one.to_prolog(), timeout=_PATIENCE))
        return {**one.to_dict(), "because": reason}

    found = changes.to_dict()
    return {**found, "gained": list(map(told, changes.gained)), "lost": list(map(told, changes.lost))}


def _write(told: dict[str, Any]) -> None:
    print(json.dumps(told, ensure_ascii=False, allow_nan=False), flush=True)
