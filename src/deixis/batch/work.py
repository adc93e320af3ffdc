"""What is done with a shard, in a process that may end: a scene that hangs or breaks it costs no other."""

from __future__ import annotations

import signal
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from typing import Final

import pyarrow as pa

from deixis.batch.columns import Columns
from deixis.batch.folder import Counts, Folder
from deixis.batch.processes import Ended, Processes
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
    rules : str
        What is another when the rule files are.
    """

    relate: Relate
    folder: Folder
    limit: float
    rules: str = ""

    def each(self, processes: Processes, shards: Sequence[Shard]) -> Iterator[Counts]:
        """Yield what became of each shard, as it comes.

        Where a process ended, the scenes of its shard are done each by itself, once, when nothing else is
        left to do: one that ends its process again, or takes longer than the limit, is refused, and the
        others are as if it had not been there.
        """
        ended: list[Shard] = []
        for one in processes.each(self.shard, shards):
            if isinstance(one, Ended):
                ended.append(one.item)
            else:
                yield one
        for shard in ended:
            yield self.scenes(processes, shard)

    def shard(self, shard: Shard) -> Counts:
        """Do a shard in this process, which ends where a scene takes too long."""
        scenes, unread = shard.read()
        return self._written(shard, [self._found(scenes)], unread, len(scenes))

    def scenes(self, processes: Processes, shard: Shard) -> Counts:
        """Do a shard scene by scene; what ends its process is refused."""
        scenes, unread = shard.read()
        ones = [(at, scenes.slice(at, 1)) for at in range(len(scenes))]
        found: dict[int, Found] = {}
        for one in processes.each(self.scene, ones):
            if isinstance(one, Ended):
                at, scene = one.item
                found[at] = Columns({}).batch(), refusals([self._lost(scene, one.code)])
            else:
                at, told = one
                found[at] = told
        return self._written(shard, [found[at] for at in sorted(found)], unread, len(scenes))

    def scene(self, numbered: tuple[int, pa.RecordBatch]) -> tuple[int, Found]:
        """Do one scene in this process, which ends where it takes too long."""
        at, scene = numbered
        return at, self._found(scene)

    def _lost(self, scene: pa.RecordBatch, code: int) -> Refused:
        (source,) = scene.column("source").to_pylist()
        if code == _LATE:
            reason = f"it took longer than {self.limit:g} s: allow more with --limit"
            return Refused(source, QueryTimeout.__name__, reason)
        reason = f"its process, which did nothing else, ended with code {code}"
        return Refused(source, EngineError.__name__, reason)

    def _found(self, scenes: pa.RecordBatch) -> Found:
        return _kept(self.relate, self.rules)(scenes, self._watched)

    @contextmanager
    def _watched(self) -> Iterator[None]:
        # Nobody handles the signal: the kernel ends the process, whatever it is doing.
        signal.setitimer(signal.ITIMER_REAL, self.limit)
        try:
            yield
        finally:
            signal.setitimer(signal.ITIMER_REAL, 0.0)

    def _written(
        self, shard: Shard, found: Sequence[Found], unread: Sequence[Refused], scenes: int
    ) -> Counts:
        relations = pa.Table.from_batches([some for some, _ in found], RELATIONS)
        # The same bytes, whether the scenes were done together or each by itself.
        relations = relations.unify_dictionaries().combine_chunks()
        errors = pa.Table.from_batches([*(some for _, some in found), refusals(unread)], ERRORS)
        return self.folder.write(shard.number, scenes + len(unread), relations, errors)


@cache
def _kept(relate: Relate, rules: str) -> Relate:  # noqa: ARG001 - what it was made of
    """Return the first that is equal to this one, ready, in a process that does nothing else."""
    work_alone()
    relate.ready()
    return relate
