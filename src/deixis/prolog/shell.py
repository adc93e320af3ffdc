"""The interactive shell: the real swipl, with a scene and the rules loaded."""

from __future__ import annotations

import os
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import NoReturn

from deixis._files import rules_dir
from deixis.errors import PrologNotFoundError
from deixis.prolog.find import find_prolog


def exec_shell(rule_files: Sequence[Path], facts: str, tabled: Sequence[tuple[str, int]] = ()) -> NoReturn:
    """Replace this process by SWI-Prolog with rule files and base facts loaded.

    Parameters
    ----------
    rule_files : sequence of Path
    facts : str
        One Prolog list of base facts; it passes through a private file that the shell deletes.

    tabled : sequence of (str, int)
        Predicates whose answers are kept in tables, so that recursion ends.

    Raises
    ------
    PrologNotFoundError
        SWI-Prolog is not installed.
    """
    swipl = find_prolog().executable
    if swipl is None:
        raise PrologNotFoundError(
            "the shell needs the swipl program: unset LIBSWIPL_PATH, or put swipl on the PATH"
        )
    handle, name = tempfile.mkstemp(prefix="deixis-", suffix=".facts")
    with os.fdopen(handle, "w", encoding="utf-8") as file:
        file.write(f"{facts}.\n")
    sys.stdout.flush()
    sys.stderr.flush()
    arguments = ["-q", "-f", "none", "-g", "shell:start", str(rules_dir() / "shell.pl")]
    told = [
        *(str(file.resolve()) for file in rule_files),
        *(f"table:{arity}:{predicate}" for predicate, arity in tabled),
    ]
    os.execv(swipl, [str(swipl), *arguments, "--", name, *told])  # noqa: S606 - a fixed program
