"""The command line for tests: in a process of its own where that matters, else in this one."""

from __future__ import annotations

import io
import os
import subprocess
import sys
from collections.abc import Mapping
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass
from pathlib import Path
from unittest.mock import patch

from deixis.cli import main


@dataclass(frozen=True)
class Result:
    """What a command left behind."""

    code: int
    out: str
    err: str


def call(*arguments: str | Path) -> Result:
    """Run a command in this process: ten times faster, and with the same exit code and output."""
    out, err = io.StringIO(), io.StringIO()
    with (
        patch.object(sys, "argv", ["deixis", *map(str, arguments)]),
        redirect_stdout(out),
        redirect_stderr(err),
    ):
        code = main()
    return Result(code, out.getvalue(), err.getvalue())


def run(
    *arguments: str | Path, stdin: str = "", cwd: Path | None = None, env: Mapping[str, str] | None = None
) -> Result:
    """Run a command in a process of its own, with its own environment variables added."""
    done = subprocess.run(
        [sys.executable, "-W", "error", "-m", "deixis", *arguments],
        input=stdin,
        cwd=cwd,
        env=os.environ | (env or {}),
        capture_output=True,
        text=True,
        encoding="utf-8",
        timeout=60,
        check=False,
    )
    return Result(done.returncode, done.stdout, done.stderr)
