"""Readings that no tool offset changes, in the decision between offset and contour.

An offset d displaces the surface by n·d and so changes a reading by g·d, g = Σ weight · n over its places. Of an angle,
of the radius of an arc and of a length between two faces of one tool's cut g is 0: what they deviate by stays under any
offset. Where that is more than they scatter (one-sided F test, each by its 1/σ²), the contour is changed, as far as the
error curves explain them.
"""

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

from trueloop.turned.compensation.decide import SIGNIFICANCE, UnmovedDecision, upper_tail
from trueloop.turned.error_curve.fit_profile import ProfileErrorModel
from trueloop.turned.touches.error_vectors import ErrorVectors, Seen
from trueloop.turned.touches.plausibility import SAME_POINT_MM
from trueloop.wording import Signed, Um, all_of, listed, wording

NO_GAIN: Final = 1e-6
"""Of the sum of a reading's weights: an offset changes the reading by less than this share."""
EXPANDED: Final = 2.0
"""A deviation of so many standard uncertainties is none by chance."""
REACHED: Final = 0.25
"""The contour is changed for a reading of which the error curves explain this share at least."""


def decide_unmoved(model: ProfileErrorModel, least_mm: float, resolution_mm: float, by: str) -> UnmovedDecision | None:
    """Returns the decision; None without such readings. `least_mm` is how a place repeats, one standard deviation;
    what deviates by no more than `resolution_mm`/2 at its places no contour could be written nearer to.
    """
    rows = unmoved(model)
    if not rows:
        return None
    off = np.array([one.value_mm for one in rows])
    sigma = np.array([math.hypot(one.standard_u_mm, least_mm * _norm(one)) for one in rows])
    told = np.array([_told_mm(model, one) for one in rows])
    p_value = upper_tail(float(np.mean((off / sigma) ** 2)), len(rows), model.degrees_of_freedom or math.inf)
    resolved = np.array([0.5 * resolution_mm * _norm(one) for one in rows])
    beyond = np.abs(off) > np.maximum(EXPANDED * sigma, resolved)
    if p_value > SIGNIFICANCE or not beyond.any():
        words = wording(
            "{names}: no offset changes that, and it deviates by no more than it scatters (p = {p:.2g})",
            names=all_of([one.name for one in rows]),
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
        one
        for one in model.vectors.seen
        if one.standard_u_mm > 0.0 and _no_gain(model, one) and not _is_shown(one, model.vectors)
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
