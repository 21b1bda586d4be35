"""The swept end mill's kernel beside its definition, its axis still or turning."""

import numpy as np
import pytest

from tests.support.mill_reference import lowest
from trueloop._core import CutterSweep
from trueloop.arrays import Array

REACH = 2.0


def way(rng: np.random.Generator, count: int, turn_rad: float) -> tuple[Array, Array]:
    """A winding way and axes near the upright; `turn_rad`: by about how much they turn between two nodes."""
    nodes = np.cumsum(rng.normal(0.0, [0.4, 0.4, 0.05], (count, 3)), axis=0)
    axes = np.array([0.0, 0.0, 1.0]) + np.cumsum(rng.normal(0.0, turn_rad, (count, 3)), axis=0) + rng.normal(0, 0.15, 3)
    return nodes, axes / np.linalg.norm(axes, axis=1, keepdims=True)


def rays_to(rng: np.random.Generator, nodes: Array, end: tuple[float, float], count: int) -> tuple[Array, Array]:
    """Rays from below, roughly upright, that pass near the end's edge."""
    direction = np.array([0.0, 0.0, 1.0]) + rng.normal(0.0, 0.25, (count, 3))
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    aside = rng.normal(0.0, 0.7 * sum(end), (count, 3)) * [1, 1, 0]
    return nodes[rng.integers(0, len(nodes), count)] + aside - 0.5 * direction, direction


@pytest.mark.parametrize("end", [(2.0, 1.0), (2.5, 0.2), (2.0, 0.0)], ids=["bull nose", "small corner", "flat"])
@pytest.mark.parametrize("turn_rad", [0.0, 0.003], ids=["still", "turning"])
@pytest.mark.parametrize("seed", range(3))
def test_kernel_and_definition_agree(end: tuple[float, float], turn_rad: float, seed: int) -> None:
    rng = np.random.default_rng(seed)
    nodes, axes = way(rng, 12, turn_rad)
    origins, directions = rays_to(rng, nodes, end, 8)
    swept = CutterSweep(nodes, *end, axes if turn_rad else axes[:1])
    found = swept.entries(origins, directions, np.full(8, REACH), REACH)
    every = axes if turn_rad else np.tile(axes[:1], (12, 1))
    wanted = [lowest(o, d, nodes, every, end, REACH) for o, d in zip(origins, directions, strict=True)]
    assert np.count_nonzero(found < REACH) >= 4
    # A disc of reach R that turns by δ on a piece is not quite convex on it: by R δ²/8.
    turned = np.max(np.linalg.norm(np.diff(every, axis=0), axis=1))
    np.testing.assert_allclose(found, wanted, atol=1e-7 + 2 * sum(end) * turned**2 / 8)
