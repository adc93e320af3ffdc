"""The other end of worker.py: one child process, started, spoken to and, if need be, killed."""

from __future__ import annotations

import os
import select
import signal
import subprocess
import sys
import tempfile
import time
import weakref
from pathlib import Path
from typing import IO, Final

from deixis.errors import EngineError
from deixis.prolog.worker import HEADER

_WORKER: Final = Path(__file__).with_name("worker.py")

# What a shared library may need to be found; nothing else of the environment reaches a question.
_KEPT_VARIABLES: Final = ("LD_LIBRARY_PATH", "DYLD_LIBRARY_PATH", "DYLD_FALLBACK_LIBRARY_PATH", "TMPDIR")

_BLOCK: Final = 1 << 20
_LAST_WORDS: Final = 500


class Child:
    """A SWI-Prolog in a session of its own, without the user's settings, in a neutral directory.

    It ends with this object, with this process, and when this process is killed. A process forked off
    this one does not own it.

    Parameters
    ----------
    library, home : Path
        The Prolog to run.
    packages : Path
        The directory that holds pyswip.
    memory : int
        Address space, bytes.
    """

    def __init__(self, library: Path, home: Path, packages: Path, memory: int) -> None:
        environment = {name: os.environ[name] for name in _KEPT_VARIABLES if name in os.environ}
        environment |= {"LIBSWIPL_PATH": str(library), "SWI_HOME_DIR": str(home), "LC_ALL": "C.UTF-8"}
        self._owner = os.getpid()
        # A pipe that nobody reads would fill up and stop the child: its last words go to a file.
        self._said: IO[bytes] = tempfile.TemporaryFile()  # noqa: SIM115 - closed with the child
        self._process = subprocess.Popen(
            [sys.executable, "-I", "-S", _WORKER, library, home, packages, str(memory)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._said,
            bufsize=0,
            cwd="/",
            env=environment,
            start_new_session=True,
        )
        self._finalizer = weakref.finalize(self, _end, self._owner, self._process, self._said)
        pipes = (self._process.stdin, self._process.stdout)
        self._requests, self._replies = (pipe.fileno() for pipe in pipes if pipe is not None)
        os.set_blocking(self._requests, False)

    @property
    def pid(self) -> int:
        """The process id."""
        return self._process.pid

    @property
    def usable(self) -> bool:
        """Whether it runs and is this process's own."""
        return self._finalizer.alive and self._owner == os.getpid() and self._process.poll() is None

    def send(self, text: str, deadline: float | None) -> None:
        """Send one request, the text of a term, before a deadline of the monotonic clock.

        Raises
        ------
        EngineError
            The child ended.
        TimeoutError
            It did not take the message in time.
        """
        message = f"{text} .\n".encode()
        rest = memoryview(len(message).to_bytes(HEADER, "big") + message)
        while rest:
            self._wait(self._requests, select.POLLOUT, deadline)
            try:
                rest = rest[os.write(self._requests, rest[:_BLOCK]) :]
            except BlockingIOError:
                continue
            except BrokenPipeError:
                raise self._lost() from None

    def receive(self, deadline: float | None) -> bytes:
        """Return the next reply, before a deadline of the monotonic clock.

        Raises
        ------
        EngineError
            The child ended.
        TimeoutError
            There is no whole reply in time.
        """
        size = int.from_bytes(self._read(HEADER, deadline), "big")
        return self._read(size, deadline)

    def kill(self) -> None:
        """Stop it at once, whatever it does; safe while another thread waits for it."""
        _kill(self._owner, self._process)

    def close(self) -> None:
        """Stop it and give back what it holds; only while no other thread waits for it."""
        self._finalizer()

    def _read(self, size: int, deadline: float | None) -> bytes:
        parts: list[bytes] = []
        while size:
            self._wait(self._replies, select.POLLIN, deadline)
            part = os.read(self._replies, min(size, _BLOCK))
            if not part:
                raise self._lost()
            parts.append(part)
            size -= len(part)
        return b"".join(parts)

    def _wait(self, channel: int, event: int, deadline: float | None) -> None:
        poll = select.poll()
        poll.register(channel, event)
        remaining = None if deadline is None else max(0.0, deadline - time.monotonic()) * 1000.0
        if not poll.poll(remaining):
            raise TimeoutError

    def _lost(self) -> EngineError:
        """Return the error that tells how the child ended, in its own words where it had any."""
        self.kill()
        code = self._process.wait()
        how = signal.Signals(-code).name if code < 0 else f"exit code {code}"
        self._said.seek(0)
        words = self._said.read().decode(errors="replace").strip()[-_LAST_WORDS:]
        return EngineError(
            f"the logic engine ended ({how}), perhaps for want of memory; the next question starts it again"
            + (f"\nIt said: {words}" if words else "")
        )


def _kill(owner: int, process: subprocess.Popen[bytes]) -> None:
    if owner != os.getpid() or process.poll() is not None:
        return
    try:
        os.killpg(process.pid, signal.SIGKILL)
    except (ProcessLookupError, PermissionError):
        # It has just ended by itself: the group of a zombie cannot be signalled everywhere.
        return


def _end(owner: int, process: subprocess.Popen[bytes], said: IO[bytes]) -> None:
    _kill(owner, process)
    if owner == os.getpid():
        process.wait()
    for pipe in (process.stdin, process.stdout, said):
        if pipe is not None:
            pipe.close()
