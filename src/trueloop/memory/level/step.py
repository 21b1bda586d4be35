"""The reading of one part of a series, and the step that follows from it for the next."""

from dataclasses import dataclass
from typing import Final

from trueloop.units import UM_PER_MM


@dataclass(frozen=True)
class PartReading:
    """One part as inspected: one number.

    `error_mm` is positive where material was left on; `correction_mm` is what the corrections in force took off when
    the part was cut, all together, positive where material was taken off. Nothing corrected: 0.

    `set_before`: the tool was set, turned or changed since the part before. `parts_since` counts the parts cut since
    the one before, itself included: 2 where one was not inspected. `counts` False: a record in quarantine, from which
    nothing is learned.
    """

    error_mm: float
    correction_mm: float = 0.0
    set_before: bool = False
    parts_since: float = 1.0
    counts: bool = True


@dataclass(frozen=True)
class Weight:
    """The share of a part's innovation by which the next correction moves, and the reason for its change."""

    value: float
    before: float | None
    reason: str


@dataclass(frozen=True)
class Step:
    """The step after one part: the correction of the next. Lengths in mm.

    `correction_mm` is the whole correction to be in force, `change_mm` how much more that is than this part had. The
    sign is that of `PartReading`: positive takes material off. `level_mm` is the error had nothing been corrected,
    now, with its standard uncertainty; `gain` the share of a correction that arrives. `predicted_mm` is the error to
    expect of the next part with that correction and `predicted_u_mm` the standard deviation of what an inspection
    will find about it, its scatter included. `innovation_mm` is what this part showed beyond what was predicted for
    it, with the standard deviation that it had to be expected with.

    Values that a rule without a model has no estimate of are None.
    """

    correction_mm: float
    change_mm: float
    weight: Weight
    predicted_mm: float
    predicted_u_mm: float | None = None
    level_mm: float | None = None
    level_u_mm: float | None = None
    scatter_mm: float | None = None
    drift_mm: float | None = None
    gain: float | None = None
    gain_u: float | None = None
    innovation_mm: float | None = None
    innovation_sd_mm: float | None = None
    held: bool = False
    """The correction stays as it is: what was corrected does not act, or acts the wrong way."""


@dataclass(frozen=True)
class LevelPrior:
    """The belief of a series before its first part; lengths in mm, of the error as inspected.

    Medians of general turning: 20 µm of setting; 2.5 µm of scatter, which is 2 µm of clamping and 1.5 µm of
    measurement; 0.5 µm of drift from part to part. Scatter and drift are log-normal with a standard deviation of
    their logarithm of `log_sd`: one standard deviation is a factor of 2.7. The share of a correction that arrives is
    normal, 1 ± `gain_sd`.
    """

    setting_mm: float = 20 / UM_PER_MM
    scatter_mm: float = 2.5 / UM_PER_MM
    drift_mm: float = 0.5 / UM_PER_MM
    log_sd: float = 1.0
    gain_sd: float = 0.3
    first_share: float = 0.75
    """The share of a correction that is applied while no inspected part has confirmed it."""


TURNING: Final = LevelPrior()
