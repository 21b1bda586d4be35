"""Repeated trials of a probing plan: what a touch repeats to [6811 §4.1: 40 trials at 15 points of a part with steps].

One trial touches all points in turn, so that what repeats to less than a touch, drift and a part that moves, show as
well; touching one point again and again shows neither.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from trueloop.arrays import Array
from trueloop.errors import Code
from trueloop.geometry.feature import Point
from trueloop.probing.calibration import BallCalibration
from trueloop.probing.probe_match import MatchedTouches, match_touches, owners_of
from trueloop.probing.probe_plan import ProbePlan


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
    """Returns a plan that makes the tour of a plan several times.

    `back_to_first` is the plan of the last point and then the first: its second touch has the way between them.
    """
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
    counts = [len(one) for one in rows]
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
        mine = sorted(int(one[trial]) for one in rows)
        places, at = [logged_mm[k] for k in mine], [lines[k] for k in mine]
        found.append(match_touches(plan, places, at, calibration, reports_surface=reports_surface))
    errors = np.array([[touch.error_mm for touch in one.touches] for one in found], dtype=np.float64)
    touches = found[0].touches
    return Trials(tuple(one.point for one in touches), tuple(one.feature or "" for one in touches), errors)
