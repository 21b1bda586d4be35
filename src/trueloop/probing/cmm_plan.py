"""Touches of a coordinate measuring machine on a turned part: gauging points, turned about the part's axis.

Moves of a measuring machine's ball from point to point of a turned part that do not touch it in between.

The part is a body of revolution. The ball comes to a point in the half plane through the axis and that point: along
the normal from `start`, and to `start` radially from outside of the largest radius or along z from beyond the free end,
and leaves it the same way; of a part that is turned all around, from behind it too. Between half planes it moves
beyond the free end, along the part outside of its largest radius. The stem is not looked at: which stylus a measuring
machine takes is not known here.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from trueloop.errors import Code, TrueloopError
from trueloop.geometry.feature import Point
from trueloop.geometry.profile import Profile
from trueloop.probing.calibration import CHORD_MM, Obstacle
from trueloop.probing.probe_plan import OVERLAP_MM, GaugingPoints, no_room_for_ball

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
    wrong = [angle for angle in angles_deg if not math.isfinite(angle)]
    if wrong or not angles_deg or len(_angles(angles_deg, False)) < len(angles_deg):
        raise Code.TCH_PLAN.refusal(
            f"{len(angles_deg)} angles about the axis, {', '.join(f'{angle:g}°' for angle in angles_deg)}, are not "
            "one or more finite ones, each once",
            hint="name every angle once, 0° is where the profile is drawn",
        )
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
    if beyond == 0.0:  # cos 90° is not 6e-17
        cosine, sine = ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0))[int(quarter) % 4]
    else:
        cosine, sine = math.cos(math.radians(angle_deg)), math.sin(math.radians(angle_deg))
    return x * cosine + 0.0, x * sine + 0.0, z


def _angles(angles_deg: Sequence[float], opposite: bool) -> list[float]:
    angles = list(dict.fromkeys(angle % 360.0 for angle in angles_deg))
    if opposite:
        angles = list(dict.fromkeys(each for angle in angles for each in (angle, (angle + HALF_TURN_DEG) % 360.0)))
    return angles


def _pair(xz: Sequence[float]) -> Point:
    return float(xz[0]), float(xz[1])


MARGIN_MM: Final = 0.5
"""The clearance between ball and part on every move but the last, along the normal."""


@dataclass(frozen=True)
class CmmApproach:
    """The ball, how far before the surface its move to a point begins, and how far it stays off the part elsewhere.

    `allowance_mm` is what the surface may stand over the nominal one.
    """

    ball_radius_mm: float = 1.0
    approach_mm: float = 3.0
    clearance_mm: float = 10.0
    allowance_mm: float = 0.0


@dataclass(frozen=True)
class CmmMove:
    """The way to one touch: positions of the ball's centre, the last of them where the move along the normal begins."""

    touch: CmmTouch
    way_mm: tuple[Vector, ...]


def cmm_moves(touches: Sequence[CmmTouch], obstacle: Obstacle, approach: CmmApproach) -> tuple[CmmMove, ...]:
    """Returns the ways to all touches in their order, from a position beyond the free end on.

    Raises PRB-REACH for a touch that cannot be reached so, PRB-BALL where the ball does not fit, TCH-PLAN for an
    approach that is not longer than the allowance and its margin or longer than the clearance.
    """
    _require_apart(approach)
    clear_mm = approach.ball_radius_mm + approach.clearance_mm
    outside, beyond = np.max(obstacle.corners_mm, axis=0) + clear_mm
    behind = None if obstacle.held_behind else float(np.min(obstacle.corners_mm[:, 1]) - clear_mm)
    level = _Level(float(outside), float(beyond), behind)
    moves = list[CmmMove]()
    before: tuple[float, Point, Point] | None = None
    for touch in touches:
        entry, start = _entry(touch, obstacle, approach, level)
        way = _between(before, (touch.angle_deg, entry), level)
        positions = [*(turned(place, angle) for angle, place in way), turned(start, touch.angle_deg)]
        moves.append(CmmMove(touch, tuple(_without_repeats(positions))))
        before = touch.angle_deg, start, entry
    return tuple(moves)


def way_back(moves: Sequence[CmmMove]) -> tuple[Vector, ...]:
    """Returns the way from the last touch to outside of the part: the last two positions of its way, in reverse."""
    return tuple(reversed(moves[-1].way_mm[-2:])) if moves else ()


