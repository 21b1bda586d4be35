"""The curve of a chain from what is remembered (`remembered`).

A straight feature is corrected by a straight line where that is near enough to what is expected. The contour must not
step: within `FADE_RAD` of a junction with such a neighbour the curve of an arc goes over from the neighbour's value to
what is remembered. The difference counts as uncertain there, anywhere between nothing and all of it.
"""

import math
from dataclasses import replace
from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.geometry.profile import Profile
from trueloop.turned.fit.between_cuts import NextCut
from trueloop.turned.fit.chain import Chain, TangentPolicy
from trueloop.turned.fit.chain_fit import ChainFit, touches_of
from trueloop.turned.fit.knots import Knots, fit_determined, joint_repeats
from trueloop.turned.fit.nose_curve import carried
from trueloop.turned.fit.prior.from_state import name_of, root_of
from trueloop.turned.fit.prior.remembered import Remembered, angles_along
from trueloop.turned.fit.spline import EndConditions
from trueloop.turned.touches.error_vectors import ErrorVectors
from trueloop.wording import Um, wording

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
    """Fades from 1 at start and end to 0 within `FADE_RAD` of contact angle, 1 − 3u² + 2u³, (2, n); 0 from a free
    end.
    """
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
