"""Whether a part is as earlier parts predict: level, form and gain of its correction, and what may have happened."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.memory.noticing.alarm import Alarm, LeftOut, Noticed, What
from trueloop.memory.noticing.left_out import kept
from trueloop.memory.noticing.tests import White, gain_of, level_and_shape
from trueloop.statistics import rms
from trueloop.units import UM_PER_MM
from trueloop.wording import Signed, Um, wording

BY_CHANCE: Final = 0.001
"""Probability below which a test raises an alarm."""
FEW_PARTS: Final = 5
WIDER: Final = 1.25
"""By which variances are taken to be larger while fewer parts than that are known: they are then too small."""
RIGHT_GAIN: Final = (0.8, 1.2)
NEAR: Final = 0.12
"""A gain this near to one that an error in the shop makes is taken for it."""


def notice(
    error_mm: Array,
    covariance_mm2: Array,
    contact_angle_rad: Array,
    parts: int,
    correction_mm: Array | None = None,
    from_memory_mm: Array | None = None,
    points: Sequence[str] | None = None,
) -> Noticed:
    """What n places of one part show beyond their prediction, (n,), with its covariance (n, n), scatter included.

    Before the finish cut these are its touches; after it, errors had nothing been corrected (E = F + C) less those
    predicted, with the correction C that they were cut with and the share of it that came from memory; positive =
    material left on, and taken off. `parts` is the number of inspected parts behind the prediction. `points` names the
    places; without, they are numbered from 1.

    Each test alarms by chance in one part of a thousand where errors are normal, seldom more where they are not, as
    touches that all others contradict are left out first, two or 15 % of them at
    most. What stays within the limits is learned, and later taken for what the edge does.
    """
    names = [str(k + 1) for k in range(len(error_mm))] if points is None else points
    covariance = np.asarray(covariance_mm2) * (WIDER if parts < FEW_PARTS else 1.0)
    stay, left = kept(error_mm, covariance, names)
    if len(stay) == 0:
        return Noticed()
    white = White.of(error_mm[stay], covariance[np.ix_(stay, stay)])
    shift, by_level, by_shape = level_and_shape(white, contact_angle_rad[stay])
    rest_mm = error_mm[stay] - np.column_stack([np.sin(contact_angle_rad), np.cos(contact_angle_rad)])[stay] @ shift
    before = correction_mm is None
    found = [
        _Found(Alarm(What.LEVEL, by_level, _of_level(shift, before)), by_shape),
        _Found(Alarm(What.SHAPE, by_shape, _of_shape(rest_mm, before)), by_level),
    ]
    gain = None if correction_mm is None else gain_of(white, correction_mm[stay])
    memory = None if from_memory_mm is None else gain_of(white, from_memory_mm[stay])
    if gain is not None:
        found.append(_Found(Alarm(What.GAIN, gain.by_chance, _of_gain(gain.share)), gain.rest, gain.share))
    if memory is not None:
        alarm = Alarm(What.MEMORY_GAIN, memory.by_chance, _of_memory(memory.share))
        found.append(_Found(alarm, memory.rest, memory.share))
    raised = sorted((one for one in found if one.alarm.probability < BY_CHANCE), key=_Found.rank)
    return Noticed(
        alarms=tuple(one.alarm for one in raised),
        left_out=left,
        level_mm=(float(shift[0]), float(shift[1])),
        gain=None if gain is None else gain.share,
        gain_u=None if gain is None else gain.u,
        memory_gain=None if memory is None else memory.share,
        quarantine=any(one.wrong_gain() for one in raised),
        notes=tuple(_of_left_out(touch) for touch in left),
    )


@dataclass(frozen=True)
class _Found:
    """A test, with the probability of what its cause leaves unexplained."""

    alarm: Alarm
    rest: float
    gain: float | None = None

    def rank(self) -> tuple[bool, bool, float]:
        """First what explains all else, and of that a gain that an error in the shop makes."""
        named = self.gain is not None and any(abs(self.gain - known) < NEAR for known in (-1.0, 0.0, 0.5, 2.0))
        return self.rest < BY_CHANCE, not named, self.alarm.probability

    def wrong_gain(self) -> bool:
        return self.gain is not None and not RIGHT_GAIN[0] <= self.gain <= RIGHT_GAIN[1]


def _of_level(shift: Array, before_finish: bool) -> str:
    x, z = Signed(shift[0] * UM_PER_MM, 1), Signed(shift[1] * UM_PER_MM, 1)
    if before_finish:
        return wording(
            "the part lies {x} µm in X (radius) and {z} µm in Z beside what earlier parts predict: the tool was set, "
            "an offset was entered or the work was clamped otherwise",
            x=x,
            z=z,
        )
    return wording(
        "the finished part lies {x} µm in X (radius) and {z} µm in Z beside what was predicted: an offset changed "
        "between the two cuts, or the finish cut was made otherwise",
        x=x,
        z=z,
    )


def _of_shape(rest_mm: Array, before_finish: bool) -> str:
    form = Um(rms(rest_mm))
    if before_finish:
        return wording(
            "the form of the error differs by {form} RMS from that of the edge: the edge was turned or changed, it "
            "chipped, or the stock is another",
            form=form,
        )
    return wording(
        "the form that the finish cut left differs by {form} RMS from what was predicted: the edge was turned or "
        "chipped between the cuts, or depth of cut or feed differ",
        form=form,
    )


def _of_gain(gain: float) -> str:
    share = Signed(gain, 2)
    if abs(gain) < NEAR:
        return wording("{gain} of the correction arrived: the corrected program or offset was not run", gain=share)
    if abs(gain - 2) < NEAR:
        return wording(
            "{gain} of the correction arrived: it was applied twice, or a radius was entered as a diameter", gain=share
        )
    if abs(gain - 0.5) < NEAR:
        return wording("{gain} of the correction arrived: a diameter was entered as a radius", gain=share)
    if abs(gain + 1) < NEAR:
        return wording("{gain} of the correction arrived: it was applied with the wrong sign", gain=share)
    return wording("{gain} of the correction arrived: it was changed, or something else makes the error", gain=share)


def _of_memory(gain: float) -> str:
    share = Signed(gain, 2)
    if abs(gain) < NEAR:
        return wording("{gain} of what memory added to the correction arrived: it was not applied", gain=share)
    if abs(gain - 2) < NEAR:
        return wording("{gain} of what memory added to the correction arrived: it was applied twice", gain=share)
    return wording("{gain} of what memory added to the correction arrived: memory is wrong of this part", gain=share)


def _of_left_out(touch: LeftOut) -> str:
    return wording(
        "touch {point} was left out: it lies {z} standard deviations beside what all others say of it",
        point=touch.point,
        z=Signed(touch.deviations, 1),
    )
