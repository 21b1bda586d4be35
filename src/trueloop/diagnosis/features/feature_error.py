"""Errors of features by name: what a diagnosis reasons about.

The form of one feature from its points: a straight line, a cubic where points allow, waves around the turn.

    e(t, θ) = Σ cₖ Pₖ(t) + Σ (aₙ cos nθ + bₙ sin nθ)

with Legendre polynomials Pₖ of t, −1 and 1 at the ends of what was measured, and n = 1, 3 waves a turn.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Final

import numpy as np
from numpy.polynomial import legendre
from scipy.optimize import brentq

from trueloop.arrays import Array, Integers, by_content
from trueloop.geometry.feature import Feature


@dataclass(frozen=True)
class FeaturePlace:
    """Where a feature is: `kind` "shaft", "face", "cone" or "arc"; x as a radius and z in the part's frame, mm.

    `z_mm` and `radius_mm` are ranges, low to high. `tool` is the name of the tool that finished it. `shape` is its line
    or arc, by which measured values are matched with it; None: they say themselves which feature they are of.
    """

    name: str
    kind: str
    radius_mm: tuple[float, float]
    z_mm: tuple[float, float]
    tool: str = ""
    shape: Feature | None = None


class ErrorKind(StrEnum):
    """Feature errors [4773 §4.2 a–f]; roundness, one wave a turn and three waves, is our own."""

    RADIUS = "radius"  # a: mean error along the normal of a shaft, near the chuck
    LENGTH = "length"  # b: error of the farther face less that of the nearer one, along z
    SHAFT_TAPER = "taper of a shaft"  # c: error at the free end less that near the chuck
    FACE_TAPER = "taper of a face"  # d: error at the largest radius less that at the smallest
    EDGE = "edge"  # e: no touch sees it
    STRAIGHTNESS = "straightness"  # f: peak to valley of what is smooth, line taken out
    WAVINESS = "waviness"  # f: root mean square of what is neither smooth nor noise of the device
    ECCENTRICITY = "eccentricity"  # amplitude of one wave a turn
    LOBING = "lobing"  # amplitude of three waves a turn


@dataclass(frozen=True)
class FeatureError:
    """One error of one feature: `value_mm` with its standard uncertainty and degrees of freedom (None: known).

    Radius, length and tapers are signed, positive where material is left on; the others are sizes. `other` is the
    nearer face of a length. `points` were used. `more` holds further numbers by names that end with their unit.
    """

    feature: str
    kind: ErrorKind
    value_mm: float
    standard_u_mm: float
    points: int
    degrees_of_freedom: int | None = None
    other: str = ""
    more: Mapping[str, float] = field(default_factory=dict)


@by_content
@dataclass(frozen=True)
class SeenPoints:
    """n points of one part: `feature` their names, `nominal_mm` (n, 2) x as a radius and z in the part's frame.

    `normal` (n, 2) is outward, (x, z). `error_mm` (n,) is along it, positive where material is left on, with standard
    uncertainties `standard_u_mm` (n,). `spindle_rad` (n,) is the angle of the part about its axis, NaN where it is not
    known. `repeat` (n,) counts readings of one point, from 1.
    """

    feature: tuple[str, ...]
    nominal_mm: Array
    normal: Array
    error_mm: Array
    standard_u_mm: Array
    spindle_rad: Array
    repeat: Integers

    def of(self, feature: str) -> "SeenPoints":
        """Those of one feature."""
        rows = np.array([name == feature for name in self.feature], dtype=bool)
        names = tuple(name for name in self.feature if name == feature)
        arrays = (self.nominal_mm, self.normal, self.error_mm, self.standard_u_mm, self.spindle_rad, self.repeat)
        return SeenPoints(names, *(values[rows] for values in arrays))


DECIMALS: Final = 6
"""Two nominal points (mm), or two angles (rad), that agree so far are one."""
EXACT_MM: Final = 1e-9
"""Standard uncertainty of a point that is stated to have none: a datum, which is zero by definition."""


@by_content
@dataclass(frozen=True)
class Averaged:
    """m points of one feature, as in SeenPoints, means of `readings`; `degrees_of_freedom` of their u, None: stated."""

    nominal_mm: Array
    normal: Array
    error_mm: Array
    standard_u_mm: Array
    spindle_rad: Array
    readings: int
    degrees_of_freedom: int | None


def averaged(points: SeenPoints) -> Averaged:
    """Means of the repeats, weighted by 1/u²; u of a mean of n is u/√n.

    Repeats that scatter by more than is stated, over all points of the feature together, enlarge every uncertainty by
    √(χ²/ν), which then has ν degrees of freedom. What all readings of a feature have in common (the radius of the ball,
    the offset of the probe) is not part of u, and is not averaged away by it: it is a cause to be found.
    """
    u = np.maximum(points.standard_u_mm, EXACT_MM)
    which, count = _same_point(points)
    weight = np.zeros((count, len(u)))
    weight[which, np.arange(len(u))] = u**-2.0
    total = weight.sum(axis=1)
    mean = weight @ points.error_mm / total
    first = np.array([int(np.flatnonzero(which == k)[0]) for k in range(count)], dtype=np.intp)
    spare = len(u) - count
    chi_squared = float(np.sum(((points.error_mm - mean[which]) / u) ** 2))
    excess = spare > 0 and chi_squared > spare
    return Averaged(
        nominal_mm=points.nominal_mm[first],
        normal=points.normal[first],
        error_mm=mean,
        standard_u_mm=np.sqrt((chi_squared / spare if excess else 1.0) / total),
        spindle_rad=points.spindle_rad[first],
        readings=len(u),
        degrees_of_freedom=spare if excess else None,
    )


def _same_point(points: SeenPoints) -> tuple[np.ndarray[tuple[int], np.dtype[np.intp]], int]:
    """Number of the point of every reading, from 0, and how many points there are."""
    angle = np.where(np.isnan(points.spindle_rad), -1.0, np.mod(points.spindle_rad, 2.0 * np.pi))
    places = np.round(np.column_stack([points.nominal_mm, angle]), DECIMALS)
    numbers: dict[tuple[float, ...], int] = {}
    which = np.array([numbers.setdefault(tuple(row), len(numbers)) for row in places.tolist()], dtype=np.intp)
    return which, len(numbers)


FEWEST_SPARE: Final = 2
"""Residuals that a scatter is taken from: one alone would be enlarged by anything from nothing to 1000 %."""


@by_content
@dataclass(frozen=True)
class Fitted:
    """Coefficients (k,) with their covariance (k, k), in units of the columns.

    `scatter_mm` is the standard deviation of points beyond what the device states, of `spare` residuals.
    `degrees_of_freedom` are those of the covariance; None: it is as known as the stated uncertainties.
    """

    coefficients: Array
    covariance: Array
    scatter_mm: float
    spare: int
    degrees_of_freedom: int | None

    def of(self, row: Array) -> tuple[float, float]:
        """Returns a linear combination of the coefficients, and its standard uncertainty."""
        return float(row @ self.coefficients), float(np.sqrt(row @ self.covariance @ row))


def fitted(columns: Array, error_mm: Array, u_mm: Array, scatter_mm: float | None = None) -> Fitted:
    """Least squares of columns (m, k) with weights 1/(u² + τ²).

    τ is `scatter_mm`, or is chosen so that Σ r²/(u² + τ²) equals the number of residuals to spare [Mandel, Paule 1970],
    and 0 where u alone explains them or fewer than `FEWEST_SPARE` are. Points are taken as independent. With τ above 0
    the covariance has as many degrees of freedom as residuals to spare.
    """
    spare = columns.shape[0] - columns.shape[1]
    tau = _scatter_mm(columns, error_mm, u_mm, spare) if scatter_mm is None else scatter_mm
    coefficients, covariance, _ = _weighted(columns, error_mm, np.hypot(u_mm, tau))
    return Fitted(coefficients, covariance, tau, spare, spare if tau > 0.0 else None)


def _scatter_mm(columns: Array, error_mm: Array, u_mm: Array, spare: int) -> float:
    if spare < FEWEST_SPARE:
        return 0.0

    def too_large(variance: float) -> float:
        return _weighted(columns, error_mm, np.sqrt(u_mm**2 + variance))[2] - spare

    if too_large(0.0) <= 0.0:
        return 0.0
    # weights that are all alike leave no less than these squares, so that the root lies below
    most = _weighted(columns, error_mm, np.ones_like(u_mm))[2] / spare
    return float(np.sqrt(brentq(too_large, 0.0, most, rtol=1e-9)))


def _weighted(columns: Array, error_mm: Array, u_mm: Array) -> tuple[Array, Array, float]:
    """Coefficients, their covariance and χ²."""
    inverse = np.linalg.pinv(columns / u_mm[:, None])
    coefficients = inverse @ (error_mm / u_mm)
    residual = (error_mm - columns @ coefficients) / u_mm
    return coefficients, inverse @ inverse.T, float(residual @ residual)


STRAIGHT: Final = ("shaft", "face", "cone")
"""Kinds of features that are straight in the plane (x, z)."""
SPAN: Final = 1.0 / 3.0
"""Points of a taper span this share of the feature: a shorter piece says more of its own than of the feature."""
SMOOTH_PLACES: Final = 6
"""Places for a cubic, as [4773 §4.2 f]: up to three waves along the feature, two points a wave."""
CUBIC: Final = 3
WAVES: Final = ((1, 5), (3, 7))
"""Waves a turn, and different angles for them: 2n + 1, and five for one, lest three lobes are taken for it."""
CONDITION: Final = 30.0
"""Above this, waves around the turn are left out: the angles follow the places, or lie on one side."""


@by_content
@dataclass(frozen=True)
class Form:
    """A feature's points with the least squares of their form.

    `along_mm` (m,) is z of shafts and cones, the radius of faces; `ends_mm` are those of what was measured, `whole_mm`
    of the feature. `waves` are the waves a turn that are in both fits, behind the polynomials. `line` has a polynomial
    of `degree` 1 at most, `smooth` the cubic, None where fewer than `SMOOTH_PLACES` are.
    """

    points: Averaged
    along_mm: Array
    ends_mm: tuple[float, float]
    whole_mm: tuple[float, float]
    degree: int
    waves: tuple[int, ...]
    line: Fitted
    smooth: Fitted | None

    @property
    def degrees_of_freedom(self) -> int | None:
        """Returns the degrees of freedom of all uncertainties; None: those of the stated uncertainty of the device."""
        return self.line_freedom if self.line_freedom is not None else self.points.degrees_of_freedom

    @property
    def line_freedom(self) -> int | None:
        """Those of a scatter that the residuals showed."""
        return (self.line if self.smooth is None else self.smooth).degrees_of_freedom

    def at(self, along_mm: float) -> Array:
        """The line's row of a place: what its coefficients are multiplied by."""
        row = np.zeros(len(self.line.coefficients))
        row[: self.degree + 1] = _polynomials(np.array([along_mm]), self.ends_mm, self.degree)[0]
        return row


