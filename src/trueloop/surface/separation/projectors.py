"""What a spline of some size can follow at given places: a span of values, by orthonormal columns.

The columns are the principal directions of the values that independent control values give; they need not be formed.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from trueloop._core import ScatteredSplines
from trueloop.arrays import Array, for_kernel


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
        """What the columns hold of values (n, k): Qᵀ V, (rank, k)."""

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
