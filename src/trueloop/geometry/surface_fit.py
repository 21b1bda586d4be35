"""A surface through or near a grid of points."""

from dataclasses import dataclass

import numpy as np

from trueloop._core import fit_surface_grid
from trueloop.arrays import Array, for_kernel
from trueloop.errors import Code
from trueloop.geometry.surface import Surface, clamped_knots


@dataclass(frozen=True, eq=False)
class GridFit:
    """A fitted surface on [0, 1] × [0, 1], the parameters of the grid's rows and columns, and the distance of the
    farthest grid point from its place on the surface.
    """

    surface: Surface
    u: Array
    v: Array
    worst_mm: float


def fit_grid(points_mm: Array, controls: tuple[int, int] | None = None, degree: int = 3) -> GridFit:
    """The least-squares surface for a grid of points (n, m, 3), by parameters from averaged chord lengths.

    Without a number of control points it goes through every point. Raises SRF-GRID for a grid too small, with holes
    (nan) or with coincident neighbours.
    """
    points = np.asarray(points_mm, float)
    _check(points, degree)
    u, v = chord_parameters(points), chord_parameters(points.swapaxes(0, 1))
    count = points.shape[:2] if controls is None else controls
    surface = fit_parameterised(points, (u, v), (_knots(u, count[0], degree), _knots(v, count[1], degree)), degree)
    off = np.linalg.norm(surface.grid_mm(u, v) - points, axis=2)
    return GridFit(surface, u, v, float(np.max(off)))


def fit_parameterised(points_mm: Array, at: tuple[Array, Array], knots: tuple[Array, Array], degree: int) -> Surface:
    """The least-squares surface when the parameters of rows and columns, in [0, 1], and the knots are known."""
    inner = tuple(for_kernel(k[degree + 1 : -degree - 1]) for k in knots)
    try:
        columns = [
            fit_surface_grid((inner[0], inner[1]), (degree, degree), at, for_kernel(points_mm[..., k]))
            for k in range(3)
        ]
    except ValueError as refused:
        raise Code.SRF_GRID.refusal(
            f"a grid of {points_mm.shape[0]} × {points_mm.shape[1]} points cannot be fitted: {refused}",
            hint="ask for fewer control points, or give a denser grid",
        ) from None
    return Surface((degree, degree), knots[0], knots[1], np.stack(columns, axis=2))


def chord_parameters(points_mm: Array) -> Array:
    """Parameters in [0, 1] of the rows of a grid: chord lengths between rows, averaged over columns."""
    steps = np.linalg.norm(np.diff(points_mm, axis=0), axis=2)
    along = np.cumsum(steps, axis=0) / np.sum(steps, axis=0)
    return np.concatenate([[0.0], np.mean(along, axis=1)])


def _knots(at: Array, count: int, degree: int) -> Array:
    """Clamped knots that follow the density of the parameters, so that every control point has its share of them."""
    if not degree < count <= len(at):
        raise Code.SRF_GRID.refusal(
            f"{count} control points of degree {degree} for {len(at)} rows: {degree + 1} to {len(at)} are possible",
            hint="ask for fewer control points, or give a denser grid",
        )
    if count == len(at):  # averages of parameters, which make interpolation well posed
        inner = np.array([np.mean(at[k + 1 : k + 1 + degree]) for k in range(count - degree - 1)])
    else:
        even = clamped_knots(count, degree)[degree + 1 : -degree - 1]
        inner = np.interp(even, np.linspace(0.0, 1.0, len(at)), at)
    return np.concatenate([np.zeros(degree + 1), inner, np.ones(degree + 1)])


def _check(points: Array, degree: int) -> None:
    hint = "give a complete grid, row by row, of at least four by four points"
    if points.ndim != 3 or points.shape[2] != 3 or min(points.shape[:2]) <= degree:
        raise Code.SRF_GRID.refusal(f"a grid of {points.shape} values is too small for degree {degree}", hint=hint)
    if np.any(bad := ~np.all(np.isfinite(points), axis=2)):
        row, column = np.argwhere(bad)[0]
        raise Code.SRF_GRID.refusal(
            f"the grid has {np.count_nonzero(bad)} holes, the first in row {row + 1}, column {column + 1}", hint=hint
        )
    for axis in (0, 1):
        steps = np.linalg.norm(np.diff(points, axis=axis), axis=2)
        if np.any(same := steps <= 0):
            row, column = np.argwhere(same)[0]
            raise Code.SRF_GRID.refusal(
                f"grid point in row {row + 1}, column {column + 1} coincides with the next one", hint=hint
            )
