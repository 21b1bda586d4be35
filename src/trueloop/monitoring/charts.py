"""Control charts of one characteristic, or of what a correction left: individuals, EWMA, CUSUM, Nelson's tests.

Limits come from a baseline: values taken while nothing was wrong, or what is known of the process. Designs by default
have about 370 values between false alarms, as a Shewhart chart has at 3 σ.

Nelson's eight tests for special causes [L. S. Nelson, Journal of Quality Technology 16 (1984) 237].

Each marks the value at which its pattern is complete. Values are in standard deviations about the centre.

The statistics that charts plot, from values in units of their standard deviation about their centre.

All functions work along the last axis, so that many series are charted at once, as in simulations of run lengths.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from trueloop.arrays import Array, Flags, by_content
from trueloop.errors import Code
from trueloop.wording import wording


@dataclass(frozen=True)
class Rule:
    """One test: its number, its finding in words, and the function that marks where it holds."""

    number: int
    meaning: str
    marks: Callable[[Array], Flags]


def beyond(z: Array) -> Flags:
    """Marks one value more than 3 σ from the centre."""
    return np.abs(z) > 3.0


def one_side(z: Array) -> Flags:
    """Marks nine in a row on one side of the centre."""
    return _in_a_row(z > 0.0, 9) | _in_a_row(z < 0.0, 9)


def trend(z: Array) -> Flags:
    """Marks six in a row that rise, or fall, steadily: five steps of one sign."""
    step = _steps(z)
    return _in_a_row(step > 0.0, 5) | _in_a_row(step < 0.0, 5)


def alternating(z: Array) -> Flags:
    """Marks fourteen in a row up and down in turn: thirteen steps, each against the one before."""
    step = np.sign(_steps(z))
    turned = np.zeros(z.shape, dtype=bool)
    turned[..., 2:] = step[..., 2:] * step[..., 1:-1] < 0.0
    return _in_a_row(turned, 12)


def two_of_three(z: Array) -> Flags:
    """Marks two of three in a row more than 2 σ off, on one side."""
    return _so_many(z > 2.0, 2, 3) | _so_many(z < -2.0, 2, 3)


def four_of_five(z: Array) -> Flags:
    """Marks four of five in a row more than 1 σ off, on one side."""
    return _so_many(z > 1.0, 4, 5) | _so_many(z < -1.0, 4, 5)


def hugging(z: Array) -> Flags:
    """Marks fifteen in a row within 1 σ of the centre, on either side."""
    return _in_a_row(np.abs(z) < 1.0, 15)


def avoiding(z: Array) -> Flags:
    """Marks eight in a row more than 1 σ off, on either side."""
    return _in_a_row(np.abs(z) > 1.0, 8)


RULES: Final = (
    Rule(1, wording("one value beyond 3 σ"), beyond),
    Rule(2, wording("nine in a row on one side"), one_side),
    Rule(3, wording("six in a row rising or falling"), trend),
    Rule(4, wording("fourteen in a row up and down in turn"), alternating),
    Rule(5, wording("two of three beyond 2 σ on one side"), two_of_three),
    Rule(6, wording("four of five beyond 1 σ on one side"), four_of_five),
    Rule(7, wording("fifteen in a row within 1 σ"), hugging),
    Rule(8, wording("eight in a row beyond 1 σ on either side"), avoiding),
)


def _steps(z: Array) -> Array:
    """Returns the step from each value's predecessor to it; 0 at the first."""
    return np.diff(z, axis=-1, prepend=z[..., :1])


def _in_a_row(holds: Flags, count: int) -> Flags:
    return _so_many(holds, count, count)


def _so_many(holds: Flags, least: int, among: int) -> Flags:
    """Marks where it holds now, and `least` times at least among the last `among`, fewer at the beginning."""
    padding = np.zeros((*holds.shape[:-1], among - 1), dtype=bool)
    windows = sliding_window_view(np.concatenate([padding, holds], axis=-1), among, axis=-1)
    marked: Flags = holds & (windows.sum(axis=-1) >= least)
    return marked


D2: Final = float(2.0 / np.sqrt(np.pi))
"""Mean range of two values of standard deviation 1, 1.128 [ISO 7870-2, d2 for n = 2]."""
D3: Final = float(np.sqrt(2.0 - 4.0 / np.pi))
"""Standard deviation of that range, 0.853 [ISO 7870-2, d3 for n = 2]."""
FEWEST: Final = 8
"""Below this many values a standard deviation is off by more than a quarter, and limits mean little."""
SHEWHART: Final = 3.0
MOVING_RANGE: Final = "moving range"
EWMA_WEIGHT, EWMA_WIDTH = 0.2, 2.859
"""370 values between false alarms at weight 0.2, limits from the first value on."""
CUSUM_ALLOWANCE, CUSUM_INTERVAL = 0.5, 4.774
"""370 values between false alarms; most sensitive to a shift of 1 σ."""


@dataclass(frozen=True)
class Baseline:
    """Centre and short-term standard deviation of a series in control, and from how many values they come."""

    centre: float
    sigma: float
    count: int


@dataclass(frozen=True)
class Alarm:
    """One alarm of a chart at one value: its place, the chart, and the rule in words."""

    index: int
    chart: str
    meaning: str


@by_content
@dataclass(frozen=True)
class Chart:
    """The plotted values, (n,), with their limits, in the unit of the values, and the places where they are beyond."""

    name: str
    plotted: Array
    centre: float
    low: Array
    high: Array
    alarms: tuple[Alarm, ...]


