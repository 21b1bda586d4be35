"""The correction of the next part, after each part of a series of one number: the weight is the Kalman gain.

The reports ask for weights of 0.50–0.75 that adjust themselves [4773 §2.5]. With a model of the series they follow
from it: the weight is what scatter, drift and the number of parts make of the Kalman gain. Two things that the model
does not know are dealt with beside it: the share of a correction that arrives is estimated, and a correction that no
inspected part has confirmed is applied with 0.75.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Final

from trueloop.memory.level.filter import (
    Levels,
    Seen,
    best_correction,
    cautious,
    learned,
    moved_on,
    predicted,
    probably_acts,
    unknown,
)
from trueloop.memory.level.step import TURNING, LevelPrior, PartReading, Step, Weight
from trueloop.wording import Signed, Um, wording

LEAST_GAIN: Final = 0.25
"""The least gain: where less of a correction arrives, by estimate, something else than what is corrected makes the
error."""
PROBABLE: Final = 0.5
"""Below this probability that corrections act as meant, none is changed."""
ALIKE: Final = 0.02
"""Weights that differ by less are called the same."""


@dataclass(frozen=True)
class _Past:
    """The state that one part passes to the next."""

    known: Levels
    largest_mm: float = 0.0
    parts: int = 0
    step: Step | None = None
    limited: bool = False


def steps(readings: Sequence[PartReading], prior: LevelPrior = TURNING) -> tuple[Step, ...]:
    """Returns one step a part, in the order in which they were cut; the last one holds the correction of the next part.

    Only parts before it and the part itself enter a step.

    >>> from trueloop.memory.level.kalman import steps
    >>> from trueloop.memory.level.step import PartReading
    >>> first, second = steps([PartReading(0.0200), PartReading(0.0070, correction_mm=0.0135)])
    >>> print(f"{1e3 * first.correction_mm:.1f} {1e3 * second.correction_mm:.1f} {second.gain:.2f}")
    13.0 20.0 0.97
    """
    return tuple(steps_as_they_come(readings, prior))


def steps_as_they_come(readings: Iterable[PartReading], prior: LevelPrior = TURNING) -> Iterator[Step]:
    """Yields each step of `steps` before the next reading is taken: a reading may depend on the step before it."""
    past = _Past(unknown(prior))
    for reading in readings:
        past = _after(past, reading, prior)
        assert past.step is not None
        yield past.step


def _after(past: _Past, reading: PartReading, prior: LevelPrior) -> _Past:
    known = moved_on(past.known, reading.parts_since, reading.set_before, prior)
    after, seen = learned(known, reading.error_mm, reading.correction_mm)
    largest, parts = past.largest_mm, past.parts
    if reading.counts:
        known, largest, parts = after, max(largest, abs(reading.correction_mm)), parts + 1
    step, limited = _step(known, seen, reading, largest, prior)
    before = None if past.step is None else past.step.weight.value
    moved = Weight(step.weight.value, before, _reason(past, reading, step, limited, parts))
    return _Past(known, largest, parts, replace(step, weight=moved), limited)


def _step(known: Levels, seen: Seen, reading: PartReading, largest_mm: float, prior: LevelPrior) -> tuple[Step, bool]:
    """Returns the step, its reason still to come, and whether the correction is limited as unconfirmed."""
    ahead = moved_on(known, 1.0, False, prior)
    whole, gain = float(best_correction(ahead)), float(known.mean(known.gain))
    allowed = float(cautious(whole, largest_mm, prior.first_share))
    held = bool(gain < LEAST_GAIN or probably_acts(known) < PROBABLE)
    correction = reading.correction_mm if held else allowed
    applied = 0.0 if held or not reading.counts else allowed / whole if whole else 1.0
    expected, variance = predicted(ahead, correction)
    step = Step(
        correction_mm=correction,
        change_mm=correction - reading.correction_mm,
        weight=Weight(float(seen.weight) * applied, None, ""),
        predicted_mm=float(known.mean(expected)),
        predicted_u_mm=float(known.total_u(expected, variance)),
        level_mm=float(known.mean(known.level)),
        level_u_mm=float(known.total_u(known.level, known.level_var)),
        scatter_mm=known.typical(known.scatter),
        drift_mm=known.typical(known.drift),
        gain=gain,
        gain_u=float(known.total_u(known.gain, known.gain_var)),
        innovation_mm=float(seen.innovation),
        innovation_sd_mm=float(seen.deviation),
        held=held,
    )
    return step, allowed != whole


def _reason(past: _Past, reading: PartReading, step: Step, limited: bool, parts: int) -> str:
    """Explains the present weight."""
    plain = _plain_reason(past, reading, step, limited, parts)
    if plain is not None:
        return plain
    assert past.step is not None and past.step.drift_mm is not None and step.drift_mm is not None
    more = step.weight.value - past.step.weight.value
    if abs(more) < ALIKE:
        return wording("as before")
    if more > 0 and past.limited:
        return wording("this part confirms the correction: it is no longer applied in part")
    if more > 0:
        drift, before = Um(step.drift_mm, ".2f"), Um(past.step.drift_mm, ".2f")
        return wording("parts drift more than was known: {drift} a part, before {before}", drift=drift, before=before)
    scatter = Um(step.scatter_mm or 0.0)
    return wording("the level is known better, from {parts} parts that scatter by {u}", parts=parts, u=scatter)


def _plain_reason(past: _Past, reading: PartReading, step: Step, limited: bool, parts: int) -> str | None:
    """Explains the weight where this needs no comparison with the weight before; else returns None."""
    if not reading.counts:
        return wording("in quarantine: nothing is learned from this part")
    if step.held:
        return wording(
            "corrections do not act as meant, by {gain} of what was corrected: none is changed until the "
            "cause is found",
            gain=Signed(step.gain or 0.0, 2),
        )
    if limited:
        return wording("no inspected part confirms a correction of this size yet: it is applied in part")
    if reading.set_before:
        return wording("the tool was set before this part: its level is learned anew")
    return wording("first part: its level was unknown") if parts == 1 else None
