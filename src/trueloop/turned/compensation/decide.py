"""The decision whether a tool offset is enough: per axis, by a test on the data, in words [6811 §3.2].

A constant offset (dX, dZ) explains the errors e = dX n_x + dZ n_z. Where what it leaves scatters no more than the
process repeats (one-sided F test on the variance ratio), or less than the control can resolve, the program's
coordinates stay as they are and the tool offset takes the correction.

Readings that no tool offset changes are decided on apart. An offset d displaces the surface by n·d and so changes a
reading by g·d, g = Σ weight · n over its places. Of an angle, of the radius of an arc and of a length between two faces
of one tool's cut g is 0: what they deviate by stays under any offset. Where that is more than they scatter (one-sided F
test, each by its 1/σ²), the contour is changed, as far as the error curves explain them.
"""

import math
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtrc, fdtrc, stdtrit

from trueloop.arrays import Array, by_content
from trueloop.statistics import NORMAL_95
from trueloop.turned.error_curve.fit_profile import ProfileErrorModel
from trueloop.turned.touches.error_vectors import ErrorVectors, Seen
from trueloop.turned.touches.touches import SAME_POINT_MM
from trueloop.wording import Signed, Um, all_of, listed, wording

SIGNIFICANCE: Final = 0.05
FACES_AXIS: Final = 0.05
"""A touch informs an axis when its normal has at least this component along it (3 degrees)."""

AXES: Final = ("X", "Z")
DETERMINED: Final = 3.0
"""Where touches that are all alike would leave an offset more than so many times as uncertain as one of them, their
normals do not determine it: it stays as it is. How well each touch is known has no part in that."""
AS_NORMAL: Final = 1e9
"""Degrees of freedom at which Student's distribution is the normal one, to 1e-9."""


@dataclass(frozen=True)
class AxisDecision:
    """The decision on one axis. `offset_mm` is to be added to the tool's offset, a radius on X, `expanded_u_mm` its
    expanded uncertainty (95 %); None: what was measured does not determine it. `p_value` nan: no test.
    """

    axis: str
    enough: bool
    offset_mm: float
    largest_left_mm: float
    p_value: float
    words: str
    expanded_u_mm: float | None = None


@dataclass(frozen=True)
class UnmovedDecision:
    """The decision on readings that no offset changes: `enough` where the contour stays for all that they show.

    `features` are those, by index, that the contour is changed on. `p_value` as of `AxisDecision`.
    """

    enough: bool
    features: tuple[int, ...]
    p_value: float
    words: str


@by_content
@dataclass(frozen=True)
class Decision:
    """The decision on both axes. `offset_is_enough` when neither needs a changed contour.

    The offsets of the axes are changes, against what was in force when the errors were measured; `in_force_mm` (x as a
    radius, z) is that as an offset. `by` is what the user asked for, "contour" or "offset", or "auto": what the test
    says. `unit_covariance` (2, 2) is that of the two offsets per unit variance of a touch; zero on an axis no touch
    faces. `common_covariance` (2, 2) is the same with what touches that lie close have in common; None: nothing.
    `touch_mm`: the standard deviation of the touch that is known best, whose variance is that unit.
    """

    x: AxisDecision
    z: AxisDecision
    unit_covariance: Array
    by: str = "auto"
    common_covariance: Array | None = None
    in_force_mm: tuple[float, float] = (0.0, 0.0)
    touch_mm: float = 0.0
    unmoved: UnmovedDecision | None = None
    """Of readings that no offset changes; None: there are none."""

    @property
    def words(self) -> tuple[str, ...]:
        """Returns the reasons, axis by axis, then of readings that no offset changes."""
        return (self.x.words, self.z.words, *(() if self.unmoved is None else (self.unmoved.words,)))

    @property
    def by_offset(self) -> bool:
        """Returns whether the tool offset takes the correction, and the contour stays as programmed."""
        return self.offset_is_enough if self.by == "auto" else self.by == "offset"

    @property
    def offset_is_enough(self) -> bool:
        """Returns whether neither axis nor a reading that no offset changes needs the contour changed."""
        return self.x.enough and self.z.enough and (self.unmoved is None or self.unmoved.enough)

    @property
    def offset_mm(self) -> tuple[float, float]:
        """Returns the change of the tool offset (x as a radius, z) that takes out the constant part."""
        return self.x.offset_mm, self.z.offset_mm

    @property
    def whole_offset_mm(self) -> tuple[float, float]:
        """Returns that change on top of the offset that was in force (x as a radius, z)."""
        return self.x.offset_mm + self.in_force_mm[0], self.z.offset_mm + self.in_force_mm[1]

    @property
    def expanded_u_mm(self) -> tuple[float | None, float | None]:
        """Returns the expanded uncertainty (95 %) of both (x as a radius, z); None: not determined."""
        return self.x.expanded_u_mm, self.z.expanded_u_mm

    def leverage(self, outward_normal: Array, sigma_mm: Array) -> Array:
        """Returns how the offset along normals (n, 2) follows the own error of touches with deviations (n,), (n,)."""
        weight = (self.touch_mm / np.maximum(sigma_mm, self.touch_mm)) ** 2 if self.touch_mm > 0.0 else 1.0
        return np.asarray(_along(outward_normal, self.unit_covariance) * weight)

    def variance(self, outward_normal: Array) -> Array:
        """Returns the variance of the offset along normals (n, 2), per unit variance of a touch, (n,)."""
        common = self.unit_covariance if self.common_covariance is None else self.common_covariance
        return _along(outward_normal, common)


