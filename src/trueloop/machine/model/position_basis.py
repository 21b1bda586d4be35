"""Functions of one axis' position: splines over segments that join smoothly, polynomials and tables among them.

Segments of degree d join with d − 1 continuous derivatives [4773 §2.4: overlapping segments smoothly joined]. One
segment is a polynomial; degree 1 is a table with linear interpolation, as controls hold; degree 0 on one segment is a
constant. Coefficients are those of B-splines, so they have the unit of the error and the size of its values.
"""

from dataclasses import dataclass

import numpy as np

from trueloop.arrays import Array
from trueloop.errors import Code, TrueloopError


@dataclass(frozen=True)
class PositionBasis:
    """`breaks` are the ends of the segments, ascending, in mm or rad. At positions `zero_at` every function vanishes.

    That takes away the shares of other errors: the constant of a positioning error (zero at the datum), and the
    straight line of a straightness error (zero at both ends of travel), which belongs to squareness.
    """

    breaks: tuple[float, ...]
    degree: int
    zero_at: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        ascending = len(self.breaks) > 1 and bool(np.all(np.diff(self.breaks) > 0))
        if not ascending or not np.all(np.isfinite(self.breaks)) or not 0 <= self.degree <= 5:
            raise TrueloopError(
                Code.MCH_BASIS,
                f"segments ending at {list(self.breaks)} with degree {self.degree} make no function of position",
                hint="two ends at least, ascending, degree 0 to 5",
            )
        if self.degree == 0 and len(self.breaks) > 2:
            raise TrueloopError(
                Code.MCH_BASIS,
                f"{len(self.breaks) - 1} segments of degree 0 would jump between them",
                hint="degree 1 joins segments; a constant has one segment",
            )

    @property
    def size(self) -> int:
        """Returns the number of coefficients."""
        return len(self.breaks) - 1 + self.degree

    @property
    def knots(self) -> Array:
        """Breaks with the ends repeated."""
        ends = [self.breaks[0]] * self.degree, [self.breaks[-1]] * self.degree
        return np.array([*ends[0], *self.breaks, *ends[1]])

    def design(self, position: Array) -> Array:
        """Values of the functions, (n, size). Beyond the breaks the value at the break holds."""
        from scipy.interpolate import BSpline

        inside = np.clip(position, self.breaks[0], self.breaks[-1])
        rows: Array = BSpline.design_matrix(inside, self.knots, self.degree).toarray()
        return rows

    def admissible(self) -> Array:
        """Returns orthonormal columns (size, free) that span the coefficients with a zero at each of `zero_at`."""
        if not self.zero_at:
            return np.eye(self.size)
        conditions = self.design(np.array(self.zero_at))
        whole = np.linalg.qr(conditions.T, mode="complete")[0]
        return whole[:, len(self.zero_at) :]


CONSTANT = PositionBasis((0.0, 1.0), 0)
"""The basis of values equal everywhere: errors of place, offsets, drift."""


def polynomial(low: float, high: float, degree: int, zero_at: tuple[float, ...] = ()) -> PositionBasis:
    """Returns a basis of one segment over the travel."""
    return PositionBasis((low, high), degree, zero_at)


def segments(low: float, high: float, count: int, degree: int, zero_at: tuple[float, ...] = ()) -> PositionBasis:
    """Returns a basis of `count` equal segments over the travel. Raises MCH-BASIS for a travel without end."""
    if not np.isfinite([low, high]).all():
        raise TrueloopError(
            Code.MCH_BASIS,
            f"{count} equal segments over a travel from {low:g} to {high:g} have no ends",
            hint="give every axis of a term that varies along it its travel: [axes.X] with travel_mm or travel_deg",
        )
    return PositionBasis(tuple(float(p) for p in np.linspace(low, high, count + 1)), degree, zero_at)


def table(positions: Array) -> PositionBasis:
    """Returns a basis of linear interpolation between positions: the coefficients are the table's values."""
    return PositionBasis(tuple(float(p) for p in positions), 1)
