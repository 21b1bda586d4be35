"""A feature that is neither line nor arc: asphere, ellipse, spline, polynomial. One representation for all of them.

The point is a piecewise polynomial of the arc length itself, so that arc length, tangent, normal and curvature are as
good as the polynomials: those of `curve_building` keep within 1e-12 mm and rad of what they are made from.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import ArrayLike

from trueloop.arrays import Array, by_content

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
