"""History: the intervals a map keeps are those that full runs at each stamp give, however frames arrive."""

from __future__ import annotations

import random
from collections.abc import Iterable
from itertools import count
from pathlib import Path
from typing import Any

from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from deixis import KnowledgeBase
from deixis.semantic_map import Interval, SemanticMap, create_map
from scenes import ROBOT, box, floor, scene, wall
from test_semantic_map import Address, address, server  # noqa: F401 - fixtures

HANS = Path(__file__).resolve().parent.parent / "kb" / "scenes" / "hans.json"


def brute(kept: SemanticMap, names: Iterable[str] | None = None, **how: Any) -> set[Interval]:
    """Return all intervals, by a full run at each stamp."""
    found: set[Interval] = set()
    before: dict[tuple[str, str, str, str | None], float] = {}
    for stamp in sorted({frame.stamp for frame in kept.frames()}):
        with KnowledgeBase(kept.scene(at=stamp), **how) as kb:
            now = {
                (one.relation, one.figure, one.reference, one.view) for one in kb.relations(relation=names)
            }
        found |= {Interval(*key, since, stamp) for key, since in before.items() if key not in now}
        before = {key: before.get(key, stamp) for key in sorted(now, key=str)}
    return found | {Interval(*key, since, None) for key, since in before.items()}


def frames(draw: random.Random, most: int) -> Iterable[dict[str, Any]]:
    """Yield random frames: a few things that come, move and go, told in any order of their stamps."""
    names = [f"o{at}" for at in range(5)]
    known: set[str] = set()
    for _ in range(most):
        some = draw.sample(names, draw.randint(0, 3))
        things = [
            box(
                name,
                (draw.choice([0, 0.1, 0.5]), draw.choice([0, 0.3]), draw.choice([0.1, 0.3, 0.35])),
                [draw.choice([0.1, 0.2, 0.6]) for _ in range(3)],
                draw.choice([0.0, 0.3]),
                draw.choice("ab"),
            )
            for name in some
        ]
        things += [floor()] if draw.random() < 0.5 else []
        things += [wall(x=0.6)] if draw.random() < 0.2 else []
        views = []
        if draw.random() < 0.5:
            position = [draw.choice([-3.0, 3.0]), draw.choice([0.0, 1.0]), 0.5]
            views = [{**ROBOT, "id": draw.choice(["v0", "v1"]), "position": position}]
            for thing in things[: draw.randint(0, 2)]:
                thing["seen_in"] = [views[0]["id"]]
        gone = [name for name in sorted(known) if name not in some and draw.random() < 0.15]
        known |= set(some)
        yield {
            "scene": scene(*things, views=views),
            "stamp": float(draw.choice([draw.randint(0, 12), draw.randint(0, 3)])),
            "whole": draw.random() < 0.15,
            "gone": gone,
        }


def told(kept: SemanticMap, draw: random.Random, most: int, batch: int) -> None:
    """Tell a map random frames, and ask it in between; each time all intervals are those of full runs."""
    kept._batch = batch
    for frame in frames(draw, most):
        kept.add(frame.pop("scene"), **frame)
        if draw.random() < 0.4:
            assert set(kept.intervals()) == brute(kept)
    assert len(kept.intervals()) == len(set(kept.intervals()))
    assert set(kept.intervals()) == brute(kept)


NUMBERS = count()


@given(seed=st.integers(0, 10**9), batch=st.sampled_from([1, 2, 256]))
@settings(max_examples=25, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_intervals_are_those_of_full_runs(seed: int, batch: int, tmp_path: Path) -> None:
    with create_map(tmp_path / f"{next(NUMBERS)}.duckdb", scene()) as kept:
        told(kept, random.Random(seed), 12, batch)  # noqa: S311 - a test
