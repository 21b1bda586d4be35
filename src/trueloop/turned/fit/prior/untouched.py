"""The expected error at a contact angle that was not touched on the feature in question: prior and touches, weighed.

Before any touch the error of a part, along the normal at contact angle φ of a feature, is taken for

    e = dX·sin φ + dZ·cos φ + w(φ) + g(φ, feature) + noise,

all normal about zero: the setting of the tool (dX, dZ), the form of its nose w, and what each feature has of its own, g
(features that join tangentially share it). w and g at two contact angles are the less alike the further these are
apart: Matérn's correlation of order 3/2, (1 + √3 d) exp(−√3 d), d = |φ − φ′| in units of `ALIKE_RAD`. What the touches
then say of another feature is the conditional mean of that, and its uncertainty grows with the distance from the
touched angles by itself. Diameters alone say most of a cone's error (dX·sin φ), and nothing of a face's.

The prior sizes are stated below. Touches that are larger than all of them together make all of them larger by one
factor, so that a large error elsewhere is never taken for a small uncertainty here. It stops being valid where features
are cut by another edge, or where part or machine bend: g is one figure for that.
"""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from trueloop.arrays import Array
from trueloop.geometry.feature import is_curved
from trueloop.geometry.profile import JunctionKind, Profile
from trueloop.turned.touches.error_vectors import ErrorVectors

SETTING_MM: Final = 0.020
"""Tool setting on either axis, one standard deviation: between a touched-off tool and one measured on a presetter."""

NOSE_MM: Final = 0.020
"""Form of the nose: the tolerance of an insert's radius and the wear of its edge."""

ALIKE_RAD: Final = math.radians(20.0)
"""Contact angles this far apart have half of the nose's form in common: 0.28 mm of a 0.8 mm radius."""

BETWEEN_FEATURES_MM: Final = 0.016
"""How far the cones of [6811 Tables 8, 10] deviate from what the same nose did on the domes, RMS over the ten parts (11
to 17 µm on nine, 30 µm on one whose taper looks falsified): the prior spread between features."""

NOISE_MM: Final = 0.0015
"""Scatter of one touch about all this, by process and probe."""

TOGETHER_RAD: Final = math.radians(1.0)
"""Touches of an arc this close count as one: the form of the nose differs by 1 µm within it."""

SUPPORTED: Final = 0.1
"""A feature of whose variance the touches explain less than this stays as programmed: nothing is known of it."""


@dataclass(frozen=True)
class Expected:
    """Errors at n contact angles of one feature, mm: mean (n,) and covariance (n, n).

    `explained` is the share of the prior variance that the touches took away, at best over the angles;
    `offsets_mm` (dX, dZ) the setting that they speak for; `nearest_rad` how far the nearest touched angle is.
    """

    mean_mm: Array
    covariance_mm2: Array
    explained: float
    offsets_mm: tuple[float, float]
    nearest_rad: float

    @property
    def supported(self) -> bool:
        """Returns whether the touches determine enough to move the feature."""
        return self.explained >= SUPPORTED


def expect(profile: Profile, vectors: ErrorVectors, angle_rad: Array, feature: int) -> Expected:
    """Predicts the errors of a feature, by index, at contact angles (n,), from the touches."""
    seen = touched_means(profile, vectors)
    groups = groups_of(profile)
    own = prior_covariance(seen.angle_rad, groups[seen.feature], seen.angle_rad, groups[seen.feature])
    total = own + np.diag(seen.noise_mm**2)
    here = np.full(len(angle_rad), groups[feature])
    cross = prior_covariance(angle_rad, here, seen.angle_rad, groups[seen.feature])
    prior = prior_covariance(angle_rad, here, angle_rad, here)
    solved = np.linalg.solve(total, np.column_stack([seen.error_mm, cross.T]))
    weights, explained = solved[:, 0], cross @ solved[:, 1:]
    larger = max(1.0, float(seen.error_mm @ weights) / len(seen.error_mm))
    terms = np.column_stack([np.sin(seen.angle_rad), np.cos(seen.angle_rad)])
    dx, dz = SETTING_MM**2 * terms.T @ weights
    return Expected(
        mean_mm=cross @ weights,
        covariance_mm2=larger * (prior - explained),
        explained=float(np.max(np.diag(explained) / np.diag(prior))),
        offsets_mm=(float(dx), float(dz)),
        nearest_rad=float(np.min(np.abs(angle_rad[:, None] - seen.angle_rad))),
    )


@dataclass(frozen=True)
class TouchedMeans:
    """The means of touches of each line, and of each arc within `TOGETHER_RAD`; all (n,).

    A scan of thousands of points thus stays a matter of some hundred numbers.
    """

    feature: NDArray[np.intp]
    arc_length_mm: Array
    angle_rad: Array
    error_mm: Array
    noise_mm: Array


def touched_means(profile: Profile, vectors: ErrorVectors) -> TouchedMeans:
    """Returns the means of all touches; empty without any."""
    rows: list[tuple[int, float, float, float, float]] = []
    angle = profile.contact_angle_rad(vectors.feature_index, vectors.arc_length_mm)
    noise = np.hypot(vectors.standard_u_mm, NOISE_MM)
    for feature in np.unique(vectors.feature_index).tolist():
        mine = vectors.of_feature(feature)
        degree = np.floor(angle[mine] / TOGETHER_RAD) * is_curved(profile.features[feature])
        for part in (mine[degree == one] for one in np.unique(degree)):
            of_mean = float(np.sqrt(np.mean(noise[part] ** 2) / len(part)))
            means = (float(np.mean(of[part])) for of in (vectors.arc_length_mm, angle, vectors.error_mm))
            rows.append((feature, *means, of_mean))
    feature_index, *columns = np.array(rows).reshape(-1, 5).T
    return TouchedMeans(feature_index.astype(np.intp), *columns)


def groups_of(profile: Profile) -> NDArray[np.intp]:
    """Returns a number for every feature, one for all those that join tangentially."""
    steps = [junction.kind is not JunctionKind.TANGENT for junction in profile.junctions]
    return np.concatenate([[0], np.cumsum(steps)]).astype(np.intp)


def prior_covariance(angle_rad: Array, group: NDArray[np.intp], other_rad: Array, other: NDArray[np.intp]) -> Array:
    """Returns the prior covariance of errors at contact angles (n,) and (m,), without noise, (n, m)."""
    apart = np.abs(angle_rad[:, None] - other_rad)
    d = math.sqrt(3.0) * apart / ALIKE_RAD
    alike = (1.0 + d) * np.exp(-d)
    same = group[:, None] == other
    total: Array = SETTING_MM**2 * np.cos(apart) + (NOSE_MM**2 + BETWEEN_FEATURES_MM**2 * same) * alike
    return total
