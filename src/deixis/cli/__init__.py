"""The command line. Data go to stdout, messages to stderr.

Exit codes: 0 yes (or done), 1 no (nothing holds, nothing found), 2 error, 3 time-out.
"""

from __future__ import annotations

import os
import sys


def main() -> int:
    """Run the command line; return or raise its exit code."""
    # Typer draws help and tracebacks with rich unless told not to: plain text starts faster and pipes better.
    os.environ.setdefault("TYPER_USE_RICH", "0")
    from deixis.cli.commands import app
    from deixis.errors import DeixisError

    try:
        app()
    except DeixisError as error:
        print(f"deixis: {error}", file=sys.stderr)
        return error.exit_code
    except BrokenPipeError:
        # The reader of our output went away, as `head` does: nothing more to say, and no traceback.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    return 0
