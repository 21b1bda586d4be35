"""Curves of each turned face of a solid in a half plane through the axis."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import Any, Final

import numpy as np

from trueloop.arrays import Array
from trueloop.formats.cad.kernel import edge_curves, kernel
from trueloop.formats.cad.step import CadFace
from trueloop.geometry.curve import curve_along
from trueloop.geometry.feature import Arc, Feature, Line, Point

WITHIN_MM: Final = 1e-4
"""Ends that lie closer are one point, axes that lie closer are one axis."""
PARALLEL: Final = 1e-6
HAS_AXIS: Final = ("CylindricalSurface", "ConicalSurface", "ToroidalSurface", "SurfaceOfRevolution")


@dataclass(frozen=True, eq=False)
class Axis:
    """A line: its point nearest to the origin, its direction; `share` of the turned area about it, `rival` the next."""

    origin: Array
    direction: Array
    share: float = 1.0
    rival: float = 0.0

    def flat(self, point: Any) -> Point:
        """Returns (x, z) of a point of the kernel: its distance from the axis, and its place along it."""
        return self.flattened([point])[0]

    def flattened(self, points: Sequence[Any]) -> list[Point]:
        """Returns several points as radius and place along the axis."""
        away = np.array([(point.X(), point.Y(), point.Z()) for point in points]) - self.origin
        z = away @ self.direction
        x = np.linalg.norm(away - z[:, None] * self.direction, axis=1)
        return list(zip(x.tolist(), z.tolist(), strict=True))

    def aside(self, point: Any) -> Array:
        """Returns the vector from the axis to a point of the kernel, perpendicular to the axis."""
        away: Array = xyz(point) - self.origin
        return away - (away @ self.direction) * self.direction

    def is_parallel(self, direction: Any) -> bool:
        """Returns whether the kernel's direction is along the axis, either way."""
        return float(np.linalg.norm(np.cross(xyz(direction), self.direction))) < PARALLEL

    def is_of(self, place: Any, direction: Any) -> bool:
        """Returns whether a line through the place in the direction is this axis."""
        return self.is_parallel(direction) and self.flat(place)[0] < WITHIN_MM

    def at(self, point: Point, turn_rad: float) -> Array:
        """Returns the place of (x, z) in space when turned about the axis."""
        first, second = self._square
        return self.origin + point[1] * self.direction + point[0] * (math.cos(turn_rad) * first
                                                                    + math.sin(turn_rad) * second)  # fmt: skip

    @cached_property
    def _square(self) -> tuple[Array, Array]:
        first = np.cross(self.direction, np.eye(3)[int(np.argmin(np.abs(self.direction)))])
        first /= np.linalg.norm(first)
        return first, np.cross(self.direction, first)


def axis_of(faces: Sequence[CadFace]) -> Axis | None:
    """Returns the line about which most of the area is turned; None where no face is."""
    groups: list[tuple[Array, Array, float]] = []
    for face in faces:
        if face.kind not in HAS_AXIS:
            continue
        own = kernel().surface_of(face.handle).Axis()
        point, direction = xyz(own.Location()), xyz(own.Direction())
        direction = direction * np.sign(direction[np.argmax(np.abs(np.round(direction, 6)))])
        foot = point - (point @ direction) * direction
        for k, (at, along, area) in enumerate(groups):
            if np.linalg.norm(at - foot) < WITHIN_MM and np.linalg.norm(along - direction) < PARALLEL:
                groups[k] = at, along, area + face.area_mm2
                break
        else:
            groups.append((foot, direction, face.area_mm2))
    if not groups:
        return None
    (at, along, area), *others = sorted(groups, key=lambda group: -group[2])
    whole = area + math.fsum(group[2] for group in others)
    return Axis(at, along, area / whole, others[0][2] / whole if others else 0.0)


def xyz(point: Any) -> Array:
    """Coordinates of a point or a direction of the kernel."""
    return np.array([point.X(), point.Y(), point.Z()])


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
    """Returns the curve as a feature; None where it does not lie in one half plane, or has no length."""
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
    """Returns the sense of the arc: that in which the way from a quarter of it to its middle turns."""
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


ROUND_AT: Final = 7
"""Places along u and v at which a surface must be round."""
SAMPLES: Final = 65
"""Places of an edge among which the nearest to the axis and the farthest are sought."""


@dataclass(frozen=True, eq=False)
class Meridian:
    """The curve that turned about the axis makes a face, or a part of it; its material is on the right."""

    face: CadFace
    feature: Feature

    @property
    def middle_mm(self) -> Point:
        """Returns the place half way along it."""
        x, z = self.feature.point_mm(self.feature.length_mm / 2)
        return float(x), float(z)


def meridians(face: CadFace, axis: Axis) -> list[Meridian]:
    """Returns the face's curves in a half plane through the axis, as far as the face reaches; none if not turned."""
    return [_with_material_right(curve, axis) for curve in _curves(face, axis)]


def has_place(face: CadFace, place: Array) -> bool:
    """Returns whether a place of its surface lies on the face, within its edges."""
    occ, surface = kernel(), kernel().surface_of(face.handle)
    found = occ.SurfacePlaces(surface).ValueOfUV(occ.Pnt(*place.tolist()), WITHIN_MM)
    u0, _, v0, _ = occ.uv_bounds(face.handle)
    u = _from(found.X(), u0, surface.UPeriod() if surface.IsUPeriodic() else 0.0)
    v = _from(found.Y(), v0, surface.VPeriod() if surface.IsVPeriodic() else 0.0)
    return bool(occ.FaceClassifier(face.handle, occ.Pnt2d(u, v), PARALLEL).State() == occ.IN)


def _from(value: float, low: float, period: float) -> float:
    """A parameter, by whole periods, at or above the face's lowest."""
    return low + (value - low) % period if period else value


