"""Inspections as points of features, with the features' places by names and nominal points, or by a profile.

A point's feature is what the profile has there; without one, what stands before a colon in its name ("shaft 1:3"), else
its kind and where it lies. Of a diameter half the deviation is the error; a length puts its face where it was found.
"""

import math
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from trueloop.diagnosis.features.feature_place import FeaturePlace
from trueloop.diagnosis.features.seen_points import SeenPoints
from trueloop.domain.characteristic import Quantity
from trueloop.domain.inspection import CmmPoint, Inspection, Reading, Touch
from trueloop.geometry.profile import Profile

U_MM: Final = 0.001
"""Standard uncertainty of a value that states none: of a probe in a machine, and of a coordinate measuring machine."""
ZERO: Final = "zero of the part"
STEEP: Final = 0.02
"""A surface whose normal leans by less, rad, is a shaft or a face."""
POINT: Final = re.compile(r"(.+?)\s*[:#]\s*\d*")


@dataclass(frozen=True)
class _Point:
    feature: str
    x_mm: float
    z_mm: float
    n_x: float
    n_z: float
    error_mm: float
    u_mm: float = U_MM
    angle_rad: float = math.nan
    repeat: int = 1


def points_of(one: Inspection, places: Mapping[str, FeaturePlace], profile: Profile | None = None) -> SeenPoints:
    """The points of an inspection whose features have places."""
    found = [point for point in _points(one, profile, places) if point.feature in places]
    numbers = np.array(
        [(p.x_mm, p.z_mm, p.n_x, p.n_z, p.error_mm, p.u_mm, p.angle_rad) for p in found], dtype=np.float64
    ).reshape(-1, 7)
    return SeenPoints(
        tuple(point.feature for point in found),
        numbers[:, 0:2],
        numbers[:, 2:4],
        numbers[:, 4],
        numbers[:, 5],
        numbers[:, 6],
        np.array(_repeats(found), dtype=np.int64),
    )


def places_of(
    inspections: Iterable[Inspection], profile: Profile | None = None, tool: str = ""
) -> dict[str, FeaturePlace]:
    """Where the features lie: the whole of a profile's, or what the points of all inspections span."""
    if profile is not None:
        return {feature.name: _of_feature(feature, tool) for feature in profile.features}
    found: dict[str, FeaturePlace] = {}
    for one in inspections:
        for point in _points(one, None, {}):
            known, place = found.get(point.feature), _at(point, tool)
            found[point.feature] = place if known is None else _both(known, place)
    return found


def _points(one: Inspection, profile: Profile | None, places: Mapping[str, FeaturePlace]) -> Iterator[_Point]:
    for point in one.points:
        yield from _of_cmm(point, profile)
    for touch in one.touches:
        yield from _of_touch(touch, profile, places)
    yield from _of_readings(one.readings)


def _of_cmm(point: CmmPoint, profile: Profile | None) -> Iterator[_Point]:
    if point.nominal_mm is None or point.outward_normal is None:
        return
    (x, y, z), (n_x, n_y, n_z) = point.nominal_mm, point.outward_normal
    radius = math.hypot(x, y)
    out = (n_x * x + n_y * y) / radius if radius > 0.0 else 0.0
    error = sum(n * (m - a) for n, m, a in zip(point.outward_normal, point.measured_mm, point.nominal_mm, strict=True))
    name = _named(point.name, profile, (radius, z), (out, n_z))
    yield _Point(name, radius, z, out, n_z, error, angle_rad=math.atan2(y, x) % (2 * math.pi))


def _of_touch(touch: Touch, profile: Profile | None, places: Mapping[str, FeaturePlace]) -> Iterator[_Point]:
    x, z = touch.nominal_mm
    n_x, n_z = _normal(touch, profile, places)
    error = touch.error_mm
    if error is None and touch.measured_mm is not None:
        error = n_x * (touch.measured_mm[0] - x) + n_z * (touch.measured_mm[1] - z)
    if error is not None:
        name = touch.feature or _named(touch.point, profile, (x, z), (n_x, n_z))
        yield _Point(name, x, z, n_x, n_z, error)


