"""A map from end to end: cut into tiles, done tile by tile on this machine or by Ray, and put together."""

from __future__ import annotations

import hashlib
import json
import multiprocessing
import os
import shutil
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from dataclasses import asdict, dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any, Final, Literal

import pyarrow as pa
import pyarrow.parquet as pq

from deixis._files import datalog_files, write_whole
from deixis.errors import DeixisError, EngineError, MissingDependency, ReaderError
from deixis.ruleset import locate
from deixis.strict_json import parse, quoted
from deixis.tiles.after import after
from deixis.tiles.sources import files, head
from deixis.tiles.store import Tile, check_size, collect, cut, name_of
from deixis.tiles.work import Job, Worker
from deixis.vocabulary import asked_for

EngineName = Literal["local", "ray"]

MEMORY: Final = 2 * 2**30
"""Bytes that sorting, and deriving from all tiles together, may take before they go on on disk."""

_MANIFEST: Final = "manifest.json"
_WORK: Final = ".deixis-work"
"""A folder beside the result while a map is worked on."""
_NOWHERE: Final = "none"
"""The partition of relations that name no thing."""


@dataclass
class Summary:
    """What became of a map: its tiles, those done now and before, and what was found so far."""

    tiles: int = 0
    done: int = 0
    before: int = 0
    things: int = 0
    relations: int = 0


def run(
    places: Sequence[Path],
    target: Path,
    *,
    size: float | None = None,
    relations: Sequence[str] = (),
    rules: Sequence[Path] = (),
    workers: int | None = None,
    engine: EngineName = "local",
    memory: int = MEMORY,
    progress: Callable[[Summary], object] = lambda _: None,
) -> Summary:
    """Derive the relations of a map of any size into a folder of Parquet files, by tile.

    ``relations/tile=X_Y/part.parquet`` has those of each tile, ``relations/tile=X_Y/after.parquet`` those
    that were derived from all tiles together, ``things/tile=X_Y/part.parquet`` its things. Files are written
    whole; a run that was stopped goes on where it was. A relation is in the tile of its figure's centre,
    where that is no surface; together they are those of :meth:`deixis.KnowledgeBase.relations`.

    Parameters
    ----------
    places : sequence of Path
        Tables of things, or scene files, or folders of them; views and thresholds stand in scene files.
    target : Path
        A folder; made if need be.
    size : float, optional
        Side of a tile, metres; by default such that none has more than some 20,000 things.
    relations : str or sequence of str
        Which; by default all that people speak in.
    rules : sequence of Path
        Rule files of one's own, or names of shipped ones.
    workers : int, optional
        Processes; by default as many as there are processors. With one, all is done in this process.
    engine : "local" or "ray"
        What the tiles are done by.
    memory : int
        Bytes that sorting may take, and deriving from all tiles together.
    progress : callable
        Called with what is done so far, after each tile.

    Raises
    ------
    ReaderError, SceneError
        The map is not there or not well formed, or the folder holds the result of something else.
    RuleError, QueryError
        Something is wrong with a rule file, or there is no such relation.
    GeometryError, EngineError
        There is too much in one tile.
    MissingDependency
        Ray is not installed.
    """
    check_size(size)
    # Whoever does a tile may stand elsewhere.
    target = target.resolve()
    inputs = files(places, target)
    told = head(inputs)
    found = tuple(str(one.absolute()) for one in (locate(rules, datalog_files()) if rules else ()))
    work = target / _WORK
    names = asked_for(relations) if relations else []
    options = {"size": size, "relations": names, "rules": found}
    before = _manifest(target, inputs, options)
    job = Job(str(work), 1.0, json.dumps(told.to_dict()), places[0].name, tuple(names), found)
    Worker(job).places  # noqa: B018 - what is wrong with the rules or the names is said at once
    if before.get("done"):
        shutil.rmtree(work, ignore_errors=True)  # of a run that was stopped at its very end
        return Summary(before["tiles"], 0, before["tiles"], before["things"], before["relations"])
    if "metres" not in before:
        shutil.rmtree(work, ignore_errors=True)
        work.mkdir(parents=True)
        start = time.monotonic()
        things = collect(inputs, told, work)
        metres, every = cut(work, size, memory)
        (work / "told.parquet").unlink()
        seconds = round(time.monotonic() - start, 3)
        before |= {
            "metres": metres,
            "things": things,
            "tiles": len(every),
            "seconds": seconds,
            "listed": every,
        }
        _note(target, before)
    job = Job(**{**asdict(job), "size": before["metres"]})
    tiles: list[Tile] = [(int(x), int(y)) for x, y in before["listed"]]
    ready = [tile for tile in tiles if _ends(target, tile).exists()]
    known = set(ready)
    todo = [tile for tile in tiles if tile not in known]
    summary = Summary(len(tiles), 0, len(ready))
    for tile in ready:
        summary.things += pq.read_metadata(_part(target, "things", tile)).num_rows
        summary.relations += pq.read_metadata(_ends(target, tile)).num_rows
    with _engine(engine, workers, job, target) as every_one:
        for things, count in every_one(todo):
            summary.done += 1
            summary.things += things
            summary.relations += count
            progress(summary)
    worker = Worker.of(job)
    for place, table in after(worker, work, work / "between", memory):
        name = _NOWHERE if place is None else name_of(place)
        _write(target / "relations" / f"tile={name}" / "after.parquet", table)
        summary.relations += len(table)
    del before["listed"]
    _note(target, {**before, "relations": summary.relations, "done": True})
    shutil.rmtree(work)
    return summary


