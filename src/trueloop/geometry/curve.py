"""A feature that is neither line nor arc: asphere, ellipse, spline, polynomial. One representation for all of them.

Curves from whatever gives a point and a derivative: pieces of arc length as short as their polynomials need.

The point is a piecewise polynomial of the arc length itself, so that arc length, tangent, normal and curvature are as
good as the polynomials: those of `curve_along` keep within 1e-12 mm and rad of what they are made from.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import TYPE_CHECKING, Final, TypeAlias

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import ArrayLike

from trueloop.arrays import Array, by_content
from trueloop.errors import Code, TrueloopError

if TYPE_CHECKING:
    from scipy.spatial import KDTree


SAMPLES_OF_PIECE: Final = 24
"""Places on each piece between which the foot of a normal is sought."""

NEWTON_STEPS: Final = 30

FOUND_MM: Final = 1e-12
"""A step of Newton's along the curve that is smaller is the last."""


@by_content
@dataclass(frozen=True)
class Curve:
    """A smooth curved feature in the plane (x, z), x a radius, in mm.

    Piece j runs from arc length `breaks_mm[j]` to `breaks_mm[j + 1]`, (m + 1,), the first at 0. On it the point is
    Σₖ `chebyshev_mm[j, k]` Tₖ(u), shape (m, n, 2), u from −1 to 1 along the piece. Beyond its ends the curve goes on
    along its circles of curvature there.
    """

    name: str
    breaks_mm: Array
    chebyshev_mm: Array

    @property
    def length_mm(self) -> float:
        """Returns the arc length from start to end."""
        return float(self.breaks_mm[-1])

    @cached_property
    def start_mm(self) -> tuple[float, float]:
        """Returns the point at which the curve begins."""
        x, z = self.point_mm(0.0)
        return float(x), float(z)

    @cached_property
    def end_mm(self) -> tuple[float, float]:
        """Returns the point at which the curve ends."""
        x, z = self.point_mm(self.length_mm)
        return float(x), float(z)

    def point_mm(self, arc_length_mm: ArrayLike) -> Array:
        """Returns the point at arc length, (...) → (..., 2)."""
        s = np.asarray(arc_length_mm, dtype=np.float64)
        point = self._series(self.chebyshev_mm, s)
        beyond = self._beyond(s)
        if not np.any(beyond):
            return point
        tangent, turned = self._unit_tangent(s), self.curvature_per_mm(s) * beyond
        along, across = beyond * np.sinc(turned / np.pi), beyond * np.sin(turned / 2) * np.sinc(turned / (2 * np.pi))
        return point + along[..., None] * tangent - across[..., None] * _left(tangent)

    def tangent(self, arc_length_mm: ArrayLike) -> Array:
        """Returns the unit tangent in the direction of travel, (...) → (..., 2)."""
        s = np.asarray(arc_length_mm, dtype=np.float64)
        tangent, beyond = self._unit_tangent(s), self._beyond(s)
        if not np.any(beyond):
            return tangent
        turned = (self.curvature_per_mm(s) * beyond)[..., None]
        return np.asarray(np.cos(turned) * tangent - np.sin(turned) * _left(tangent))

    def outward_normal(self, arc_length_mm: ArrayLike) -> Array:
        """Returns the unit normal out of the material, (...) → (..., 2)."""
        return _left(self.tangent(arc_length_mm))

    def curvature_per_mm(self, arc_length_mm: ArrayLike) -> Array:
        """Returns the signed κ with dn/ds = κ t: positive where the curve is convex, offset outwards it grows."""
        s = np.asarray(arc_length_mm, dtype=np.float64)
        derived = self._series(self._with_derivatives[..., 2:], s)
        return _bend(_unit(derived[..., :2]), derived[..., 2:])

    def locate(self, points_mm: ArrayLike) -> tuple[Array, Array]:
        """Returns the arc length of the foot of the nearest normal and the distance along it (positive outside the
        material).

        The foot of a point beyond the ends is on the circles of curvature there: negative before the start.
        """
        points = np.asarray(points_mm, dtype=np.float64)
        flat = points.reshape(-1, 2)
        s = self._feet(flat)
        point, tangent, curvature = self._at(s)
        normal, off = _left(tangent), flat - point
        distance, leaves = np.sum(off * normal, axis=-1), np.sum(off * tangent, axis=-1)
        beyond = ((s == 0.0) & (leaves < 0.0)) | ((s == self.length_mm) & (leaves > 0.0))
        if np.any(beyond):
            on, along = _on_circle(curvature, off, tangent, normal)
            s, distance = np.where(beyond, s + along, s), np.where(beyond, on, distance)
        return s.reshape(points.shape[:-1]), distance.reshape(points.shape[:-1])

    def reversed(self) -> "Curve":
        """Returns this curve run from its end to its start: convex becomes concave."""
        signs = np.where(np.arange(self.chebyshev_mm.shape[1]) % 2, -1.0, 1.0)
        breaks = (self.length_mm - self.breaks_mm)[::-1]
        return Curve(self.name, breaks, self.chebyshev_mm[::-1] * signs[:, None])

    @cached_property
    def turn_rad(self) -> float:
        """Returns the angle by which the tangent turns from start to end, positive to the right: ∫ κ ds."""
        tangent = self.tangent(self.sampled_mm[0])
        steps = np.arctan2(
            tangent[:-1, 0] * tangent[1:, 1] - tangent[:-1, 1] * tangent[1:, 0],
            np.sum(tangent[:-1] * tangent[1:], axis=1),
        )
        return float(np.sum(steps))

    @cached_property
    def sampled_mm(self) -> tuple[Array, Array]:
        """Returns arc lengths (k,), both ends among them and ascending, and the points there (k, 2)."""
        within = np.linspace(0.0, 1.0, SAMPLES_OF_PIECE, endpoint=False)
        s = (self.breaks_mm[:-1, None] + within * np.diff(self.breaks_mm)[:, None]).ravel()
        s = np.append(s, self.length_mm)
        return s, self.point_mm(s)

    def radius_range_mm(self) -> tuple[float, float]:
        """Returns the least radii of curvature where concave, and where convex; infinite where it nowhere is."""
        ends = self.breaks_mm[1:] - 1e-12 * np.diff(self.breaks_mm)  # of the piece before a break as well
        curvature = self.curvature_per_mm(np.concatenate([self.sampled_mm[0], ends]))
        concave, convex = float(np.max(-curvature)), float(np.max(curvature))
        return (1 / concave if concave > 0 else np.inf), (1 / convex if convex > 0 else np.inf)

    @cached_property
    def _with_derivatives(self) -> Array:
        """Series of point, first and second derivative by arc length, (pieces, terms, 6): evaluated at once."""
        per_mm = (2.0 / np.diff(self.breaks_mm))[:, None, None]
        first = chebyshev.chebder(self.chebyshev_mm, axis=1) * per_mm
        second = chebyshev.chebder(first, axis=1) * per_mm
        terms = self.chebyshev_mm.shape[1]
        filled = (np.pad(one, ((0, 0), (0, terms - one.shape[1]), (0, 0))) for one in (first, second))
        return np.concatenate([self.chebyshev_mm, *filled], axis=2)

    @cached_property
    def _tree(self) -> "KDTree":
        """The sampled places, to find the nearest one."""
        from scipy.spatial import KDTree  # slow to import

        return KDTree(self.sampled_mm[1])

    def _series(self, coefficients: Array, s: Array) -> Array:
        piece = np.clip(np.searchsorted(self.breaks_mm, s, side="right") - 1, 0, len(self.breaks_mm) - 2)
        low, high = self.breaks_mm[piece], self.breaks_mm[piece + 1]
        u = np.clip((2 * s - low - high) / (high - low), -1.0, 1.0)
        rows = np.moveaxis(coefficients[piece], -2, 0)
        return np.asarray(chebyshev.chebval(u[..., None], rows, tensor=False))

    def _unit_tangent(self, s: Array) -> Array:
        """Returns the unit tangent at the nearest place of the curve itself."""
        return _unit(self._series(self._with_derivatives[..., 2:4], s))

    def _at(self, s: Array) -> tuple[Array, Array, Array]:
        """Returns point, unit tangent and curvature at places of the curve itself."""
        jet = self._series(self._with_derivatives, s)
        tangent = _unit(jet[..., 2:4])
        return jet[..., :2], tangent, _bend(tangent, jet[..., 4:])

    def _beyond(self, s: Array) -> Array:
        """Returns by how much arc lengths lie beyond the ends: negative before the start, 0 on the curve."""
        return np.asarray(s - np.clip(s, 0.0, self.length_mm))

    def _feet(self, points: Array) -> Array:
        """Returns the arc length of the nearest place, by Newton's steps on (q − p(s))·t(s) = 0."""
        places, nearest = self.sampled_mm[0], self._tree.query(points)[1]
        low, high = places[np.maximum(nearest - 1, 0)], places[np.minimum(nearest + 1, len(places) - 1)]
        s = places[nearest]
        for _ in range(NEWTON_STEPS):
            point, tangent, curvature = self._at(s)
            off = points - point
            along, distance = np.sum(off * tangent, axis=-1), np.sum(off * _left(tangent), axis=-1)
            stretch = 1.0 + curvature * distance
            step = along / np.where(stretch > 0.1, stretch, 0.1)
            moved = np.clip(s + step, low, high)
            change, s = np.abs(moved - s), moved
            if np.all(change < FOUND_MM):
                break
        return s


def _unit(direction: Array) -> Array:
    return np.asarray(direction / np.linalg.norm(direction, axis=-1, keepdims=True))


def _bend(tangent: Array, second: Array) -> Array:
    """Returns the signed curvature from unit tangents and second derivatives by arc length."""
    return np.asarray(-np.sum(second * _left(tangent), axis=-1))


def _on_circle(curvature: Array, off: Array, tangent: Array, normal: Array) -> tuple[Array, Array]:
    """Returns the distance from a circle of curvature, and arc length along it to the foot; a line where it is one."""
    a, b = np.sum(off * tangent, axis=-1), np.sum(off * normal, axis=-1)
    out = np.hypot(curvature * a, 1.0 + curvature * b)
    distance = (curvature * (a * a + b * b) + 2 * b) / (1.0 + out)
    straight = np.abs(curvature) < 1e-12
    angle = np.arctan2(curvature * a, 1.0 + curvature * b)
    return distance, np.where(straight, a, angle / np.where(straight, 1.0, curvature))


def _left(tangent: Array) -> Array:
    """Turns a tangent (t_x, t_z) left: returns the outward normal (t_z, −t_x)."""
    return np.stack([tangent[..., 1], -tangent[..., 0]], axis=-1)


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