def _with_material_right(meridian: Meridian, axis: Axis) -> Meridian:
    """The face's own normal, out of the material, must be on the left."""
    occ, half = kernel(), meridian.feature.length_mm / 2
    at = axis.at(meridian.middle_mm, 0.0)
    surface = occ.surface_of(meridian.face.handle)
    uv = occ.SurfacePlaces(surface).ValueOfUV(occ.Pnt(*at.tolist()), WITHIN_MM)
    normal = xyz(occ.Differential(surface, uv.X(), uv.Y(), 1, PARALLEL).Normal())
    x, z = meridian.feature.outward_normal(half)
    out = float(normal @ (axis.at((float(x), float(z)), 0.0) - axis.origin))
    out *= -1 if meridian.face.handle.Orientation() == occ.REVERSED else 1
    return meridian if out > 0 else replace(meridian, feature=meridian.feature.reversed())


def _curves(face: CadFace, axis: Axis) -> list[Meridian]:
    surface = kernel().surface_of(face.handle)
    if face.kind == "Plane":
        turned = axis.is_parallel(surface.Axis().Direction())
        return list(_of_plane(face, axis)) if turned else []
    if face.kind == "SphericalSurface":
        centre = surface.Location()
        return list(_of_sphere(face, axis, centre, surface.Radius())) if axis.flat(centre)[0] < WITHIN_MM else []
    if face.kind in HAS_AXIS and axis.is_of(surface.Axis().Location(), surface.Axis().Direction()):
        return _along(face, axis, v=True)
    return _of_spline(face, axis) if face.kind not in HAS_AXIS else []


def run_on(curves: Sequence[Meridian], features: Sequence[Feature]) -> list[int]:
    """Returns which lines and arcs of a section run along one of these curves, or along a part of one."""
    found = []
    for k, feature in enumerate(features):
        for curve in curves:
            shares = np.linspace(0.0, 1.0, 11)[1:-1]
            along, aside = feature.locate(curve.feature.point_mm(shares * curve.feature.length_mm))
            if np.any((np.abs(aside) < WITHIN_MM) & (along > 0) & (along < feature.length_mm)):
                found.append(k)
                break
    return found


def rings(face: CadFace, axis: Axis) -> Iterator[Point]:
    """Yields (x, z) of the edges that are circles about the axis, whole or in part."""
    for curve in edge_curves(face.handle):
        if curve.GetType() == kernel().CIRCLE:
            circle = curve.Circle()
            if axis.is_of(circle.Location(), circle.Axis().Direction()):
                yield circle.Radius(), axis.flat(circle.Location())[1]


def edge_places(face: CadFace, axis: Axis) -> Iterator[Point]:
    """Yields (x, z) of places along the edges of a face."""
    for curve in edge_curves(face.handle):
        yield from _places(curve, axis)


def _places(curve: Any, axis: Axis) -> list[Point]:
    share = np.linspace(curve.FirstParameter(), curve.LastParameter(), SAMPLES)
    return axis.flattened([curve.Value(t) for t in share.tolist()])


def _of_plane(face: CadFace, axis: Axis) -> Iterator[Meridian]:
    """From the axis outwards, cut where one of its loops is nearest to the axis or farthest from it."""
    radii, z = {0.0}, 0.0
    for curve in edge_curves(face.handle):
        places = _places(curve, axis)
        z = places[0][1]
        radii |= {min(x for x, _ in places), max(x for x, _ in places)}
    for inner, outer in pairwise(_apart(radii)):
        yield Meridian(face, Line("", (inner, z), (outer, z)))


def _of_sphere(face: CadFace, axis: Axis, centre: Any, radius: float) -> Iterator[Meridian]:
    """From pole to pole, cut at its circles about the axis."""
    z = axis.flat(centre)[1]
    angles = {math.atan2(x, at - z) for x, at in rings(face, axis)}
    for low, high in pairwise(_apart({0.0, math.pi, *angles})):
        ends = [(radius * math.sin(angle), z + radius * math.cos(angle)) for angle in (high, low)]
        yield Meridian(face, Arc("", ends[0], ends[1], (0.0, z), high - low))


def _along(face: CadFace, axis: Axis, *, v: bool) -> list[Meridian]:
    """The curve of the surface that runs through the middle of the face in u, or in v."""
    occ, surface = kernel(), kernel().surface_of(face.handle)
    u0, u1, v0, v1 = occ.uv_bounds(face.handle)
    line = surface.UIso((u0 + u1) / 2) if v else surface.VIso((v0 + v1) / 2)
    feature = flat_feature(occ.FreeCurve(line, *((v0, v1) if v else (u0, u1))), axis)
    return [Meridian(face, feature)] if feature is not None else []


def _of_spline(face: CadFace, axis: Axis) -> list[Meridian]:
    """Of a surface that is stated otherwise than as turned: is it round about the axis along u, or along v?"""
    surface, (u0, u1, v0, v1) = kernel().surface_of(face.handle), kernel().uv_bounds(face.handle)
    grid = np.array(
        [
            axis.flattened([surface.Value(u, v) for v in np.linspace(v0, v1, ROUND_AT).tolist()])
            for u in np.linspace(u0, u1, ROUND_AT).tolist()
        ]
    )
    spread_u, spread_v = (float(np.max(np.ptp(grid, axis=k))) for k in (0, 1))
    if min(spread_u, spread_v) > WITHIN_MM:
        return []
    return _along(face, axis, v=spread_u < spread_v)


def _apart(values: set[float]) -> list[float]:
    """In order, those that agree but for rounding once."""
    kept: list[float] = []
    for value in sorted(values):
        if not kept or value - kept[-1] > WITHIN_MM:
            kept.append(value)
    return kept