def do(job: Job, target: Path, tile: Tile) -> tuple[int, int]:
    """Do one tile and write what was found; return how many things it has and how many relations."""
    found = Worker.of(job)(tile)
    name = name_of(tile)
    for node, table in found.between.items():
        _write(Path(job.folder) / "between" / node / f"{name}.parquet", table)
    _write(_part(target, "things", tile), found.things)
    # Last: by this file a tile is known to be done.
    _write(_ends(target, tile), found.relations)
    return len(found.things), len(found.relations)


def _ends(target: Path, tile: Tile) -> Path:
    return _part(target, "relations", tile)


def _part(target: Path, what: str, tile: Tile) -> Path:
    return target / what / f"tile={name_of(tile)}" / "part.parquet"


def _write(place: Path, table: pa.Table) -> None:
    sink = pa.BufferOutputStream()
    pq.write_table(table, sink, compression="zstd")
    place.parent.mkdir(parents=True, exist_ok=True)
    write_whole(place, sink.getvalue())


_Results = Callable[[Sequence[Tile]], Iterator[tuple[int, int]]]


class _Local:
    """Does tiles in processes of this machine."""

    def __init__(self, workers: int | None, job: Job, target: Path) -> None:
        self._workers = workers or len(os.sched_getaffinity(0))
        self._job, self._target = job, target

    def __enter__(self) -> _Results:
        return self._alone if self._workers == 1 else self._shared

    def __exit__(self, *_: object) -> None:
        pass

    def _alone(self, tiles: Sequence[Tile]) -> Iterator[tuple[int, int]]:
        for tile in tiles:
            yield do(self._job, self._target, tile)

    def _shared(self, tiles: Sequence[Tile]) -> Iterator[tuple[int, int]]:
        context = multiprocessing.get_context("forkserver")
        waiting: set[Future[tuple[int, int]]] = set()
        with ProcessPoolExecutor(min(self._workers, max(len(tiles), 1)), mp_context=context) as pool:
            try:
                for tile in tiles:
                    if len(waiting) >= 2 * self._workers:
                        ready, waiting = wait(waiting, return_when=FIRST_COMPLETED)
                        yield from (one.result() for one in ready)
                    waiting.add(pool.submit(do, self._job, self._target, tile))
                while waiting:
                    ready, waiting = wait(waiting, return_when=FIRST_COMPLETED)
                    yield from (one.result() for one in ready)
            except BrokenProcessPool as error:
                raise EngineError(
                    "a process that did a tile was ended, for want of memory perhaps: choose smaller tiles, "
                    "or fewer workers; what is done is kept"
                ) from error
            finally:
                pool.shutdown(cancel_futures=True)


class _Ray:
    """Does tiles by Ray, on as many machines as share the folder."""

    def __init__(self, workers: int | None, job: Job, target: Path) -> None:
        try:
            import ray
        except ImportError as error:
            raise MissingDependency("Ray was not found: pip install 'deixis[ray]'") from error
        self._ray: Any = ray
        self._workers, self._job, self._target = workers, job, target
        self._ours = False

    def __enter__(self) -> _Results:
        if not self._ray.is_initialized():
            self._ours = True
            self._ray.init(
                num_cpus=None if os.environ.get("RAY_ADDRESS") else self._workers,
                include_dashboard=False,
                log_to_driver=False,
                logging_level="error",
            )
        return self._tiles

    def __exit__(self, *_: object) -> None:
        if self._ours:
            self._ray.shutdown()

    def _tiles(self, tiles: Sequence[Tile]) -> Iterator[tuple[int, int]]:
        remote = self._ray.remote(do)
        waiting: list[Any] = []
        most = 2 * (self._workers or int(self._ray.cluster_resources().get("CPU", 1)))
        for tile in tiles:
            if len(waiting) >= most:
                ready, waiting = self._ray.wait(waiting)
                yield from self._results(ready)
            waiting.append(remote.remote(self._job, self._target, tile))
        while waiting:
            ready, waiting = self._ray.wait(waiting)
            yield from self._results(ready)

    def _results(self, ready: Sequence[Any]) -> Iterator[tuple[int, int]]:
        try:
            yield from self._ray.get(ready)
        except self._ray.exceptions.RayTaskError as error:
            cause = error.cause
            raise (cause if isinstance(cause, DeixisError) else error) from None
        except self._ray.exceptions.RayError as error:
            raise EngineError(
                f"Ray could not do a tile: {str(error).splitlines()[0]}; what is done is kept"
            ) from error


def _engine(name: EngineName, workers: int | None, job: Job, target: Path) -> _Local | _Ray:
    return (_Ray if name == "ray" else _Local)(workers, job, target)


def _manifest(target: Path, inputs: Sequence[Path], options: dict[str, Any]) -> dict[str, Any]:
    """Return what is noted of a folder, which is of the same map and options or empty."""
    stats = [(str(one.resolve()), one.stat().st_size, one.stat().st_mtime_ns) for one in inputs]
    rules = [Path(one).read_text(encoding="utf-8") for one in options["rules"]]
    digest = hashlib.sha256(json.dumps([version("deixis"), options, stats, rules]).encode()).hexdigest()
    place = target / _MANIFEST
    where = quoted(str(target), 200)
    if place.exists():
        noted = parse(place.read_bytes(), ReaderError, quoted(str(place), 200))
        if not isinstance(noted, dict) or noted.get("digest") != digest:
            raise ReaderError(
                f"{where} holds the result of another map or other options: choose another folder"
            )
        return noted
    if target.exists() and (not target.is_dir() or any(one.name != _WORK for one in target.iterdir())):
        raise ReaderError(f"{where} holds something else: choose another folder")
    target.mkdir(parents=True, exist_ok=True)
    return {"schema": 1, "digest": digest, "options": options, "inputs": [one.name for one in inputs]}


def _note(target: Path, noted: dict[str, Any]) -> None:
    write_whole(target / _MANIFEST, (json.dumps(noted, indent=1) + "\n").encode())
