"""The curve of a chain from what is remembered (`remembered`).

A straight feature is corrected by a straight line where that is near enough to what is expected. The contour must not
step: within `FADE_RAD` of a junction with such a neighbour the curve of an arc goes over from the neighbour's value to
what is remembered. The difference counts as uncertain there, anywhere between nothing and all of it.

The prediction of the next cut from earlier parts of the edge and today's touches, along the features of a profile.

Who knows earlier parts of the edge fills this table; the fit takes it for the error of the next cut, and today's
touches are in it already.
"""

import math
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from trueloop.arrays import Array, by_content
from trueloop.geometry.profile import Profile
from trueloop.turned.fit.between_cuts import NextCut
from trueloop.turned.fit.chain_fit import (
    Chain,
    ChainFit,
    Knots,
    TangentPolicy,
    fit_determined,
    joint_repeats,
    touches_of,
)
from trueloop.turned.fit.nose_fit import carried
from trueloop.turned.fit.prior.from_state import name_of, root_of
from trueloop.turned.fit.spline import EndConditions
from trueloop.turned.touches.error_vectors import ErrorVectors
from trueloop.wording import Um, wording

GRID_RAD: Final = math.radians(0.5)
"""Steps of the table. A nose whose form turns by 20 µm within 20° deviates from straight steps by 0.01 µm."""


@by_content
@dataclass(frozen=True)
class Remembered:
    """The errors of the next cut had nothing been corrected, at n places; positive = material left on.

    Places are by feature index and arc length, (n,), those of a feature ascending from its start to its end. `mean_mm`
    (n,) is expected, `covariance_mm2` (n, n) that of the next cut's error about it, its scatter included: nothing is to
    be added for what cuts do differently. A correction of 1 is expected to take off `gain`, so that `correct_mm` (n,)
    is what to correct by. `corrects`: False where the correction is the touches' own curve, and the table only says
    what that leaves.
    """

    feature_index: NDArray[np.intp]
    arc_length_mm: Array
    mean_mm: Array
    covariance_mm2: Array
    correct_mm: Array
    gain: float = 1.0
    corrects: bool = True

    def knows(self, chain: Chain) -> bool:
        """Returns whether it has all of a chain."""
        return set(chain.features) <= set(self.feature_index.tolist())

    def of(self, chain: Chain) -> tuple[NDArray[np.intp], Array]:
        """Returns which of the places lie on a chain, in their order along it, and arc lengths along it, (k,)."""
        rows = [np.flatnonzero(self.feature_index == i) for i in chain.features]
        s = [start + self.arc_length_mm[at] for start, at in zip(chain.starts_mm, rows, strict=True)]
        return np.concatenate(rows), np.concatenate(s)


def angles_along(profile: Profile, index: int) -> tuple[Array, Array]:
    """Returns arc lengths along a feature, its ends among them, a step of contact angle apart at most; these angles."""
    feature = profile.features[index]
    turn = feature.length_mm * abs(float(feature.curvature_per_mm(0.0)))
    s = np.linspace(0.0, feature.length_mm, max(math.ceil(turn / GRID_RAD - 1e-9), 8) + 1)
    return s, profile.contact_along_rad(index, s)


FADE_RAD: Final = math.radians(4.0)
"""The contact angle over which the curve goes over to a straight neighbour's value; at most half of the chain's."""

KNOT_RAD: Final = math.radians(1.0)
"""Knots of the curve this close follow what earlier parts tell to 0.05 µm."""


STRAIGHT_U: Final = 1.0
STRAIGHT_MM: Final = 0.0005
"""A straight feature is corrected by a straight line where that is within so many standard uncertainties of the next
cut, or within this, of what is expected: every bend makes the program longer."""


