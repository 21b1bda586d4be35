"""What readings say of errors anywhere on the part: prior, touches and readings, weighed.

A reading sees a weighted sum of errors (`touches.seen`): half of a diameter's deviation is the error at its place, a
length sees the errors of two faces. Six readings fit no curves of their own. So before any of them the error at a
place is taken for what `untouched` says, and for a taper besides:

    e = dX·sin φ + dZ·cos φ + w(φ) + g(φ, feature) + (τ·(z − z₀) + τ_f·(z − z_f))·sin φ + noise,

all normal about zero. τ is the taper of the whole part about its middle z₀, τ_f one that features which join
tangentially have of their own about theirs, z_f. The readings and touches then give the conditional mean and its
covariance at any place, on features that were read and on those that were not: exact for any weighted sum, for all is
linear and normal. What deviates from the prior more than it should makes all uncertainties larger by one factor. It
stops being valid where a part bends, which is no straight taper, and where features are cut by another edge.
"""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from trueloop.arrays import Array
from trueloop.geometry.profile import Profile
from trueloop.turned.fit.prior.untouched import NOISE_MM, groups_of, prior_covariance, touched_means
from trueloop.turned.touches.error_vectors import ErrorVectors

TAPER: Final = 50e-6
"""Taper of a part, one standard deviation, radius over length: 10 µm on the diameter in 100 mm. Acceptance tests of
lathes allow 20 µm on the diameter in 300 mm when new and warm (ISO 1708, ISO 13041; from memory), 33 µm a metre; a
lathe in use that is warming up, or a tailstock set by hand, has some more."""

OWN_TAPER: Final = 30e-6
"""The same of what one feature has of its own: the edge wears and the machine gets warmer by some µm in the course of
one cut of 100 mm."""

BY_DEFINITION_MM: Final = 1e-7
"""Standard uncertainty that stands for none: what keeps the equations solvable, a thousandth of a reading's digit."""

CONTRADICTS: Final = 3.5
"""A reading that is this many standard uncertainties from what the others say of it is named: one of six does so by
chance on 3 parts in 1000."""


@dataclass(frozen=True)
class Places:
    """Places on a profile: feature and arc length; contact angle, z and n_x there; and their features' groups; (n,)."""

    feature_index: NDArray[np.intp]
    arc_length_mm: Array
    angle_rad: Array
    z_mm: Array
    group: NDArray[np.intp]

    @classmethod
    def of(cls, profile: Profile, feature_index: NDArray[np.intp], arc_length_mm: Array) -> "Places":
        """From features and arc lengths."""
        pairs = [(profile.features[int(i)], s) for i, s in zip(feature_index, arc_length_mm, strict=True)]
        z_mm = np.array([float(feature.point_mm(s)[1]) for feature, s in pairs])
        group = groups_of(profile)[feature_index]
        return cls(feature_index, arc_length_mm, profile.contact_angle_rad(feature_index, arc_length_mm), z_mm, group)


@dataclass(frozen=True)
class Known:
    """All that was seen, solved: `places` it was seen at, (n,), and `weights` (m, n) of the m observations there.

    `error_mm` (m,) are the observations, `names` theirs; `solved` (m,) and `inverse` (m, m) are C⁻¹y and C⁻¹ of their
    prior covariance C; `larger` is the factor of all variances.
    """

    profile: Profile
    places: Places
    names: tuple[str, ...]
    weights: Array
    error_mm: Array
    solved: Array
    inverse: Array
    larger: float

    def at(self, places: Places) -> "tuple[Array, Array, float]":
        """Mean (k,) and covariance (k, k) of the error at places, mm, and the largest share that is explained."""
        cross = _prior(self.profile, places, self.places) @ self.weights.T
        prior = _prior(self.profile, places, places)
        explained = cross @ self.inverse @ cross.T
        share = float(np.max(np.diag(explained) / np.diag(prior)))
        return cross @ self.solved, self.larger * (prior - explained), share

    @property
    def left_out_mm(self) -> Array:
        """Every observation less what all others say of it, (m,)."""
        return np.asarray(self.solved / np.diag(self.inverse))

    def contradicted(self) -> tuple[str, ...]:
        """The observations that the others contradict, in words; the part's own uncertainties are in it."""
        u = np.sqrt(self.larger / np.diag(self.inverse))
        found = np.flatnonzero(np.abs(self.left_out_mm) > CONTRADICTS * u)
        return tuple(
            f"{self.names[k]}: an error of {1e3 * self.error_mm[k]:+.1f} µm, where the others say "
            f"{1e3 * (self.error_mm[k] - self.left_out_mm[k]):+.1f} µm with a standard uncertainty of "
            f"{1e3 * u[k]:.1f} µm. Read it again"
            for k in found
        )


def known(profile: Profile, vectors: ErrorVectors) -> Known:
    """What touches and readings say together."""
    touches = touched_means(profile, vectors.chosen(np.flatnonzero(~vectors.by_gauge)))
    count = len(touches.feature)
    places = Places.of(
        profile,
        np.concatenate([touches.feature, *(one.feature_index for one in vectors.seen)]),
        np.concatenate([touches.arc_length_mm, *(one.arc_length_mm for one in vectors.seen)]),
    )
    weights = np.zeros((count + len(vectors.seen), len(places.z_mm)))
    weights[:count, :count] = np.eye(count)
    at = count
    for row, one in enumerate(vectors.seen, count):
        weights[row, at : at + len(one.weight)] = one.weight
        at += len(one.weight)
    error = np.concatenate([touches.error_mm, [one.value_mm for one in vectors.seen]])
    noise = np.concatenate([touches.noise_mm, [_noise_mm(one.standard_u_mm, one.weight) for one in vectors.seen]])
    prior = weights @ _prior(profile, places, places) @ weights.T
    inverse = np.asarray(np.linalg.inv(prior + np.diag(noise**2)), dtype=np.float64)
    solved = inverse @ error
    names = (*(profile.names[i] for i in touches.feature), *(one.name for one in vectors.seen))
    larger = max(1.0, float(error @ solved) / len(error))
    return Known(profile, places, names, weights, error, solved, inverse, larger)


def _noise_mm(standard_u_mm: float, weight: Array) -> float:
    """Gauging, and the scatter of the cut at each place; neither of what holds by definition."""
    if standard_u_mm == 0.0:
        return BY_DEFINITION_MM
    return math.hypot(standard_u_mm, NOISE_MM * float(np.linalg.norm(weight)))


def _prior(profile: Profile, one: Places, other: Places) -> Array:
    """Prior covariance of the errors at places (n,) and (m,), without noise, (n, m)."""
    x_share = np.sin(one.angle_rad)[:, None] * np.sin(other.angle_rad)
    ends = np.array([[f.start_mm[1], f.end_mm[1]] for f in profile.features])
    middle = 0.5 * float(np.min(ends) + np.max(ends))
    taper = TAPER**2 * np.outer(one.z_mm - middle, other.z_mm - middle)
    groups = groups_of(profile)
    own = np.array([0.5 * (ends[groups == g].min() + ends[groups == g].max()) for g in range(int(groups[-1]) + 1)])
    same = one.group[:, None] == other.group
    along = OWN_TAPER**2 * same * np.outer(one.z_mm - own[one.group], other.z_mm - own[other.group])
    base = prior_covariance(one.angle_rad, one.group, other.angle_rad, other.group)
    total: Array = base + x_share * (taper + along)
    return total
