"""One error term: a sum of parts with adjustable parameters, as [4773] Eq. 3 and what generalises it.

    E(q, T) = Σ over parts  s(T) · f(q),   s = 1, or a signal minus its reference value

f is a function of the axis' position (`PositionBasis`). A signal is a temperature, the spindle speed, or one of them
after a first-order lag (`signals.py`). Eq. 3, δz(z) = A + B·T12 + C·z + D·z², is a quadratic part without signal and a
constant part with signal T12. Own parameters for forward and return travel model backlash.

Functions of one axis' position: splines over segments that join smoothly, polynomials and tables among them.

Segments of degree d join with d − 1 continuous derivatives [4773 §2.4: overlapping segments smoothly joined]. One
segment is a polynomial; degree 1 is a table with linear interpolation, as controls hold; degree 0 on one segment is a
constant. Coefficients are those of B-splines, so they have the unit of the error and the size of its values.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from trueloop.arrays import Array
from trueloop.errors import Code
from trueloop.machine.model.chain import ErrorName


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
            raise Code.MCH_BASIS.refusal(
                f"segments ending at {list(self.breaks)} with degree {self.degree} make no function of position",
                hint="two ends at least, ascending, degree 0 to 5",
            )
        if self.degree == 0 and len(self.breaks) > 2:
            raise Code.MCH_BASIS.refusal(
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


def segments(low: float, high: float, count: int, degree: int, zero_at: tuple[float, ...] = ()) -> PositionBasis:
    """Returns a basis of `count` equal segments over the travel. Raises MCH-BASIS for a travel without end."""
    if not np.isfinite([low, high]).all():
        raise Code.MCH_BASIS.refusal(
            f"{count} equal segments over a travel from {low:g} to {high:g} have no ends",
            hint="give every axis of a term that varies along it its travel: [axes.X] with travel_mm or travel_deg",
        )
    return PositionBasis(tuple(float(p) for p in np.linspace(low, high, count + 1)), degree, zero_at)


Signals = Mapping[str, Array | float]
"""Values by signal name, () or (n,): °C, rev/min, or what the sensor gives."""


def means(signals: Signals) -> dict[str, float]:
    """Returns one value a signal: its mean, where it has several."""
    return {name: float(np.mean(value)) for name, value in signals.items()}


@dataclass(frozen=True)
class Part:
    """`basis` times (signal − reference), or `basis` alone."""

    basis: PositionBasis = CONSTANT
    signal: str | None = None
    reference: float = 0.0

    def factor(self, signals: Signals) -> Array | float:
        """Returns the factor of the functions of position. Raises MCH-SIGNAL when the signal is not given."""
        if self.signal is None:
            return 1.0
        if self.signal not in signals:
            raise Code.MCH_SIGNAL.refusal(
                f"the model needs the signal {self.signal!r}; given are {len(signals)}: {', '.join(signals) or 'none'}",
                hint="give its value, in the unit it had in the data that the model was made from",
                values={"signals": [self.signal]},
            )
        return signals[self.signal] - self.reference


@dataclass(frozen=True)
class Term:
    """The form of one axis error. `both_ways` gives forward and return travel parameters of their own."""

    name: ErrorName
    parts: tuple[Part, ...] = (Part(),)
    both_ways: bool = False

    @property
    def size(self) -> int:
        """Returns the number of coefficients: forward's, then return's where they differ."""
        return sum(part.basis.size for part in self.parts) * (2 if self.both_ways else 1)

    def design(self, position: Array, travel: Array, signals: Signals) -> Array:
        """Values of every function, (n, size). `travel` is +1 forward, −1 return, 0 unknown: the mean of both."""
        one_way = np.hstack([part.basis.design(position) * _column(part.factor(signals)) for part in self.parts])
        if not self.both_ways:
            return one_way
        return np.hstack([one_way * _column(0.5 * (1 + travel)), one_way * _column(0.5 * (1 - travel))])

    def admissible(self) -> Array:
        """Columns (size, free) that span the coefficients allowed by the parts' zeros."""
        from scipy.linalg import block_diag

        blocks = [part.basis.admissible() for part in self.parts] * (2 if self.both_ways else 1)
        if self.both_ways:
            blocks[len(self.parts) :] = [np.eye(part.basis.size) for part in self.parts]
        return block_diag(*blocks)

    def values(self, coefficients: Array, position: Array, travel: Array, signals: Signals) -> Array:
        """Returns the error, (n,), mm or rad."""
        return self.design(position, travel, signals) @ coefficients

    def needs(self) -> tuple[str, ...]:
        """Signals without which it cannot be evaluated."""
        return tuple(dict.fromkeys(part.signal for part in self.parts if part.signal is not None))


def _column(values: Array | float) -> Array:
    return np.asarray(values, dtype=np.float64).reshape(-1, 1)
