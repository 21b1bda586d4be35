"""Tests of a part against the prediction of earlier parts: level, form and gain of its correction, and possible
causes. Touches that all others contradict are left out: one grain of dirt must not raise an alarm about an edge.

Innovations e ~ N(0, V) are what n places showed beyond their prediction. Those of level are H δ, H = (sin φ, cos φ):
the generalised least-squares δ explains T = δᵀ(HᵀV⁻¹H)δ of eᵀV⁻¹e, which is χ² with the rank of H; the rest is that of
shape, with what degrees of freedom are left. A correction C of which the share g arrived leaves e = (1 − g) C, as
E = F + C counts it whole.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import Final

import numpy as np
from scipy.special import chdtrc, ndtr, ndtri

from trueloop.arrays import Array, Integers
from trueloop.domain.life import Stage
from trueloop.estimate.weights import plain
from trueloop.memory.edge.predict import innovations
from trueloop.memory.made_part import MadePart
from trueloop.statistics import rms
from trueloop.wording import Signed, Um, wording


class What(StrEnum):
    """The property of a part that differs from the prediction of earlier parts."""

    LEVEL = "level"  # the whole part moved by (dX, dZ)
    SHAPE = "shape"  # what is left of it
    DRIFT = "drift"  # it changes from part to part
    GAIN = "gain"  # the share of the correction that arrived
    MEMORY_GAIN = "memory gain"  # of that part of the correction that came from memory


@dataclass(frozen=True)
class LeftOut:
    """A touch that all others contradict: its place, name, deviations from their prediction, positive = material."""

    index: int
    point: str
    deviations: float


@dataclass(frozen=True)
class Alarm:
    """One test that failed. `probability` is that of such a result by chance, `says` states what may have happened."""

    what: What
    probability: float
    says: str


@dataclass(frozen=True)
class PartChanges:
    """The changes noticed of one part. `alarms` has the likeliest first; it is empty where nothing is unusual.

    `level_mm` is (dX, dZ) by which the part's error lies beside the prediction, X a radius; `gain` the share of the
    correction that arrived, with its standard uncertainty, None without a correction. `quarantine`: nothing may be
    learned from this record until a person has looked, because what was corrected is not what was recorded.
    """

    alarms: tuple[Alarm, ...] = ()
    left_out: tuple[LeftOut, ...] = ()
    level_mm: tuple[float, float] | None = None
    gain: float | None = None
    gain_u: float | None = None
    memory_gain: float | None = None
    quarantine: bool = False
    notes: tuple[str, ...] = ()

    @property
    def own_fit(self) -> bool:
        """Returns whether today's part is to be corrected by its own touches alone."""
        return bool(self.alarms)


SLIPS: Final = (-1.0, 0.0, 0.5, 2.0)
"""Shares of a correction that a slip in the shop makes: wrong sign, not run, a radius entered
where a diameter belongs, and run twice or a diameter entered where a radius belongs."""
SLIPS_OF_MEMORY: Final = (0.0, 2.0)
NEAR: Final = 0.12
"""A gain this near to one of them is taken for it."""


def is_slip(gain: float, slips: tuple[float, ...] = SLIPS) -> bool:
    """Returns whether a slip in the shop makes such a share of a correction arrive."""
    return any(abs(gain - known) < NEAR for known in slips)


def of_level(shift: Array, before_finish: bool) -> str:
    """Describes a part with a displaced level: (dX, dZ), mm."""
    x, z = Um(shift[0], "+.1f"), Um(shift[1], "+.1f")
    if before_finish:
        return wording(
            "the part differs by {x} in X (radius) and {z} in Z from what earlier parts predict: the tool was set, an "
            "offset was entered or the work was clamped otherwise",
            x=x,
            z=z,
        )
    return wording(
        "the finished part differs by {x} in X (radius) and {z} in Z from what was predicted: an offset changed "
        "between the two cuts, or the finish cut was made otherwise",
        x=x,
        z=z,
    )


def of_shape(rest_mm: Array, before_finish: bool) -> str:
    """Describes a part whose error has another form: the remainder without its level, (n,), mm."""
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


