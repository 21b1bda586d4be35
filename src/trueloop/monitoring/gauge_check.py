"""A gauge by its checks on calibrated parts: bias, repeatability, drift."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from scipy import stats

from trueloop.arrays import Array

COVERAGE: Final = 2.0
LEAST_TIMES: Final = 3


@dataclass(frozen=True)
class Slope:
    """Drift a day ± `half_width` (95 %, Student), in the unit of the deviations."""

    per_day: float
    half_width: float

    @property
    def significant(self) -> bool:
        """Returns whether it is more than chance."""
        return abs(self.per_day) > self.half_width


@dataclass(frozen=True)
class Drift:
    """The evidence of checks on a gauge, all in one unit.

    `bias` is the mean deviation, measured less calibrated: positive where the gauge shows too much; `bias_u` its
    standard uncertainty with that of the calibration. `repeatability` is the standard deviation of repeats within one
    check from `freedom` degrees of freedom, `between` that of the checks; None: not determined. `slope` is None for
    fewer than three checks of known, different times.
    """

    count: int
    bias: float
    bias_u: float | None
    repeatability: float | None
    freedom: int
    between: float | None
    slope: Slope | None

    @property
    def biased(self) -> bool:
        """Returns whether the bias is beyond its expanded uncertainty, k = 2."""
        return self.bias_u is not None and abs(self.bias) > COVERAGE * self.bias_u


def drift(repeats: Sequence[Array], days: Array | None, calibration_u: float) -> Drift:
    """Evaluates checks in order: deviations of each, measured less calibrated, `repeats` of shape (m,); days (n,),
    None: unknown.

    The calibration's uncertainty is common to all checks and does not average out: u² = s²/n + u_cal². Of one check s
    is that of the mean of its repeats; without repeats the bias has no uncertainty.
    """
    means, n = np.array([one.mean() for one in repeats]), len(repeats)
    freedom = sum(len(one) - 1 for one in repeats)
    squares = sum(float(((one - one.mean()) ** 2).sum()) for one in repeats)
    repeatability = float(np.sqrt(squares / freedom)) if freedom else None
    between = float(means.std(ddof=1)) if n > 1 else None
    of_mean = None if between is None else between / np.sqrt(n)
    if of_mean is None and repeatability is not None:
        of_mean = repeatability / np.sqrt(len(repeats[0]))
    bias_u = None if of_mean is None else float(np.hypot(of_mean, calibration_u))
    return Drift(
        count=n,
        bias=float(means.mean()),
        bias_u=bias_u,
        repeatability=repeatability,
        freedom=freedom,
        between=between,
        slope=_slope(means, days),
    )


def _slope(means: Array, days: Array | None) -> Slope | None:
    """Fits a line through the checks by least squares."""
    if days is None or len(np.unique(days)) < LEAST_TIMES:
        return None
    if not np.ptp(means):
        return Slope(0.0, 0.0)  # linregress leaves the standard error open
    found = stats.linregress(days, means)
    half = float(stats.t.ppf(0.975, len(days) - 2)) * float(found.stderr)
    return Slope(float(found.slope), half)


def e_n(deviation: float, gauge_u: float, calibration_u: float) -> float:
    """Returns the deviation over the expanded uncertainty of both, k = 2 [ISO 13528]: beyond ±1 a check fails."""
    return deviation / (COVERAGE * float(np.hypot(gauge_u, calibration_u)))
