"""Matching of logged touches with the points of a plan: by position, never by count.

A control may leave a touch out, repeat one, or log another job; the position on the approach line decides to which
point a touch belongs.

Repeated trials of a probing plan: what a touch repeats to [6811 §4.1: 40 trials at 15 points of a part with steps].

One trial touches all points in turn, so that what repeats to less than a touch, drift and a part that moves, show as
well; touching one point again and again shows neither.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.domain.inspection import Touch
from trueloop.errors import Code, Finding, Place, Severity
from trueloop.geometry.feature import Point, contact_angle_rad
from trueloop.probing.calibration import BallCalibration
from trueloop.probing.probe_plan import ProbePlan

BESIDE_MM: Final = 0.1
"""A touch this far beside an approach line does not belong to it: the probing move is straight."""

AT_START: Final = 0.05
"""Touches within this share of the stand-off from where the approach began did not meet the part."""

AT_END: Final = 0.05
"""Touches within this share of the overtravel from the end of the probing move did not meet the part."""


@dataclass(frozen=True)
class MatchedTouches:
    """Touches in the plan's order, with their part errors, and what was odd about the log."""

    touches: tuple[Touch, ...]
    findings: tuple[Finding, ...]

    def as_dict(self) -> dict[str, object]:
        """Returns points and part errors for JSON."""
        return {"touches": [{"point": touch.point, "error_mm": touch.error_mm} for touch in self.touches]}


def match_touches(
    plan: ProbePlan,
    logged_mm: Sequence[Point],
    lines: Sequence[int],
    calibration: BallCalibration | None,
    *,
    reports_surface: bool = False,
) -> MatchedTouches:
    """Returns part errors `n · (reported − nominal) − effective ball radius − allowance` of the touches of a plan.

    `logged_mm` are reported positions: ball centres, or points of the surface with `reports_surface` (macros that take
    the ball off). Raises PRB-CALIBRATION without a calibration that covers all touches, PRB-RETRACT where touches are
    at the retract position, PRB-MISSED where they are at the end of the probing move, PRB-OTHER where they belong to no
    point, PRB-TWICE and PRB-MISSING. Another order is a finding.
    """
    expected, normal = _expected(plan, calibration, reports_surface)
    owner = owners_of(plan, logged_mm, lines, calibration, reports_surface=reports_surface)
    _require_each_once(plan, owner, lines)
    row_of = {int(point): row for row, point in enumerate(owner)}
    along = np.einsum("ij,ij->i", np.array(logged_mm) - expected[owner], normal[owner])
    touches = tuple(
        Touch(t.point, t.nominal_mm, t.feature, error_mm=float(along[row_of[k]]), line=lines[row_of[k]])
        for k, t in enumerate(plan.touches)
    )
    return MatchedTouches(touches, _order_findings(plan, owner, lines))


def owners_of(
    plan: ProbePlan,
    logged_mm: Sequence[Point],
    lines: Sequence[int],
    calibration: BallCalibration | None,
    *,
    reports_surface: bool = False,
) -> "np.ndarray[tuple[int], np.dtype[np.intp]]":
    """Returns each logged touch's point, by its position in the plan. Raises as `match_touches`, not for counts."""
    expected, normal = _expected(plan, calibration, reports_surface)
    planned_ball = 0.0 if reports_surface else plan.stylus.ball_radius_mm
    _require_met(plan, normal, planned_ball, np.array(logged_mm), lines)
    return _owners(plan, expected, normal, np.array(logged_mm), lines)


def _expected(plan: ProbePlan, calibration: BallCalibration | None, reports_surface: bool) -> tuple[Array, Array]:
    """Returns the positions that are reported of a part without errors, and the normals, (n, 2) each."""
    if calibration is None and not reports_surface:
        raise Code.PRB_CALIBRATION.refusal(
            f"the probe of {plan.stylus.ball_radius_mm:.3f} mm ball radius is not calibrated: its touches cannot be "
            "corrected for ball, pre-travel and lobing",
            hint="touch a sphere or ring of known size, put what `trueloop probe calibrate` prints into the probe file",
        )
    normal = np.array([touch.normal for touch in plan.touches])
    ball = np.zeros(len(normal)) if calibration is None or reports_surface else _ball_mm(plan, normal, calibration)
    nominal = np.array([touch.nominal_mm for touch in plan.touches])
    return nominal + (plan.approach.allowance_mm + ball)[:, None] * normal, normal


def _ball_mm(plan: ProbePlan, normal: Array, calibration: BallCalibration) -> Array:
    """Effective ball radius of each touch."""
    outside = ~calibration.covers(normal)
    if np.any(outside):
        k = int(np.argmax(outside))
        low, high = math.degrees(calibration.lowest_rad), math.degrees(calibration.highest_rad)
        first, angle = plan.touches[k], math.degrees(float(contact_angle_rad(normal[k])))
        raise Code.PRB_CALIBRATION.refusal(
            f"the probe is calibrated from {low:.1f}° to {high:.1f}° of contact angle: {np.count_nonzero(outside)} of "
            f"{len(normal)} touches lie outside, the first, {first.point!r} on {first.feature!r}, at {angle:.1f}°",
            hint="calibrate it again, touching the sphere or ring in all directions that the part is touched in",
        )
    return calibration.radius_mm(normal)