def _along(outward_normal: Array, covariance: Array) -> Array:
    spread: Array = np.einsum("ij,jk,ik->i", outward_normal, covariance, outward_normal)
    return spread


def decide(
    process_error_mm: Array,
    outward_normal: Array,
    sigma_mm: float | Array,
    degrees_of_freedom: float,
    resolution_mm: float,
    weight: float,
    by: str = "auto",
    from_memory: bool = False,
    correlated: tuple[NDArray[np.intp], Array] | None = None,
    in_force_mm: tuple[float, float] = (0.0, 0.0),
    contour_in_force_mm: Array | None = None,
    *,
    common_u_mm: float = 0.0,
    known: bool = False,
    cuts_zero: bool = False,
    vague_mm: float = math.inf,
) -> Decision:
    """Fits one offset to all touches, each weighted by 1/σ², and tests its residuals over σ, axis by axis.

    What it leaves up to half of the control's step `resolution_mm` no contour could be written nearer to.
    `process_error_mm` (n,), `outward_normal` (n, 2); `sigma_mm`, a number or (n,), is how the process and its gauging
    repeat, with its degrees of freedom (inf when known). The offset is −weight × the fitted constants. `by` as in
    `Decision`; `from_memory`: some of the places were not touched, their errors are from earlier parts. `correlated`:
    positions (k,) of touches and the correlation (k, k) of their scatter; all others are independent. `in_force_mm` is
    the offset (x as a radius, z) in force, `contour_in_force_mm` (n,) what a contour in force moved the places by, of
    which the best offset counts.
    `common_u_mm` (standard) is what moves the next cut as a whole. `known`: all errors are expected values of the next
    cut, which do not scatter as touches do, and the contour carries the correction in any case: then an offset is
    enough where it leaves no more than the control can resolve. Errors that are zero by definition are none of these:
    they show no scatter. U of an offset holds that, what the touches scatter by, and where they deviate from any offset
    by more, that scatter: √(χ²/ν) of it (Birge). `cuts_zero`: z counts from a face that this tool cuts: an offset along
    Z moves that face as well, changes no error, and is not fitted.
    An offset is not determined, and stays, where the normals do not span its axis (`DETERMINED`), and where the touches
    leave it a standard uncertainty above `vague_mm`. What touches of that axis alone deviate by is tested all the same.
    """
    informs = np.abs(outward_normal) > FACES_AXIS
    faces = np.any(informs, axis=0) & np.array([True, not cuts_zero])
    sigma = np.broadcast_to(np.asarray(sigma_mm, float), process_error_mm.shape)
    touch_mm = float(np.min(sigma))
    weight_of = touch_mm / sigma if touch_mm > 0.0 else np.ones_like(sigma)
    weighted = outward_normal * weight_of[:, None]
    inverse = np.linalg.pinv(np.where(faces, weighted, 0.0), rcond=1e-9)
    variance = np.diag(_scattered(inverse, correlated))
    spans = np.linalg.norm(np.linalg.pinv(np.where(faces, outward_normal, 0.0), rcond=1e-9), axis=1) <= DETERMINED
    determined = spans & (touch_mm * np.linalg.norm(inverse, axis=1) <= vague_mm)
    if not np.all(determined):
        inverse = np.linalg.pinv(np.where(determined & faces, weighted, 0.0), rcond=1e-9)
    constants = inverse @ (weight_of * process_error_mm)
    left = process_error_mm - outward_normal @ constants
    alone = ~np.any(informs & determined & faces, axis=1)
    spare = int(np.count_nonzero(~alone)) - int(np.count_nonzero(determined & faces))
    off = (weight_of * left)[~alone]
    scatter_mm = max(touch_mm, float(np.sqrt(off @ off / spare)) if spare > 0 else 0.0)
    from_touches = float(stdtrit(min(degrees_of_freedom, AS_NORMAL), 0.975)) * scatter_mm * np.sqrt(variance)
    u_mm = np.hypot(from_touches, NORMAL_95 * common_u_mm)
    u_of = (float(u_mm[0]), None if cuts_zero else float(u_mm[1]))
    how = degrees_of_freedom, resolution_mm, known
    x, z = (
        _decide_axis(
            axis,
            _Test.of(left[informs[:, axis]], sigma[informs[:, axis]], int(faces[axis]), *how),
            *(0.0 - weight * constants[axis], u_of[axis], from_memory, by),
        )
        if determined[axis]
        else _undetermined(axis, float(u_mm[axis]), _Test.of(left[alone], sigma[alone], 0, *how), by)
        for axis in range(2)
    )
    z = _from_own_face(z) if cuts_zero else z
    moved = np.zeros(2) if contour_in_force_mm is None else inverse @ (weight_of * contour_in_force_mm)
    before = (in_force_mm[0] + float(moved[0]), in_force_mm[1] + float(moved[1]))
    return Decision(
        x=x,
        z=z,
        unit_covariance=inverse @ inverse.T,
        by=by,
        common_covariance=_scattered(inverse, correlated),
        in_force_mm=before,
        touch_mm=touch_mm,
    )


