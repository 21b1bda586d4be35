"""Capability and performance of a characteristic against its limits, with intervals [ISO 22514-2]; gauges by checks.

Pp and Ppk take the standard deviation of all values, Cp and Cpk the short-term one of the moving range: the
difference is drift. All are for values that are normally distributed. A gauge is checked on calibrated parts: bias,
repeatability, drift.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from scipy import stats

from trueloop.arrays import Array
from trueloop.errors import Code
from trueloop.monitoring.charts import Baseline, baseline

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
    means, n = np.array([repeat.mean() for repeat in repeats]), len(repeats)
    freedom = sum(len(repeat) - 1 for repeat in repeats)
    squares = sum(float(((repeat - repeat.mean()) ** 2).sum()) for repeat in repeats)
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


SHARE_OF_FREEDOM: Final = 0.62
"""A standard deviation from n − 1 moving ranges is as good as one from 0.62 (n − 1) independent values: the variance of
the mean moving range of normal values, whose neighbours share a value [Cryer, Ryan 1990]."""


@dataclass(frozen=True)
class Index:
    """One index with its interval at `level`; `value` is None where a limit that it needs is not stated."""

    name: str
    value: float | None
    low: float | None = None
    high: float | None = None


@dataclass(frozen=True)
class Capability:
    """The four indices of one characteristic. `normal_p` is that of values as unlike the normal (Shapiro)."""

    count: int
    mean: float
    sigma: float
    short_sigma: float
    indices: tuple[Index, ...]
    normal_p: float


def capability(
    values: Array, lower: float | None, upper: float | None, level: float = 0.95, base: Baseline | None = None
) -> Capability:
    """Indices of values (n,) against limits; None: no limit on that side.

    `base` has the short-term standard deviation and from how many values it comes; None: from these values. Raises
    MON-FEW for too few values, MON-LIMITS without a limit and for a lower one that is not below the upper one.
    """
    if (lower is None and upper is None) or (lower is not None and upper is not None and lower >= upper):
        raise Code.MON_LIMITS.refusal(
            f"limits {lower} and {upper} say nothing of capability",
            hint="state a lower limit, an upper one above it, or both",
        )
    base, n = base or baseline(values), len(values)
    mean, sigma = float(np.mean(values)), float(np.std(values, ddof=1))
    indices = [
        made
        for letter, s, freedom in (("P", sigma, n - 1.0), ("C", base.sigma, SHARE_OF_FREEDOM * (base.count - 1)))
        for made in (
            _spread(f"{letter}p", lower, upper, s, freedom, level),
            nearer_limit(letter, lower, upper, mean, s, n, freedom, level),
        )
    ]
    return Capability(
        count=n,
        mean=mean,
        sigma=sigma,
        short_sigma=base.sigma,
        indices=tuple(indices),
        normal_p=float(stats.shapiro(values).pvalue),
    )


def _spread(name: str, lower: float | None, upper: float | None, s: float, freedom: float, level: float) -> Index:
    """Returns (U − L)/6 s; its interval follows from that of s, which is exact: χ²."""
    if lower is None or upper is None:
        return Index(name, None)
    value = (upper - lower) / (6.0 * s)
    low, high = (value * np.sqrt(stats.chi2.ppf(p, freedom) / freedom) for p in ((1 - level) / 2, (1 + level) / 2))
    return Index(name, float(value), float(low), float(high))


def nearer_limit(
    letter: str, lower: float | None, upper: float | None, mean: float, s: float, n: int, freedom: float, level: float
) -> Index:
    """Returns Ppk or Cpk by `letter`: the nearer limit's distance from the mean of n values in 3 s, s with `freedom`.

    The interval is ± z √(1/9n + P²/2ν) [Bissell 1990], for normal values. One limit at least is stated.
    """
    above = np.inf if upper is None else upper - mean
    below = np.inf if lower is None else mean - lower
    value = min(above, below) / (3.0 * s)
    half = stats.norm.ppf((1 + level) / 2) * np.sqrt(1.0 / (9.0 * n) + value**2 / (2.0 * freedom))
    return Index(f"{letter}pk", float(value), float(value - half), float(value + half))
