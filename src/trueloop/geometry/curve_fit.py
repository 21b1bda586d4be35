"""A smooth curve through a list of points, as few pieces as keep their tolerance."""

from math import comb
from typing import Final

import numpy as np
from numpy.polynomial import Chebyshev, Polynomial
from numpy.typing import ArrayLike

from trueloop.arrays import Array
from trueloop.errors import Code, TrueloopError
from trueloop.geometry.curve import Curve
from trueloop.geometry.curve_kinds import b_spline

DEGREE: Final = 5
"""The degree of the spline: its curvature and the slope of its curvature have no jumps."""

POINTS_A_PIECE: Final = 2
"""With fewer points than that to a piece the curve would follow their rounding."""

END_WEIGHT: Final = 1e4
"""The weight of the first and the last point against the others: the neighbouring features begin there."""

REFITS: Final = 4
"""The number of times that the points are moved along the curve to where it passes nearest to them."""


def curve_through(name: str, points_mm: ArrayLike, tolerance_mm: float) -> Curve:
    """Returns the curve of the fewest pieces that passes all points (n, 2), in order, within the tolerance.

    A least-squares B-spline over the points' chord length, its knots between the points. Raises GEO-CURVE-FIT where
    none does, GEO-CURVE for fewer than three points or two that are the same.
    """
    points = np.asarray(points_mm, dtype=np.float64)
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    if len(points) < 3 or np.min(steps) <= 0.0:
        raise Code.GEO_CURVE.refusal(
            f"'{name}' has {len(points)} points, {int(np.sum(steps <= 0.0))} of them where the one before is",
            hint="give at least three points, each once, in the order of the profile",
            values={"feature": name},
        )
    chord = np.concatenate([[0.0], np.cumsum(steps)])
    chord /= chord[-1]
    degree, pieces = min(DEGREE, len(points) - 1), 1
    while True:
        curve, off = _fitted(name, points, chord, degree, pieces)
        if np.max(off) <= tolerance_mm:
            return curve
        if len(points) < POINTS_A_PIECE * (2 * pieces) + degree:
            raise _not_held(name, points, off, tolerance_mm, pieces)
        pieces *= 2


def off_points_mm(curve: Curve, points_mm: ArrayLike) -> Array:
    """Distances of points (n, 2) from the curve, (n,)."""
    s, distance = curve.locate(points_mm)
    return np.hypot(distance, s - np.clip(s, 0.0, curve.length_mm))


def _fitted(name: str, points: Array, chord: Array, degree: int, pieces: int) -> tuple[Curve, Array]:
    """Returns the spline of that many pieces, and the distance of each point from it."""
    from scipy.interpolate import make_lsq_spline  # slow to import

    at, weights = chord, np.ones(len(points))
    weights[[0, -1]] = END_WEIGHT
    inner = np.interp(np.arange(1, pieces) / pieces, np.linspace(0.0, 1.0, len(chord)), chord)
    knots = np.concatenate([np.zeros(degree + 1), inner, np.ones(degree + 1)])
    spline = make_lsq_spline(at, points, knots, degree, w=weights)
    for _ in range(REFITS):
        along = spline.derivative()(at)
        at = at + np.sum((points - spline(at)) * along, axis=1) / np.sum(along * along, axis=1)
        at = np.concatenate([[0.0], np.clip(at[1:-1], 0.0, 1.0), [1.0]])
        if np.min(np.diff(at)) <= 0.0:
            break
        spline = make_lsq_spline(at, points, knots, degree, w=weights)
    curve = b_spline(name, spline.c, knots, degree)
    return curve, off_points_mm(curve, points)


def _not_held(name: str, points: Array, off: Array, tolerance_mm: float, pieces: int) -> TrueloopError:
    k = int(np.argmax(off))
    return Code.GEO_CURVE_FIT.refusal(
        f"'{name}' of {pieces} pieces through {len(points)} points deviates by {off[k]:.5f} mm from point {k + 1} at "
        f"x = {points[k, 0]:.4f} mm, z = {points[k, 1]:.4f} mm; its tolerance is {tolerance_mm:.5f} mm",
        hint="look at that point first; else give more points there, a wider tolerance, or end the feature at a corner",
        values={"feature": name, "off_mm": float(off[k])},
    )


LEFT_OUT_MM: Final = 1e-13
"""Terms of a piece's series from the first on from which all are smaller are left out."""


def spline_of(curve: Curve) -> tuple[Array, Array, int]:
    """Returns the curve as a spline over its arc length: control points (n, 2), knots (n + degree + 1,) and degree."""
    largest = np.max(np.abs(curve.chebyshev_mm), axis=(0, 2))
    degree = max(1, int(np.max(np.flatnonzero(largest > LEFT_OUT_MM))))
    pieces = [_control(series[: degree + 1]) for series in curve.chebyshev_mm]
    control = np.vstack([pieces[0][:1], *(piece[1:] for piece in pieces)])
    ends = curve.breaks_mm[[0, -1]]
    return control, np.concatenate([ends[:1], np.repeat(curve.breaks_mm, degree), ends[1:]]), degree


def _control(series: Array) -> Array:
    """Returns Bézier's control points of a piece: bⱼ = Σᵢ C(j, i)/C(n, i) aᵢ, aᵢ the coefficients of tⁱ on 0 … 1."""
    degree = len(series) - 1
    powers = np.zeros((degree + 1, 2))
    for axis in (0, 1):
        in_t = Chebyshev(series[:, axis]).convert(kind=Polynomial)(Polynomial([-1.0, 2.0]))
        powers[: len(in_t.coef), axis] = in_t.coef
    to_control = np.array([[comb(j, i) / comb(degree, i) for i in range(degree + 1)] for j in range(degree + 1)])
    return np.asarray(to_control @ powers)