def _scattered(inverse: Array, correlated: tuple[NDArray[np.intp], Array] | None) -> Array:
    """Returns the covariance of both offsets per unit variance of a touch, (2, 2)."""
    total = inverse @ inverse.T
    if correlated is not None:
        own = inverse[:, correlated[0]]
        total = total + own @ (correlated[1] - np.eye(len(own.T))) @ own.T
    return np.asarray(total)


@dataclass(frozen=True)
class _Test:
    """The test of what an offset leaves at touches: `largest_mm` of it, and the probability of as much by chance."""

    touches: int
    sigma_mm: float
    largest_mm: float
    p_value: float
    enough: bool

    @classmethod
    def of(
        cls, left_mm: Array, sigma_mm: Array, fitted: int, degrees_of_freedom: float, resolution_mm: float, known: bool
    ) -> "_Test":
        """Of touches (n,) to which `fitted` constants were fitted."""
        n = len(left_mm)
        if n == 0:
            return cls(touches=0, sigma_mm=0.0, largest_mm=0.0, p_value=math.nan, enough=True)
        over, largest = max(n - fitted, 1), float(np.max(np.abs(left_mm)))
        ratio = float(np.sum((left_mm / sigma_mm) ** 2)) / over if np.all(sigma_mm > 0.0) else math.inf
        p_value = upper_tail(ratio, over, degrees_of_freedom)
        return cls(
            touches=n,
            sigma_mm=float(np.median(sigma_mm)),
            largest_mm=largest,
            p_value=p_value,
            enough=largest <= resolution_mm / 2 or (p_value > SIGNIFICANCE and not known),
        )

    def verdict(self, by: str) -> str:
        """Describes the consequence."""
        if self.enough:
            return wording("such an offset is enough")
        if self.p_value > SIGNIFICANCE:
            return wording("earlier parts tell the curve, which the contour follows")
        if by == "offset":
            return wording(
                "that is more than the process scatters by itself; the job corrects by the offset all the same"
            )
        return wording("that is more than the process scatters by itself, so the contour is changed")


