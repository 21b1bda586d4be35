"""Own curve or nose model: leave-one-out decides for every arc, and both figures are kept.

The own curve knows this part alone; the nose model knows the nose from other parts and takes two offsets from this one.
Many touches favour the first, few the second. The own curve's shape was already chosen by the same figure, which
flatters it: with n touches it must be better by one part in √n.
"""

import math
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from trueloop.arrays import Array
from trueloop.errors import TrueloopError
from trueloop.geometry.profile import Profile
from trueloop.statistics import rms
from trueloop.turned.fit.chain_fit import ChainFit, TangentPolicy, joint_repeats
from trueloop.turned.fit.nose_fit import NoseModel, NosePrediction, NoseTouches, nose_curve, nose_touches
from trueloop.turned.touches.error_vectors import ErrorVectors
from trueloop.wording import Um, all_of, wording

UNSEEN_RAD: Final = math.radians(6.0)
"""How much of a chain's contact angles a nose model may leave open at an end: parts are touched about 4° from the ends
of their arcs, and what lies much beyond is drawn out from no knowledge."""


@dataclass(frozen=True)
class ModelChoice:
    """Leave-one-out RMS of both models on the same touches of one curve, and which of them serves.

    `own_rms_mm` is infinite where one touch alone determines something. With too few touches to leave one out of
    the offsets, `nose_rms_mm` is the model's own standard uncertainty of a touch.
    """

    features: tuple[str, ...]
    touches: int
    own_rms_mm: float
    nose_rms_mm: float
    nose_serves: bool

    @property
    def words(self) -> str:
        """Describes the choice and its reason."""
        served = wording("nose model of other parts, with two offsets from this one")
        return wording(
            "{feature}: {served}; leave-one-out RMS over {n} touches: nose model {nose}, own curve {own}",
            feature=all_of(self.features),
            served=served if self.nose_serves else wording("own curve"),
            n=self.touches,
            nose=Um(self.nose_rms_mm, ".2f"),
            own=wording("no figure") if math.isinf(self.own_rms_mm) else Um(self.own_rms_mm, ".2f"),
        )


@dataclass(frozen=True)
class NoseOnPart:
    """A nose model, and the part's touches on arcs that it covers; `positions` are theirs in the error vectors."""

    prediction: NosePrediction
    touches: NoseTouches
    positions: NDArray[np.intp]


def nose_on_part(profile: Profile, vectors: ErrorVectors, nose: NoseModel) -> NoseOnPart:
    """Applies a nose model of other parts to this one. Raises FIT-POINTS when touches do not set the tool offsets."""
    touches = nose_touches("this part", profile, vectors)
    used = touches.on_arc & nose.covers(touches.contact_angle_rad)
    arcs = touches.subset(used)
    return NoseOnPart(nose.predict(arcs), arcs, np.flatnonzero(~vectors.at_reference)[used])


def choose(
    profile: Profile, vectors: ErrorVectors, fit: ChainFit, nose: NoseOnPart, policy: TangentPolicy
) -> tuple[ChainFit, ModelChoice]:
    """Chooses the fit of a chain of arcs, or the nose model's curve in its place where that predicts the touches
    better.

    A nose model that was never seen at some of the chain's contact angles does not serve it: it would guess there.
    """
    mine = np.isin(nose.positions, fit.touches)
    errors = _left_out(nose, mine)
    own = fit.leave_one_out_mm[np.isin(fit.touches, nose.positions[mine])]
    own_rms = float("inf") if np.any(np.isnan(own)) else rms(own)
    nose_rms = rms(errors)
    if math.isnan(nose_rms):
        u = nose.prediction.standard_deviation_mm(nose.touches.contact_angle_rad[mine])
        nose_rms = rms(np.hypot(u, nose.prediction.model.scatter_mm))
    names = tuple(profile.features[i].name for i in fit.chain.features)
    nose_serves = nose_rms < own_rms * (1.0 + 1.0 / math.sqrt(len(errors)))
    choice = ModelChoice(names, len(errors), own_rms, nose_rms, nose_serves)
    unseen_rad = _unseen_rad(profile, fit, nose.prediction.model)
    if unseen_rad > UNSEEN_RAD:
        words = wording(
            "{feature}: the nose model of other parts leaves {open:.0f}° of its contact angles open",
            feature=choice.features[0],
            open=math.degrees(unseen_rad),
        )
        return replace(fit, notes=(*fit.notes, words)), replace(choice, nose_serves=False)
    if not choice.nose_serves:
        return fit, choice
    left_out = np.full(len(fit.touches), np.nan)
    left_out[np.isin(fit.touches, nose.positions[mine])] = errors
    served = nose_curve(profile, vectors, fit, nose.prediction, joint_repeats(policy, 3))
    spare = max(len(fit.touches) - 2, 0)
    return replace(served, leave_one_out_mm=left_out, spare=spare, notes=(choice.words,)), choice


def _unseen_rad(profile: Profile, fit: ChainFit, nose: NoseModel) -> float:
    """Returns by how much contact angles of the chain lie outside the nose's fitted range, at the worse end."""
    ends = [
        float(angle)
        for i in fit.chain.features
        for angle in profile.contact_along_rad(i, [0.0, profile.features[i].length_mm])
    ]
    return max(max(ends) - nose.highest_rad, nose.lowest_rad - min(ends), 0.0)


def _left_out(nose: NoseOnPart, mine: NDArray[np.bool_]) -> Array:
    """Returns the error of predicting each touch with offsets from all the others; NaN where those do not set them."""
    errors = []
    for k in np.flatnonzero(mine):
        others = nose.touches.subset(np.arange(len(mine)) != k)
        try:
            expected = nose.prediction.model.predict(others).value_mm(nose.touches.contact_angle_rad[k])[0]
        except TrueloopError:
            expected = np.nan
        errors.append(nose.touches.error_mm[k] - expected)
    return np.array(errors)
