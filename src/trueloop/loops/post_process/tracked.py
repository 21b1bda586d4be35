"""A series with the prediction of every part before its inspection, beside the measured error.

A replay of memory's proposals for every part of a series, from the parts before it, and of the errors that would
have been left.

The error of a part had nothing been corrected is E = F + C; with the correction c that earlier parts propose it would
have been E − c. Whether all of a correction arrives cannot be seen from parts that were never corrected: the replay
takes it that it does. The first part has nothing to go by: it is left out of all sums.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from statistics import fmean, stdev
from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.domain.life import Identity
from trueloop.loops.post_process.series import MadePart, Series
from trueloop.memory.level.kalman import TURNING, LevelPrior, PartReading, Step, steps, steps_as_they_come
from trueloop.monitoring.capability import nearer_limit
from trueloop.statistics import NORMAL_95, rms

CAPABLE_FROM: Final = 20
"""Parts from which on a capability index is meaningful; below, it may be off by a factor of 1.5 and more."""


@dataclass(frozen=True)
class TrackedPart:
    """One part: its predicted error with the correction that it was cut with, the measured error, and the step that
    follows.

    `expected_mm` ± 1.96 `expected_u_mm` was to hold its error with 95 %, from earlier parts alone; None without a
    model. `alarm`: what is found beyond that cannot be chance.
    """

    made: MadePart
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
class TrackedSeries:
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
        since = max((k for k, part in enumerate(recent) if part.made.set_before), default=0)
        return next((part for part in reversed(recent[since:]) if part.alarm), None)

    @property
    def next_mm(self) -> float:
        """Returns the error to expect of the next part, mm, with the correction in force and nothing more."""
        step = self.last.step
        # The step predicts with its own correction; what is taken off less than that stays on.
        return step.predicted_mm + self.gain * (step.correction_mm - self.in_force_mm)

    @property
    def gain(self) -> float:
        """Returns the share of a correction that arrives; 1 where it is not estimated."""
        return 1.0 if self.last.step.gain is None else self.last.step.gain

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
) -> TrackedSeries:
    """Follows a series by earlier parts alone; `factors` and `in_force_mm` by series, else 1 and the last part's."""
    done = steps([made_part.reading for made_part in series.made], prior)
    parts = tuple(_parts(series.made, done))
    now_mm = (in_force_mm or {}).get(series.identity, series.made[-1].correction_mm)
    return TrackedSeries(series, parts, now_mm, (factors or {}).get(series.identity, 1.0))


def _parts(made: Sequence[MadePart], done: Sequence[Step]) -> Iterator[TrackedPart]:
    for k, (made_part, step) in enumerate(zip(made, done, strict=True)):
        expected, u = _expected(made_part, step)
        yield TrackedPart(made_part, expected, u, step, k > 0 and not made_part.set_before and alarming(step, k))


def _expected(made: MadePart, step: Step) -> tuple[float | None, float | None]:
    if step.innovation_mm is None:
        return None, None
    return made.error_mm - step.innovation_mm, step.innovation_sd_mm


def capability(series: Series) -> Capability | None:
    """Returns the capability of parts since the tool was last set; None below 20 parts, or without a limit."""
    errors, asked = [made_part.error_mm for made_part in _since_set(series.made)], series.characteristic
    lower, upper = (
        None if limit is None else limit - asked.nominal for limit in (asked.lower_limit, asked.upper_limit)
    )
    n = len(errors)
    if n < CAPABLE_FROM or (lower is None and upper is None) or stdev(errors) == 0.0:
        return None
    found = nearer_limit("P", lower, upper, fmean(errors), stdev(errors), n, n - 1.0, level=0.90)
    return None if found.value is None or found.low is None else Capability(found.value, found.low, n)


def _since_set(made: Sequence[MadePart]) -> Sequence[MadePart]:
    start = max((k for k, made_part in enumerate(made) if made_part.set_before), default=0)
    return made[start:]


def alarming(step: Step, parts: int) -> bool:
    """Returns whether an innovation has a probability below 0.001; below five parts the limit is 1.25 times as wide."""
    if step.innovation_mm is None or not step.innovation_sd_mm:
        return False
    limit = 3.29 * (1.25 if parts < 5 else 1.0)
    return abs(step.innovation_mm) > limit * step.innovation_sd_mm