def _require_apart(approach: CmmApproach) -> None:
    least = approach.allowance_mm + MARGIN_MM
    if not least < approach.approach_mm <= approach.clearance_mm:
        raise Code.TCH_PLAN.refusal(
            f"the approach of {approach.approach_mm:g} mm is not above {least:g} mm (allowance and margin) and at most "
            f"the clearance of {approach.clearance_mm:g} mm",
            hint="give a longer approach, or a larger clearance",
        )


@dataclass(frozen=True)
class _Level:
    """What is surely free: outside of this radius, beyond this z, and behind this one where nothing holds the part."""

    outside_mm: float
    beyond_mm: float
    behind_mm: float | None


def _entry(touch: CmmTouch, obstacle: Obstacle, approach: CmmApproach, level: _Level) -> tuple[Point, Point]:
    """Where the ball leaves what is surely free for this touch, and where its move along the normal begins."""
    (x, z), (nx, nz), radius = touch.place_mm, touch.normal, approach.ball_radius_mm
    far, near = radius + approach.approach_mm, radius + approach.allowance_mm
    start, contact = (x + far * nx, z + far * nz), (x + near * nx, z + near * nz)
    distance, nearest = obstacle.distance_mm(np.array(start), np.array(contact))
    if distance < radius - OVERLAP_MM - CHORD_MM:
        raise _refusal(Code.PRB_BALL, touch, nearest, approach, contact, distance)
    sideways, along = [(level.outside_mm, start[1])], [(start[0], level.beyond_mm)]
    if level.behind_mm is not None:
        along.insert(0 if nz < 0.0 else 1, (start[0], level.behind_mm))
    ways = [*along, *sideways] if abs(nz) > abs(nx) else [*sideways, *along]
    found = [obstacle.distance_mm(np.array(entry), np.array(start)) for entry in ways]
    for entry, (free, _) in zip(ways, found, strict=True):
        if free >= radius + MARGIN_MM + CHORD_MM:
            return entry, start
    free, nearest = max(found)
    raise _refusal(Code.PRB_REACH, touch, nearest, approach, start, free)


def _between(
    before: tuple[float, Point, Point] | None, then: tuple[float, Point], level: _Level
) -> list[tuple[float, Point]]:
    """From a start back to its entry and on to the next one: along z where that is enough, else beyond the free end."""
    angle, entry = then
    into = [(angle, place) for place in reversed(_outwards(entry, level))]
    if before is None:
        return [(angle, (into[0][1][0], level.beyond_mm)), *into]
    angle_before, start, entry_before = before
    back = [(angle_before, place) for place in (start, *_outwards(entry_before, level))]
    (_, (x_before, _)), (_, (x_then, _)) = back[-1], into[0]
    if angle_before == angle and x_before == x_then == level.outside_mm:
        return [*back, *into]
    return [*back, (angle_before, (x_before, level.beyond_mm)), (angle, (x_then, level.beyond_mm)), *into]


def _outwards(entry: Point, level: _Level) -> list[Point]:
    """An entry, and of one from behind the place beside it from which the way along the part is free."""
    return [entry] if entry[1] != level.behind_mm else [entry, (level.outside_mm, entry[1])]


def _without_repeats(positions: Sequence[Vector]) -> list[Vector]:
    return [here for k, here in enumerate(positions) if k == 0 or here != positions[k - 1]]


def _refusal(
    code: Code, touch: CmmTouch, nearest: str, approach: CmmApproach, at: Point, distance_mm: float
) -> TrueloopError:
    left_mm = max(distance_mm - approach.ball_radius_mm, 0.0)
    if code is Code.PRB_BALL:
        overlap_mm = approach.ball_radius_mm - distance_mm
        return no_room_for_ball(touch.name, touch.feature, nearest, approach.ball_radius_mm, overlap_mm)
    return code.refusal(
        f"point {touch.name!r} on {touch.feature!r} cannot be reached from outside or along z: on the way to the "
        f"ball's centre at x {at[0]:.3f} mm (radius), z {at[1]:.3f} mm {left_mm:.3f} mm are left to {nearest!r}, "
        f"{MARGIN_MM + CHORD_MM:.3f} mm are needed",
        hint="give a shorter approach or a smaller ball, or leave the point out",
        values={
            "point": touch.name,
            "feature": touch.feature,
            "obstacle": nearest,
            "x_mm": at[0],
            "z_mm": at[1],
            "clearance_mm": left_mm,
            "margin_mm": MARGIN_MM + CHORD_MM,
        },
    )