def baseline(values: Sequence[float] | Array) -> Baseline:
    """Estimates centre and σ from values in control: their mean, and their mean moving range over d2.

    The moving range does not see a slow drift, so that the drift shows. Raises MON-FEW for fewer than eight values, and
    for values that are all equal.
    """
    given = np.asarray(values, dtype=np.float64)
    sigma = float(ranges(given).mean() / D2) if len(given) > 1 else 0.0
    if len(given) < FEWEST or sigma == 0.0:
        raise Code.MON_FEW.refusal(
            f"{len(given)} values with a mean moving range of {sigma * D2:g} say no standard deviation",
            hint=f"chart {FEWEST} values that differ at least, or give centre and sigma",
            values={"count": len(given)},
        )
    return Baseline(float(given.mean()), sigma, len(given))


def individuals(values: Array, base: Baseline, rules: Sequence[Rule] = RULES[:1]) -> Chart:
    """Charts single values after Shewhart [ISO 7870-2], ± 3 σ, with the requested ones of Nelson's tests."""
    z = _z(values, base)
    found = [Alarm(int(k), "individuals", rule.meaning) for rule in rules for k in np.flatnonzero(rule.marks(z))]
    half = np.full(len(values), SHEWHART * base.sigma)
    return _chart("individuals", values, base.centre, half, found)


def moving_range(values: Array, base: Baseline) -> Chart:
    """Charts the moving range of two [ISO 7870-2]: the difference of one value from the one before, up to D4 = 3.267
    mean ranges. The first value has none: nan. An alarm repeats that of the individuals at one outlier.
    """
    moved = np.concatenate([[np.nan], ranges(np.asarray(values, dtype=np.float64))])[: len(values)]
    centre, high = D2 * base.sigma, (D2 + SHEWHART * D3) * base.sigma
    found = _beyond(MOVING_RANGE, moved > high, wording("differs from the value before by more than 3.7 σ"))
    return Chart(
        name=MOVING_RANGE,
        plotted=moved,
        centre=centre,
        low=np.zeros(len(values)),
        high=np.full(len(values), high),
        alarms=tuple(found),
    )


def ewma(values: Array, base: Baseline, weight: float = EWMA_WEIGHT, width: float = EWMA_WIDTH) -> Chart:
    """Charts the weighted average of all values so far [ISO 7870-6]; limits follow its own standard deviation."""
    z = moving_average(_z(values, base), weight)
    sigma = ewma_sigma(weight, len(values))
    said = wording("the weighted average is beyond {width} of its σ", width=f"{width:g}")
    found = _beyond("EWMA", np.abs(z) > width * sigma, said)
    return _chart("EWMA", base.centre + base.sigma * z, base.centre, width * base.sigma * sigma, found)


def cusum(
    values: Array, base: Baseline, allowance: float = CUSUM_ALLOWANCE, interval: float = CUSUM_INTERVAL
) -> tuple[Chart, Chart]:
    """Sums of what exceeds `allowance` σ above and below [ISO 7870-4], upwards from 0; alarms beyond `interval` σ."""
    up, down = cusum_sums(_z(values, base), allowance)
    half = np.full(len(values), interval * base.sigma)
    parts = (
        ("CUSUM upwards", up, wording("the values have been above the centre for long")),
        ("CUSUM downwards", down, wording("the values have been below the centre for long")),
    )
    charts = [_chart(name, base.sigma * s, 0.0, half, _beyond(name, s > interval, said)) for name, s, said in parts]
    return charts[0], charts[1]


def _z(values: Array, base: Baseline) -> Array:
    return (np.asarray(values, dtype=np.float64) - base.centre) / base.sigma


def _beyond(chart: str, where: Flags, meaning: str) -> list[Alarm]:
    return [Alarm(int(k), chart, meaning) for k in np.flatnonzero(where)]


def _chart(name: str, values: Array, centre: float, half: Array, alarms: Sequence[Alarm]) -> Chart:
    ordered = tuple(sorted(alarms, key=lambda alarm: alarm.index))
    return Chart(
        name=name,
        plotted=np.asarray(values, dtype=np.float64),
        centre=centre,
        low=centre - half,
        high=centre + half,
        alarms=ordered,
    )


FAST_START: Final = 0.0
"""The start of both sums of a CUSUM: at zero, without head start."""


def ranges(z: Array) -> Array:
    """Differences of neighbours without sign, one fewer than values."""
    return np.abs(np.diff(z, axis=-1))


def moving_average(z: Array, weight: float) -> Array:
    """Returns the exponentially weighted average from the centre: y = (1 − weight)·y + weight·z [Roberts 1959]."""
    from scipy.signal import lfilter

    filtered: Array = lfilter([weight], [1.0, weight - 1.0], z, axis=-1)
    return filtered


def ewma_sigma(weight: float, count: int) -> Array:
    """Returns the standard deviation of that average at the first `count` values, for deviation 1, (count,)."""
    k = np.arange(1, count + 1)
    sigma: Array = np.sqrt(weight / (2.0 - weight) * (1.0 - (1.0 - weight) ** (2 * k)))
    return sigma


def cusum_sums(z: Array, allowance: float) -> tuple[Array, Array]:
    """Returns the sums of a tabular CUSUM, upwards and downwards, ≥ 0 [Page 1954]: S = max(0, S ± z − allowance)."""
    up, down = np.zeros_like(z), np.zeros_like(z)
    above = below = np.full(z.shape[:-1], FAST_START)
    for k in range(z.shape[-1]):
        above = np.maximum(0.0, above + z[..., k] - allowance)
        below = np.maximum(0.0, below - z[..., k] - allowance)
        up[..., k], down[..., k] = above, below
    return up, down
