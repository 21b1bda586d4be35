"""Arcs in pieces that every control can cut."""

import math
from collections.abc import Iterator
from dataclasses import replace

from trueloop.nc.program.along import PLANE_AXES
from trueloop.nc.translate.statements import Circle, Straight, Vector

_WHOLE_TURN = 1e-9
"""Share of a turn that rounding of angles may leave."""
_ROOM_STEPS = 2.0
"""An arc of a smaller radius or chord could turn the other way, or all the way round, when it is rounded."""


def pieces(circle: Circle, step_mm: float) -> Iterator[Circle | Straight]:
    """Whole turns, each for itself, and the rest; a line where rounding to `step_mm` leaves no room for an arc."""
    turns = abs(circle.sweep_rad) / math.tau
    whole = math.floor(turns + _WHOLE_TURN)
    rest = turns - whole > _WHOLE_TURN
    total = turns if rest else whole
    for turn in range(whole):
        ends = _along(circle, turn / total), _along(circle, (turn + 1) / total)
        sweep_rad = math.copysign(math.tau, circle.sweep_rad)
        yield _with_room(replace(circle, start_mm=ends[0], end_mm=ends[1], sweep_rad=sweep_rad), step_mm)
    if rest:
        sweep_rad = math.copysign((turns - whole) * math.tau, circle.sweep_rad)
        yield _with_room(replace(circle, start_mm=_along(circle, whole / total), sweep_rad=sweep_rad), step_mm)


def _along(circle: Circle, share: float) -> Vector:
    """The start, moved along the third axis by a share of the whole way: after whole turns the tool is there."""
    third = 3 - sum(PLANE_AXES[circle.plane])
    rise = share * (circle.end_mm[third] - circle.start_mm[third])
    x, y, z = (at + (rise if axis == third else 0.0) for axis, at in enumerate(circle.start_mm))
    return x, y, z


def _with_room(circle: Circle, step_mm: float) -> Circle | Straight:
    first, second = PLANE_AXES[circle.plane]
    start, end, centre = circle.start_mm, circle.end_mm, circle.centre_mm
    radius_mm = math.hypot(start[first] - centre[first], start[second] - centre[second])
    chord_mm = math.hypot(end[first] - start[first], end[second] - start[second])
    short = abs(circle.sweep_rad) < math.pi and chord_mm < _ROOM_STEPS * step_mm
    if radius_mm >= _ROOM_STEPS * step_mm and not short:
        return circle
    named = {first, second} | ({3 - first - second} if circle.rises else set())
    x, y, z = (end[axis] if axis in named else None for axis in range(3))
    return Straight(False, (x, y, z), circle.feed)
