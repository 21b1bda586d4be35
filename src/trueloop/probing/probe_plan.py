"""The probing plan: how to come to every gauging point, and back, without touching anything else."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Annotated, Final

import numpy as np
from numpy.typing import NDArray

from trueloop.arrays import Array
from trueloop.domain.option import Option
from trueloop.errors import Code, TrueloopError
from trueloop.geometry.feature import Point
from trueloop.geometry.profile import Profile
from trueloop.probing.calibration import Meeting, Obstacle, Stylus, first_meeting

MARGIN_MM: Final = 2.54
"""Arc length between a feature's end and its first point: 0.1 in, as on the arcs of [6517 Table 1] and [6811 §5.3]."""


@dataclass(frozen=True)
class Spacing:
    """The points on a feature and margins at its ends, mm of arc; a single one in the middle, or at `at_mm`."""

    count: int
    start_margin_mm: float = MARGIN_MM
    end_margin_mm: float = MARGIN_MM
    at_mm: float | None = None


@dataclass(frozen=True)
class GaugingPoints:
    """Points on a profile, ordered along it; shapes (n,) and, for the last two, (n, 2)."""

    feature_index: NDArray[np.intp]
    arc_length_mm: Array
    nominal_mm: Array
    outward_normal: Array


def equally_spaced(
    profile: Profile, spacings: Mapping[str, Spacing], reachable_mm: Array | None = None
) -> GaugingPoints:
    """Places points on the named features, the first and last at their margins and the others evenly between.

    Margins count from the features' ends, or, with `reachable_mm` (n, 2) of a `CentrePath`, from the ends of what the
    nose reaches. Raises TCH-PLAN for a feature that the profile does not have, for no points, and where the margins
    leave no room.
    """
    for name in spacings:
        if name not in profile.names:
            raise _refusal(
                f"{len(spacings)} features are to be touched, but the profile has no '{name}'",
                f"the profile's features: {', '.join(profile.names)}",
            )
    intervals = [(0.0, feature.length_mm) for feature in profile.features] if reachable_mm is None else reachable_mm
    placed = [
        (i, arc_length)
        for i, (name, (low, high)) in enumerate(zip(profile.names, intervals, strict=True))
        if name in spacings
        for arc_length in _along(name, spacings[name], float(low), float(high))
    ]
    return _points(profile, placed)


def _along(name: str, spacing: Spacing, low: float, high: float) -> Array:
    if spacing.count < 1:
        raise _refusal(f"'{name}' is to get {spacing.count} points", "leave out features that are not to be touched")
    first, last = low + spacing.start_margin_mm, high - spacing.end_margin_mm
    if spacing.count == 1:
        first = last = (low + high) / 2 if spacing.at_mm is None else spacing.at_mm
    inside = low <= first and last <= high and (first < last or spacing.count == 1)
    if not inside:
        raise _refusal(
            f"{spacing.count} points on '{name}' from {first:.3f} mm to {last:.3f} mm: it can be touched from "
            f"{low:.3f} mm to {high:.3f} mm",
            "give smaller margins, or one point in the middle",
        )
    return np.linspace(first, last, spacing.count)


def _points(profile: Profile, placed: list[tuple[int, float]]) -> GaugingPoints:
    features = [profile.features[i] for i, _ in placed]
    arc_length = [s for _, s in placed]
    nominal = [feature.point_mm(s) for feature, s in zip(features, arc_length, strict=True)]
    normal = [feature.outward_normal(s) for feature, s in zip(features, arc_length, strict=True)]
    return GaugingPoints(
        np.array([i for i, _ in placed], dtype=np.intp),
        np.array(arc_length),
        np.reshape(nominal, (-1, 2)),
        np.reshape(normal, (-1, 2)),
    )


def _refusal(message: str, hint: str) -> TrueloopError:
    return Code.TCH_PLAN.refusal(message, hint=hint)


OVERLAP_MM: Final = 0.005
"""The overlap, mm, that a touching ball may have with the polygon that stands for the surface."""


@dataclass(frozen=True)
class SecondTouch:
    """After a touch the ball backs off by `back_off_mm` and touches again, `feed_mm_per_min`; that alone counts."""

    back_off_mm: float
    feed_mm_per_min: float


