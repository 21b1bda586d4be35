"""Touches of a coordinate measuring machine on a turned part: gauging points, turned about the part's axis."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from trueloop.errors import Code, TrueloopError
from trueloop.geometry.feature import Point
from trueloop.geometry.profile import Profile
from trueloop.probing.plan import GaugingPoints

Vector = tuple[float, float, float]

PARALLEL: float = 1e-6
"""A surface whose normal has a smaller z component is a cylinder: 1e-6 is 1 nm over a millimetre."""
HALF_TURN_DEG = 180.0


@dataclass(frozen=True)
class CmmTouch:
    """A place to touch: (x, z) and outward normal in the half plane of the profile, x a radius, mm.

    `angle_deg` is where about the part's axis: the turn about +z from the half plane y = 0, x > 0 towards +y.
    """

    name: str
    feature: str
    place_mm: Point
    normal: Point
    angle_deg: float = 0.0

    @property
    def nominal_mm(self) -> Vector:
        """Returns the place in the part's frame, z along its axis."""
        return turned(self.place_mm, self.angle_deg)

    @property
    def outward_normal(self) -> Vector:
        """Its normal there."""
        return turned(self.normal, self.angle_deg)


def cmm_plan(
    profile: Profile,
    points: GaugingPoints,
    names: Sequence[str],
    angles_deg: Sequence[float] = (0.0,),
    *,
    diameters: bool = False,
) -> tuple[CmmTouch, ...]:
    """Returns every gauging point at every angle; with `diameters` those on cylinders also half a turn further.

    A point at one angle alone keeps its name, else the angle is added: `12_180`. Raises TCH-PLAN where no angle, no
    finite one, or one angle twice is given.
    """
    _require_different(angles_deg)
    planned = []
    for k, name in enumerate(names):
        place, normal = _pair(points.nominal_mm[k]), _pair(points.outward_normal[k])
        angles = _angles(angles_deg, diameters and abs(normal[1]) < PARALLEL)
        for angle in angles:
            named = name if len(angles) == 1 else f"{name}_{angle:g}"
            feature = profile.names[int(points.feature_index[k])]
            planned.append(CmmTouch(named, feature, place, normal, angle))
    return tuple(planned)


def turned(point: Point, angle_deg: float) -> Vector:
    """Turns a point or vector (x, z) of the profile's half plane about +z by an angle that is counted from x to y."""
    x, z = point
    quarter, beyond = divmod(angle_deg, 90.0)
    if beyond == 0.0:  # cos 90° is no 6e-17
        cosine, sine = ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0))[int(quarter) % 4]
    else:
        cosine, sine = math.cos(math.radians(angle_deg)), math.sin(math.radians(angle_deg))
    return x * cosine + 0.0, x * sine + 0.0, z


def _angles(angles_deg: Sequence[float], opposite: bool) -> list[float]:
    angles = list(dict.fromkeys(angle % 360.0 for angle in angles_deg))
    if opposite:
        angles = list(dict.fromkeys(each for angle in angles for each in (angle, (angle + HALF_TURN_DEG) % 360.0)))
    return angles


def _require_different(angles_deg: Sequence[float]) -> None:
    wrong = [angle for angle in angles_deg if not math.isfinite(angle)]
    if wrong or not angles_deg or len(_angles(angles_deg, False)) < len(angles_deg):
        raise TrueloopError(
            Code.TCH_PLAN,
            f"{len(angles_deg)} angles about the axis, {', '.join(f'{angle:g}°' for angle in angles_deg)}, are not "
            "one or more finite ones, each once",
            hint="name every angle once, 0° is where the profile is drawn",
        )


def _pair(xz: Sequence[float]) -> Point:
    return float(xz[0]), float(xz[1])