def _require_met(plan: ProbePlan, normal: Array, ball_mm: float, logged: Array, lines: Sequence[int]) -> None:
    """Not every control stops where a probing move meets nothing: its end is logged then as if it were a touch."""
    nominal, approach = np.array([touch.nominal_mm for touch in plan.touches]), plan.approach
    ends = nominal + (approach.allowance_mm + ball_mm - approach.overtravel_mm) * normal
    off = np.linalg.norm(logged[:, None, :] - ends[None, :, :], axis=2)
    missed = np.min(off, axis=1) <= AT_END * approach.overtravel_mm
    if np.any(missed):
        k = int(np.argmax(missed))
        raise Code.PRB_MISSED.refusal(
            f"{np.count_nonzero(missed)} of {len(logged)} probing moves went to their end without a touch, "
            f"{approach.overtravel_mm:.3f} mm into the part, the first at point "
            f"{plan.touches[int(np.argmin(off[k]))].point!r}",
            hint="is the part there, with the work offset it was planned for, and the probe switched on?",
            place=Place(line=lines[k]),
            values={
                "moves": len(logged),
                "missed": int(np.count_nonzero(missed)),
                "overtravel_mm": approach.overtravel_mm,
                "point": plan.touches[int(np.argmin(off[k]))].point,
            },
        )


def _owners(
    plan: ProbePlan, expected: Array, normal: Array, logged: Array, lines: Sequence[int]
) -> "np.ndarray[tuple[int], np.dtype[np.intp]]":
    """The point of each logged touch: on whose probing move it lies, nearest to the expected contact."""
    away = logged[:, None, :] - expected[None, :, :]
    along = np.einsum("ijk,jk->ij", away, normal)
    beside = np.abs(away[..., 0] * normal[:, 1] - away[..., 1] * normal[:, 0])
    stand_off, overtravel = plan.approach.stand_off_mm, plan.approach.overtravel_mm
    slack = 2 * BESIDE_MM
    on_move = (beside <= BESIDE_MM) & (along <= stand_off + slack) & (along >= -overtravel - slack)
    at_start = on_move & (along >= stand_off * (1.0 - AT_START))
    _require_on_plan(plan, logged, lines, on_move, at_start, np.min(np.hypot(along, beside), axis=1))
    return np.asarray(np.argmin(np.where(on_move, np.abs(along), np.inf), axis=1))


def _require_on_plan(
    plan: ProbePlan,
    logged: Array,
    lines: Sequence[int],
    on_move: "np.ndarray[tuple[int, int], np.dtype[np.bool_]]",
    at_start: "np.ndarray[tuple[int, int], np.dtype[np.bool_]]",
    nearest_mm: Array,
) -> None:
    retracted = np.any(at_start, axis=1) & ~np.any(on_move & ~at_start, axis=1)
    if np.any(retracted):
        k = int(np.argmax(retracted))
        raise Code.PRB_RETRACT.refusal(
            f"{np.count_nonzero(retracted)} of {len(logged)} touches are where the approach began, "
            f"{plan.approach.stand_off_mm:.3f} mm off the part, the first at x {logged[k, 0]:.4f} mm, "
            f"z {logged[k, 1]:.4f} mm",
            hint="the probe was triggered already or never switched on: look at it, then probe again",
            place=Place(line=lines[k]),
            values={
                "touches": len(logged),
                "retracted": int(np.count_nonzero(retracted)),
                "stand_off_mm": plan.approach.stand_off_mm,
            },
        )
    stray = ~np.any(on_move, axis=1)
    if np.any(stray):
        k = int(np.argmax(stray))
        raise Code.PRB_OTHER.refusal(
            f"{np.count_nonzero(stray)} of {len(logged)} touches are at none of the job's {len(plan.touches)} points, "
            f"the first at x {logged[k, 0]:.4f} mm (radius), z {logged[k, 1]:.4f} mm, {nearest_mm[k]:.3f} mm from the "
            "nearest",
            hint="is this the log of this job, in its unit and diameter mode, with the work offset it was planned for?",
            place=Place(line=lines[k]),
            values={
                "touches": len(logged),
                "others": int(np.count_nonzero(stray)),
                "x_mm": float(logged[k, 0]),
                "z_mm": float(logged[k, 1]),
                "nearest_mm": float(nearest_mm[k]),
            },
        )


def _require_each_once(
    plan: ProbePlan, owner: "np.ndarray[tuple[int], np.dtype[np.intp]]", lines: Sequence[int]
) -> None:
    count = np.bincount(owner, minlength=len(plan.touches))
    if np.any(count > 1):
        k = int(np.argmax(count > 1))
        rows = [lines[int(row)] for row in np.flatnonzero(owner == k)]
        raise Code.PRB_TWICE.refusal(
            f"point {plan.touches[k].point!r} was touched {count[k]} times, in lines {', '.join(map(str, rows))}",
            hint="keep one touch a point: delete the others from a copy of the log",
            place=Place(line=rows[-1]),
            values={"point": plan.touches[k].point, "lines": rows},
        )
    if np.any(count == 0):
        missing = [plan.touches[int(k)].point for k in np.flatnonzero(count == 0)]
        raise Code.PRB_MISSING.refusal(
            f"{len(missing)} of {len(plan.touches)} points have no touch: {', '.join(map(repr, missing))}",
            hint="probe again, or take these points out of the plan",
            values={"points": missing},
        )


