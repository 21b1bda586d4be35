"""A replay of memory's proposals for every part of a series, from the parts before it, and of the errors that would
have been left.

The error of a part had nothing been corrected is E = F + C; with the correction c that earlier parts propose it would
have been E − c. Whether all of a correction arrives cannot be seen from parts that were never corrected: the replay
takes it that it does. The first part has nothing to go by: it is left out of all sums.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.loops.post_process.series import Made, Series
from trueloop.loops.post_process.tracked import alarming
from trueloop.memory.level.kalman import steps_as_they_come
from trueloop.memory.level.step import TURNING, LevelPrior, PartReading, Step
from trueloop.statistics import NORMAL_95, rms


@dataclass(frozen=True)
class Replayed:
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
    parts: tuple[Replayed, ...]
    rivals_mm: Mapping[str, tuple[float, ...]]

    def rms_mm(self, rule: str = "memory") -> float | None:
        """Returns the root mean square from the second part on: "memory", "measured", or a rival; None of one part."""
        if len(self.parts) < 2:
            return None
        return float(rms(np.array(self.left_mm(rule)[1:])))

    def left_mm(self, rule: str) -> tuple[float, ...]:
        """Returns the errors that a rule would have left of every part."""
        if rule == "memory":
            return tuple(one.left_mm for one in self.parts)
        if rule == "measured":
            return tuple(one.measured_mm for one in self.parts)
        return self.rivals_mm[rule]

    @property
    def inside(self) -> tuple[int, int]:
        """Returns the number of parts from the second on that are inside their bands, and of how many."""
        later = self.parts[1:]
        return sum(one.inside for one in later), len(later)


RULES: Final[Mapping[str, Callable[[Array], float]]] = {
    "mean of all parts before": lambda before: float(np.mean(before)),
    "0.75 of the part before": lambda before: 0.75 * float(before[-1]),
}
"""The rules of other shops: the correction from the uncorrected errors of the parts before, (k,). Stated beforehand."""


def replay(series: Series, prior: LevelPrior = TURNING) -> Replay:
    """Replays a series: what is proposed for a part comes from earlier parts alone."""
    proposed_mm = [0.0]

    def readings() -> Iterator[PartReading]:
        for one in series.made:
            c_mm = proposed_mm[-1]
            yield PartReading(one.uncorrected_mm - c_mm, c_mm, set_before=one.set_before, counts=one.counts)

    parts: list[Replayed] = []
    for one, step in zip(series.made, steps_as_they_come(readings(), prior), strict=True):
        parts.append(replayed(one, proposed_mm[-1], step, len(parts)))
        proposed_mm.append(step.correction_mm)
    return Replay(series, tuple(parts), rivals(series.made))


def replayed(one: Made, correction_mm: float, step: Step, before: int) -> Replayed:
    """Returns a part with that correction; `step` is the one after it, `before` counts the parts before."""
    left_mm = one.uncorrected_mm - correction_mm
    innovation, deviation = step.innovation_mm or 0.0, step.innovation_sd_mm or 0.0
    return Replayed(
        *(one.serial, one.error_mm, one.uncorrected_mm, correction_mm, left_mm),
        *(left_mm - innovation, deviation, step.weight.value, step.weight.reason, step.drift_mm),
        alarm=before > 0 and not one.set_before and alarming(step, before),
        set_before=one.set_before,
    )


def rivals(made: Sequence[Made]) -> Mapping[str, tuple[float, ...]]:
    """Returns the errors that simpler rules would have left; without a part before, all of the error."""
    errors = np.array([one.uncorrected_mm for one in made])
    return {
        name: tuple(
            float(error) if k == 0 else float(error) - rule(errors[:k]) for k, error in enumerate(errors.tolist())
        )
        for name, rule in RULES.items()
    }