def of_gain(gain: float) -> str:
    """Describes a correction of which another share arrived than all of it."""
    share = Signed(gain, 2)
    if abs(gain) < NEAR:
        return wording("{gain} of the correction arrived: the corrected program or offset was not run", gain=share)
    if abs(gain - 2) < NEAR:
        return wording(
            "{gain} of the correction arrived: it was applied twice, or a diameter was entered as a radius", gain=share
        )
    if abs(gain - 0.5) < NEAR:
        return wording("{gain} of the correction arrived: a radius was entered as a diameter", gain=share)
    if abs(gain + 1) < NEAR:
        return wording("{gain} of the correction arrived: it was applied with the wrong sign", gain=share)
    return wording("{gain} of the correction arrived: it was changed, or something else makes the error", gain=share)


def of_memory(gain: float) -> str:
    """Describes memory's addition to a correction of which another share arrived than all of it."""
    share = Signed(gain, 2)
    if abs(gain) < NEAR:
        return wording("{gain} of what memory added to the correction arrived: it was not applied", gain=share)
    if abs(gain - 2) < NEAR:
        return wording("{gain} of what memory added to the correction arrived: it was applied twice", gain=share)
    return wording("{gain} of what memory added to the correction arrived", gain=share)


def of_left_out(touch: LeftOut) -> str:
    """Describes a touch that the others contradict."""
    return wording(
        "touch {point} was left out: it differs by {z} standard deviations from the prediction by all others",
        point=touch.point,
        z=Signed(touch.deviations, 1),
    )


SAME_DIRECTION: Final = 1e-3
"""Share of the largest singular value below which a direction is unseen: on a cylinder, nothing along Z."""


@dataclass(frozen=True)
class White:
    """Innovations and what they are compared with, multiplied by L⁻¹, V = L Lᵀ: independent, with variance 1."""

    error: Array
    lower: Array

    @classmethod
    def of(cls, error: Array, covariance: Array) -> "White":
        """Raises `LinAlgError` where the covariance is not positive definite."""
        lower: Array = np.asarray(np.linalg.cholesky(covariance), np.float64)
        return cls(np.asarray(np.linalg.solve(lower, error), np.float64), lower)

    def seen(self, directions: Array) -> Array:
        """Columns (n, m) as the white innovations see them."""
        return np.asarray(np.linalg.solve(self.lower, directions))


def level_and_shape(white: White, contact_angle_rad: Array) -> tuple[Array, float, float]:
    """Returns (dX, dZ), mm, the shortest for that level; probabilities of level and of shape, 1 where unseen."""
    directions = white.seen(np.column_stack([np.sin(contact_angle_rad), np.cos(contact_angle_rad)]))
    u, sizes, v = np.linalg.svd(directions, full_matrices=False)
    seen = sizes > SAME_DIRECTION * sizes[0]
    along = u.T @ white.error
    level = float(np.sum(along[seen] ** 2))
    rest = float(white.error @ white.error) - level
    shift = v.T @ np.where(seen, along / np.where(seen, sizes, 1.0), 0.0)
    return shift, _chance(level, int(seen.sum())), _chance(rest, len(white.error) - int(seen.sum()))


@dataclass(frozen=True)
class Gain:
    """The share of a correction that arrived, its u; probabilities `by_chance` if all did, `rest` of what it leaves."""

    share: float
    u: float
    by_chance: float
    rest: float


def gain_of(white: White, correction_mm: Array) -> Gain:
    """Estimates the gain by regressing the innovations on the correction."""
    seen = white.seen(correction_mm)
    square, all_chi2, n = float(seen @ seen), float(white.error @ white.error), len(white.error)
    if square == 0:
        return Gain(1.0, float("inf"), 1.0, _chance(all_chi2, n))
    missing, u = float(seen @ white.error) / square, 1 / np.sqrt(square)
    rest = _chance(all_chi2 - (missing / u) ** 2, n - 1)
    return Gain(1 - missing, float(u), float(2 * ndtr(-abs(missing) / u)), rest)


