"""Where measured points support a pattern, and what stands for it where they do not.

Up to about a step from its points, and as long as these determine it, a part's spline is taken; farther on, by kriging
(`kriging`), what the pattern's own process expects, which fades to none. The two are blended where both are good.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from trueloop.arrays import Array, for_kernel
from trueloop.surface.on_face import SUPPORT
from trueloop.surface.pattern.kriging import Kriging, Process, Sides, fitted_process
from trueloop.surface.separation.separate import Separation
from trueloop.surface.separation.spline_surface import SMOOTHING, Places, Size, SplineSurface, basis, fit_grid, splines

if TYPE_CHECKING:
    from scipy.spatial import KDTree

FINE: Final = Size(63, 63, 3)
"""Samples a side of faded models, and the splines through them: finer than any pattern's."""


NEAR: Final = 0.75
"""Of the distance to the fourth nearest point: from the middle of a square mesh to its corners it is 0.71."""


BLENDED: Final = 1.75
"""At so many times that distance, nothing is left of the spline."""


DETERMINED: Final = (2.0, 4.0)
"""Variance of the spline, over that of one of its points, up to which it is taken, and from which on it is not: at
points themselves it is below 1.
"""


CREASES: Final = 2.0
"""Samples that the blending is smoothed over (one standard deviation)."""


KNOWN: Final = 0.99
"""A place is supported where measurements take away this share of the variance that waves and noise have: the pattern
is then known there to a tenth of its own scatter.
"""


SOME: Final = 2000


@dataclass(frozen=True, eq=False)
class Support:
    """How far measurements tell the pattern, on a square of `SUPPORT` parameters a side, [0, 1] both.

    `known` is 1 beside measured points and 1 − V/(τ² + σ²) elsewhere, V the variance about what kriging expects, not
    below 0; `deviation_mm` what V adds to the uncertainty: one standard deviation, widened for being an estimate;
    `parts` how many parts tell of a place.
    """

    process: Process
    known: Array
    deviation_mm: Array
    parts: Array

    @property
    def supported(self) -> np.ndarray:
        """Which samples are supported by measurements."""
        return self.known >= KNOWN


def between(samples: Array, u: Array, v: Array) -> Array:
    """Samples on an even square of parameters, linearly between them, at pairs (n,) of parameters."""
    last = len(samples) - 1
    a, b = np.clip(u, 0.0, 1.0) * last, np.clip(v, 0.0, 1.0) * last
    i, j = np.minimum(a.astype(int), last - 1), np.minimum(b.astype(int), last - 1)
    a, b = a - i, b - j
    low, high = (samples[k, j] * (1 - b) + samples[k, j + 1] * b for k in (i, i + 1))
    return np.asarray(low * (1 - a) + high * a)


def faded(parts: Sequence[Separation]) -> tuple[tuple[SplineSurface, ...], Support] | None:
    """The parts' models with what fades where their points do not support them; None where they do everywhere."""
    sides = parts[0].places.sides_mm
    at = np.linspace(0.0, 1.0, SUPPORT)
    u, v = np.repeat(at, SUPPORT), np.tile(at, SUPPORT)
    where = np.stack([u, v], axis=1) * sides
    own = {key: own_share(part, sides, u, v) for key, part in {id(part.places): part for part in parts}.items()}
    share = np.stack([own[id(part.places)] for part in parts])
    bare = np.flatnonzero(np.min(share, axis=0) < 1.0)
    if not len(bare):
        return None
    values = pooled(parts, sides)
    process = fitted_process(values.at_mm, values.mean_mm, sides, values.step_mm)
    expected_mm = expectations(process, values.at_mm, values.values_mm, where[bare])
    variance_mm2 = Kriging(process, values.at_mm).variance_mm2(where[bare])
    own_mm2 = _own_variances_mm2(process, values, where[bare], variance_mm2)
    models = []
    for part, kept, mean in zip(parts, share[:, bare], expected_mm, strict=True):
        model = part.deterministic.grid_mm(at, at).ravel()
        model[bare] = kept * model[bare] + (1 - kept) * mean
        models.append(fit_grid((at, at), model.reshape(SUPPORT, SUPPORT), FINE))
    return tuple(models), _support(process, process.widening(sides[0] * sides[1]), share, bare, (own_mm2, variance_mm2))


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


def expectations(process: Process, at: Array, values_mm: Array, where: Array) -> Array:
    """Returns what kriging expects of every part at places (m, …), (parts, m), from its values (parts, n), else nan.

    Where a part has no value, the mean of the others stands, with what its own values differ from it.
    """
    whole, there = Kriging(process, at), np.isfinite(values_mm)
    if np.all(there):
        return whole.expected_mm(values_mm.T, where).T
    mean_mm = np.nanmean(values_mm, axis=0)
    mean = whole.expected_mm(mean_mm[:, None], np.concatenate([where, at]))[:, 0]
    beside, at_points = mean[: len(where)], mean[len(where) :]
    return np.stack(
        [
            beside + Kriging(process, at[has]).expected_mm((some - at_points)[has, None], where)[:, 0]
            for some, has in zip(values_mm, there, strict=True)
        ]
    )


