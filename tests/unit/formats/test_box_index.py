"""Which boxes overlap, beside all of them compared with all; and what a large drawing takes."""

import tracemalloc
from unittest.mock import patch

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from trueloop.arrays import Array
from trueloop.formats.cad import box_index
from trueloop.formats.cad.box_index import TooDenseError, overlapping
from trueloop.formats.cad.dxf_edges import Edges, cut_where_met
from trueloop.geometry.feature import Line


def _boxes(random: np.random.Generator, count: int, on_grid: bool) -> tuple[Array, Array]:
    """Boxes of very unlike sizes, points among them; on a grid so that many only touch."""
    low = random.uniform(-100, 100, (count, 2))
    size = 10 ** random.uniform(-4, 2, (count, 1)) * random.integers(0, 2, (count, 2))
    return (np.round(low), np.round(low + size)) if on_grid else (low, low + size)


@given(st.integers(0, 2**32), st.tuples(st.integers(0, 60), st.integers(0, 60)), st.booleans(), st.integers(1, 99))
def test_the_pairs_are_those_of_all_with_all(seed: int, sizes: tuple[int, int], on_grid: bool, at_once: int) -> None:
    random = np.random.default_rng(seed)
    (low, high), (other_low, other_high) = (_boxes(random, count, on_grid) for count in sizes)
    apart = np.any((low[:, None] > other_high[None]) | (other_low[None] > high[:, None]), axis=-1)
    with patch.object(box_index, "AT_ONCE", at_once):
        found = overlapping(low, high, other_low, other_high)
    np.testing.assert_array_equal(found, np.argwhere(~apart).reshape(-1, 2))


@pytest.mark.parametrize("stacked", [False, True])
def test_100_000_lines_take_memory_by_their_number(stacked: bool) -> None:
    """Compared all with all they would take 10¹⁰ bytes for each property of a pair; thrown together, and as lines of
    30 mm one above the other, of which a cell holds ten.
    """
    random = np.random.default_rng(1)
    low = random.uniform(0, 400, (100_000, 2))
    high = low + random.uniform(0, 1, (100_000, 2))
    if stacked:
        low = np.stack([np.zeros(100_000), 3.0 * np.arange(100_000)], axis=1)
        high = low + np.array([30.0, 0.0])
    tracemalloc.start()
    found = overlapping(low, high, low, high)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert 100_000 <= len(found) < 200_000 and peak < 50e6


def test_lines_all_in_one_place_are_refused() -> None:
    same = np.zeros((3000, 2))
    with pytest.raises(TooDenseError, match="4000000 pairs"):
        overlapping(same, same, same, same)


def test_a_grid_of_lines_is_cut_at_its_crossings() -> None:
    """20 by 20 lines, each across all others: 400 crossings, 21 pieces a line."""
    across = [Line("", (float(k), -1.0), (float(k), 20.0)) for k in range(20)]
    along = [Line("", (-1.0, float(k)), (20.0, float(k))) for k in range(20)]
    pieces = cut_where_met(Edges.of([*across, *along], ["0"] * 40), 1e-3)
    assert len(pieces) == 40 * 21
    assert pieces.length_mm.sum() == pytest.approx(40 * 21.0)