@dataclass(frozen=True)
class Approach:
    """The approach to a point; lengths in mm.

    The probing move begins `stand_off_mm` before the expected contact and ends `overtravel_mm` beyond it, where a
    missing touch is reported. `margin_mm` stays free between stylus and part everywhere else. `allowance_mm` is what
    the surface lies above the nominal one. `second`: how each point is touched again, None where it is touched once.
    """

    stand_off_mm: Annotated[
        float, Option("approach.stand_off_mm", "How far before the expected contact the probing move begins.", above=0)
    ] = 2.0
    overtravel_mm: Annotated[
        float,
        Option(
            "approach.overtravel_mm",
            "How far beyond the expected contact it goes before a touch counts as missing.",
            above=0,
        ),
    ] = 1.0
    margin_mm: Annotated[
        float, Option("approach.margin_mm", "What stays free around ball and stem on the way.", above=0)
    ] = 0.5
    allowance_mm: float = 0.0
    second: SecondTouch | None = None

    @property
    def back_off_mm(self) -> float:
        """Returns the way back between the two touches of a point; 0 where there is one."""
        return self.second.back_off_mm if self.second else 0.0


@dataclass(frozen=True)
class PlannedTouch:
    """One touch: its point, and positions of the ball's centre in part coordinates, x a radius, mm.

    `way` leads from where the touch before ended to `start`; from there the probing move goes to `target`, expected to
    be stopped at `contact`, and back to `start`. `normal` points out of the material.
    """

    point: str
    feature: str
    nominal_mm: Point
    normal: Point
    way_mm: tuple[Point, ...]
    start_mm: Point
    contact_mm: Point
    target_mm: Point

    def back_off_vector_mm(self, second: SecondTouch) -> Point:
        """Returns the way back between the two touches as a vector."""
        return second.back_off_mm * self.normal[0], second.back_off_mm * self.normal[1]


@dataclass(frozen=True)
class ProbePlan:
    """All touches in order. The probe comes from `safe_mm` and goes back there along `retreat_mm`."""

    touches: tuple[PlannedTouch, ...]
    safe_mm: Point
    retreat_mm: tuple[Point, ...]
    stylus: Stylus
    approach: Approach

    def as_dict(self) -> dict[str, object]:
        """Returns the safe position and the touches for JSON."""
        return {"safe_mm": self.safe_mm, "touches": [vars(touch) for touch in self.touches]}


def probe_plan(
    profile: Profile,
    points: GaugingPoints,
    obstacle: Obstacle,
    stylus: Stylus,
    approach: Approach,
    names: Sequence[str] | None = None,
) -> ProbePlan:
    """Plans the touches of these points in their order.

    Raises PRB-BALL where the ball does not fit, PRB-REACH for a point that ball or stem cannot reach: both name the
    point and what is in the way.
    """
    far = stylus.ball_radius_mm + approach.stand_off_mm + 5.0 * approach.margin_mm
    beside = np.maximum(-stylus.stem_length_mm * stylus.stem_direction, 0.0) + stylus.stem_radius_mm
    safe = np.asarray(np.max(obstacle.corners_mm, axis=0) + far + beside)
    touches, at = [], safe
    for touch in probing_moves(profile, points, stylus, approach, names):
        require_ball_fits(touch, obstacle, stylus)
        name, feature = touch.point, touch.feature
        start, contact = np.array(touch.start_mm), np.array(touch.contact_mm)
        farthest = start + approach.back_off_mm * np.array(touch.normal)
        _require_free(name, feature, obstacle, stylus, approach, farthest, contact)
        way = _way(name, feature, obstacle, stylus, approach, at, start, safe)
        touches.append(replace(touch, way_mm=tuple(_point(p) for p in way)))
        at = start
    last = touches[-1].point if touches else "the last one"
    retreat = _way(last, "the way back", obstacle, stylus, approach, at, safe, safe)
    return ProbePlan(tuple(touches), _point(safe), tuple(_point(p) for p in (*retreat, safe)), stylus, approach)


def probing_moves(
    profile: Profile, points: GaugingPoints, stylus: Stylus, approach: Approach, names: Sequence[str] | None = None
) -> tuple[PlannedTouch, ...]:
    """Returns the probing moves alone, with no way from one to the next, as a log of touches is matched with them."""
    names = names or [str(k + 1) for k in range(len(points.arc_length_mm))]
    starts, contacts, targets = _positions(points, stylus, approach)
    return tuple(
        PlannedTouch(
            point=name,
            feature=profile.names[int(points.feature_index[k])],
            nominal_mm=_point(points.nominal_mm[k]),
            normal=_point(points.outward_normal[k]),
            way_mm=(),
            start_mm=_point(starts[k]),
            contact_mm=_point(contacts[k]),
            target_mm=_point(targets[k]),
        )
        for k, name in enumerate(names)
    )


def _positions(points: GaugingPoints, stylus: Stylus, approach: Approach) -> tuple[Array, Array, Array]:
    normal = points.outward_normal
    contact = points.nominal_mm + (approach.allowance_mm + stylus.ball_radius_mm) * normal
    return contact + approach.stand_off_mm * normal, contact, contact - approach.overtravel_mm * normal