def _own_variances_mm2(process: Process, values: Pooled, where: Array, variance_mm2: Array) -> Array:
    """Returns the variance at places by every part's own points, (parts, m); `variance_mm2` is that by all points."""
    there = np.isfinite(values.values_mm)
    if np.all(there):
        return np.tile(variance_mm2, (len(there), 1))
    return np.stack([Kriging(process, values.at_mm[has]).variance_mm2(where) for has in there])


def _support(
    process: Process, widening: float, share: Array, bare: np.ndarray, variances_mm2: tuple[Array, Array]
) -> Support:
    own_mm2, variance_mm2 = variances_mm2
    yardstick, best = process.waves_mm2 + process.noise_mm2, np.max(share[:, bare], axis=0)
    known, deviation, parts = (
        np.ones(share.shape[1]),
        np.zeros(share.shape[1]),
        np.full(share.shape[1], len(share) * 1.0),
    )
    known[bare] = np.maximum(np.clip(1 - variance_mm2 / yardstick, 0.0, 1.0), best)
    deviation[bare] = widening * np.sqrt((1 - best) * variance_mm2)
    backing = np.maximum(1 - np.clip(own_mm2 / yardstick, 0.0, 1.0), share[:, bare])
    most = np.max(backing, axis=0)
    parts[bare] = np.where(most > 0, np.sum(backing, axis=0) / np.where(most > 0, most, 1.0), len(share))
    square = (SUPPORT, SUPPORT)
    return Support(process, known.reshape(square), deviation.reshape(square), parts.reshape(square))


def own_share(part: Separation, sides: Sides, u: Array, v: Array) -> Array:
    """How much a part's own spline is taken on a square of places, at shares u and v of the sides: 1 within about a
    step of its points, as long as these determine it there; less beyond either.
    """
    from scipy.ndimage import gaussian_filter  # slow to import
    from scipy.spatial import KDTree

    tree, at = KDTree(_flat(part.places, sides)), np.stack([u, v], axis=1)
    distance = np.asarray(tree.query(at * sides)[0])
    near = _fading(distance / _reach_mm(part.places, sides, tree), 1.0, BLENDED)
    if np.any(near < 1.0):  # between two nearest points the distance has creases
        near = np.clip(gaussian_filter(near.reshape(SUPPORT, SUPPORT), CREASES, mode="nearest"), 0.0, 1.0).ravel()
    return near * _fading(_leverage(part.places, part.chosen.size, at), *DETERMINED)


def _fading(values: Array, full: float, none: float) -> Array:
    """1 up to `full`, 0 from `none`, in between with two continuous derivatives."""
    past = np.clip((values - full) / (none - full), 0.0, 1.0)
    return np.asarray(1 - past**3 * (10 - 15 * past + 6 * past**2))


def _leverage(places: Places, size: Size, at: Array) -> Array:
    """Variance of a part's spline at parameters (m, 2), over that of one of its points."""
    if places.rows is not None and places.columns is not None:
        lines = enumerate((places.rows, places.columns))
        along, across = (_of_lines(basis(size, axis, at[:, axis]), basis(size, axis, where)) for axis, where in lines)
        return along * across
    spread, turn = np.linalg.eigh(splines(places, size).normal())
    turn = turn / np.sqrt(np.maximum(spread, SMOOTHING * np.mean(spread)))
    return splines(Places(np.empty((0, 3)), at[:, 0], at[:, 1]), size).squares(for_kernel(turn @ turn.T))


def _of_lines(wanted: Array, measured: Array) -> Array:
    return np.asarray(np.einsum("ai,ij,aj->a", wanted, np.linalg.inv(measured.T @ measured), wanted))


def _reach_mm(places: Places, sides: Sides, tree: "KDTree") -> float:
    """How far places may be from a part's points that these support: the middle of a mesh is."""
    if places.rows is not None and places.columns is not None:
        step_u, step_v = (float(np.median(np.abs(np.diff(lines)))) for lines in (places.rows, places.columns))
        return 0.51 * float(np.hypot(step_u * sides[0], step_v * sides[1]))
    points = _flat(places, sides)
    distance, _ = tree.query(points[:: max(1, len(points) // SOME)], k=[5])
    return NEAR * float(np.median(distance))


def _flat(places: Places, sides: Sides) -> Array:
    return np.stack([places.u * sides[0], places.v * sides[1]], axis=1)


CELLS: Final = 900


def pooled(parts: Sequence[Separation], sides_mm: tuple[float, float], most: float = CELLS) -> Pooled:
    """Values of parts in cells as wide as the points are apart, `most` on the whole patch.

    A part's value is its spline at the cell's place with the mean of what it leaves in the cell: the pattern's slope
    between a point and the cell's place is then no noise. The place is the mean over all parts' points: where a part's
    own points do not determine its spline there, it has no value, because a spline beyond its points is arbitrary.
    """
    step = max(float(np.sqrt(sides_mm[0] * sides_mm[1] / most)), min(_apart_mm(part, sides_mm) for part in parts))
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
        has = (count > 0) & (_leverage(part.places, part.chosen.size, np.stack([u, v], axis=1)) <= DETERMINED[0])
        left = _sums(cell, part.random_mm, filled)[has] / count[has]
        own[has] = part.deterministic.value_mm(u[has], v[has]) + left
    some = np.any(np.isfinite(values), axis=0)
    return Pooled(np.stack([u * sides_mm[0], v * sides_mm[1]], axis=1)[some], values[:, some], step)


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
