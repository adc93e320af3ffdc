"""Strips: the sums and fits of windows are those that each window by itself would give."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from deixis.perception.smoothing import smooth
from deixis.perception.strips import Strip


def strip_of(u: np.ndarray, v: np.ndarray, layer: np.ndarray, radius: int) -> Strip:
    frames = [
        [u[layer == one].min(), u[layer == one].max(), v[layer == one].min(), v[layer == one].max()]
        for one in range(int(layer.max()) + 1)
    ]
    return Strip.of(u, v, layer, np.array(frames), radius)


@given(seed=st.integers(0, 2**32 - 1), radius=st.integers(1, 6), layers=st.integers(1, 4))
def test_fits_are_those_of_least_squares(seed: int, radius: int, layers: int) -> None:
    rng = np.random.default_rng(seed)
    parts = []
    for number in range(layers):
        height, width = rng.integers(1, 24, 2)
        v, u = np.nonzero(rng.random((height, width)) < rng.uniform(0.2, 1.0))
        if not len(u):
            v, u = np.zeros(1, dtype=int), np.zeros(1, dtype=int)
        parts.append(np.stack([u + rng.integers(0, 600), v + rng.integers(0, 400), np.full(len(u), number)]))
    u, v, layer = np.concatenate(parts, axis=1)
    depth = rng.uniform(0.5, 6.0) + rng.normal(0.0, 0.02, len(u))
    use = rng.random(len(u)) < 0.9
    strip = strip_of(u, v, layer, radius)
    every = np.arange(len(u))
    crowd = strip.crowd(every)
    fit, spread, count = strip.fit(depth, use, every)
    for index in rng.choice(every, min(len(every), 12), replace=False):
        window = (layer == layer[index]) & (np.abs(u - u[index]) <= radius) & (np.abs(v - v[index]) <= radius)
        assert crowd[index] == window.sum()
        window &= use
        assert count[index] == window.sum()
        x, y = u[window] - u[index], v[window] - v[index]
        if count[index] < 3 or np.linalg.matrix_rank(np.stack([np.ones(len(x)), x, y])) < 3:
            continue
        assert spread[index] >= 1.0 / count[index] - 1e-6
        # The fit by least squares with the same small spread added to that of the window.
        dx, dy, q = x - x.mean(), y - y.mean(), 1.0 / depth[window]
        square = np.array([[dx @ dx, dx @ dy], [dx @ dy, dy @ dy]]) / len(x) + 0.05 * np.eye(2)
        slope = np.linalg.solve(square, np.array([dx @ q, dy @ q]) / len(x))
        expected = 1.0 / (q.mean() - slope @ [x.mean(), y.mean()])
        assert fit[index] == pytest.approx(expected, abs=1e-5)


def test_the_far_end_of_a_thing_is_kept() -> None:
    """A floor that goes away from the camera lies in many layers; none of it is left out."""
    rows = np.arange(60)[:, None] + np.zeros((1, 40))
    true = 1.0 / (0.6 - 0.007 * rows)
    depth = true + np.random.default_rng(0).normal(0.0, 0.005, true.shape)
    found = smooth(depth, np.ones(true.shape, dtype=bool), 0.005)
    last = found.v == 59
    assert last.sum() >= 38
    assert np.abs(found.depth[last] - true[59, 0]).max() < 0.03


@pytest.mark.parametrize("shape", [(1, 1), (1, 200), (30, 1)])
def test_lines_and_specks_make_no_fuss(shape: tuple[int, int]) -> None:
    depth = np.linspace(1.0, 9.0, shape[0] * shape[1]).reshape(shape)
    found = smooth(depth, np.ones(shape, dtype=bool), 0.01)
    assert len(found.u) + found.dropped == depth.size


def test_layers_are_worked_on_some_at_a_time() -> None:
    """Pixels that fly far are in hundreds of layers, more than one strip holds."""
    rng = np.random.default_rng(0)
    flying = rng.random((90, 90)) < 0.08
    depth = np.where(flying, rng.uniform(0.5, 60.0, flying.shape), 2.0)
    found = smooth(depth, np.ones(depth.shape, dtype=bool), 0.001)
    assert found.dropped == pytest.approx(flying.sum(), abs=12)
    assert np.count_nonzero(np.abs(found.depth - 2.0) < 1e-3) >= (~flying).sum()