def _of_readings(readings: Sequence[Reading]) -> Iterator[_Point]:
    """A length counts from the part's zero or from the face named, wherever that lies."""
    at = {ZERO: 0.0}
    for one in readings:
        if one.nominal is None:
            continue
        name, u, deviation = one.feature or one.characteristic, one.standard_u or U_MM, one.actual - one.nominal
        sign = -1.0 if one.side == "inner" else 1.0
        z = one.place_mm[-1] if one.place_mm else 0.0
        if one.quantity in (Quantity.DIAMETER, Quantity.RADIUS):
            share = 0.5 if one.quantity is Quantity.DIAMETER else 1.0
            yield _Point(
                name, share * one.nominal, z, sign, 0.0, sign * share * deviation, share * u, repeat=one.repeat
            )
        elif one.quantity is Quantity.LENGTH:
            other = one.other or ZERO
            begin = at.setdefault(other, 0.0)
            at[name] = begin + one.nominal
            yield _Point(other, 0.0, begin, 0.0, 1.0, 0.0, u, repeat=one.repeat)
            yield _Point(name, 0.0, at[name], 0.0, 1.0, deviation, u, repeat=one.repeat)


def _normal(touch: Touch, profile: Profile | None, places: Mapping[str, FeaturePlace]) -> tuple[float, float]:
    if profile is not None:
        names = profile.names
        index = names.index(touch.feature) if touch.feature in names else _nearest(profile, touch.nominal_mm)
        feature = profile.features[index]
        length, _ = feature.locate(touch.nominal_mm)
        n_x, n_z = feature.outward_normal(float(length)).tolist()
        return n_x, n_z
    place = places.get(touch.feature or "")
    return (0.0, 1.0) if place is not None and place.kind == "face" else (1.0, 0.0)


def _nearest(profile: Profile, at_mm: tuple[float, float]) -> int:
    distances = []
    for feature in profile.features:
        length, across = feature.locate(at_mm)
        beyond = max(-float(length), float(length) - feature.length_mm, 0.0)
        distances.append(math.hypot(float(across), beyond))
    return int(np.argmin(distances))


def _named(name: str, profile: Profile | None, at_mm: tuple[float, float], normal: tuple[float, float]) -> str:
    if profile is not None:
        return profile.names[_nearest(profile, at_mm)]
    stated = POINT.fullmatch(name)
    if stated is not None:
        return stated[1]
    kind = _kind(normal)
    if kind == "shaft":
        return f"shaft {2 * at_mm[0]:.3f} mm"
    return f"face at z {at_mm[1]:.3f} mm" if kind == "face" else "cone"


def _kind(normal: tuple[float, float]) -> str:
    if abs(normal[1]) < STEEP:
        return "shaft"
    return "face" if abs(normal[0]) < STEEP else "cone"


def _at(point: _Point, tool: str) -> FeaturePlace:
    kind = _kind((point.n_x, point.n_z))
    return FeaturePlace(point.feature, kind, (point.x_mm, point.x_mm), (point.z_mm, point.z_mm), tool)


def _both(one: FeaturePlace, other: FeaturePlace) -> FeaturePlace:
    radius, z = (
        (min(a[0], b[0]), max(a[1], b[1])) for a, b in ((one.radius_mm, other.radius_mm), (one.z_mm, other.z_mm))
    )
    return replace(one, radius_mm=radius, z_mm=z)


def _of_feature(feature: object, tool: str) -> FeaturePlace:
    ends = np.array([feature.point_mm(s) for s in (0.0, feature.length_mm)])  # type: ignore[attr-defined]
    n_x, n_z = np.abs(feature.outward_normal(0.0))  # type: ignore[attr-defined]
    kind = _kind((float(n_x), float(n_z))) if hasattr(feature, "start_mm") and _straight(feature) else "arc"
    (x_low, z_low), (x_high, z_high) = ends.min(axis=0).tolist(), ends.max(axis=0).tolist()
    return FeaturePlace(feature.name, kind, (x_low, x_high), (z_low, z_high), tool)  # type: ignore[attr-defined]


def _straight(feature: object) -> bool:
    return not np.any(feature.curvature_per_mm(np.array([0.0])))  # type: ignore[attr-defined]


def _repeats(points: Sequence[_Point]) -> list[int]:
    """As stated, else counted where one place was read again."""
    seen: dict[tuple[object, ...], int] = {}
    counted = []
    for one in points:
        key = (one.feature, one.x_mm, one.z_mm, one.angle_rad if not math.isnan(one.angle_rad) else None)
        seen[key] = max(seen.get(key, 0) + 1, one.repeat)
        counted.append(seen[key])
    return counted
