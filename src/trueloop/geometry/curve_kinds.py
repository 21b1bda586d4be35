"""Curves by their definitions: asphere, ellipse, polynomial and spline, from one point to another that lie on them.

Each is the whole curve, cut between the stated ends: the ends must lie on it within `END_MM`.
"""

import math
from collections.abc import Sequence
from math import comb
from typing import Final

import numpy as np
from numpy.polynomial import Chebyshev, Polynomial, polynomial
from numpy.typing import ArrayLike

from trueloop.arrays import Array
from trueloop.errors import Code, TrueloopError
from trueloop.geometry.curve import Curve, curve_along, mapped, part_of

Point = tuple[float, float]

END_MM: Final = 1e-3
"""The distance, mm, that a stated end may lie off the curve: coordinates of a drawing are rounded to a micrometre."""


def asphere(
    name: str,
    ends_mm: tuple[Point, Point],
    vertex_mm: Point,
    radius_mm: float,
    conic: float = 0.0,
    powers: dict[int, float] | None = None,
    towards_free_end: bool = False,
) -> Curve:
    """Returns an asphere of ISO 10110-12: sag z(h) = h²/(R(1 + √(1 − (1 + k)h²/R²))) + Σ Aᵢ hⁱ over h = x − x of the
    vertex.

    `powers` has the Aᵢ, in mm to 1 − i, of |h|. The sag counts from the vertex to the chuck, or to the free end: a dome
    at the free end of a part has a positive radius and a sag to the chuck. Raises GEO-CURVE where the root has
    no value, GEO-CURVE-END where an end is not on it.
    """
    powers, sign = powers or {}, 1.0 if towards_free_end else -1.0
    highest = max(abs(x - vertex_mm[0]) for x, _ in ends_mm)
    if (1 + conic) * highest**2 >= radius_mm**2:
        raise Code.GEO_CURVE.refusal(
            f"the asphere '{name}' has no slope at {highest:.4f} mm from its axis: its root is zero at "
            f"{abs(radius_mm) / math.sqrt(1 + conic):.4f} mm",
            hint="check radius and conic constant, and that x is a radius where the job does not say diameter",
            values={"feature": name},
        )

    def point(h: Array) -> Array:
        root = np.sqrt(1 - (1 + conic) * (h / radius_mm) ** 2)
        sag = h * h / (radius_mm * (1 + root)) + sum(a * np.abs(h) ** i for i, a in powers.items())
        return np.stack([vertex_mm[0] + h, vertex_mm[1] + sign * sag], axis=-1)

    def derivative(h: Array) -> Array:
        root = np.sqrt(1 - (1 + conic) * (h / radius_mm) ** 2)
        slope = h / (radius_mm * root) + sum(i * a * np.abs(h) ** (i - 1) * np.sign(h) for i, a in powers.items())
        return np.stack([np.ones_like(h), sign * slope], axis=-1)

    (start, end), across = ends_mm, vertex_mm[0]
    low, high = sorted((start[0] - across, end[0] - across))
    _require_apart(name, low, high)
    breaks = [low, 0.0, high] if low < 0.0 < high else [low, high]  # odd powers of |h|
    return _as_run(curve_along(name, point, derivative, breaks), start, end)


def ellipse(
    name: str,
    ends_mm: tuple[Point, Point],
    centre_mm: Point,
    semi_axes_mm: Point,
    rotation_rad: float = 0.0,
    *,
    convex: bool = True,
) -> Curve:
    """Returns an ellipse with semi-axes along (x, z), turned by `rotation_rad` from +z to +x, run convex or concave."""
    a, b = semi_axes_mm
    turn = np.array(
        [[math.cos(rotation_rad), math.sin(rotation_rad)], [-math.sin(rotation_rad), math.cos(rotation_rad)]]
    )
    from_rad, to_rad = (math.atan2(x / a, z / b) for x, z in ((np.asarray(end) - centre_mm) @ turn for end in ends_mm))
    side = -1.0 if convex else 1.0  # the angle from +z towards +x falls along a convex run
    whole_turn = 2 * math.pi
    swept = (side * (to_rad - from_rad)) % whole_turn or whole_turn
    drawn = curve_along(
        name,
        lambda t: np.stack([a * np.sin(from_rad + side * t), b * np.cos(from_rad + side * t)], axis=-1),
        lambda t: side * np.stack([a * np.cos(from_rad + side * t), -b * np.sin(from_rad + side * t)], axis=-1),
        [0.0, swept],
    )
    curve = mapped(drawn, turn, np.asarray(centre_mm))
    _require_end(curve, 0.0, ends_mm[0])
    _require_end(curve, curve.length_mm, ends_mm[1])
    return curve


