"""The same work on a Ray cluster: Ray Data schedules, and does again what was on a machine that is gone."""

from __future__ import annotations

import logging
import os
import pickle
from collections.abc import Iterator, Sequence
from dataclasses import asdict
from functools import cache, partial
from typing import Any, Final

from deixis.batch.folder import Counts
from deixis.batch.processes import Processes
from deixis.batch.sources import Shard
from deixis.batch.work import Work
from deixis.errors import MissingDependency

_BLOCKS: Final = 4096
"""The most tasks; each has several shards where there are more."""


def each(work: Work, left: Sequence[Shard]) -> Iterator[Counts]:
    """Yield what became of each shard.

    The cluster is the one this process is connected to, else that of RAY_ADDRESS, else one on this machine.

    Raises
    ------
    MissingDependency
        Ray is not installed.
    """
    try:
        import ray
        import ray.data
    except ModuleNotFoundError as cause:
        raise MissingDependency(f"--engine ray needs {cause.name}: pip install 'deixis[ray]'") from None
    if not ray.is_initialized():
        os.environ.setdefault("RAY_USAGE_STATS_ENABLED", "0")
        ray.init(include_dashboard=False, log_to_driver=False, logging_level=logging.WARNING)
    # What it says of its plans is for those who write them.
    logging.getLogger("ray.data").setLevel(logging.ERROR)
    items = [{"shard": pickle.dumps(one)} for one in left]
    data = ray.data.from_items(items, override_num_blocks=min(len(items), _BLOCKS))
    found = data.map(partial(_on_worker, work))
    found.context.enable_progress_bars = False
    for counts in found.iter_rows():
        yield Counts(**counts)


def _on_worker(work: Work, row: dict[str, Any]) -> dict[str, int]:
    """Do a shard on a worker of the cluster, in a process that may be ended instead of the worker's own."""
    shard = pickle.loads(row["shard"])  # noqa: S301 - from `each`
    (counts,) = work.each(_processes(), [shard])
    return asdict(counts)


@cache
def _processes() -> Processes:
    """Return the one of this worker; it ends with it, since it then has nobody to work for."""
    return Processes(1)
