"""Which files are meant by the names a user gives: paths, names of shipped files, and what they import."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from difflib import get_close_matches
from pathlib import Path
from typing import Final

from deixis._files import kb_dir, rules_dir
from deixis.errors import RuleError
from deixis.ruleset.reading import read_file

SHIPPED: Final = ("support", "background", "safety")
"""Rule files beside the theory's that come with Deixis and can be given by these names."""


def shipped(name: str) -> Path:
    """Return the path of a shipped rule file.

    Examples
    --------
    >>> shipped("safety").name
    'safety.pl'
    """
    return (kb_dir() if name == "background" else rules_dir()) / f"{name}.pl"


def locate(given: Sequence[str | os.PathLike[str]], theory: Sequence[Path]) -> tuple[Path, ...]:
    """Return the rule files that are meant, each once, and in front of each the files that it imports.

    Parameters
    ----------
    given : sequence of path
        A path; or, where there is no such file, one of the names in :data:`SHIPPED`.
    theory : sequence of path
        Files that are loaded anyway.

    Raises
    ------
    RuleError
        There is no such file.

    Examples
    --------
    >>> [path.name for path in locate(["safety"], [rules_dir() / "facts.pl"])][0]
    'topology.pl'
    """
    found: dict[Path, Path] = {}
    known = {path.resolve() for path in theory}
    for one in given:
        _add(_meant(one), found, known)
    return tuple(found.values())


def _add(path: Path, found: dict[Path, Path], known: set[Path]) -> None:
    """Append a file behind what it imports; ``known`` are the files that need not be looked at again."""
    resolved = path.resolve()
    if resolved in known:
        return
    known.add(resolved)
    for imported in _imported(path):
        _add(imported, found, known)
    found[resolved] = path


def _imported(path: Path) -> Iterator[Path]:
    """Yield the files beside this one that it imports; others are the checker's to report."""
    file, _ = read_file(path)
    for name, _ in file.imports:
        for beside in (path.parent / name, path.parent / f"{name}.pl"):
            if beside.is_file():
                yield beside
                break


def _meant(given: str | os.PathLike[str]) -> Path:
    path = Path(given)
    if path.is_file() or str(path.parent) != ".":
        return path
    if path.name in SHIPPED:
        return shipped(path.name)
    if path.suffix or path.exists():
        return path
    close = get_close_matches(path.name, SHIPPED, n=1)
    hint = f"did you mean {close[0]!r}?" if close else f"shipped are {', '.join(SHIPPED)}"
    raise RuleError(f"there is no rule file {path}: {hint}")
