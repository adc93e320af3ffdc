"""Work shared by processors, and what must not depend on how it is shared."""

from __future__ import annotations

import os
import threading

import numpy as np
import pytest

from deixis import locality
from deixis.boxes import Boxes
from deixis.broadphase import candidate_rows
from deixis.grounding import measure_pairs
from deixis.locality import Neighbourhood, Rows, runs
from deixis.parallel import WORKERS, share
from deixis.thresholds import Thresholds


def scattered(count: int, spread: float = 12.0) -> Boxes:
    rng = np.random.default_rng(count)
    center = rng.uniform(0.0, [spread, spread, 2.0], (count, 3))
    half = rng.uniform(0.02, 0.4, (count, 3))
    normal = np.full(count, -1)
    normal[: count // 100] = 2
    return Boxes(center, half, rng.uniform(-3.0, 3.0, count), normal, np.zeros(count, dtype=bool))


def test_every_part_is_done_once() -> None:
    done: list[int] = []
    share(done.append, range(1000))
    assert sorted(done) == list(range(1000))


def test_an_error_is_raised_and_ends_the_work() -> None:
    done: list[int] = []

    def work(part: int) -> None:
        if part == 3:
            raise ValueError("three")
        done.append(part)

    with pytest.raises(ValueError, match="three"):
        share(work, range(100_000))
    assert len(done) < 100_000
    share(done.append, [-1])
    assert -1 in done


def test_work_may_be_shared_within_work_and_by_many_threads() -> None:
    done: list[int] = []

    def outer(_: int) -> None:
        share(done.append, range(20))

    threads = [threading.Thread(target=share, args=(outer, range(10))) for _ in range(4 * WORKERS)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(60.0)
    assert len(done) == len(threads) * 10 * 20


@pytest.mark.skipif(not hasattr(os, "fork"), reason="this system does not fork")
@pytest.mark.filterwarnings("ignore:.*fork.*:DeprecationWarning")
def test_a_forked_child_works_too() -> None:
    share(lambda _: None, range(100))
    child = os.fork()
    if child == 0:
        done: list[int] = []
        share(done.append, range(1000))
        os._exit(0 if len(done) == 1000 else 1)
    assert os.waitpid(child, 0)[1] == 0


def test_pairs_are_those_of_all_with_all() -> None:
    for spread in (3.0, 30.0, 3.0e4):
        some, limits = scattered(500, spread), Thresholds()
        i, j = (index[~np.eye(500, dtype=bool)] for index in np.indices((500, 500)))
        every = measure_pairs(some, i, j, limits)
        found = measure_pairs(some, *candidate_rows(some, limits), limits)
        np.testing.assert_array_equal(every.figure, found.figure)
        np.testing.assert_array_equal(every.reference, found.reference)


def test_blocks_of_neighbours_change_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    some, limits = scattered(700), Thresholds()
    figure, reference = candidate_rows(some, limits)
    plain = measure_pairs(some, figure, reference, limits)
    monkeypatch.setattr(locality, "_SPREAD", 100)
    monkeypatch.setattr(locality, "_BLOCK", 64)
    near = measure_pairs(some, figure, reference, limits)
    for name in plain.__slots__:
        np.testing.assert_array_equal(getattr(plain, name), getattr(near, name))


@pytest.mark.parametrize("figure", [np.sort(np.arange(5000) % 37), np.arange(5000) % 37, np.zeros(5000, int)])
def test_each_row_is_in_one_block(figure: np.ndarray, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(locality, "_SPREAD", 30)
    monkeypatch.setattr(locality, "_BLOCK", 50)
    seen = np.zeros(len(figure), dtype=int)

    def work(rows: Rows) -> None:
        seen[rows] += 1

    Neighbourhood(scattered(40)).for_blocks(figure, work)
    assert (seen == 1).all()


def test_runs_of_nothing() -> None:
    nothing = np.zeros(0, dtype=np.int64)
    assert runs(nothing, nothing).tolist() == []
    assert runs(np.array([4, 9]), np.array([0, 1])).tolist() == [9]
