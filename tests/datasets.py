"""Data sets for tests and benchmarks: furnished rooms, and scenes that do no good."""

from __future__ import annotations

import json
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np

from bench.job import room


def rooms(count: int, things: int = 30) -> list[dict[str, Any]]:
    """Return rooms as JSON values of scene format v1, each with an id of its own."""
    return [{**room(things, seed).to_dict(), "id": f"room-{seed}"} for seed in range(count)]


def crowd(count: int = 2_000) -> dict[str, Any]:
    """Return a scene that takes long: everything is in everything else."""
    centers = np.random.default_rng(0).uniform(0.0, 1.0, (count, 3)).tolist()
    things = [{"id": f"o{at}", "box": {"center": one, "size": [0.5] * 3}} for at, one in enumerate(centers)]
    return {"deixis": 1, "id": "crowd", "objects": things, "views": []}


def as_lines(place: Path, scenes: Iterable[dict[str, Any] | bytes]) -> Path:
    """Write scenes as JSON lines; bytes are put in as they are."""
    lines = [one if isinstance(one, bytes) else json.dumps(one).encode() for one in scenes]
    place.write_bytes(b"\n".join(lines) + b"\n")
    return place