def fit_remembered(
    profile: Profile,
    vectors: ErrorVectors,
    own: ChainFit,
    remembered: Remembered,
    policy: TangentPolicy,
    *,
    straight: bool = False,
) -> ChainFit:
    """Returns the fit of one chain in the place of its `own`, or that one with the remembered errors of the next cut.

    The chain has to be one that it `knows`; `straight`: of lines, whose bow no moves can follow. The scatter of the
    touches stays that about their own curve.
    """
    chain, conditions = own.chain, own.fit.conditions
    rows, s = remembered.of(chain)
    covariance = remembered.covariance_mm2[np.ix_(rows, rows)]
    mean, u = remembered.mean_mm[rows], np.sqrt(np.diag(covariance))
    once = np.append(np.diff(s) > 0.0, True)  # a joint is sampled from both sides
    kept = np.ones((len(s), 1))
    if chain.curved:
        turned = _turned(profile, chain)
        fades = _fades(turned, conditions)
        met, correct = _met(mean, fades, conditions), _met(remembered.correct_mm[rows], fades, conditions)
        kept = np.prod(1.0 - fades, axis=0)[:, None]
        knots = Knots(_knots(chain, s, turned), chain.joints_mm, joint_repeats(policy, 3))
        degree = 3
    else:
        met, correct, conditions = mean, remembered.correct_mm[rows], EndConditions()
        degree = 1 if straight or _is_straight(s[once], correct[once], u[once]) else 3
        knots = Knots(() if degree == 1 else _evenly(chain), chain.joints_mm if degree == 3 else (), 1)
    next_cut = NextCut(s, met, np.hypot(u, (met - mean) / math.sqrt(3.0)), remembered.gain)
    if not remembered.corrects:
        return replace(own, next_cut=next_cut)
    curve, knots = fit_determined(s[once], correct[once], knots, chain.length_mm, degree, conditions)
    root = kept * root_of(covariance)
    touches = touches_of(profile, chain, vectors)
    return replace(
        own,
        fit=curve,
        residual_mm=touches.error_mm - curve.spline.of(curve.spline.value_form(touches.arc_length_mm)),
        leave_one_out_mm=np.full(len(touches.positions), np.nan),
        scattered=own.fit if own.scattered is None else own.scattered,
        knot_every=(None,) * len(chain.features),
        from_model_mm=carried(s[once], root[once], knots, curve),
        next_cut=next_cut,
        notes=(_note(profile, chain, len(touches.positions), met, next_cut.standard_u_mm),),
        unsupported=False,
    )


def _is_straight(s: Array, value: Array, u: Array) -> bool:
    """Returns whether a straight line through values along a feature is near enough to them."""
    line = np.polynomial.Polynomial.fit(s, value, 1)(s)
    return bool(np.all(np.abs(value - line) <= np.maximum(STRAIGHT_U * u, STRAIGHT_MM)))


def _evenly(chain: Chain) -> tuple[float, ...]:
    """Returns two knots within each feature of a chain."""
    ends = zip(chain.starts_mm, [*chain.joints_mm, chain.length_mm], strict=True)
    return tuple(start + (end - start) * k / 3 for start, end in ends for k in (1, 2))


def _turned(profile: Profile, chain: Chain) -> Array:
    """Returns by how much the contact angle has turned since the start of a chain, at its places, (n,)."""
    angle = np.concatenate([angles_along(profile, i)[1] for i in chain.features])
    return np.append(0.0, np.cumsum(np.abs(np.diff(angle))))


def _fades(turned: Array, conditions: EndConditions) -> Array:
    """Fades from 1 at both ends to 0 within `FADE_RAD` of contact angle, 1 − 3u² + 2u³, (2, n); 0 from a free end."""
    reach = min(FADE_RAD, 0.5 * float(turned[-1]))
    u = np.minimum(np.stack([turned, turned[-1] - turned]) / reach, 1.0)
    held = np.array([conditions.start_value_mm is not None, conditions.end_value_mm is not None])
    return np.asarray((1.0 - 3.0 * u**2 + 2.0 * u**3) * held[:, None])


def _met(values: Array, fades: Array, conditions: EndConditions) -> Array:
    """Values along the chain, (n,), that go over to those prescribed at its ends."""
    given = zip((conditions.start_value_mm, conditions.end_value_mm), values[[0, -1]].tolist(), strict=True)
    short = np.array([0.0 if value is None else value - own for value, own in given])
    return np.asarray(values + short @ fades)


def _knots(chain: Chain, s: Array, turned: Array) -> tuple[float, ...]:
    """Every `KNOT_RAD`, clear of ends and joints; two at once where the curve has gone over from a neighbour's value.

    There its second derivative steps, and a cubic spline with such a knot has the transition without loss.
    """
    whole = float(turned[-1])
    reach = min(FADE_RAD, 0.5 * whole)
    inner = np.linspace(reach, whole - reach, max(math.ceil((whole - 2.0 * reach) / KNOT_RAD), 1) + 1)
    ends = [0.5 * reach, reach, whole - reach, whole - 0.5 * reach]
    places = np.interp(np.sort([*ends, *inner]), turned, s)
    joints = np.array([*chain.starts_mm, chain.length_mm])
    return tuple(float(t) for t in places if np.min(np.abs(joints - t)) > 0.01 * chain.length_mm)


def _note(profile: Profile, chain: Chain, touches: int, mean: Array, u: Array) -> str:
    return wording(
        "{feature}: {low} to {high} by earlier parts of the edge and {n} touches of this one; standard uncertainty of "
        "the next cut up to {u}",
        feature=name_of(profile, chain),
        low=Um(float(np.min(mean))),
        high=Um(float(np.max(mean))),
        n=touches,
        u=Um(float(np.max(u))),
    )