def require_ball_fits(touch: PlannedTouch, obstacle: Obstacle, stylus: Stylus) -> None:
    """Raises PRB-BALL where at contact the ball overlaps anything by more than `OVERLAP_MM`."""
    clearance, nearest = stylus.ball_clearance_mm(obstacle, np.array(touch.contact_mm))
    if clearance < -OVERLAP_MM:
        raise no_room_for_ball(touch.point, touch.feature, nearest, stylus.ball_radius_mm, -clearance)


def no_room_for_ball(point: str, feature: str, nearest: str, ball_radius_mm: float, overlap_mm: float) -> TrueloopError:
    """Returns the refusal PRB-BALL: at a point the ball overlaps another feature than its own."""
    return Code.PRB_BALL.refusal(
        f"at point {point!r} on {feature!r} a ball of {2 * ball_radius_mm:.3f} mm overlaps {nearest!r} by "
        f"{overlap_mm:.3f} mm",
        hint="use a smaller ball, or move the point away from the corner or out of the groove",
        values={
            "point": point,
            "feature": feature,
            "obstacle": nearest,
            "ball_diameter_mm": 2 * ball_radius_mm,
            "overlap_mm": overlap_mm,
        },
    )


def _require_free(
    name: str, feature: str, obstacle: Obstacle, stylus: Stylus, approach: Approach, start: Array, contact: Array
) -> None:
    """The stem keeps a margin up to the contact, the ball at the start; on its way to the contact it touches nothing.

    `start` is the farthest from the part that the ball can be: a touch may come anywhere on the probing move, also
    where that begins, and the ball backs off from there. A stem along a face has no more room than it is thinner than
    the ball: half of that is its margin there.
    """
    beside = (stylus.ball_radius_mm - stylus.stem_radius_mm) / 2
    margin = min(approach.margin_mm, beside)
    meeting = first_meeting(stylus.stem_clearance_mm, obstacle, start, contact, margin)
    meeting = meeting or first_meeting(stylus.ball_clearance_mm, obstacle, start, contact, -OVERLAP_MM)
    clearance, nearest = stylus.ball_clearance_mm(obstacle, start)
    if meeting is None and clearance < min(approach.margin_mm, approach.stand_off_mm - 0.01):
        meeting = Meeting(_point(start), nearest, clearance)
    if meeting is not None:
        raise _unreachable(name, feature, meeting, approach)


def _way(
    name: str, feature: str, obstacle: Obstacle, stylus: Stylus, approach: Approach, a: Array, b: Array, safe: Array
) -> tuple[Array, ...]:
    """Positions between a and b: none where the straight way is free, else over the retract levels of x and z."""
    (ax, az), (bx, bz), (sx, sz) = a, b, safe
    ways: list[list[tuple[float, float]]] = [
        [],
        [(sx, az), (sx, bz)],
        [(ax, sz), (bx, sz)],
        [(sx, az), (sx, sz), (bx, sz)],
        [(ax, sz), (sx, sz), (sx, bz)],
    ]
    nearest: Meeting | None = None
    for way in ways:
        between = [np.array(p) for p in way if not (np.allclose(p, a) or np.allclose(p, b))]
        meetings = [
            first_meeting(stylus.clearance_mm, obstacle, p, q, min(approach.margin_mm, approach.stand_off_mm - 0.01))
            for p, q in pairwise([a, *between, b])
        ]
        found = next((meeting for meeting in meetings if meeting is not None), None)
        if found is None:
            return tuple(between)
        nearest = nearest or found
    assert nearest is not None
    raise _unreachable(name, feature, nearest, approach)


def _unreachable(name: str, feature: str, meeting: Meeting, approach: Approach) -> TrueloopError:
    x, z = meeting.centre_mm
    return Code.PRB_REACH.refusal(
        f"point {name!r} on {feature!r} cannot be reached: with the ball's centre at x {x:.3f} mm (radius), "
        f"z {z:.3f} mm the clearance to {meeting.with_what!r} is {max(meeting.clearance_mm, 0.0):.3f} mm, "
        f"{approach.margin_mm:.3f} mm needed",
        hint="turn the stylus, use a thinner or longer stem, leave the point out, or accept a smaller margin, "
        "stand-off or back-off",
        values={
            "point": name,
            "feature": feature,
            "obstacle": meeting.with_what,
            "x_mm": x,
            "z_mm": z,
            "clearance_mm": max(meeting.clearance_mm, 0.0),
            "margin_mm": approach.margin_mm,
        },
    )


def _point(xz: Array) -> Point:
    return float(xz[0]), float(xz[1])