def form_of(points: Averaged, place: FeaturePlace) -> Form:
    """The form that the points of one feature determine; a constant of one place, or of an arc."""
    along, whole = _along(points, place)
    ends = (float(along.min()), float(along.max()))
    places = len(np.unique(np.round(along, 6)))
    spread = ends[1] - ends[0] > SPAN * (whole[1] - whole[0])
    straight = place.kind in STRAIGHT and places > 1 and spread
    cubic = straight and places >= SMOOTH_PLACES
    around, waves = _around(points, _polynomials(along, ends, CUBIC if cubic else int(straight)))
    smooth = None
    if cubic:
        columns = np.hstack([_polynomials(along, ends, CUBIC), around])
        smooth = fitted(columns, points.error_mm, points.standard_u_mm)
    columns = np.hstack([_polynomials(along, ends, int(straight)), around])
    scatter = None if smooth is None else smooth.scatter_mm
    line = fitted(columns, points.error_mm, points.standard_u_mm, scatter)
    return Form(
        points=points,
        along_mm=along,
        ends_mm=ends,
        whole_mm=whole,
        degree=int(straight),
        waves=waves,
        line=line,
        smooth=smooth,
    )


def _along(points: Averaged, place: FeaturePlace) -> tuple[Array, tuple[float, float]]:
    column, whole = (0, place.radius_mm) if place.kind == "face" else (1, place.z_mm)
    return points.nominal_mm[:, column], whole


def _polynomials(along_mm: Array, ends_mm: tuple[float, float], degree: int) -> Array:
    """P₀ … P of the degree, (m, degree + 1)."""
    low, high = ends_mm
    t = (2.0 * along_mm - low - high) / (high - low) if high > low else np.zeros_like(along_mm)
    return np.asarray(legendre.legvander(t, degree), dtype=np.float64)


def _around(points: Averaged, polynomials: Array) -> tuple[Array, tuple[int, ...]]:
    """Columns of waves around the turn, as many as the angles tell, and which."""
    angle = points.spindle_rad
    none = np.zeros((len(angle), 0))
    if np.isnan(angle).any():
        return none, ()
    different = len(np.unique(np.round(np.mod(angle, 2.0 * np.pi), 6)))
    waves = tuple(n for n, needed in WAVES if different >= needed)
    while waves:
        columns = np.column_stack([turn(n * angle) for n in waves for turn in (np.cos, np.sin)])
        both = np.hstack([polynomials, columns])
        if both.shape[0] >= both.shape[1] and np.linalg.cond(both) < CONDITION:
            return columns, waves
        waves = waves[:-1]
    return none, ()
