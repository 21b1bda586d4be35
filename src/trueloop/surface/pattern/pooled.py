"""Parts' values at common places: means over cells, for what cannot look at every point of every part."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.surface.separation.separate import Separation

CELLS: Final = 900
SOME: Final = 2000
"""Points that tell how far they are apart."""


@dataclass(frozen=True, eq=False)
class Pooled:
    """Mean places (n, 2) in mm of all parts' points in cells of `step_mm`, and every part's value there (parts, n), nan
    for none.
    """

    at_mm: Array
    values_mm: Array
    step_mm: float

    @property
    def mean_mm(self) -> Array:
        """The mean of the parts that have a value, (n,)."""
        return np.asarray(np.nanmean(self.values_mm, axis=0))


def pooled(parts: Sequence[Separation], sides_mm: tuple[float, float]) -> Pooled:
    """Values of parts in cells as wide as the points are apart, `CELLS` on the whole patch at most.

    A part's value is its spline at the cell's place with the mean of what it leaves in the cell: the pattern's slope
    between a point and the cell's place is then no noise.
    """
    step = max(float(np.sqrt(sides_mm[0] * sides_mm[1] / CELLS)), min(_apart_mm(part, sides_mm) for part in parts))
    shape = [max(1, round(side / step)) for side in sides_mm]
    cells = [_cell(part, shape) for part in parts]
    filled = np.unique(np.concatenate(cells))
    counts = np.stack([_sums(cell, np.ones(len(cell)), filled) for cell in cells])
    u, v = (
        np.sum(
            [_sums(cell, getattr(part.places, name), filled) for cell, part in zip(cells, parts, strict=True)], axis=0
        )
        / np.sum(counts, axis=0)
        for name in "uv"
    )
    values = np.full(counts.shape, np.nan)
    for own, part, cell, count in zip(values, parts, cells, counts, strict=True):
        has = count > 0
        left = _sums(cell, part.random_mm, filled)[has] / count[has]
        own[has] = part.deterministic.value_mm(u[has], v[has]) + left
    return Pooled(np.stack([u * sides_mm[0], v * sides_mm[1]], axis=1), values, step)


def _apart_mm(part: Separation, sides_mm: tuple[float, float]) -> float:
    """How far a part's points are apart: on a grid its larger step at most, wherever the grid ends."""
    from scipy.spatial import KDTree  # slow to import

    points = np.stack([part.places.u, part.places.v], axis=1) * sides_mm
    distance, _ = KDTree(points).query(points[:: max(1, len(points) // SOME)], k=[5])
    return float(np.median(distance))


def _cell(part: Separation, shape: Sequence[int]) -> np.ndarray:
    row, column = (
        np.clip((along * count).astype(int), 0, count - 1)
        for along, count in zip((part.places.u, part.places.v), shape, strict=True)
    )
    return np.asarray(row * shape[1] + column)


def _sums(cell: np.ndarray, values: Array, filled: np.ndarray) -> Array:
    """Sums of values over the cells that are filled."""
    return np.asarray(np.bincount(cell, values, int(filled[-1]) + 1)[filled], float)
