"""The interactive shell: the real swipl, with scenes and the rules loaded."""

from __future__ import annotations

import os
import sys
import tempfile
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import NoReturn

from deixis._files import rules_dir
from deixis.errors import PrologNotFoundError, QueryError
from deixis.facts import Facts
from deixis.frames import WORLD
from deixis.prolog.find import find_prolog
from deixis.prolog.text import facts_parts

Grounded = tuple[Facts, Sequence[tuple[str, str]]]
"""A grounded scene, with id and label of each of its views."""


def exec_shell(
    rule_files: Sequence[Path], scenes: Sequence[Grounded], tabled: Sequence[tuple[str, int]] = ()
) -> NoReturn:
    """Replace this process by SWI-Prolog with rule files and base facts loaded.

    Parameters
    ----------
    rule_files : sequence of Path
    scenes : sequence of (Facts, views)
        Their facts pass through private files that the shell deletes.
    tabled : sequence of (str, int)
        Predicates whose answers are kept in tables, so that recursion ends.

    Raises
    ------
    PrologNotFoundError
        SWI-Prolog is not installed.
    QueryError
        Several scenes cannot be told apart, see :func:`apart`.
    """
    command = shell_command(rule_files, scenes, tabled)
    sys.stdout.flush()
    sys.stderr.flush()
    os.execv(command[0], command)  # noqa: S606 - a fixed program


def shell_command(
    rule_files: Sequence[Path], scenes: Sequence[Grounded], tabled: Sequence[tuple[str, int]] = ()
) -> list[str]:
    """Write the facts to private files, and return the command that reads and deletes them.

    Parameters and errors are those of :func:`exec_shell`.
    """
    swipl = find_prolog().executable
    if swipl is None:
        raise PrologNotFoundError(
            "the shell needs the swipl program: unset LIBSWIPL_PATH, or put swipl on the PATH"
        )
    several = apart(scenes)
    names = []
    # The thresholds are the same for all.
    told = [
        facts_parts(facts, views, thresholds=number == 0) for number, (facts, views) in enumerate(several)
    ]
    for part in zip(*told, strict=True):
        handle, name = tempfile.mkstemp(prefix="deixis-", suffix=".facts")
        names.append(name)
        with os.fdopen(handle, "w", encoding="utf-8") as file:
            file.writelines(f"{one}.\n" for lists in part for one in lists)
    arguments = ["-q", "-f", "none", "-g", "shell:start", str(rules_dir() / "shell.pl")]
    more = [
        *(str(file.resolve()) for file in rule_files),
        *(f"table:{arity}:{predicate}" for predicate, arity in tabled),
    ]
    return [str(swipl), *arguments, "--", *names, *more]


def apart(scenes: Sequence[Grounded]) -> list[Grounded]:
    """Return several scenes with ids that no two share: ``cup`` of the scene ``hall`` becomes ``hall_cup``.

    One scene stays as it is.

    Raises
    ------
    QueryError
        Two scenes have the same id, make the same name, or are read with different thresholds.

    Examples
    --------
    >>> from deixis.grounding import ground
    >>> from deixis.scene import Scene
    >>> box = {"center": [0, 0, 0], "size": [1, 1, 1]}
    >>> scenes = [Scene.from_dict({"deixis": 1, "id": name, "objects": [{"id": "cup", "box": box}]})
    ...           for name in ("hall", "attic")]
    >>> [facts.ids for facts, _ in apart([(ground(scene), []) for scene in scenes])]
    [('hall_cup',), ('attic_cup',)]
    """
    if len(scenes) == 1:
        return list(scenes)
    _once((facts.scene for facts, _ in scenes), "two scenes are called {}: give one of them another id")
    first = scenes[0][0]
    for facts, _ in scenes:
        if facts.thresholds != first.thresholds:
            raise QueryError(
                f"the scenes {first.scene!r} and {facts.scene!r} are read with different thresholds, which "
                f"one shell cannot do: open them one by one, or give them the same"
            )
    named = [_named(facts, views) for facts, views in scenes]
    names = [name for facts, views in named for name in (*facts.ids, *(view for view, _ in views))]
    _once(names, "two things of these scenes would be called {}: rename one of them, or its scene")
    return named


def _named(facts: Facts, views: Sequence[tuple[str, str]]) -> Grounded:
    def name(one: str) -> str:
        return f"{facts.scene}_{one}"

    seen = tuple(one if one.view == WORLD else replace(one, view=name(one.view)) for one in facts.views)
    return (
        replace(facts, ids=tuple(map(name, facts.ids)), views=seen),
        [(name(view), label) for view, label in views],
    )


def _once(names: Iterable[str], message: str) -> None:
    for name, count in Counter(names).items():
        if count > 1:
            raise QueryError(message.format(repr(name)))
