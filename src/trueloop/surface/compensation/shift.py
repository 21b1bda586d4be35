"""The corrected surface: the nominal one moved along its normals by −w times the pattern.

M(u, v) = N(u, v) − w · MPM(u, v) · n(u, v) [MPM Eq. 5], fitted again as a B-spline surface on the nominal's parameters.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, Protocol

import numpy as np

from trueloop.arrays import Array
from trueloop.domain.limits import Limits, allowed_by
from trueloop.errors import Code, TrueloopError
from trueloop.geometry.surface import Surface
from trueloop.geometry.surface_fit import fit_parameterised
from trueloop.surface.on_face import LIMITS, WHOLE, OnFace
from trueloop.surface.options import SurfaceOptions
from trueloop.units import UM_PER_MM

DEGREE: Final = 3
CHECKS: Final = 3
"""Places between two samples of the fit where the fitted surface is compared with the exact one."""
FEWEST: Final = 8
MOST: Final = 150
"""Pieces a direction that the refit begins and ends with, more where the nominal has more."""
MANY: Final = 50
HOPELESS: Final = 0.7
"""Half as many pieces again take a smooth surface to a fifth of the distance: where many gain less, none will do."""


class Deviation(Protocol):
    """A deviation in mm over parameters in [0, 1]: a pattern, a part's model, or raw errors interpolated."""

    def grid_mm(self, u: Array, v: Array) -> Array:
        """Values at every u with every v."""

    def value_mm(self, u: Array, v: Array) -> Array:
        """Values at pairs of parameters."""


@dataclass(frozen=True, eq=False)
class CorrectedSurface:
    """The corrected surface on [0, 1] × [0, 1], and how far the refit deviates from the exact M(u, v) at most."""

    surface: Surface
    worst_mm: float
    largest_shift_mm: float


def corrected_surface(
    nominal: Surface,
    deviation: Deviation,
    *,
    weight: float = 1.0,
    tolerance_mm: float = SurfaceOptions.tolerance_mm,
    limits: Limits | None = None,
    there: OnFace = WHOLE,
) -> CorrectedSurface:
    """The surface to be machined instead of the nominal one.

    Pieces are added until a check three times as dense as the samples finds the refit within tolerance; knots of the
    nominal stay knots. Limits are judged on the face that is there alone. Raises CMP-SIZE or CMP-SLOPE where the
    correction exceeds the limits, SRF-TOLERANCE where more pieces do not help.
    """
    check_surface_limits(nominal, deviation, weight, limits or Limits(), there)
    pieces, before = FEWEST, np.inf
    while True:
        lines = [_lines(*direction, pieces) for direction in zip(_knots(nominal), nominal.degrees, strict=True)]
        surface = _fitted(nominal, deviation, weight, lines)
        worst = _off(nominal, deviation, weight, surface, lines)
        if worst <= tolerance_mm:
            inside = there.square(LIMITS)
            largest = float(np.max(np.abs(deviation.grid_mm(*_samples(LIMITS)))[inside], initial=0.0)) * weight
            return CorrectedSurface(surface, worst, largest)
        if pieces >= MOST or (pieces > MANY and worst > HOPELESS * before):
            rows, columns = surface.control_mm.shape[:2]
            raise TrueloopError(
                Code.SRF_TOLERANCE,
                f"{rows} × {columns} control points leave {worst * UM_PER_MM:.3g} µm; "
                f"{tolerance_mm * UM_PER_MM:g} µm is wanted",
                hint="the nominal surface has a crease or a seam there: correct its faces one by one, or allow more",
                override="compensation.tolerance_um in the job",
                values={"left_um": worst * UM_PER_MM, "limit_um": tolerance_mm * UM_PER_MM},
            )
        pieces, before = min(MOST, int(1.5 * pieces)), worst


def moved_mm(nominal: Surface, deviation: Deviation, weight: float, u: Array, v: Array) -> Array:
    """The exact M(u, v) on a grid of parameters in [0, 1]: (len(u), len(v), 3)."""
    (u0, u1), (v0, v1) = nominal.domain
    wide_u, wide_v = np.repeat(u0 + (u1 - u0) * u, len(v)), np.tile(v0 + (v1 - v0) * v, len(u))
    at = nominal.partials(wide_u, wide_v)
    shift = weight * deviation.grid_mm(u, v).ravel()
    return np.asarray(at.point_mm - shift[:, None] * nominal.normal_of(at)).reshape(len(u), len(v), 3)


