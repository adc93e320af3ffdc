"""Work shared by the processors: numpy and the index let go of the interpreter while they compute."""

from __future__ import annotations

import os
from collections import deque
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from typing import Final, TypeVar

Part = TypeVar("Part")

WORKERS: Final = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
"""Threads that share the work, the caller's own among them."""


@cache
def _helpers() -> ThreadPoolExecutor:
    """Return the threads that help, started once: starting one takes longer than measuring a room."""
    return ThreadPoolExecutor(max(WORKERS - 1, 1), thread_name_prefix="deixis")


if hasattr(os, "register_at_fork"):
    # Threads do not live on in a forked child, though their pool would seem to: it gets one of its own.
    os.register_at_fork(after_in_child=_helpers.cache_clear)


_alone = False


def work_alone() -> None:
    """Share nothing from now on: other processes have the other processors."""
    global _alone  # noqa: PLW0603 - of this process, like its processors
    _alone = True


def share(work: Callable[[Part], None], parts: Iterable[Part]) -> None:
    """Do the work for all parts, in any order, on all processors.

    The caller's thread works too and never waits for a helper to begin, so that many threads may call this
    at once, and the work itself may. The first error is raised, once nothing is at work any more.

    Examples
    --------
    >>> done = []
    >>> share(done.append, range(3))
    >>> sorted(done)
    [0, 1, 2]
    """
    left = deque(parts)

    def run() -> None:
        while True:
            try:
                part = left.popleft()
            except IndexError:
                return
            try:
                work(part)
            except BaseException:
                left.clear()
                raise

    helping = [_helpers().submit(run) for _ in range(0 if _alone else min(WORKERS, len(left)) - 1)]
    try:
        run()
    finally:
        at_work = [helper for helper in helping if not helper.cancel()]
        failed = [cause for helper in at_work if (cause := helper.exception()) is not None]
    if failed:
        raise failed[0]