def _decide_axis(
    axis: int, test: _Test, offset_mm: float, expanded_u_mm: float | None, from_memory: bool, by: str
) -> AxisDecision:
    name = AXES[axis]
    if test.touches == 0:
        words = wording("{axis}: no touch faces {axis}; it stays as it is.", axis=name)
        return AxisDecision(
            axis=name, enough=True, offset_mm=0.0, largest_left_mm=0.0, p_value=float("nan"), words=words
        )
    touches = wording("{n} touches", n=test.touches)
    words = wording(
        "{axis}: a constant offset of {offset} would leave up to {left} at {places}, where {sigma} (one standard "
        "deviation) is repeatability; {verdict} (p = {p:.2g}).",
        axis=name,
        offset=_offset_words(axis, offset_mm, expanded_u_mm),
        left=Um(test.largest_mm),
        places=wording("{n} touches and places that earlier parts tell", n=test.touches) if from_memory else touches,
        sigma=Um(test.sigma_mm),
        verdict=test.verdict(by),
        p=test.p_value,
    )
    return AxisDecision(
        axis=name,
        enough=test.enough,
        offset_mm=offset_mm,
        largest_left_mm=test.largest_mm,
        p_value=test.p_value,
        words=words,
        expanded_u_mm=expanded_u_mm,
    )


def _undetermined(axis: int, expanded_u_mm: float, test: _Test, by: str) -> AxisDecision:
    """Returns the decision on an axis along which touches determine no offset: it stays, the rest is the contour's."""
    words = wording(
        "{axis}: what was measured does not determine an offset along {axis} (± {u}); it stays as it is.",
        axis=AXES[axis],
        u=Um(expanded_u_mm),
    )
    if not test.enough:
        words = wording(
            "{words} Up to {left} remain at {places}, where {sigma} (one standard deviation) is repeatability; "
            "{verdict} (p = {p:.2g}).",
            words=words,
            left=Um(test.largest_mm),
            places=wording("{n} touches", n=test.touches),
            sigma=Um(test.sigma_mm),
            verdict=test.verdict(by),
            p=test.p_value,
        )
    return AxisDecision(
        axis=AXES[axis],
        enough=test.enough,
        offset_mm=0.0,
        largest_left_mm=test.largest_mm,
        p_value=test.p_value,
        words=words,
    )


def _from_own_face(z: AxisDecision) -> AxisDecision:
    """Returns the decision on Z where z counts from a face that the tool itself cuts; no other may face Z."""
    if math.isnan(z.p_value):
        words = wording(
            "Z: it counts from a face that the tool itself cuts; an offset along Z moves all it cuts, and stays as it "
            "is."
        )
        return replace(z, words=words)
    words = wording(
        "{words} Z counts from a face that the tool itself cuts: an offset along Z moves both, and stays as it is.",
        words=z.words,
    )
    return replace(z, words=words)


def _offset_words(axis: int, offset_mm: float, expanded_u_mm: float | None) -> object:
    """Describes the offset with its U (95 %), where it has one."""
    if expanded_u_mm is None:
        return Um(offset_mm)
    words = wording("{offset} ± {u}", offset=Um(offset_mm, "+.1f"), u=Um(expanded_u_mm))
    return wording("{x} (on the radius)", x=words) if axis == 0 else words


def upper_tail(ratio: float, over: float, under: float) -> float:
    """Returns P(F > ratio); the chi-square limit when the variance in the denominator is known."""
    return float(chdtrc(over, ratio * over)) if np.isinf(under) else float(fdtrc(over, under, ratio))


NO_GAIN: Final = 1e-6
"""The share of a reading's weights below which an offset does not change the reading."""
EXPANDED: Final = 2.0
"""Number of standard uncertainties above which a deviation is not taken for chance."""
REACHED: Final = 0.25
"""The contour is changed for a reading of which the error curves explain this share at least."""