def _chance(chi2: float, degrees: int) -> float:
    return float(chdtrc(degrees, max(chi2, 0.0))) if degrees else 1.0


BY_CHANCE: Final = 0.001
"""Probability below which a test raises an alarm."""
SCARCE: Final = 1.5
"""Simulated with two parts of history, standardised errors have a variance of 1.2 to 1.3; their tails, which tests look
at, are longer than that of one normal distribution.
"""
RIGHT_GAIN: Final = (0.8, 1.2)


def notice(
    error_mm: Array,
    covariance_mm2: Array,
    contact_angle_rad: Array,
    parts: int,
    correction_mm: Array | None = None,
    from_memory_mm: Array | None = None,
    points: Sequence[str] | None = None,
) -> PartChanges:
    """Returns the changes that n places of one part show against their prediction, (n,), with its covariance (n, n),
    scatter included.

    Before the finish cut these are its touches; after it, errors had nothing been corrected (E = F + C) less those
    predicted, with the correction C that they were cut with and the share of it that came from memory; positive =
    material left on, and taken off. `parts` is the number of inspected parts behind the prediction. `points` names the
    places; without, they are numbered from 1.

    Each test alarms by chance in one part of a thousand where errors are normal, seldom more where they are not, as
    touches that all others contradict are left out first: of six at most two, of many at most 15 %. What stays within
    the limits is learned, and later taken for what the edge does.
    """
    names = [str(k + 1) for k in range(len(error_mm))] if points is None else points
    covariance = np.asarray(covariance_mm2) * wider(parts)
    stay, left = kept(error_mm, covariance, names)
    if len(stay) == 0:
        return PartChanges()
    white, angle = White.of(error_mm[stay], covariance[np.ix_(stay, stay)]), contact_angle_rad[stay]
    shift, of_error = _of_error(white, error_mm[stay], angle, before_finish=correction_mm is None)
    gain = None if correction_mm is None else gain_of(white, correction_mm[stay])
    memory = None if from_memory_mm is None else gain_of(white, from_memory_mm[stay])
    found = [*of_error, *_of_gains(gain, memory)]
    raised = sorted((one for one in found if one.raised()), key=_Found.rank)
    return PartChanges(
        alarms=tuple(one.alarm for one in raised),
        left_out=left,
        level_mm=(float(shift[0]), float(shift[1])),
        gain=None if gain is None else gain.share,
        gain_u=None if gain is None else gain.u,
        memory_gain=None if memory is None else memory.share,
        quarantine=any(one.wrong_gain() for one in raised),
        notes=tuple(of_left_out(touch) for touch in left),
    )


def notice_part(history: Sequence[MadePart], part: MadePart) -> dict[Stage, PartChanges]:
    """Returns by cut how a part differs from the prediction of earlier parts of the edge, in cutting order.

    Its touches are judged by earlier parts, its finish inspection by these and by its own touches. A cut without places
    is absent, and so are all of a part before which none was inspected: what is believed beforehand is not a reason to
    call a part changed.
    """
    parts = sum(earlier.uncorrected_mm is not None for earlier in history)
    if not parts:
        return {}
    found = {}
    for innovation in innovations(history, part):
        finish = part.finish if innovation.stage is Stage.FINISH else None
        found[innovation.stage] = notice(
            innovation.error_mm,
            innovation.covariance_mm2,
            innovation.contact_angle_rad,
            parts,
            None if finish is None else innovation.correction_mm,
            None if finish is None else part.from_memory_mm,
            (part.semifinish if finish is None else finish).point,
        )
    return found


def wider(parts: int) -> float:
    """Returns the factor by which variances are enlarged: the scatter of parts is known from few of them, and taken as
    known. 2.5 with one part, 1.25 with six, 1.1 with fifteen.
    """
    return 1 + SCARCE / max(parts, 1)


