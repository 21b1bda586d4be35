"""Curves of the kernel that lie in a half plane through an axis, as lines, arcs and curves in (x, z)."""

import math
from typing import Any, Final

import numpy as np

from trueloop.arrays import Array
from trueloop.formats.cad.axis import PARALLEL, WITHIN_MM, Axis, xyz
from trueloop.formats.cad.kernel import kernel
from trueloop.geometry.curve_building import curve_along
from trueloop.geometry.feature import Arc, Feature, Line, Point

PLACES: Final = 17
"""Places at which a curve must lie in the half plane."""


class HalfPlane:
    """The half plane from the axis through the place of a curve that is farthest from it."""

    def __init__(self, curve: Any, axis: Axis) -> None:
        self.axis, self.curve = axis, curve
        self.low, self.high = float(curve.FirstParameter()), float(curve.LastParameter())
        asides = [axis.aside(curve.Value(t)) for t in np.linspace(self.low, self.high, PLACES).tolist()]
        farthest = max(asides, key=np.linalg.norm)
        self.out = farthest / max(float(np.linalg.norm(farthest)), WITHIN_MM)
        away = [np.linalg.norm(aside - (aside @ self.out) * self.out) for aside in asides]
        self.holds_curve = max(map(float, away)) < WITHIN_MM

    def flat(self, point: Any) -> Point:
        """Returns (x, z) of a point; x is negative beyond the axis."""
        place = xyz(point) - self.axis.origin
        return float(place @ self.out), float(place @ self.axis.direction)

    def at(self, parameter: float) -> Point:
        """Returns (x, z) of a place of the curve."""
        return self.flat(self.curve.Value(parameter))


def flat_feature(curve: Any, axis: Axis) -> Feature | None:
    """Returns the curve as a feature; None where it does not lie in one half plane, or is no longer than a point."""
    occ, plane = kernel(), HalfPlane(curve, axis)
    if not plane.holds_curve:
        return None
    start, end = plane.at(plane.low), plane.at(plane.high)
    if curve.GetType() == occ.LINE:
        return Line("", start, end) if math.dist(start, end) > WITHIN_MM else None
    if curve.GetType() == occ.CIRCLE:
        arc = _arc(plane)
        return arc if arc.length_mm > WITHIN_MM else None
    return curve_along("", _points(plane), _derivatives(plane), _smooth(curve))


def _arc(plane: HalfPlane) -> Arc:
    """Whether the way from a quarter of it to the middle turns left or right says which way the arc turns."""
    sweep_rad = plane.high - plane.low
    (x0, z0), (x1, z1), (x2, z2) = (plane.at(plane.low + share * sweep_rad) for share in (0.0, 0.25, 0.5))
    left = (z2 - z0) * (x1 - x0) - (x2 - x0) * (z1 - z0)
    centre = plane.flat(plane.curve.Circle().Location())
    return Arc("", (x0, z0), plane.at(plane.high), centre, math.copysign(min(sweep_rad, 2 * math.pi), left))


def _points(plane: HalfPlane) -> Any:
    return lambda t: np.array([plane.at(one) for one in t.tolist()])


def _derivatives(plane: HalfPlane) -> Any:
    occ, rows = kernel(), np.array([plane.out, plane.axis.direction])

    def derivatives(t: Array) -> Array:
        found = []
        for one in t.tolist():
            point, vector = occ.Pnt(), occ.Vec()
            plane.curve.D1(one, point, vector)
            found.append(rows @ xyz(vector))
        return np.array(found)

    return derivatives


def _smooth(curve: Any) -> list[float]:
    """The parameters between which all derivatives go on."""
    occ = kernel()
    places = occ.Reals(1, curve.NbIntervals(occ.CN) + 1)
    curve.Intervals(places, occ.CN)
    found = [float(places.Value(k)) for k in range(1, places.Length() + 1)]
    return [a for a, b in zip(found, [*found[1:], math.inf], strict=True) if b - a > PARALLEL]
