"""Moves of a measuring machine's ball from point to point of a turned part that do not touch it in between.

The part is a body of revolution. The ball comes to a point in the half plane through the axis and that point: along
the normal from `start`, and to `start` radially from outside of the largest radius or along z from beyond the free end,
and leaves it the same way. Between half planes it moves beyond the free end, along the part outside of its largest
radius. The stem is not looked at: which stylus a measuring machine takes is not known here.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from trueloop.errors import Code, TrueloopError
from trueloop.geometry.feature import Point
from trueloop.probing.cmm_plan import CmmTouch, Vector, turned
from trueloop.probing.obstacle import CHORD_MM, Obstacle
from trueloop.probing.probe_plan import OVERLAP_MM, no_room_for_ball

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
    outside, beyond = np.max(obstacle.corners_mm, axis=0) + approach.ball_radius_mm + approach.clearance_mm
    level = float(outside), float(beyond)
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
        raise TrueloopError(
            Code.TCH_PLAN,
            f"the approach of {approach.approach_mm:g} mm is not above {least:g} mm (allowance and margin) and at most "
            f"the clearance of {approach.clearance_mm:g} mm",
            hint="give a longer approach, or a larger clearance",
        )


def _entry(touch: CmmTouch, obstacle: Obstacle, approach: CmmApproach, level: Point) -> tuple[Point, Point]:
    """Where the ball leaves what is surely free for this touch, and where its move along the normal begins."""
    (x, z), (nx, nz), radius = touch.place_mm, touch.normal, approach.ball_radius_mm
    far, near = radius + approach.approach_mm, radius + approach.allowance_mm
    start, contact = (x + far * nx, z + far * nz), (x + near * nx, z + near * nz)
    distance, nearest = obstacle.distance_mm(np.array(start), np.array(contact))
    if distance < radius - OVERLAP_MM - CHORD_MM:
        raise _refusal(Code.PRB_BALL, touch, nearest, approach, contact, distance)
    sideways, along = (level[0], start[1]), (start[0], level[1])
    ways = (along, sideways) if abs(nz) > abs(nx) else (sideways, along)
    found = [obstacle.distance_mm(np.array(entry), np.array(start)) for entry in ways]
    for entry, (free, _) in zip(ways, found, strict=True):
        if free >= radius + MARGIN_MM + CHORD_MM:
            return entry, start
    free, nearest = max(found)
    raise _refusal(Code.PRB_REACH, touch, nearest, approach, start, free)


def _between(
    before: tuple[float, Point, Point] | None, then: tuple[float, Point], level: Point
) -> list[tuple[float, Point]]:
    """From a start back to its entry and on to the next one: along z where that is enough, else beyond the free end."""
    angle, entry = then
    over = (angle, (entry[0], level[1]))
    if before is None:
        return [over, then]
    back = [(before[0], before[1]), (before[0], before[2])]
    if before[0] == angle and before[2][0] == entry[0] == level[0]:
        return [*back, then]
    return [*back, (before[0], (before[2][0], level[1])), over, then]


def _without_repeats(positions: Sequence[Vector]) -> list[Vector]:
    return [here for k, here in enumerate(positions) if k == 0 or here != positions[k - 1]]


def _refusal(
    code: Code, touch: CmmTouch, nearest: str, approach: CmmApproach, at: Point, distance_mm: float
) -> TrueloopError:
    left_mm = max(distance_mm - approach.ball_radius_mm, 0.0)
    if code is Code.PRB_BALL:
        overlap_mm = approach.ball_radius_mm - distance_mm
        return no_room_for_ball(touch.name, touch.feature, nearest, approach.ball_radius_mm, overlap_mm)
    return TrueloopError(
        code,
        f"point {touch.name!r} on {touch.feature!r} cannot be reached from outside or along z: on the way to the "
        f"ball's centre at x {at[0]:.3f} mm (radius), z {at[1]:.3f} mm {left_mm:.3f} mm are left to {nearest!r}, "
        f"{MARGIN_MM:.3f} mm are asked for",
        hint="give a shorter approach or a smaller ball, or leave the point out",
        values={
            "point": touch.name,
            "feature": touch.feature,
            "obstacle": nearest,
            "x_mm": at[0],
            "z_mm": at[1],
            "clearance_mm": left_mm,
            "margin_mm": MARGIN_MM,
        },
    )