def _order_findings(
    plan: ProbePlan, owner: "np.ndarray[tuple[int], np.dtype[np.intp]]", lines: Sequence[int]
) -> tuple[Finding, ...]:
    turned = np.flatnonzero(np.diff(owner) < 0)
    if not len(turned):
        return ()
    k = int(turned[0])
    point, before = (plan.touches[int(owner[one])].point for one in (k + 1, k))
    more = f", and {len(turned) - 1} more" if len(turned) > 1 else ""
    return (
        Finding(
            Severity.WARNING,
            Code.PRB_ORDER,
            f"point {point!r} was touched after {before!r}, against the plan{more}",
            "was the program changed? The touches were put in order by where they lie",
            Place(line=lines[k + 1]),
            values={"point": point, "before": before},
        ),
    )


def renamed(findings: Sequence[Finding], file: str) -> tuple[Finding, ...]:
    """Returns the findings with the log's name in their places."""
    return tuple(replace(found, place=replace(found.place, file=file)) for found in findings)


@dataclass(frozen=True)
class PointScatter:
    """The scatter of one point's touches: their standard deviation and range over the trials, mm."""

    point: str
    feature: str
    scatter_mm: float
    range_mm: float


@dataclass(frozen=True, eq=False)
class Trials:
    """Part errors of m trials of n points, (m, n) mm, positive where material is left on, in the plan's order."""

    points: tuple[str, ...]
    features: tuple[str, ...]
    error_mm: Array

    @property
    def scatter(self) -> tuple[PointScatter, ...]:
        """Returns the scatter of every point."""
        sd, span = np.std(self.error_mm, axis=0, ddof=1), np.ptp(self.error_mm, axis=0)
        rows = zip(self.points, self.features, sd.tolist(), span.tolist(), strict=True)
        return tuple(PointScatter(*row) for row in rows)

    def pooled_mm(self, feature: str | None = None) -> float:
        """Returns the standard deviation of a touch, of one feature's points or of all: root of the mean variance."""
        mine = [k for k, name in enumerate(self.features) if feature in (None, name)]
        return math.sqrt(float(np.mean(np.var(self.error_mm[:, mine], axis=0, ddof=1))))

    @property
    def successive_mm(self) -> float:
        """Returns the standard deviation of a touch from differences of successive trials: drift is not in it."""
        return math.sqrt(float(np.mean(np.diff(self.error_mm, axis=0) ** 2)) / 2.0)

    @property
    def freedom(self) -> int:
        """Returns the degrees of freedom of the scatter of all points together."""
        return (len(self.error_mm) - 1) * len(self.points)


def repeated(plan: ProbePlan, back_to_first: ProbePlan, trials: int) -> ProbePlan:
    """Returns a plan that makes the tour several times; `back_to_first`: the way from the last point to the first."""
    again = replace(plan.touches[0], way_mm=back_to_first.touches[-1].way_mm)
    return replace(plan, touches=plan.touches + (trials - 1) * (again, *plan.touches[1:]))


def match_trials(
    plan: ProbePlan,
    logged_mm: Sequence[Point],
    lines: Sequence[int],
    calibration: BallCalibration,
    *,
    reports_surface: bool = False,
) -> Trials:
    """Returns the part errors of all trials of a plan's tour; the k-th touch of a point is of the k-th trial.

    Raises PRB-TRIALS where points were touched a different number of times, or once; and as `match_touches`.
    """
    owner = owners_of(plan, logged_mm, lines, calibration, reports_surface=reports_surface)
    rows = [np.flatnonzero(owner == k) for k in range(len(plan.touches))]
    counts = [len(row) for row in rows]
    if min(counts) != max(counts) or max(counts) < 2:
        fewest = plan.touches[int(np.argmin(counts))].point
        raise Code.PRB_TRIALS.refusal(
            f"{len(logged_mm)} touches of {len(counts)} points are no repeated trials: point {fewest!r} has "
            f"{min(counts)} touches, the one with most {max(counts)}",
            hint="run the program of `trueloop probe program --trials 40` to its end, and give its whole log",
            values={"touches": len(logged_mm), "points": len(counts), "fewest": min(counts), "most": max(counts)},
        )
    found: list[MatchedTouches] = []
    for trial in range(counts[0]):
        mine = sorted(int(row[trial]) for row in rows)
        places, at = [logged_mm[k] for k in mine], [lines[k] for k in mine]
        found.append(match_touches(plan, places, at, calibration, reports_surface=reports_surface))
    errors = np.array([[touch.error_mm for touch in one.touches] for one in found], dtype=np.float64)
    touches = found[0].touches
    return Trials(tuple(one.point for one in touches), tuple(one.feature or "" for one in touches), errors)
