"""The child process that runs SWI-Prolog through pyswip: requests come in, replies go out, nothing else.

Started by path, so that it imports nothing of Deixis: ``python -I -S worker.py LIBRARY HOME PACKAGES
MEMORY``. Each message is its length in eight bytes, big-endian, then UTF-8 text. pyswip is used for its
bindings of the C interface only: text crosses as one string term, never as part of a goal.
"""

from __future__ import annotations

import ctypes
import os
import queue
import resource
import signal
import sys
import threading
from pathlib import Path
from typing import Final

HEADER: Final = 8
"""Bytes of a message's length."""

_LARGEST_FILE: Final = 1 << 20
"""Nothing is written to files but what a dying Prolog says."""

_SOURCE: Final = Path(__file__).with_name("bridge.pl")


def limit(memory: int) -> None:
    """Bound what this process may use: address space, file size, no core dump."""
    for which, amount in (
        (resource.RLIMIT_CORE, 0),
        (resource.RLIMIT_FSIZE, _LARGEST_FILE),
        (resource.RLIMIT_AS, memory),
    ):
        _, hard = resource.getrlimit(which)
        allowed = amount if hard == resource.RLIM_INFINITY else min(amount, hard)
        resource.setrlimit(which, (allowed, hard))
    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)


def take_channel() -> tuple[int, int]:
    """Move the two pipes out of reach of goals that read or write, and return them."""
    requests, replies = os.dup(0), os.dup(1)
    nothing = os.open(os.devnull, os.O_RDONLY)
    os.dup2(nothing, 0)
    os.dup2(2, 1)
    return requests, replies


def start_prolog(library: str, home: str, memory: int) -> None:
    """Start Prolog ahead of pyswip, which would read the user's init file and bound nothing.

    Initialising again, as the import of pyswip does, has no effect.
    """
    arguments = [
        "deixis",
        "--quiet",
        "-f",
        "none",
        "--no-packs",
        "--no-tty",
        f"--stack-limit={memory // 2}b",
        f"--table-space={memory // 4}b",
        f"--home={home}",
    ]
    prolog = ctypes.CDLL(library, mode=ctypes.RTLD_GLOBAL)
    vector = (ctypes.c_char_p * (len(arguments) + 1))(*(word.encode() for word in arguments), None)
    if not prolog.PL_initialise(len(arguments), vector):
        raise SystemExit("SWI-Prolog did not start")


def receive(channel: int, size: int) -> bytes:
    """Return exactly this many bytes; end the process when the other side is gone, whatever Prolog does."""
    parts = []
    while size:
        part = os.read(channel, min(size, 1 << 20))
        if not part:
            os._exit(0)
        parts.append(part)
        size -= len(part)
    return b"".join(parts)


def read_requests(channel: int, inbox: queue.SimpleQueue[bytes]) -> None:
    """Pass on each request, for ever."""
    while True:
        inbox.put(receive(channel, int.from_bytes(receive(channel, HEADER), "big")))


def send(channel: int, reply: bytes) -> None:
    """Write one message."""
    rest = memoryview(len(reply).to_bytes(HEADER, "big") + reply)
    while rest:
        rest = rest[os.write(channel, rest) :]


def serve(requests: int, replies: int) -> None:
    """Load the bridge, then answer requests until the other side is gone."""
    from pyswip import core

    get_text = core._lib.PL_get_nchars
    get_text.argtypes = [
        core.term_t,
        ctypes.POINTER(ctypes.c_size_t),
        ctypes.POINTER(ctypes.c_void_p),
        ctypes.c_uint,
    ]
    get_text.restype = ctypes.c_int

    def call(name: str, module: str, kind: int, text: bytes, arity: int) -> bytes | None:
        frame = core.PL_open_foreign_frame()
        arguments = core.PL_new_term_refs(arity)
        core.PL_put_chars(arguments, kind | core.REP_UTF8, len(text), text)
        done = core.PL_call_predicate(
            None,
            core.PL_Q_NODEBUG | core.PL_Q_CATCH_EXCEPTION,
            core.PL_predicate(name, arity, module),
            arguments,
        )
        reply = None
        if done and arity > 1:
            size, start = ctypes.c_size_t(), ctypes.c_void_p()
            flags = core.CVT_STRING | core.REP_UTF8
            if get_text(arguments + 1, ctypes.byref(size), ctypes.byref(start), flags):
                reply = ctypes.string_at(start, size.value)
        core.PL_discard_foreign_frame(frame)
        return reply

    call("consult", "user", core.PL_ATOM, str(_SOURCE).encode(), 1)
    inbox: queue.SimpleQueue[bytes] = queue.SimpleQueue()
    threading.Thread(target=read_requests, args=(requests, inbox), daemon=True).start()
    while True:
        reply = call("request", "bridge", core.PL_STRING, inbox.get(), 2)
        if reply is None:
            raise SystemExit("the bridge gave no reply")
        send(replies, reply)


def main(library: str, home: str, packages: str, memory: str) -> None:
    """Run as the child."""
    limit(int(memory))
    requests, replies = take_channel()
    start_prolog(library, home, int(memory))
    sys.path.append(packages)
    serve(requests, replies)


if __name__ == "__main__":
    main(*sys.argv[1:])
