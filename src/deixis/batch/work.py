"""Shards done in processes that may be ended: a scene that hangs, or breaks its process, costs no other."""

from __future__ import annotations

import signal
from collections.abc import Iterator, Sequence
from concurrent.futures import Future
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from typing import Final

import pyarrow as pa
from pebble import ProcessExpired, ProcessPool

from deixis.batch.folder import Counts, Folder
from deixis.batch.relate import Relate, refusals
from deixis.batch.schema import ERRORS, RELATIONS
from deixis.batch.sources import Refused, Shard
from deixis.errors import EngineError, QueryTimeout
from deixis.parallel import work_alone

_LATE: Final = -signal.SIGALRM
"""Exit code of a process whose time was up."""

Found = tuple[pa.RecordBatch, pa.RecordBatch]
"""Relations, and what was refused."""


@dataclass(frozen=True, slots=True)
class Work:
    """What is done with each shard: the same on this machine and on others.

    Parameters
    ----------
    relate : Relate
    folder : Folder
        Where it is written; all who work see it.
    limit : float
        Seconds that a scene may take.
    """

    relate: Relate
    folder: Folder
    limit: float

    def start(self, pool: ProcessPool, shard: Shard) -> Future[Counts]:
        """Have a shard done by a process of a pool."""
        begun: Future[Counts] = pool.schedule(_shard, args=(self, shard))
        return begun

    def alone(self, pool: ProcessPool, shard: Shard) -> Counts:
        """Do a shard whose process ended, each scene by itself, once.

        One that ends its process again, or takes longer than the limit, is refused; the others are as if it
        had not been there.
        """
        scenes, unread = shard.read()
        ones = [scenes.slice(at, 1) for at in range(len(scenes))]
        begun = [pool.schedule(_scene, args=(self, one)) for one in ones]
        found: list[Found] = []
        lost = list(unread)
        for one, future in zip(ones, begun, strict=True):
            try:
                found.append(future.result())
            except ProcessExpired as end:
                lost.append(self._lost(one, end))
        return self.written(shard, found, lost, len(scenes) + len(unread))

    def _lost(self, scene: pa.RecordBatch, end: ProcessExpired) -> Refused:
        (source,) = scene.column("source").to_pylist()
        if end.exitcode == _LATE:
            reason = f"it took longer than {self.limit:g} s: allow more with --limit"
            return Refused(source, QueryTimeout.__name__, reason)
        reason = f"its process, alone with it, ended with code {end.exitcode}"
        return Refused(source, EngineError.__name__, reason)

    def written(
        self, shard: Shard, found: Sequence[Found], refused: Sequence[Refused], scenes: int
    ) -> Counts:
        """Write what was found in the scenes of a shard, and what of it could not be looked at."""
        relations = pa.Table.from_batches([some for some, _ in found], RELATIONS)
        errors = pa.Table.from_batches([*(some for _, some in found), refusals(refused)], ERRORS)
        return self.folder.write(shard.number, scenes, relations, errors)

    def relations(self, scenes: pa.RecordBatch) -> Found:
        """Return the relations of scenes, or end this process where one of them takes too long."""
        return _kept(self.relate)(scenes, self._watched)

    @contextmanager
    def _watched(self) -> Iterator[None]:
        # Nobody handles the signal: the kernel ends the process, whatever it is doing.
        signal.setitimer(signal.ITIMER_REAL, self.limit)
        try:
            yield
        finally:
            signal.setitimer(signal.ITIMER_REAL, 0.0)


def _shard(work: Work, shard: Shard) -> Counts:
    """Do a shard, in a process of its own."""
    scenes, unread = shard.read()
    return work.written(shard, [work.relations(scenes)], unread, len(scenes) + len(unread))


def _scene(work: Work, scene: pa.RecordBatch) -> Found:
    """Do one scene, in a process of its own."""
    return work.relations(scene)


@cache
def _kept(relate: Relate) -> Relate:
    """Return the first that is equal to this one, ready, in a process that does nothing else."""
    work_alone()
    relate.ready()
    return relate
