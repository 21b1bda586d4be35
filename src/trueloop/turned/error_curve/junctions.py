"""The junctions of displaced features: the displacement d of each.

Each curve displaces its feature along the normal; the displaced curves meet in the nominal junction plus d, with
`n₁·d = e₁(end)` and `n₂·d = e₂(start)`. At a tangent junction both say the same and d has no tangential part. At the
two ends of the profile a straight cut perpendicular to the end feature and without error stands in [6811 §3.4].

The tangency of the next part at its tangent junctions.

The error of the uncorrected process has a kink at a tangent junction, because the nose errs as a function of contact
angle. Under the policy PART the path takes the opposite kink and the part is tangent up to the uncertainty of that
kink; under PATH the path has none and the kink stays on the part.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.geometry.feature import Point
from trueloop.geometry.profile import JunctionKind, Profile
from trueloop.turned.error_curve.curve import ErrorCurve
from trueloop.turned.error_curve.uncertainty import FittedChains
from trueloop.turned.fit.chain_fit import TangentPolicy
from trueloop.units import UM_PER_MM
from trueloop.wording import Um, wording

LARGEST_SHIFT: Final = 0.1
"""A meeting point that moves along a feature by more than this share of its length is not a meeting point: at a corner
of a fraction of a degree any difference of the two errors would throw it far off."""


@dataclass(frozen=True)
class DisplacedJunction:
    """A junction of the profile and where the error curves put it; lengths in mm.

    `before`, `after`: feature indices, None at the ends of the profile. `displacement_mm` is d = (dx, dz), its
    tangential parts are along the direction of travel of either feature. `gap_mm` is what the two displaced curves
    miss each other by: zero except at a corner too flat to solve. `kind` is None at the ends of the profile.
    """

    before: int | None
    after: int | None
    kind: JunctionKind | None
    nominal_mm: Point
    error_before_mm: float | None
    error_after_mm: float | None
    displacement_mm: Point
    standard_u_mm: Point
    tangential_before_mm: float | None
    tangential_after_mm: float | None
    gap_mm: float
    note: str


def displaced_junctions(profile: Profile, curves: tuple[ErrorCurve, ...]) -> tuple[DisplacedJunction, ...]:
    """Returns the junction table: start of the profile, every junction in order, end of the profile."""
    last = len(profile.features) - 1
    inner = [_junction(profile, curves, i) for i in range(last)]
    return (_profile_end(profile, curves, 0, False), *inner, _profile_end(profile, curves, last, True))


def _profile_end(profile: Profile, curves: tuple[ErrorCurve, ...], index: int, at_end: bool) -> DisplacedJunction:
    feature = profile.features[index]
    s = feature.length_mm if at_end else 0.0
    normal = feature.outward_normal(s)
    error, u = float(curves[index].value_mm(s)[0]), float(curves[index].standard_deviation_mm(s)[0])
    return DisplacedJunction(
        before=index if at_end else None,
        after=None if at_end else index,
        kind=None,
        nominal_mm=_point(feature.point_mm(s)),
        error_before_mm=error if at_end else None,
        error_after_mm=None if at_end else error,
        displacement_mm=_point(error * normal),
        standard_u_mm=_point(u * np.abs(normal)),
        tangential_before_mm=0.0 if at_end else None,
        tangential_after_mm=None if at_end else 0.0,
        gap_mm=0.0,
        note=wording("end of the profile: displaced along the normal"),
    )


def _junction(profile: Profile, curves: tuple[ErrorCurve, ...], index: int) -> DisplacedJunction:
    before, after = profile.features[index], profile.features[index + 1]
    length = before.length_mm
    normals = np.stack([before.outward_normal(length), after.outward_normal(0.0)])
    errors = np.array([curves[index].value_mm(length)[0], curves[index + 1].value_mm(0.0)[0]])
    u = np.array([curves[index].standard_deviation_mm(length)[0], curves[index + 1].standard_deviation_mm(0.0)[0]])
    tangents = np.stack([before.tangent(length), after.tangent(0.0)])
    kind = profile.junctions[index].kind
    inverse, note = _meeting(kind, normals, tangents, errors, min(length, after.length_mm))
    d = inverse @ errors
    shift = tangents @ d if kind == JunctionKind.CORNER else np.zeros(2)
    return DisplacedJunction(
        before=index,
        after=index + 1,
        kind=kind,
        nominal_mm=_point(before.point_mm(length)),
        error_before_mm=float(errors[0]),
        error_after_mm=float(errors[1]),
        displacement_mm=_point(d),
        standard_u_mm=_point(_standard_u(kind, inverse, u)),
        tangential_before_mm=float(shift[0]),
        tangential_after_mm=float(shift[1]),
        gap_mm=float(np.max(np.abs(normals @ d - errors))),
        note=note,
    )


def _meeting(
    kind: JunctionKind, normals: Array, tangents: Array, errors: Array, shorter_mm: float
) -> tuple[Array, str]:
    """Returns the matrix that takes the two errors to d, and the rule that was applied."""
    both = normals[0] + normals[1]
    along_normal = np.outer(both / max(float(1.0 + normals[0] @ normals[1]), 1e-9), [0.5, 0.5])
    if kind == JunctionKind.TANGENT:
        return along_normal, wording("tangent: displaced along the normal")
    if kind == JunctionKind.APART:
        return along_normal, wording("apart: another edge cuts what lies between them")
    if abs(np.linalg.det(normals)) > 1e-9:
        inverse = np.asarray(np.linalg.inv(normals), dtype=np.float64)
        shift = float(np.max(np.abs(tangents @ inverse @ errors)))
        if shift <= LARGEST_SHIFT * shorter_mm:
            return inverse, wording("corner: the displaced features meet")
    step = Um(abs(float(errors[0] - errors[1])), ".2f")
    return along_normal, wording(
        "corner too flat to let the features meet: the mean of both, a step of {step} is left", step=step
    )


def _standard_u(kind: JunctionKind, inverse: Array, u: Array) -> Array:
    """Returns the standard uncertainty of d: one value at a tangent junction, independent errors at a corner."""
    if kind == JunctionKind.TANGENT:
        shared: Array = np.abs(np.sum(inverse, axis=1)) * np.max(u)
        return shared
    variance: Array = inverse**2 @ u**2
    return np.sqrt(variance)


def _point(vector: Array) -> Point:
    return float(vector[0]), float(vector[1])


@dataclass(frozen=True)
class Tangency:
    """Predicted tangency error of the part at one tangent junction, for a full correction (weight 1).

    `kink` is the jump of the error's slope across the junction with the slope left free, mm per mm or rad;
    `predicted_rad` what of it the part will have, `standard_u_rad` its standard uncertainty. For a weight w under PART
    the part keeps (1 − w)·kink. `before` and `after` are feature indices.
    """

    before: int
    after: int
    point_mm: Point
    kink: float
    predicted_rad: float
    standard_u_rad: float

    @property
    def standard_u_um_per_mm(self) -> float:
        """Returns the standard uncertainty in the unit of the trade: µm of height a mm of length."""
        return self.standard_u_rad * UM_PER_MM


def tangencies(profile: Profile, free: FittedChains, policy: TangentPolicy) -> tuple[Tangency, ...]:
    """Returns one entry a tangent junction. `free` is the fit with continuous values and free slopes (PART)."""
    place = {index: (c, k) for c, fit in free.fits.items() for k, index in enumerate(fit.chain.features)}
    found = []
    for i, junction in enumerate(profile.junctions):
        if junction.kind != JunctionKind.TANGENT:
            continue
        chain, k = place[i]
        inside = place[i + 1][0] == chain
        kink, variance = _inside(free, chain, k) if inside else _between(free, chain)
        end = profile.features[i].point_mm(profile.features[i].length_mm)
        predicted = 0.0 if policy == TangentPolicy.PART else kink
        u = float(np.sqrt(max(variance, 0.0)))
        found.append(
            Tangency(
                before=i,
                after=i + 1,
                point_mm=(float(end[0]), float(end[1])),
                kink=kink,
                predicted_rad=predicted,
                standard_u_rad=u,
            )
        )
    return tuple(found)


def _inside(free: FittedChains, chain: int, k: int) -> tuple[float, float]:
    """Returns the kink and its variance at a joint within a chain."""
    spline = free.splines[chain]
    form = spline.kink_form(free.fits[chain].chain.joints_mm[k])
    return float(spline.of(form)[0]), float(spline.variance(form)[0])


def _between(free: FittedChains, before: int) -> tuple[float, float]:
    """Returns the kink and its variance between the end of a chain and the start of the next.

    The value handed from one to the other ties the two slopes together; that covariance is subtracted twice.
    """
    after = before + 1
    a, b = free.splines[before], free.splines[after]
    slope_a, slope_b = a.slope_form(a.length_mm), b.slope_form(0.0)
    kink = float((b.of(slope_b) - a.of(slope_a))[0])
    variance = float((a.variance(slope_a) + b.variance(slope_b))[0])
    if free.reference is not None:  # the last column of both is one and the same error
        both = slope_a.of(a.prescribed_mm[:, -1]) * slope_b.of(b.prescribed_mm[:, -1])
        variance -= 2.0 * float(both[0])
    for here, there, at_end in ((before, after, False), (after, before, True)):
        variance -= 2.0 * _tied(free, here, there, at_end)
    return kink, variance


def _tied(free: FittedChains, taker: int, giver: int, giver_at_end: bool) -> float:
    """Returns the covariance of the slopes at a junction where chain `taker` takes its value from `giver`; else 0."""
    fit = free.fits[taker]
    source = fit.sources[0 if giver_at_end else 1].neighbour
    if source is None or source.chain != giver:
        return 0.0
    spline, given = free.splines[taker], free.splines[giver]
    at_taker, at_giver = (0.0, given.length_mm) if giver_at_end else (spline.length_mm, 0.0)
    column = 0 if giver_at_end else fit.fit.conditions.count - 1
    response = float(spline.slope_form(at_taker).of(fit.fit.sensitivity)[0, column])
    slope = given.slope_form(at_giver)
    return response * float(given.covariance(given.value_form(at_giver), slope)[0])