@dataclass(frozen=True)
class ReplayedSeries:
    """One part: measured, had nothing been corrected, what would have been taken off, and what that would have left.

    `left_mm` was predicted as `expected_mm` ± 1.96 `expected_u_mm`. `weight` and `reason` are those after this part.
    """

    serial: str
    measured_mm: float
    uncorrected_mm: float
    correction_mm: float
    left_mm: float
    expected_mm: float
    expected_u_mm: float
    weight: float
    reason: str
    drift_mm: float | None
    alarm: bool
    set_before: bool

    @property
    def inside(self) -> bool:
        """Returns whether the error that would have been left is inside its 95 % band."""
        return abs(self.left_mm - self.expected_mm) <= NORMAL_95 * self.expected_u_mm


@dataclass(frozen=True)
class Replay:
    """A series replayed part by part; `rivals_mm` by name: what other rules would have left, (n,) each."""

    series: Series
    parts: tuple[ReplayedSeries, ...]
    rivals_mm: Mapping[str, tuple[float, ...]]

    def rms_mm(self, rule: str = "memory") -> float | None:
        """Returns the root mean square from the second part on: "memory", "measured", or a rival; None of one part."""
        if len(self.parts) < 2:
            return None
        return float(rms(np.array(self.left_mm(rule)[1:])))

    def left_mm(self, rule: str) -> tuple[float, ...]:
        """Returns the errors that a rule would have left of every part."""
        if rule == "memory":
            return tuple(part.left_mm for part in self.parts)
        if rule == "measured":
            return tuple(part.measured_mm for part in self.parts)
        return self.rivals_mm[rule]

    @property
    def inside(self) -> tuple[int, int]:
        """Returns the number of parts from the second on that are inside their bands, and of how many."""
        later = self.parts[1:]
        return sum(series.inside for series in later), len(later)


RULES: Final[Mapping[str, Callable[[Array], float]]] = {
    "mean of all parts before": lambda before: float(np.mean(before)),
    "0.75 of the part before": lambda before: 0.75 * float(before[-1]),
}
"""The rules of other shops: the correction from the uncorrected errors of the parts before, (k,). Stated beforehand."""


def replay(series: Series, prior: LevelPrior = TURNING) -> Replay:
    """Replays a series: what is proposed for a part comes from earlier parts alone."""
    proposed_mm = [0.0]

    def readings() -> Iterator[PartReading]:
        for made_part in series.made:
            c_mm = proposed_mm[-1]
            yield PartReading(
                made_part.uncorrected_mm - c_mm, c_mm, set_before=made_part.set_before, counts=made_part.counts
            )

    parts: list[ReplayedSeries] = []
    for made_part, step in zip(series.made, steps_as_they_come(readings(), prior), strict=True):
        parts.append(replayed(made_part, proposed_mm[-1], step, len(parts)))
        proposed_mm.append(step.correction_mm)
    return Replay(series, tuple(parts), rivals(series.made))


def replayed(part: MadePart, correction_mm: float, step: Step, before: int) -> ReplayedSeries:
    """Returns a part with that correction; `step` is the one after it, `before` counts the parts before."""
    left_mm = part.uncorrected_mm - correction_mm
    innovation, deviation = step.innovation_mm or 0.0, step.innovation_sd_mm or 0.0
    return ReplayedSeries(
        serial=part.serial,
        measured_mm=part.error_mm,
        uncorrected_mm=part.uncorrected_mm,
        correction_mm=correction_mm,
        left_mm=left_mm,
        expected_mm=left_mm - innovation,
        expected_u_mm=deviation,
        weight=step.weight.value,
        reason=step.weight.reason,
        drift_mm=step.drift_mm,
        alarm=before > 0 and not part.set_before and alarming(step, before),
        set_before=part.set_before,
    )


def rivals(made: Sequence[MadePart]) -> Mapping[str, tuple[float, ...]]:
    """Returns the errors that simpler rules would have left; without a part before, all of the error."""
    errors = np.array([made_part.uncorrected_mm for made_part in made])
    return {
        name: tuple(
            float(error) if k == 0 else float(error) - rule(errors[:k]) for k, error in enumerate(errors.tolist())
        )
        for name, rule in RULES.items()
    }
