"""A spline over the parameters of a surface: deviation as a function of place, on [0, 1] × [0, 1]."""

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from trueloop._core import ScatteredSplines, fit_surface_grid
from trueloop.arrays import Array, for_kernel
from trueloop.errors import Code
from trueloop.geometry.surface import basis_matrix, basis_rows, clamped_knots


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
