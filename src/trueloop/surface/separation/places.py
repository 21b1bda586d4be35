"""Where deviations of a surface are known, and what a spline of some size can follow there."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache, partial
from typing import Final

import numpy as np

from trueloop._core import ScatteredSplines
from trueloop.arrays import Array, for_kernel
from trueloop.errors import Code
from trueloop.geometry.surface import Surface, clamped_knots
from trueloop.surface.deviations.deviations import SurfaceDeviations
from trueloop.surface.separation.spline_surface import (
    GridProjector,
    Projector,
    ScatteredProjector,
    Size,
    SplineSurface,
    basis,
    fit_grid,
)

REGULAR: Final = 0.1
"""Points belong to a grid's rows when they stray from them by less than this share of the rows' distance."""
WIDEST: Final = 2.5
"""Rows farther apart than so many of their usual steps leave a gap: such a grid is not a full one."""
SMOOTHING: Final = 1e-6
"""Weight of roughness, for scattered points and grids with holes: it decides only where the points do not."""


@dataclass(frozen=True, eq=False)
class Places:
    """Nominal points (n, 3) and their parameters in [0, 1]; `rows` and `columns` are the grid's parameters where the
    points fill a grid, row by row.
    """

    points_mm: Array
    u: Array
    v: Array
    rows: Array | None = None
    columns: Array | None = None

    @cached_property
    def sides_mm(self) -> tuple[float, float]:
        """About how long the patch is along u and along v."""
        spread = self.points_mm - np.mean(self.points_mm, axis=0)
        design = np.stack([self.u, self.v], axis=1) - [np.mean(self.u), np.mean(self.v)]
        along = np.linalg.lstsq(design, spread, rcond=None)[0]
        return float(np.linalg.norm(along[0])), float(np.linalg.norm(along[1]))


def places_of(surface: Surface, deviations: SurfaceDeviations) -> tuple[Places, Array]:
    """Places and errors of one part. A grid without holes whose points keep to its rows and columns stays a grid."""
    (u0, u1), (v0, v1) = surface.domain
    u, v = (deviations.u - u0) / (u1 - u0), (deviations.v - v0) / (v1 - v0)
    there = deviations.measured
    rows = columns = None
    if deviations.shape is not None and np.all(there):
        rows, columns = _lines(u.reshape(deviations.shape)), _lines(v.reshape(deviations.shape).T)
    if rows is None or columns is None:
        return Places(deviations.nominal_mm[there], u[there], v[there]), deviations.error_mm[there]
    return Places(deviations.nominal_mm, u, v, rows, columns), deviations.error_mm


def same_places(places: Sequence[Places]) -> list[Places]:
    """The places with those of equal grids made one: a part's touches stray by micrometres from the next part's."""
    kept: list[Places] = []
    shared = []
    for place in places:
        known = next((k for k in kept if _alike(k, place)), None)
        if known is None:
            kept.append(place)
        shared.append(known or place)
    return shared


def _alike(a: Places, b: Places) -> bool:
    if a.rows is None or b.rows is None or a.columns is None or b.columns is None:
        return a.rows is b.rows and _alike_scattered(a, b)
    if len(a.rows) != len(b.rows) or len(a.columns) != len(b.columns):
        return False
    pairs = ((a.rows, b.rows), (a.columns, b.columns))
    return all(float(np.max(np.abs(x - y))) < REGULAR * float(np.min(np.abs(np.diff(x)))) for x, y in pairs)


def _alike_scattered(a: Places, b: Places) -> bool:
    """Scattered points, or grids with the same holes: each as near to its like as points of a grid of so many."""
    if len(a.u) != len(b.u):
        return False
    step = 1 / np.sqrt(len(a.u))
    return bool(max(np.max(np.abs(a.u - b.u)), np.max(np.abs(a.v - b.v))) < REGULAR * step)


@lru_cache(maxsize=256)
def projector(places: Places, size: Size) -> Projector:
    """The span of splines of that size at these places."""
    if places.rows is not None and places.columns is not None:
        along, lengths, _ = np.linalg.svd(basis(size, 0, places.rows), full_matrices=False)
        across, widths, _ = np.linalg.svd(basis(size, 1, places.columns), full_matrices=False)
        return GridProjector(along, across, np.outer(lengths**2, widths**2).ravel())
    spread, turn = np.linalg.eigh(splines(places, size).normal())
    kept = spread > SMOOTHING * np.mean(spread)
    # The points are not held with every size tried: a million of them, sixty times over, would not fit.
    return ScatteredProjector(partial(splines, places, size), turn[:, kept] / np.sqrt(spread[kept]), spread[kept])


def regress(places: Places, values_mm: Array, size: Size) -> SplineSurface:
    """The least-squares spline of that size.

    On a grid it is exact; elsewhere a trace of smoothing, `SMOOTHING` times the squared second differences of the
    control values, fills what no point determines. Raises SRF-MODEL for more control points than the points determine.
    """
    if places.rows is not None and places.columns is not None:
        grid = values_mm.reshape(len(places.rows), len(places.columns))
        return fit_grid((places.rows, places.columns), grid, size)
    if size.controls > len(values_mm):
        raise Code.SRF_MODEL.refusal(
            f"{size.controls} control points for {len(values_mm)} measured points",
            hint="ask for fewer control points, or measure more points",
        )
    at, rough = splines(places, size), _roughness(size)
    normal, roughness = at.normal(), rough.T @ rough
    normal += SMOOTHING * np.trace(normal) / np.trace(roughness) * roughness
    found = np.linalg.solve(normal, at.sums(for_kernel(values_mm[:, None])))
    return SplineSurface(size, np.asarray(found.reshape(size.rows, size.columns)))


def splines(places: Places, size: Size) -> ScatteredSplines:
    """The splines of that size at the places, one by one."""
    inner = [clamped_knots(n, size.degree)[size.degree + 1 : -size.degree - 1] for n in (size.rows, size.columns)]
    knots = for_kernel(inner[0]), for_kernel(inner[1])
    return ScatteredSplines(knots, (size.degree, size.degree), (for_kernel(places.u), for_kernel(places.v)))


def _lines(parameters: Array) -> Array | None:
    """The parameter of each row of a grid, where its points keep to it and no row is missing; else None."""
    lines = np.clip(np.mean(parameters, axis=1), 0.0, 1.0)
    steps = np.diff(lines)
    stray = np.max(np.abs(parameters - lines[:, None]))
    if len(lines) < 2 or stray >= REGULAR * np.min(np.abs(steps)):
        return None
    gaps = np.diff(np.concatenate([[0.0], np.sort(lines), [1.0]]))
    return lines if np.max(gaps) < WIDEST * np.median(np.abs(steps)) else None


def _roughness(size: Size) -> Array:
    """Second differences of the control values along both directions."""
    along = np.kron(np.diff(np.eye(size.rows), 2, axis=0), np.eye(size.columns))
    across = np.kron(np.eye(size.rows), np.diff(np.eye(size.columns), 2, axis=0))
    return np.concatenate([along, across])


DEGREES: Final = (2, 3)
"""Degree 2 is the least that keeps second derivatives finite where pieces meet [MPM §5]."""
FULLEST: Final = 0.8
"""Most control points a direction, as a share of the rows measured: along both, 64 % of the places' freedom is then
followed, and the other third is what the tests judge by.
"""
SEEN: Final = 900
"""So many control points are tried in any case, and twice those of the best before the search ends: 30 × 30 are more
than 25 × 25 places can have, so that only scans are searched in part.
"""


def sizes(places: Places, degrees: Sequence[int] = DEGREES) -> Iterator[Size]:
    """Sizes by growing number of control points, spaced alike along both sides; at each, degrees in ascending order."""
    length = places.sides_mm
    if places.rows is not None and places.columns is not None:
        most = (int(FULLEST * len(places.rows)), int(FULLEST * len(places.columns)))
    else:
        most_in_all = FULLEST**2 * len(places.u)
        ratio = np.sqrt(length[0] / length[1])
        most = (int(np.sqrt(most_in_all) * ratio), int(np.sqrt(most_in_all) / ratio))
    shorter = min(length)
    least = min(degrees) + 1
    for count in range(least, max(most) + 1):
        rows, columns = (
            min(max(least, round(count * side / shorter)), top) for side, top in zip(length, most, strict=True)
        )
        for degree in degrees:
            if min(rows, columns) > degree:
                yield Size(rows, columns, degree)
        if (rows, columns) == most:
            return


def thinner(size: Size) -> list[Size]:
    """Sizes with one control point fewer along one direction."""
    fewer = (replace(size, rows=size.rows - 1), replace(size, columns=size.columns - 1))
    return [size for size in fewer if min(size.rows, size.columns) > size.degree]


def most_likely(candidates: Sequence[Size], likely: Callable[[Size], float]) -> Size:
    """The likeliest of the candidates, in order; then with more or fewer control points along one direction alone."""
    best, most = candidates[0], candidates[-1]
    for size in candidates:
        if size.controls > max(SEEN, 2 * best.controls):
            break
        best = max(best, size, key=likely)

    def around(size: Size) -> list[Size]:
        either = [*thinner(size), replace(size, rows=size.rows + 1), replace(size, columns=size.columns + 1)]
        return [near for near in either if near.rows <= most.rows and near.columns <= most.columns]

    return climbed(best, likely, around, lambda _: True)


def climbed(
    best: Size,
    likely: Callable[[Size], float],
    neighbours: Callable[[Size], list[Size]],
    allowed: Callable[[Size], bool],
) -> Size:
    """From neighbour to allowed neighbour as long as that is more likely."""
    while True:
        better = [size for size in neighbours(best) if likely(size) > likely(best) and allowed(size)]
        if not better:
            return best
        best = max(better, key=likely)
