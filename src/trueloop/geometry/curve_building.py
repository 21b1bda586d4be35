"""Curves from whatever gives a point and a derivative: pieces of arc length as short as their polynomials need."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Final, TypeAlias

import numpy as np
from numpy.polynomial import chebyshev

from trueloop.arrays import Array
from trueloop.errors import Code, TrueloopError
from trueloop.geometry.curve import Curve

NODES: Final = 24
"""Places of Chebyshev's on a piece: a polynomial of degree 23 gives the tangent, its integral the point."""

RESOLVED: Final = 1e-12
"""The last terms of a series that is resolved are this much smaller than its largest."""

HALVINGS: Final = 40
"""A piece this often halved is at a place where the curve has no tangent or no curvature."""

CORNER_RAD: Final = 1e-5
"""Tangents before and after a break that differ by more make a corner."""

Along: TypeAlias = Callable[[Array], Array]
"""A parameter (n,) to points or derivatives (n, 2)."""

_ANGLES: Final = np.pi * (2 * np.arange(NODES)[::-1] + 1) / (2 * NODES)
_PLACES: Final = np.cos(_ANGLES)
"""Chebyshev's places on −1 … 1, ascending."""
_TO_SERIES: Final = (
    np.cos(np.outer(np.arange(NODES), _ANGLES)) * np.where(np.arange(NODES) > 0, 2.0, 1.0)[:, None] / NODES
)
"""Values there to the coefficients of the series through them."""


def curve_along(name: str, point: Along, derivative: Along, breaks: Sequence[float]) -> Curve:
    """Returns the curve that `point` runs along from the first of `breaks` to the last; smooth between them.

    `derivative` is that of the point by the parameter. Raises GEO-CURVE where it has a corner, a cusp or no value.
    """
    pieces = [piece for low, high in pairwise(breaks) for piece in _pieces(name, derivative, low, high)]
    lows, lengths, tangents = (np.array(each) for each in zip(*pieces, strict=True))
    starts_mm = point(lows)
    series = np.moveaxis(_TO_SERIES @ tangents, 1, 0)
    at_start, at_end = (chebyshev.chebval(u, series, tensor=False) for u in (-1.0, 1.0))
    sine = at_end[:-1, 0] * at_start[1:, 1] - at_end[:-1, 1] * at_start[1:, 0]
    turn = np.arctan2(sine, np.sum(at_end[:-1] * at_start[1:], axis=-1))
    for k in np.flatnonzero(np.abs(turn) > CORNER_RAD)[:1]:
        x, z = starts_mm[k + 1]
        raise _refused(name, f"turns by {np.degrees(abs(turn[k])):.4f}° at x = {x:.4f} mm, z = {z:.4f} mm")
    return _integrated(name, lengths, tangents, point(lows))


def part_of(curve: Curve, from_mm: float, to_mm: float) -> Curve:
    """Returns the part of the curve between two arc lengths; beyond its ends along its circles of curvature."""
    inner = curve.breaks_mm[(curve.breaks_mm > from_mm) & (curve.breaks_mm < to_mm)]
    breaks = np.concatenate([[from_mm], inner, [to_mm]])
    if from_mm < 0.0 or to_mm > curve.length_mm:
        return curve_along(curve.name, curve.point_mm, curve.tangent, breaks.tolist())
    places = breaks[:-1, None] + (1 + _PLACES) / 2 * np.diff(breaks)[:, None]
    return _integrated(curve.name, np.diff(breaks), curve.tangent(places), curve.point_mm(breaks[:-1]))


def moved_out(curve: Curve, distance_mm: float) -> Curve:
    """Moves the curve along its outward normal: p + d n, whose derivative is (1 + κ d) t. It must not turn back."""
    return curve_along(
        curve.name,
        lambda s: curve.point_mm(s) + distance_mm * curve.outward_normal(s),
        lambda s: (1.0 + distance_mm * curve.curvature_per_mm(s))[:, None] * curve.tangent(s),
        curve.breaks_mm.tolist(),
    )


def mapped(curve: Curve, matrix: Array, offset_mm: Array) -> Curve:
    """Turns, mirrors or shifts the curve: points p to `matrix` p + offset, the matrix orthogonal."""
    series = curve.chebyshev_mm @ np.asarray(matrix, dtype=np.float64).T
    series[:, 0] += offset_mm
    return replace(curve, chebyshev_mm=series)


def _pieces(name: str, derivative: Along, low: float, high: float) -> Iterator[tuple[float, float, Array]]:
    """Yields each piece's first parameter, its length in mm and its unit tangents at Chebyshev's places."""
    waiting = [(low, high, 0)]
    while waiting:
        a, b, halvings = waiting.pop()
        found = _resolved(derivative, a, b)
        if found is not None:
            yield a, *found
        elif halvings == HALVINGS:
            raise _refused(name, f"has a cusp, an end or a corner at its parameter {a:.9g}")
        else:
            middle = (a + b) / 2
            waiting += [(middle, b, halvings + 1), (a, middle, halvings + 1)]


def _resolved(derivative: Along, low: float, high: float) -> tuple[float, Array] | None:
    """Returns the length and tangents of a piece whose series are resolved."""
    speed = np.linalg.norm(derivative((low + high + (high - low) * _PLACES) / 2), axis=1)
    series = _TO_SERIES @ speed
    if not np.all(np.isfinite(series)) or np.min(speed) <= 0.0 or not _ends(series, float(np.max(speed))):
        return None
    length = chebyshev.chebint(series, lbnd=-1.0)
    whole = float(chebyshev.chebval(1.0, length))
    u = np.array(_PLACES)
    for _ in range(8):
        off = chebyshev.chebval(u, length) - (1 + _PLACES) / 2 * whole
        u = np.clip(u - off / chebyshev.chebval(u, series), -1.0, 1.0)
    along = derivative((low + high + (high - low) * u) / 2)
    tangents = along / np.linalg.norm(along, axis=1, keepdims=True)
    return (whole * (high - low) / 2, tangents) if _ends(_TO_SERIES @ tangents, 1.0) else None


def _ends(series: Array, largest: float) -> bool:
    return bool(np.max(np.abs(series[-3:])) <= RESOLVED * largest)


def _integrated(name: str, lengths_mm: Array, tangents: Array, starts_mm: Array) -> Curve:
    """Pieces of these lengths (m,), with tangents (m, NODES, 2) at Chebyshev's places, from these points (m, 2) on."""
    series = chebyshev.chebint(_TO_SERIES @ tangents, axis=1, lbnd=-1.0) * (lengths_mm / 2)[:, None, None]
    series[:, 0] += starts_mm
    return Curve(name, np.concatenate([[0.0], np.cumsum(lengths_mm)]), series)


def _refused(name: str, what: str) -> TrueloopError:
    return Code.GEO_CURVE.refusal(
        f"the curve '{name}' {what}",
        hint="a curved feature is smooth: end it at a corner and begin another there",
        values={"feature": name},
    )
