"""A data set from end to end: scenes in files to relations in a folder, here or on a Ray cluster."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Final, Literal

from deixis.batch.folder import Counts, Folder, rules_digest
from deixis.batch.processes import Processes
from deixis.batch.relate import Relate
from deixis.batch.sources import Shard, files, shards
from deixis.batch.work import Work
from deixis.parallel import WORKERS

Engine = Literal["processes", "ray"]
"""What the shards are shared among: processes of this machine, or a Ray cluster."""

SHARD: Final = 128
"""Scenes in a shard."""

LIMIT: Final = 60.0
"""Seconds that a scene may take."""

_LONGEST: Final = 1.0e9
"""Seconds: a longer limit, such as infinity, is none, and no timer can be set to it."""


def run(
    places: Sequence[Path],
    target: Path,
    relate: Relate,
    *,
    limit: float = LIMIT,
    shard: int = SHARD,
    workers: int = WORKERS,
    engine: Engine = "processes",
    progress: Callable[[Counts, int], object] = lambda *_: None,
) -> Counts:
    """Derive the relations of all scenes into a folder of Parquet files, one a shard.

    A shard that is done is not done again: a run that was stopped goes on where it was. What is refused is in
    the folder ``_errors``, what all of it rests on in ``_manifest.json``.

    Parameters
    ----------
    places : sequence of Path
        Files of scenes, JSON lines, Parquet, or folders of them.
    target : Path
        The folder; made if need be.
    relate : Relate
    limit : float
        Seconds that a scene may take; infinity for any time.
    shard : int
        The most scenes in a shard.
    workers : int
        Processes; a Ray cluster has its own.
    engine : "processes" or "ray"
        The result is the same.
    progress : callable
        Called with what is done so far, and how many scenes there are; lines and rows without any count too.

    Returns
    -------
    Counts
        Of all that is in the folder.

    Raises
    ------
    ReaderError
        An input is not there, or the folder holds the result of something else.
    RuleError, QueryError
        Something is wrong with a rule file, or there is no such relation.
    MissingDependency
        What measures meshes is not installed, or Ray is not.
    """
    relate = replace(relate, rules=tuple(map(_whole, relate.rules)))
    relate.ready()
    limit = min(limit, _LONGEST)
    folder = Folder(target.resolve())
    given = files(places, folder.path)
    folder.begin(given, relate, limit, shard)
    every = list(shards(given, shard))
    states = [folder.done(one.number) for one in every]
    done = sum((state for state in states if state is not None), Counts())
    total = sum(map(len, every))
    progress(done, total)
    left = [one for one, state in zip(every, states, strict=True) if state is None]
    for counts in _each(engine, Work(relate, folder, limit, rules_digest(relate)), left, workers):
        done += counts
        progress(done, total)
    return done


def _each(engine: Engine, work: Work, left: Sequence[Shard], workers: int) -> Iterator[Counts]:
    """Yield what became of each shard that is left."""
    if not left:
        return
    if engine == "ray":
        from deixis.batch.on_ray import each

        yield from each(work, left)
    else:
        with Processes(min(workers, len(left))) as processes:
            yield from work.each(processes, left)


def _whole(name: str) -> str:
    """Return where a rule file is, for those who look from elsewhere; names of shipped ones as they are."""
    return str(Path(name).resolve()) if Path(name).is_file() else name
