"""The corrected surface: the nominal one moved along its normals by −w times the pattern.

M(u, v) = N(u, v) − w · MPM(u, v) · n(u, v) [MPM Eq. 5], fitted again as a B-spline surface on the nominal's parameters.
"""

from dataclasses import dataclass
from typing import Final, Protocol

import numpy as np

from trueloop.compensation.limits import Limits
from trueloop.errors import Code, TrueloopError
from trueloop.geometry.feature import Array
from trueloop.geometry.surface import Surface
from trueloop.geometry.surface_fit import fit_parameterised
from trueloop.units import UM_PER_MM

DEGREE: Final = 3
CHECKS: Final = 3
"""Places between two samples of the fit where the fitted surface is compared with the exact one."""
LARGEST: Final = 200
"""Most control points a direction."""
SAMPLES: Final = 60


class Deviation(Protocol):
    """A deviation in mm over parameters in [0, 1]: a pattern, a part's model, or raw errors interpolated."""

    def grid_mm(self, u: Array, v: Array) -> Array:
        """Values at every u with every v."""

    def value_mm(self, u: Array, v: Array) -> Array:
        """Values at pairs of parameters."""


@dataclass(frozen=True, eq=False)
class CorrectedSurface:
    """The corrected surface on [0, 1] × [0, 1], and how far the refit stands off the exact M(u, v) at most."""

    surface: Surface
    worst_mm: float
    largest_shift_mm: float


def corrected_surface(
    nominal: Surface,
    deviation: Deviation,
    *,
    weight: float = 1.0,
    tolerance_mm: float = 1e-4,
    limits: Limits | None = None,
) -> CorrectedSurface:
    """The surface to be machined instead of the nominal one.

    Control points are added evenly until a check three times as dense as the samples finds the refit within tolerance.
    Raises CMP-SIZE or CMP-SLOPE where the correction exceeds the limits, SRF-TOLERANCE where 200 control points a
    direction do not suffice.
    """
    check_surface_limits(nominal, deviation, weight, limits or Limits())
    count = max(8, *nominal.control_mm.shape[:2])
    while True:
        surface = _fitted(nominal, deviation, weight, count)
        worst = _off(nominal, deviation, weight, surface, count)
        if worst <= tolerance_mm:
            largest = float(np.max(np.abs(deviation.grid_mm(*_samples(SAMPLES))))) * weight
            return CorrectedSurface(surface, worst, largest)
        if count >= LARGEST:
            raise TrueloopError(
                Code.SRF_TOLERANCE,
                f"{count} × {count} control points leave {worst * UM_PER_MM:.3g} µm; "
                f"{tolerance_mm * UM_PER_MM:g} µm is wanted",
                hint="the nominal surface has a crease or a seam there: correct its faces one by one, or allow more",
                override="compensation.tolerance_um in the job",
            )
        count = min(LARGEST, int(1.5 * count))


def moved_mm(nominal: Surface, deviation: Deviation, weight: float, u: Array, v: Array) -> Array:
    """The exact M(u, v) on a grid of parameters in [0, 1]: (len(u), len(v), 3)."""
    (u0, u1), (v0, v1) = nominal.domain
    wide_u, wide_v = np.repeat(u0 + (u1 - u0) * u, len(v)), np.tile(v0 + (v1 - v0) * v, len(u))
    at = nominal.partials(wide_u, wide_v)
    shift = weight * deviation.grid_mm(u, v).ravel()
    return np.asarray(at.point_mm - shift[:, None] * nominal.normal_of(at)).reshape(len(u), len(v), 3)


def check_surface_limits(nominal: Surface, deviation: Deviation, weight: float, limits: Limits) -> None:
    """Refuses a correction that is too large or too steep anywhere, saying where and by how much."""
    at = _samples(SAMPLES)
    points = nominal.grid_mm(*(low + (high - low) * a for (low, high), a in zip(nominal.domain, at, strict=True)))
    size = np.abs(weight * deviation.grid_mm(*at))
    slope = np.zeros_like(size)
    for axis in (0, 1):
        steps = np.linalg.norm(np.diff(points, axis=axis), axis=2)
        inner = (slice(0, -1), slice(None)) if axis == 0 else (slice(None), slice(0, -1))
        slope[inner] = np.hypot(slope[inner], np.diff(weight * deviation.grid_mm(*at), axis=axis) / steps)
    for code, values, limit, unit, key in (
        (Code.CMP_SIZE, size, limits.correction_mm, "µm", "max_correction_um"),
        (Code.CMP_SLOPE, slope, limits.slope, "µm/mm", "max_slope_um_per_mm"),
    ):
        k = np.unravel_index(int(np.argmax(values)), values.shape)
        if values[k] > limit:
            x, y, z = points[k]
            raise TrueloopError(
                code,
                f"the correction reaches {values[k] * UM_PER_MM:.1f} {unit} at x {x:.3f}, y {y:.3f}, z {z:.3f} mm; the "
                f"limit is {limit * UM_PER_MM:.1f} {unit}",
                hint="look at the deviations there first: bad touches are likelier than such an error",
                override=f"compensation.{key} in the job",
            )


def _fitted(nominal: Surface, deviation: Deviation, weight: float, count: int) -> Surface:
    inner = np.linspace(0.0, 1.0, count - DEGREE + 1)[1:-1]
    knots = np.concatenate([np.zeros(DEGREE + 1), inner, np.ones(DEGREE + 1)])
    u, v = _samples(2 * count)
    surface = fit_parameterised(moved_mm(nominal, deviation, weight, u, v), (u, v), (knots, knots), DEGREE)
    return surface.turned_over() if nominal.flipped else surface


def _off(nominal: Surface, deviation: Deviation, weight: float, surface: Surface, count: int) -> float:
    u, v = _samples(min(2 * CHECKS * count, 700))
    exact, fitted = moved_mm(nominal, deviation, weight, u, v), surface.grid_mm(u, v)
    return float(np.max(np.linalg.norm(exact - fitted, axis=2)))


def _samples(count: int) -> tuple[Array, Array]:
    at = np.linspace(0.0, 1.0, count)
    return at, at