def check_surface_limits(nominal: Surface, deviation: Deviation, weight: float, limits: Limits, there: OnFace) -> None:
    """Refuses a correction that is too large or too steep anywhere on the face, saying where and by how much."""
    at, inside = _samples(LIMITS), there.square(LIMITS)
    points = nominal.grid_mm(*(low + (high - low) * a for (low, high), a in zip(nominal.domain, at, strict=True)))
    size = np.where(inside, np.abs(weight * deviation.grid_mm(*at)), 0.0)
    slope = np.zeros_like(size)
    for axis in (0, 1):
        steps = np.linalg.norm(np.diff(points, axis=axis), axis=2)
        inner = (slice(0, -1), slice(None)) if axis == 0 else (slice(None), slice(0, -1))
        both = inside[inner] & (inside[1:] if axis == 0 else inside[:, 1:])
        rise = np.where(both, np.diff(weight * deviation.grid_mm(*at), axis=axis), 0.0)
        slope[inner] = np.hypot(slope[inner], rise / steps)
    for code, values, limit, unit, field in (
        (Code.CMP_SIZE, size, limits.correction_mm, "µm", "correction_mm"),
        (Code.CMP_SLOPE, slope, limits.slope, "µm/mm", "slope"),
    ):
        k = np.unravel_index(int(np.argmax(values)), values.shape)
        if values[k] > limit:
            x, y, z = points[k]
            raise TrueloopError(
                code,
                f"the correction reaches {values[k] * UM_PER_MM:.1f} {unit} at x {x:.3f}, y {y:.3f}, z {z:.3f} mm; the "
                f"limit is {limit * UM_PER_MM:.1f} {unit}",
                hint="look at the deviations there first: bad touches are likelier than such an error",
                override=allowed_by(field),
                values=dict(zip(code.values, (float(values[k]) * UM_PER_MM, limit * UM_PER_MM), strict=True)),
            )


@dataclass(frozen=True, eq=False)
class _Lines:
    """The knots of the refit in one direction, on [0, 1], and the parameters of its samples."""

    knots: Array
    samples: Array
    checks: Array


def _lines(knots: Array, degree: int, pieces: int) -> _Lines:
    """At least so many pieces, none across a knot of the nominal surface, and as smooth there as the normal is.

    Where the nominal is smooth to order p − m, its normal, and with it the corrected surface, is so to one order less.
    """
    inner, count = np.unique(knots[(knots > 0) & (knots < 1)], return_counts=True)
    spans = np.diff(np.concatenate([[0.0], inner, [1.0]]))
    parts = [max(1, round(pieces * float(span))) for span in spans]
    ends = np.concatenate([[0.0], inner, [1.0]])
    cells = np.concatenate(
        [np.linspace(a, b, n, endpoint=False) for a, b, n in zip(ends[:-1], ends[1:], parts, strict=True)]
    )
    repeat = dict(zip(inner.tolist(), np.clip(DEGREE - (degree - count - 1), 1, DEGREE).tolist(), strict=True))
    own = np.repeat(cells[1:], [repeat.get(cell, 1) for cell in cells[1:].tolist()])
    edges = np.append(cells, 1.0)

    def within(each: int) -> Array:
        share = np.arange(each) / each
        return np.append((edges[:-1, None] + np.diff(edges)[:, None] * share).ravel(), 1.0)

    clamped = np.concatenate([np.zeros(DEGREE + 1), own, np.ones(DEGREE + 1)])
    return _Lines(clamped, within(DEGREE + 1), within(CHECKS * (DEGREE + 1)))


def _knots(nominal: Surface) -> tuple[Array, Array]:
    """The nominal's knots on [0, 1]."""
    (u0, u1), (v0, v1) = nominal.domain
    return (nominal.knots_u - u0) / (u1 - u0), (nominal.knots_v - v0) / (v1 - v0)


def _fitted(nominal: Surface, deviation: Deviation, weight: float, lines: Sequence[_Lines]) -> Surface:
    along, across = lines
    points = moved_mm(nominal, deviation, weight, along.samples, across.samples)
    surface = fit_parameterised(points, (along.samples, across.samples), (along.knots, across.knots), DEGREE)
    return surface.turned_over() if nominal.flipped else surface


def _off(nominal: Surface, deviation: Deviation, weight: float, surface: Surface, lines: Sequence[_Lines]) -> float:
    u, v = (line.checks[:: max(1, len(line.checks) // 700)] for line in lines)
    exact, fitted = moved_mm(nominal, deviation, weight, u, v), surface.grid_mm(u, v)
    return float(np.max(np.linalg.norm(exact - fitted, axis=2)))


def _samples(count: int) -> tuple[Array, Array]:
    at = np.linspace(0.0, 1.0, count)
    return at, at
