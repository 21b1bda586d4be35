"""A curve written as a B-spline: what a job file and a drawing can hold."""

from math import comb
from typing import Final

import numpy as np
from numpy.polynomial import Chebyshev, Polynomial

from trueloop.arrays import Array
from trueloop.geometry.curve import Curve

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