def decide_unmoved(model: ProfileErrorModel, least_mm: float, resolution_mm: float, by: str) -> UnmovedDecision | None:
    """Returns the decision; None without such readings. `least_mm` is how a place repeats, one standard deviation;
    what deviates by no more than `resolution_mm`/2 at its places no contour could be written nearer to.
    """
    rows = unmoved(model)
    if not rows:
        return None
    off = np.array([observation.value_mm for observation in rows])
    sigma = np.array([math.hypot(observation.standard_u_mm, least_mm * _norm(observation)) for observation in rows])
    told = np.array([_told_mm(model, observation) for observation in rows])
    p_value = upper_tail(float(np.mean((off / sigma) ** 2)), len(rows), model.degrees_of_freedom or math.inf)
    resolved = np.array([0.5 * resolution_mm * _norm(observation) for observation in rows])
    beyond = np.abs(off) > np.maximum(EXPANDED * sigma, resolved)
    if p_value > SIGNIFICANCE or not beyond.any():
        words = wording(
            "{names}: no offset changes that, and it deviates by no more than it scatters (p = {p:.2g})",
            names=all_of([observation.name for observation in rows]),
            p=p_value,
        )
        return UnmovedDecision(True, (), p_value, words)
    reached = beyond & (told * off > REACHED * off**2)
    features = sorted({index for k in np.flatnonzero(reached) for index in rows[k].feature_index.tolist()})
    said = [_words(rows[k], told[k], bool(reached[k]), by) for k in np.flatnonzero(beyond)]
    return UnmovedDecision(not features, tuple(features), p_value, listed(said))


def unmoved(model: ProfileErrorModel) -> list[Seen]:
    """Returns the readings that no offset changes, but lengths whose faces are points of the fit already."""
    return [
        observation
        for observation in model.vectors.seen
        if observation.standard_u_mm > 0.0
        and _no_gain(model, observation)
        and not _is_shown(observation, model.vectors)
    ]


def _no_gain(model: ProfileErrorModel, reading: Seen) -> bool:
    pairs = zip(reading.feature_index.tolist(), reading.arc_length_mm.tolist(), strict=True)
    gain = reading.weight @ np.array([model.profile.features[index].outward_normal(s) for index, s in pairs])
    return bool(np.all(np.abs(gain) <= NO_GAIN * np.sum(np.abs(reading.weight))))


def _is_shown(reading: Seen, vectors: ErrorVectors) -> bool:
    """Returns whether every place of a reading is a point of the fit: the test of the axes weighs it there."""

    def shown(index: int, s: float) -> bool:
        same: NDArray[np.bool_] = vectors.feature_index == index
        return bool(np.any(same & (np.abs(vectors.arc_length_mm - s) < SAME_POINT_MM)))

    return all(shown(i, s) for i, s in zip(reading.feature_index.tolist(), reading.arc_length_mm.tolist(), strict=True))


def _norm(reading: Seen) -> float:
    return float(np.linalg.norm(reading.weight))


def _told_mm(model: ProfileErrorModel, reading: Seen) -> float:
    """Returns what the error curves explain of a reading's deviation."""
    pairs = zip(reading.feature_index.tolist(), reading.arc_length_mm.tolist(), strict=True)
    errors = np.array([float(model.curves[index].value_mm(s)[0]) for index, s in pairs])
    return float(reading.weight @ errors)


def _words(reading: Seen, told: float, reached: bool, by: str) -> str:
    if not reached:
        then = wording("neither does the contour: the measurements do not tell where its surfaces stand")
    elif by == "offset":
        then = wording("the job corrects by the offset all the same")
    else:
        then = wording("the contour takes out {told}", told=_size(reading, told))
    return wording(
        "{name} deviates by {off} ± {u}, which no offset changes: {then}",
        name=reading.name,
        off=_size(reading, reading.value_mm),
        u=_size(reading, EXPANDED * reading.standard_u_mm, ".1f"),
        then=then,
    )


def _size(reading: Seen, value: float, spec: str = "+.1f") -> object:
    if reading.unit == "mm":
        return Um(value, spec)
    degrees = math.degrees(value)
    return wording("{degrees}°", degrees=Signed(degrees, 3) if "+" in spec else f"{degrees:.3f}")
