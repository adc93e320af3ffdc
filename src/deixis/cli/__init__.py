"""The command line. Data go to stdout, in UTF-8; messages go to stderr.

Exit codes: 0 yes (or done), 1 no (nothing holds, nothing found), 2 error, 3 time-out.
"""

from __future__ import annotations

import io
import os
import sys
import traceback
from typing import TextIO


def main() -> int:
    """Run the command line; return its exit code."""
    # Typer draws help and tracebacks with rich unless told not to: plain text starts faster and pipes better.
    os.environ.setdefault("TYPER_USE_RICH", "0")
    from deixis.cli.output import printable_lines
    from deixis.errors import DeixisError

    stdout = sys.stdout
    if isinstance(stdout, io.TextIOWrapper):
        # Ids are anyone's: a locale that lacks their letters must not stop the answer half-way.
        stdout.reconfigure(encoding="utf-8")
    try:
        return _run(stdout)
    except DeixisError as error:
        print(f"deixis: {printable_lines(error)}", file=sys.stderr)
        return error.exit_code
    except BrokenPipeError:
        # The reader of our output went away, as `head` does: nothing more to say, and no traceback.
        _discard(stdout)
        return 0
    except OSError as error:
        print(f"deixis: cannot go on: {printable_lines(error)}", file=sys.stderr)
        _discard(stdout)
        return 2
    except Exception:  # noqa: BLE001 - shown in full; Python's own exit code for it would mean "no"
        traceback.print_exc()
        return 2


def _run(stdout: TextIO) -> int:
    """Run one command to the last byte of its output; return its exit code."""
    # The first eight add their commands to those of the last.
    from deixis.cli import bags, batch, history, live, questions, tiles, view, words  # noqa: F401
    from deixis.cli.commands import app

    code: object = 0
    try:
        app()
    except SystemExit as done:
        code = done.code
    if sys.stdout is not stdout:
        # Typer puts another stream there when the reader is gone, and would exit with 1, which means no.
        sys.stdout = stdout
        raise BrokenPipeError
    stdout.flush()
    return code if isinstance(code, int) else 0


def _discard(stdout: TextIO) -> None:
    """Let what is still unwritten go nowhere, so that the interpreter does not try once more at its end."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), stdout.fileno())
