"""Data sets on a Ray cluster: the same as here, to the byte, also when a worker is ended."""

from __future__ import annotations

import os
import signal
from pathlib import Path

import pytest

from cluster import MARK
from datasets import as_lines, crowd, rooms
from deixis.batch import Relate
from deixis.batch.folder import Counts
from deixis.batch.run import run

pytestmark = [
    pytest.mark.xdist_group("ray"),
    # Ray's own, from within.
    pytest.mark.filterwarnings("ignore::DeprecationWarning:ray.*"),
]


def workers(cluster: str) -> list[int]:
    """Return the processes of the cluster that are at work on shards."""
    found = []
    for place in Path("/proc").glob("[0-9]*"):
        try:
            working = place.joinpath("cmdline").read_bytes().startswith(b"ray::Map")
            if working and f"{MARK}={cluster}".encode() in place.joinpath("environ").read_bytes():
                found.append(int(place.name))
        except OSError:  # it has ended, or is somebody else's
            continue
    return found


def files(folder: Path) -> dict[str, bytes]:
    """Return what was written."""
    return {str(one.relative_to(folder)): one.read_bytes() for one in folder.rglob("[!._]*.parquet")}


def test_a_cluster_gives_the_same_also_when_a_worker_is_ended(cluster: str, tmp_path: Path) -> None:
    every = rooms(22, 8)
    place = as_lines(tmp_path / "rooms.jsonl", [*every[:7], crowd(), b"garbage", *every[7:]])
    here = run([place], tmp_path / "here", Relate(), limit=3.0, shard=3, workers=2)
    ended: list[int] = []

    def end_one(done: Counts, total: int) -> None:
        if 0 < done.scenes < total and not ended:
            ended.extend(workers(cluster)[:1])
            for worker in ended:
                os.kill(worker, signal.SIGKILL)

    there = run([place], tmp_path / "there", Relate(), limit=3.0, shard=3, engine="ray", progress=end_one)
    assert len(ended) == 1
    assert there == here == Counts(24, here.relations, 2)
    assert files(tmp_path / "here") == files(tmp_path / "there")
    assert len(files(tmp_path / "there")) == 2 * 8


def test_a_cluster_goes_on_where_this_machine_was(cluster: str, tmp_path: Path) -> None:
    place = as_lines(tmp_path / "rooms.jsonl", rooms(6, 8))
    assert cluster
    whole = run([place], tmp_path / "out", Relate(relations=("near",)), shard=2, workers=1)
    for name in ("00000001.parquet", "_errors/00000001.parquet"):
        (tmp_path / "out" / name).rename(tmp_path / Path(name).name)
    kept = files(tmp_path / "out")
    assert run([place], tmp_path / "out", Relate(relations=("near",)), shard=2, engine="ray") == whole
    assert len(files(tmp_path / "out")) == len(kept) + 2
