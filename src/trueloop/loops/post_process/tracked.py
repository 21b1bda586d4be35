"""A series with the prediction of every part before its inspection, beside the measured error."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from statistics import fmean, stdev
from typing import Final

from trueloop.domain.life import Identity
from trueloop.loops.post_process.series import Made, Series
from trueloop.memory.level.kalman import steps
from trueloop.memory.level.step import TURNING, LevelPrior, Step
from trueloop.monitoring.capability import nearer_limit
from trueloop.statistics import NORMAL_95

CAPABLE_FROM: Final = 20
"""The number of parts from which on a capability index is meaningful; below, it may be off by a factor of 1.5 and
more."""


@dataclass(frozen=True)
class TrackedPart:
    """One part: its predicted error with the correction that it was cut with, the measured error, and the step that
    follows.

    `expected_mm` ± 1.96 `expected_u_mm` was to hold its error with 95 %, from earlier parts alone; None without a
    model. `alarm`: what is found beyond that cannot be chance.
    """

    made: Made
    expected_mm: float | None
    expected_u_mm: float | None
    step: Step
    alarm: bool

    @property
    def inside(self) -> bool | None:
        """Returns whether the error was inside the 95 % band; None where there was none."""
        if self.expected_mm is None or self.expected_u_mm is None:
            return None
        return abs(self.made.error_mm - self.expected_mm) <= NORMAL_95 * self.expected_u_mm


@dataclass(frozen=True)
class Tracked:
    """A series followed from part to part.

    `in_force_mm` is what the accepted proposals take off the next part, the last one's included that no part was cut
    with yet: proposing without it would correct twice. `factor`: which share of a change is proposed, by a decision on
    weights.
    """

    series: Series
    parts: tuple[TrackedPart, ...]
    in_force_mm: float = 0.0
    factor: float = 1.0

    @property
    def last(self) -> TrackedPart:
        """Returns the latest part. A series has one at least."""
        return self.parts[-1]

    @property
    def open_alarm(self) -> TrackedPart | None:
        """Returns a part among the last two that was alarming, since which memory was not begun anew."""
        recent = self.parts[-2:]
        since = max((k for k, one in enumerate(recent) if one.made.set_before), default=0)
        return next((one for one in reversed(recent[since:]) if one.alarm), None)

    @property
    def change_mm(self) -> float:
        """Returns what to take off more than is in force, mm; the size changes by −1 times it. 0 while held."""
        return 0.0 if self.last.step.held else self.factor * (self.last.step.correction_mm - self.in_force_mm)


@dataclass(frozen=True)
class Capability:
    """Ppk of parts that scatter normally, with its one-sided lower limit of 95 % (`monitoring.capability`)."""

    ppk: float
    lower: float
    parts: int


def tracked(
    series: Series,
    factors: Mapping[Identity, float] | None = None,
    in_force_mm: Mapping[Identity, float] | None = None,
    prior: LevelPrior = TURNING,
) -> Tracked:
    """Follows a series: every expectation is of earlier parts alone.

    `factors` and `in_force_mm` by series; one that is not named has the factor 1, and what its last part was cut with.
    """
    done = steps([one.reading for one in series.made], prior)
    parts = tuple(_parts(series.made, done))
    now_mm = (in_force_mm or {}).get(series.identity, series.made[-1].correction_mm)
    return Tracked(series, parts, now_mm, (factors or {}).get(series.identity, 1.0))


def _parts(made: Sequence[Made], done: Sequence[Step]) -> Iterator[TrackedPart]:
    for k, (one, step) in enumerate(zip(made, done, strict=True)):
        expected, u = _expected(one, step)
        yield TrackedPart(one, expected, u, step, k > 0 and not one.set_before and alarming(step, k))


def _expected(made: Made, step: Step) -> tuple[float | None, float | None]:
    if step.innovation_mm is None:
        return None, None
    return made.error_mm - step.innovation_mm, step.innovation_sd_mm


def capability(series: Series) -> Capability | None:
    """Returns the capability of parts since the tool was last set; None below 20 parts, or without a limit."""
    errors, asked = [one.error_mm for one in _since_set(series.made)], series.characteristic
    lower, upper = (
        None if limit is None else limit - asked.nominal for limit in (asked.lower_limit, asked.upper_limit)
    )
    n = len(errors)
    if n < CAPABLE_FROM or (lower is None and upper is None) or stdev(errors) == 0.0:
        return None
    found = nearer_limit("P", lower, upper, fmean(errors), stdev(errors), n, n - 1.0, level=0.90)
    return None if found.value is None or found.low is None else Capability(found.value, found.low, n)


def _since_set(made: Sequence[Made]) -> Sequence[Made]:
    start = max((k for k, one in enumerate(made) if one.set_before), default=0)
    return made[start:]


def alarming(step: Step, parts: int) -> bool:
    """Returns whether an innovation has a probability below 0.001; below five parts the limit is 1.25 times as wide."""
    if step.innovation_mm is None or not step.innovation_sd_mm:
        return False
    limit = 3.29 * (1.25 if parts < 5 else 1.0)
    return abs(step.innovation_mm) > limit * step.innovation_sd_mm