def power_series(
    name: str,
    ends_mm: tuple[Point, Point],
    coefficients: Sequence[float],
    origin_mm: float = 0.0,
    *,
    of_x: bool = False,
) -> Curve:
    """Returns the polynomial x = Σ cₖ (z − origin)ᵏ, or z of x, in mm."""
    argument = 0 if of_x else 1
    slope = polynomial.polyder(np.asarray(coefficients, dtype=np.float64))
    low, high = sorted(end[argument] for end in ends_mm)

    def placed(t: Array, series: ArrayLike, along: Array) -> Array:
        value = np.asarray(polynomial.polyval(t - origin_mm, np.asarray(series)), dtype=np.float64)
        return np.stack([along, value] if of_x else [value, along], axis=-1)

    _require_apart(name, low, high)
    curve = curve_along(
        name, lambda t: placed(t, coefficients, t), lambda t: placed(t, slope, np.ones_like(t)), [low, high]
    )
    return _as_run(curve, *ends_mm)


def b_spline(
    name: str, control_mm: ArrayLike, knots: ArrayLike, degree: int, weights: ArrayLike | None = None
) -> Curve:
    """Returns a B-spline of control points (n, 2), n + degree + 1 ascending knots and, where it is rational, n weights.

    Runs over the knots' valid span, from the first control point on if they are clamped. Raises GEO-CURVE where
    numbers do not fit together, or where it is not smooth.
    """
    from scipy.interpolate import BSpline  # slow to import

    control, at = np.asarray(control_mm, dtype=np.float64), np.asarray(knots, dtype=np.float64)
    weight = np.ones(len(control)) if weights is None else np.asarray(weights, dtype=np.float64)
    _require_spline(name, control, at, degree, weight)
    origin = control[0]
    raised = BSpline(at, np.column_stack([(control - origin) * weight[:, None], weight]), degree)
    slope = raised.derivative()

    def point(t: Array) -> Array:
        value = raised(t)
        return np.asarray(origin + value[..., :2] / value[..., 2:])

    def derivative(t: Array) -> Array:
        value, change = raised(t), slope(t)
        return np.asarray((change[..., :2] - value[..., :2] / value[..., 2:] * change[..., 2:]) / value[..., 2:])

    breaks = np.unique(at[degree : len(at) - degree])
    return curve_along(name, point, derivative, breaks.tolist())


def between_ends(curve: Curve, start_mm: Point, end_mm: Point) -> Curve:
    """Returns the part of a curve from one point on it to another, in the direction that takes."""
    return _as_run(curve, start_mm, end_mm)


def _as_run(curve: Curve, start_mm: Point, end_mm: Point) -> Curve:
    from_mm, to_mm = (float(curve.locate(end)[0]) for end in (start_mm, end_mm))
    for at_mm, end in ((from_mm, start_mm), (to_mm, end_mm)):
        _require_end(curve, min(max(at_mm, 0.0), curve.length_mm), end)
    if from_mm > to_mm:
        curve = curve.reversed()
        from_mm, to_mm = curve.length_mm - from_mm, curve.length_mm - to_mm
    low, high = max(from_mm, 0.0), min(to_mm, curve.length_mm)
    _require_apart(curve.name, low, high)
    if low < END_MM and curve.length_mm - high < END_MM:
        return curve
    return part_of(curve, low, high)


def _require_end(curve: Curve, at_mm: float, end_mm: Point) -> None:
    """Refuses an end that is not on the curve."""
    x, z = (float(value) for value in curve.point_mm(at_mm))
    off_mm = math.dist((x, z), end_mm)
    if off_mm > END_MM:
        raise Code.GEO_CURVE_END.refusal(
            f"'{curve.name}' passes x = {x:.4f} mm, z = {z:.4f} mm (x a radius), {off_mm:.4f} mm from its stated end "
            f"x = {end_mm[0]:.4f} mm, z = {end_mm[1]:.4f} mm",
            hint="equation and ends must agree within 1 µm: check vertex, sign and constants, and the end's diameter",
            values={"feature": curve.name, "off_mm": off_mm},
        )


def _require_apart(name: str, low: float, high: float) -> None:
    """Refuses a curve from a place to the same place."""
    if not high > low:
        raise Code.GEO_LENGTH.refusal(
            f"'{name}' is {high - low:.6f} mm long: it ends where it starts",
            hint="give the point where the feature before it ends, and another one as its end",
            values={"feature": name, "length_mm": high - low},
        )


def _require_spline(name: str, control: Array, knots: Array, degree: int, weights: Array) -> None:
    """Refuses control points, knots and weights that do not make a spline."""
    count = len(control)
    wrong = None
    if degree < 1 or count <= degree:
        wrong = f"{count} control points for degree {degree}: at least {degree + 1} are needed"
    elif len(knots) != count + degree + 1:
        wrong = f"{len(knots)} knots: {count} control points of degree {degree} need {count + degree + 1}"
    elif len(weights) != count or np.any(weights <= 0.0):
        wrong = f"{len(weights)} weights for {count} control points: one each is needed, more than 0"
    elif np.any(np.diff(knots) < 0.0) or knots[degree] == knots[count]:
        wrong = f"knots that do not ascend from {knots[0]:g} to {knots[-1]:g}"
    if wrong is not None:
        raise Code.GEO_CURVE.refusal(
            f"the spline '{name}' has {wrong}",
            hint="write control points, knots, degree and weights as the drawing file has them",
            values={"feature": name},
        )


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
