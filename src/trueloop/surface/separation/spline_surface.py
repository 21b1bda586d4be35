"""A spline over the parameters of a surface: deviation as a function of place, on [0, 1] × [0, 1].

Where deviations of a surface are known, and what a spline of some size can follow there.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache, partial
from typing import Final

import numpy as np

from trueloop._core import ScatteredSplines, fit_surface_grid
from trueloop.arrays import Array, for_kernel
from trueloop.errors import Code
from trueloop.geometry.surface import Surface, basis_matrix, basis_rows, clamped_knots
from trueloop.surface.deviations.deviations import SurfaceDeviations


class Projector(ABC):
    """The columns Q (n, rank); `spread` (rank,) are the variances along them."""

    spread: Array

    @property
    def rank(self) -> int:
        """How many columns there are."""
        return len(self.spread)

    @property
    def columns(self) -> Array:
        """All columns as one matrix: for as many places as fit."""
        return self.combined(np.eye(self.rank))

    @abstractmethod
    def coordinates(self, values: Array) -> Array:
        """Returns the projection of values (n, k) on the columns: Qᵀ V, (rank, k)."""

    @abstractmethod
    def combined(self, factors: Array) -> Array:
        """Q F for factors (rank, k)."""

    @property
    @abstractmethod
    def leverages(self) -> Array:
        """How much each value determines its own projection, 0 to 1."""

    def residuals(self, values: Array) -> Array:
        """Values (n,) or (n, k) less their projection: what least squares leaves."""
        columns = values.reshape(len(values), -1)
        return np.asarray((columns - self.combined(self.coordinates(columns))).reshape(values.shape))


@dataclass(frozen=True, eq=False)
class GridProjector(Projector):
    """On a grid Q = along ⊗ across."""

    along: Array
    across: Array
    spread: Array

    def coordinates(self, values: Array) -> Array:
        """Qᵀ V."""
        grids = values.reshape(len(self.along), len(self.across), -1)
        inside = np.einsum("ai,abk,bj->ijk", self.along, grids, self.across, optimize=True)
        return np.asarray(inside.reshape(self.rank, -1))

    def combined(self, factors: Array) -> Array:
        """Q F."""
        inside = factors.reshape(self.along.shape[1], self.across.shape[1], -1)
        grids = np.einsum("ai,ijk,bj->abk", self.along, inside, self.across, optimize=True)
        return np.asarray(grids.reshape(len(self.along) * len(self.across), -1))

    @cached_property
    def leverages(self) -> Array:
        """Squared lengths of Q's rows."""
        return np.outer(np.sum(self.along**2, axis=1), np.sum(self.across**2, axis=1)).ravel()


@dataclass(frozen=True, eq=False)
class ScatteredProjector(Projector):
    """Elsewhere Q = A T: A the design matrix of splines, T (controls, rank) what makes its columns orthonormal."""

    splines: Callable[[], ScatteredSplines]
    turn: Array
    spread: Array

    def coordinates(self, values: Array) -> Array:
        """Qᵀ V."""
        return np.asarray(self.turn.T @ self.splines().sums(for_kernel(values)))

    def combined(self, factors: Array) -> Array:
        """Q F."""
        return self.splines().combined(for_kernel(self.turn @ factors))

    @cached_property
    def leverages(self) -> Array:
        """Squared lengths of Q's rows."""
        return self.splines().squares(for_kernel(self.turn @ self.turn.T))


@dataclass(frozen=True)
class Size:
    """How much a spline surface can follow: control points along u and v, and the degree in both directions."""

    rows: int
    columns: int
    degree: int = 3

    @property
    def controls(self) -> int:
        """Number of control points."""
        return self.rows * self.columns

    def __str__(self) -> str:
        return f"{self.rows} × {self.columns}, degree {self.degree}"


@dataclass(frozen=True, eq=False)
class SplineSurface:
    """Deviations in mm by control values (rows, columns) on evenly spaced clamped knots."""

    size: Size
    coefficients_mm: Array

    def value_mm(self, u: Array, v: Array) -> Array:
        """Values at pairs of parameters in [0, 1]."""
        a = basis_rows(clamped_knots(self.size.rows, self.size.degree), self.size.degree, np.asarray(u, float))
        b = basis_rows(clamped_knots(self.size.columns, self.size.degree), self.size.degree, np.asarray(v, float))
        reach = np.arange(self.size.degree + 1)
        near = self.coefficients_mm[(a.first[:, None] + reach)[:, :, None], (b.first[:, None] + reach)[:, None, :]]
        left, right = (a.values, a.slopes)[0], (b.values, b.slopes)[0]
        return np.asarray(np.einsum("ni,nij,nj->n", left, near, right))

    def grid_mm(self, u: Array, v: Array) -> Array:
        """Values at every u with every v."""
        return np.asarray(basis(self.size, 0, u) @ self.coefficients_mm @ basis(self.size, 1, v).T)


def basis(size: Size, axis: int, at: Array) -> Array:
    """The basis of one direction (0: u, 1: v) as a matrix."""
    count = (size.rows, size.columns)[axis]
    return basis_matrix(clamped_knots(count, size.degree), size.degree, np.asarray(at, float))


def fit_grid(at: tuple[Array, Array], values_mm: Array, size: Size) -> SplineSurface:
    """The least-squares spline for values on a full grid of parameters in [0, 1].

    Raises SRF-MODEL when the grid does not determine so many control points.
    """
    inner = [
        for_kernel(clamped_knots(count, size.degree)[size.degree + 1 : -size.degree - 1])
        for count in (size.rows, size.columns)
    ]
    places = for_kernel(at[0]), for_kernel(at[1])
    try:
        found = fit_surface_grid((inner[0], inner[1]), (size.degree, size.degree), places, for_kernel(values_mm))
    except ValueError as refused:
        raise Code.SRF_MODEL.refusal(
            f"{size} control points cannot be fitted to {values_mm.shape[0]} × {values_mm.shape[1]} points: {refused}",
            hint="ask for fewer control points, or measure more densely",
        ) from None
    return SplineSurface(size, found)


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