@dataclass(frozen=True)
class _Found:
    """A test, with the probability of what its cause leaves unexplained."""

    alarm: Alarm
    rest: float
    gain: float | None = None

    def rank(self) -> tuple[bool, bool, bool, float]:
        """Returns the key of the order: first what explains all else, and of that a gain that an error in the shop
        makes: of the whole correction before that of memory's share, which may be nearly all of it.
        """
        of_memory = self.alarm.what is What.MEMORY_GAIN
        return self.rest < BY_CHANCE, not self.slip, of_memory, self.alarm.probability

    def raised(self) -> bool:
        """Returns whether the alarm is raised. A test of a gain that gives one near 1, or of memory's share one that no
        slip makes, has detected something else: level and shape decide whether it is unusual.
        """
        meant = self.gain is None or (self.slip if self.alarm.what is What.MEMORY_GAIN else self.wrong_gain())
        return meant and self.alarm.probability < BY_CHANCE

    @property
    def slip(self) -> bool:
        known = SLIPS_OF_MEMORY if self.alarm.what is What.MEMORY_GAIN else SLIPS
        return self.gain is not None and is_slip(self.gain, known)

    def wrong_gain(self) -> bool:
        return self.gain is not None and not RIGHT_GAIN[0] <= self.gain <= RIGHT_GAIN[1]


def _of_error(white: White, error_mm: Array, angle_rad: Array, before_finish: bool) -> tuple[Array, list[_Found]]:
    """Returns (dX, dZ), mm, and the tests of level and shape."""
    shift, by_level, by_shape = level_and_shape(white, angle_rad)
    rest_mm = error_mm - np.column_stack([np.sin(angle_rad), np.cos(angle_rad)]) @ shift
    level = Alarm(What.LEVEL, by_level, of_level(shift, before_finish))
    shape = Alarm(What.SHAPE, by_shape, of_shape(rest_mm, before_finish))
    return shift, [_Found(level, by_shape), _Found(shape, by_level)]


def _of_gains(gain: Gain | None, memory: Gain | None) -> list[_Found]:
    """Returns the tests of the share of the correction that arrived, and of that of memory's addition to it."""
    found = []
    if gain is not None:
        found.append(_Found(Alarm(What.GAIN, gain.by_chance, of_gain(gain.share)), gain.rest, gain.share))
    if memory is not None:
        alarm = Alarm(What.MEMORY_GAIN, memory.by_chance, of_memory(memory.share))
        found.append(_Found(alarm, memory.rest, memory.share))
    return found


CONTRADICTED: Final = 3.0
"""Standard deviations, of up to twenty touches."""
BY_CHANCE_ABOVE: Final = 0.027
"""With more, so that parts with many touches have no more of them left out: expected number above the limit."""
MOST: Final = 2
SHARE: Final = 0.15
"""More contradicted touches than two, or than this share of many, are not an accident. Where 2 % of touches are gross,
0.7 % of parts have three or more among twenty, and 0.06 % four.
"""
FOR_TWO, FOR_ONE = 6, 3
"""The least numbers of touches to leave out two and one: fewer do not decide which of them is wrong."""


def kept(error: Array, covariance: Array, points: Sequence[str]) -> tuple[Integers, tuple[LeftOut, ...]]:
    """Indices of the errors that stay, and those left out, the most contradicted first."""
    stay = np.arange(len(error))
    left: list[LeftOut] = []
    while len(left) < _most(len(error)):
        found = plain(covariance[np.ix_(stay, stay)], error[stay])
        z = found.left_out_mm / found.left_out_u_mm
        worst = int(np.argmax(np.abs(z)))
        # The number of standard deviations by which a touch among n has to differ: by chance one of them does so in 1
        # of 37 parts.
        if abs(z[worst]) <= max(CONTRADICTED, float(ndtri(1.0 - BY_CHANCE_ABOVE / len(stay)))):
            break
        index = int(stay[worst])
        left.append(LeftOut(index, points[index], float(z[worst])))
        stay = np.delete(stay, worst)
    return stay, tuple(left)


def _most(n: int) -> int:
    return max(MOST, int(SHARE * n)) if n >= FOR_TWO else 1 if n >= FOR_ONE else 0
