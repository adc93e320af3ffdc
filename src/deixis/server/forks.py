"""The child's side: a process that answers messages, and forks children that do the same.

The first is started with all modules loaded and no thread; whatever is forked from it, or from its
children, is ready in milliseconds and shares their memory until it writes to it. A child ends when the
server closes its end of the socket, and when its parent ends.
"""

from __future__ import annotations

import contextlib
import ctypes
import gc
import os
import resource
import signal
import socket
import sys
import traceback
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, Final

from deixis.errors import DeixisError
from deixis.server.wire import Channel, Closed

Reply = tuple[Mapping[str, Any], bytes]
Work = Callable[[Mapping[str, Any], bytes], Reply]
"""From a message to its answer."""

_FILE: Final = 1 << 26
"""Bytes of a file that a process may write: the facts of some ten thousand things, for SWI-Prolog."""

_PARENT_DEATH_SIGNAL: Final = 1
"""PR_SET_PDEATHSIG of Linux."""


def restrict(memory: int, *, files: bool) -> None:
    """Bound what this process may use from now on.

    Parameters
    ----------
    memory : int
        Address space beyond what it has now, bytes.
    files : bool
        Whether it may open anything at all: without, there is no file and no socket for it, whatever the
        libraries in it are asked to do.
    """
    bounds = {resource.RLIMIT_CORE: 0, resource.RLIMIT_FSIZE: _FILE, resource.RLIMIT_AS: _size() + memory}
    if not files:
        bounds |= {resource.RLIMIT_NOFILE: 0, resource.RLIMIT_FSIZE: 0}
    for which, amount in bounds.items():
        _, hard = resource.getrlimit(which)
        allowed = amount if hard == resource.RLIM_INFINITY else min(amount, hard)
        resource.setrlimit(which, (allowed, allowed))


def _size() -> int:
    """Return the address space in use, bytes; where it is not told, what a fresh process has."""
    told = Path("/proc/self/statm")
    pages = int(told.read_text().split()[0]) if told.exists() else 1 << 17
    return pages * resource.getpagesize()


def attend(channel: Channel, work: Mapping[str, Work]) -> None:
    """Answer messages until the other side is gone; never returns.

    Beside the ``work`` by name there are ``fork`` (with a descriptor: the socket of the child), ``restrict``
    and ``kill``.
    """
    children: set[int] = set()
    ended: set[int] = set()

    def end(*_: object) -> None:
        for pid in children:
            _kill(pid, signal.SIGTERM)
        os._exit(0)

    signal.signal(signal.SIGTERM, end)
    while True:
        try:
            header, body, descriptor = channel.receive()
        except (Closed, ConnectionError):
            end()
        # With the least priority, a process takes a while to end: nobody waits for it.
        ended -= {pid for pid in ended if os.waitpid(pid, os.WNOHANG)[0]}
        match header["do"]:
            case "fork":
                pid = _fork(channel, descriptor)
                if pid == 0:
                    children.clear()
                    ended.clear()
                    continue
                children.add(pid)
                channel.send({"pid": pid})
            case "kill":
                if header["pid"] in children:
                    _kill(header["pid"])
                    children.discard(header["pid"])
                    ended.add(header["pid"])
                channel.send({"done": True})
            case "restrict":
                if header.get("leaf"):
                    # Nothing of Python's runs while a library computes: the system must be able to end it.
                    signal.signal(signal.SIGTERM, signal.SIG_DFL)
                restrict(header["memory"], files=header["files"])
                channel.send({"done": True})
            case name:
                channel.send(*_answer(work[name], header, body))


def _answer(work: Work, header: Mapping[str, Any], body: bytes) -> Reply:
    try:
        return work(header, body)
    except DeixisError as error:
        return {"error": type(error).__name__, "text": str(error)}, b""
    except MemoryError:
        return {"error": "MemoryError", "text": "the memory limit was reached"}, b""
    except Exception:  # noqa: BLE001 - told to the server, which logs it and ends this process
        return {"error": "unexpected", "text": traceback.format_exc()}, b""


def _fork(channel: Channel, descriptor: int | None) -> int:
    """Fork; the child goes on with the socket that came, its parent without."""
    if descriptor is None:
        raise AssertionError("no socket for the child came with the message")
    # What is there now is never collected: collecting would copy the pages that are shared.
    gc.freeze()
    pid = os.fork()
    own = socket.socket(fileno=descriptor)
    if pid:
        own.close()
        return pid
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(_PARENT_DEATH_SIGNAL, signal.SIGKILL)
    channel.close()
    channel.__init__(own)  # type: ignore[misc]
    return 0


def _kill(pid: int, how: signal.Signals = signal.SIGKILL) -> None:
    with contextlib.suppress(ProcessLookupError):
        os.kill(pid, how)
