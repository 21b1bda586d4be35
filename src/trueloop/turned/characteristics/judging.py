"""A characteristic judged from the part errors at its places and their covariance.

Covariances of part errors at several places, cause by cause, as `error_curve.budget` has at single ones.

A size that takes several places (a length between two faces, the angle of a cone) needs to know what its places have in
common: what moves a whole cut moves both faces alike and changes no length.

| cause | between two places |
|---|---|
| the fitted curve | the spline's own covariance; of two chains, what both have from the reference touch |
| the process' scatter | none: it differs from touch to touch |
| between cuts, the whole cut | one vector (x, z) for all; with a z reference, along x alone |
| between cuts, along the cut | exp(−d/ℓ) on one feature, ℓ its length, of an arc at most 30°; features independent |
| a next cut that earlier parts tell | the same, of all that is uncertain there |
| what nobody says the error follows (`lean`) | one sign along a feature |

The next cut's own reference touch is common to all places that follow it.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Final, TypeAlias

import numpy as np
from numpy.typing import NDArray

from trueloop.arrays import Array
from trueloop.domain.characteristic import Characteristic, Judgement, Quantity, Verdict
from trueloop.geometry.feature import Feature
from trueloop.geometry.profile import Profile
from trueloop.statistics import root_of
from trueloop.tolerances.conformance import PROVEN, judge
from trueloop.turned.characteristics.measurand import Measurand
from trueloop.turned.compensation.shift import Shift
from trueloop.turned.error_curve.curve import ErrorCurve
from trueloop.turned.error_curve.fit_profile import ProfileErrorModel

ALIKE_RAD: Final = np.radians(30.0)
"""Distance in contact angle over which the edge's error differs (`fit.between_cuts`)."""
CurveFunction: TypeAlias = Callable[[ErrorCurve, Array], Array]


@dataclass(frozen=True, eq=False)
class Covariance:
    """Of part errors at n places, (n, n), mm²: `found` from touches, with their degrees of freedom, and `stated`."""

    found: Array
    stated: Array
    degrees_of_freedom: int | None

    @property
    def parts(self) -> tuple[Array, Array]:
        """Returns both parts."""
        return self.found, self.stated

    def with_stated(self, more: Array) -> "Covariance":
        """Returns the covariance with a further cause that is stated, (n, n)."""
        return Covariance(self.found, self.stated + more, self.degrees_of_freedom)

    def with_measured(self, at: NDArray[np.intp], standard_u_mm: Array) -> "Covariance":
        """Returns the covariance with errors at measured places that are known by themselves, not from the curve."""
        found, stated = self.found.copy(), self.stated.copy()
        for part in (found, stated):
            part[at, :] = part[:, at] = 0.0
        stated[at, at] = standard_u_mm**2
        return Covariance(found, stated, self.degrees_of_freedom)

    def of(self, gains: Array) -> tuple[Array, list[int | None]]:
        """Returns the standard uncertainties of sizes with these gains (m, n), and the effective degrees of freedom of
        each.

        By Welch and Satterthwaite, what is stated being as good as known from infinitely many [GUM G.4].
        """
        found = np.einsum("mi,ij,mj->m", gains, self.found, gains)
        total = np.maximum(found + np.einsum("mi,ij,mj->m", gains, self.stated, gains), 0.0)
        return np.sqrt(total), [self._freedom(f, t) for f, t in zip(found.tolist(), total.tolist(), strict=True)]

    def _freedom(self, freedom: float, total: float) -> int | None:
        if self.degrees_of_freedom is None or freedom <= 0.0:
            return None
        effective = self.degrees_of_freedom * (total / freedom) ** 2
        return int(effective) if effective < 1000.0 else None


@dataclass(frozen=True, eq=False)
class Places:
    """The places of a profile with the values of the curves there: feature index, arc length, normals (n, 2)."""

    model: ProfileErrorModel
    feature_index: NDArray[np.intp]
    arc_length_mm: Array

    @property
    def outward_normal(self) -> Array:
        """Returns the outward normals, (n, 2)."""
        features = self.model.profile.features
        return np.array([features[i].outward_normal(s) for i, s in _one_by_one(self)])

    @property
    def nominal_mm(self) -> Array:
        """Returns the nominal points (x as a radius, z), (n, 2)."""
        features = self.model.profile.features
        return np.array([features[i].point_mm(s) for i, s in _one_by_one(self)])

    @property
    def curve_mm(self) -> Array:
        """Returns the fitted error of the process, (n,)."""
        return self.each(lambda curve, s: curve.value_mm(s))

    @property
    def expected_mm(self) -> Array:
        """Returns the expected error of the next cut, had nothing been corrected, (n,)."""
        return self.each(ErrorCurve.expected_mm)

    def each(self, of: CurveFunction) -> Array:
        """Evaluates a function of every place's curve and its arc length there, (n,)."""
        found = np.zeros(len(self.feature_index))
        for i in np.unique(self.feature_index):
            rows = self.feature_index == i
            found[rows] = of(self.model.curves[i], self.arc_length_mm[rows])
        return found

    def shifted_mm(self, shifts: tuple[Shift, ...]) -> Array:
        """Shifts by feature, at the places, (n,)."""
        return np.array([float(shifts[i].value_mm(s)) for i, s in _one_by_one(self)])


def of_measured_part(places: Places) -> Covariance:
    """Returns the covariance of the touched part's errors: the curve's, and the scatter between its touches."""
    found, estimated = _of_curves(places)
    scatter = places.each(lambda curve, s: np.full(len(s), curve.repeatability_mm**2))
    return Covariance(found + np.diag(scatter), estimated, _freedom(places.model))


def of_next_cut(places: Places, unasked: tuple[Shift, ...]) -> Covariance:
    """Returns the covariance of the next cut's errors about the expected; `unasked` as in `loops.turned.correction`."""
    found, estimated = _of_curves(places)
    repeatability = places.each(lambda curve, s: np.full(len(s), curve.repeatability_mm))
    # By how much errors fall where the touch that the part's z is taken from has material left on, (n,)
    at = places.model.vectors.at_reference
    facing = places.model.vectors.outward_normal[at]
    share = places.outward_normal[:, 1] / facing[0, 1] if len(facing) else np.zeros(len(places.feature_index))
    own = repeatability * share
    lean = _same_feature(places) * np.outer(one := places.shifted_mm(unasked) / np.sqrt(3.0), one)
    # The covariance by a displacement of a whole cut along x and z; with a z reference along x alone: the part's zero
    # moves too.
    difference = places.each(lambda curve, s: np.full(len(s), curve.between_cuts.common_difference_mm))
    axes = [1.0, 0.0] if np.any(places.model.vectors.at_reference) else [1.0, 1.0]
    moved = places.outward_normal * axes
    stated = estimated + np.asarray((moved @ moved.T) * np.outer(difference, difference)) + _along_cut(places, share)
    process = np.diag(repeatability**2) + np.outer(own, own)
    from_memory = places.each(lambda curve, s: np.full(len(s), float(curve.next_cut is not None)))
    else_known = np.outer(1.0 - from_memory, 1.0 - from_memory)
    u = places.each(lambda curve, s: np.zeros(len(s)) if curve.next_cut is None else curve.budget(s).stated_mm)
    remembered = _alike(places) * np.outer(u, u)
    return Covariance(else_known * (found + process), else_known * stated + remembered + lean, _freedom(places.model))


def _freedom(model: ProfileErrorModel) -> int | None:
    return model.degrees_of_freedom or None


def _of_curves(places: Places) -> tuple[Array, Array]:
    """Returns the covariance of the fitted curves: of touched features, and of those that were estimated."""
    n, curves = len(places.feature_index), [places.model.curves[i] for i in places.feature_index]
    chain = np.array([id(curve.spline) for curve in curves])
    total, reference = np.zeros((n, n)), np.zeros(n)
    for one in np.unique(chain):
        rows = np.flatnonzero(chain == one)
        spline = curves[rows[0]].spline
        forms = np.vstack([curves[k].coefficient_rows(places.arc_length_mm[k]) for k in rows])
        total[np.ix_(rows, rows)] = forms @ spline.dense_covariance_mm2 @ forms.T
        if curves[rows[0]].reference is not None:
            reference[rows] = forms @ spline.prescribed_mm[:, -1]
    total += np.not_equal.outer(chain, chain) * np.outer(reference, reference)
    drawn_out = places.each(ErrorCurve.drawn_out_u_mm)
    total += _same_feature(places) * np.outer(drawn_out, drawn_out)
    known = np.array([float(curve.touches > 0) for curve in curves])
    return total * np.outer(known, known), total * (1.0 - np.outer(known, known))


def _one_by_one(places: Places) -> list[tuple[int, float]]:
    return list(zip(places.feature_index.tolist(), places.arc_length_mm.tolist(), strict=True))


def _same_feature(places: Places) -> Array:
    return np.equal.outer(places.feature_index, places.feature_index).astype(np.float64)


def _alike_over_mm(feature: Feature) -> float:
    """Returns how far along a feature the cut's own differences stay alike."""
    curvature = abs(float(feature.curvature_per_mm(0.0)))
    return min(feature.length_mm, ALIKE_RAD / curvature if curvature > 0.0 else np.inf)


def _along_cut(places: Places, share: Array) -> Array:
    """Returns the covariance by variation along the cut beyond the distance of touches, with the reference's share."""
    difference = places.each(lambda curve, s: np.full(len(s), curve.between_cuts.scatter_difference_mm))
    return np.asarray((_alike(places) + np.outer(share, share)) * np.outer(difference, difference))


def _alike(places: Places) -> Array:
    return alike_along(places.model.profile, places.feature_index, places.arc_length_mm)


def alike_along(profile: Profile, feature_index: NDArray[np.intp], arc_length_mm: Array) -> Array:
    """Returns the correlation of a cut's own differences at n places, (n, n): exp(−d/ℓ) on one feature."""
    length = np.array([_alike_over_mm(profile.features[i]) for i in feature_index])
    apart = np.abs(np.subtract.outer(arc_length_mm, arc_length_mm))
    return np.asarray(np.equal.outer(feature_index, feature_index) * np.exp(-apart / length))


DRAWS: Final = 10_000
"""Parts drawn where several sizes have to be in together: a probability is good to 0.5 %."""


def judged(characteristic: Characteristic, sizes: Measurand, error_mm: Array, covariance: Covariance) -> Judgement:
    """Judges one size by its distribution; of several, the one least likely to be in, and the probability of all."""
    values = sizes.nominal + sizes.gains @ error_mm
    if characteristic.quantity is Quantity.FORM:
        return _form(characteristic, _drawn(values, sizes.gains, covariance))
    standard_u, freedom = covariance.of(sizes.gains)
    each = [
        judge(value, u, known, characteristic.lower_limit, characteristic.upper_limit)
        for value, u, known in zip(values.tolist(), standard_u.tolist(), freedom, strict=True)
    ]
    worst = min(each, key=lambda judgement: (judgement.probability_in or 0.0, judgement.margin or 0.0))
    return (
        worst
        if len(each) == 1 or worst.probability_in is None
        else _together(characteristic, worst, _drawn(values, sizes.gains, covariance))
    )


def _together(characteristic: Characteristic, worst: Judgement, drawn: Array) -> Judgement:
    """Returns the worst size with the probability that all are in, and proven in only where that is proven."""
    low = -np.inf if characteristic.lower_limit is None else characteristic.lower_limit
    high = np.inf if characteristic.upper_limit is None else characteristic.upper_limit
    share = float(np.mean(np.all((drawn >= low) & (drawn <= high), axis=1)))
    probability = share if worst.probability_in is None else min(share, worst.probability_in)
    unproven = worst.verdict == "in" and probability < PROVEN
    return replace(worst, probability_in=probability, verdict="undecided" if unproven else worst.verdict)


def _form(characteristic: Characteristic, drawn: Array) -> Judgement:
    """Judges the range of the residuals of a fitted line or circle: never negative, so judged by its share alone."""
    form = np.ptp(drawn, axis=1)
    upper, value = characteristic.upper_limit, float(np.mean(form))
    if upper is None:
        return Judgement(
            value=value,
            standard_u=float(np.std(form)),
            degrees_of_freedom=None,
            probability_in=None,
            margin=None,
            verdict=None,
        )
    share = float(np.mean(form <= upper))
    verdict: Verdict = "in" if share >= PROVEN else "out" if share <= 1.0 - PROVEN else "undecided"
    return Judgement(
        value=value,
        standard_u=float(np.std(form)),
        degrees_of_freedom=None,
        probability_in=share,
        margin=upper - value,
        verdict=verdict,
    )


def _drawn(values: Array, gains: Array, covariance: Covariance) -> Array:
    """Draws sizes of so many parts, (draws, m), the same in every run; those from touches by Student's distribution."""
    rng = np.random.default_rng(0)
    found, stated = (rng.standard_normal((DRAWS, len(part))) @ root_of(part).T for part in covariance.parts)
    freedom = covariance.degrees_of_freedom
    if freedom is not None:
        found *= np.sqrt(freedom / rng.chisquare(freedom, DRAWS))[:, None]
    return np.asarray(values + (found + stated) @ gains.T)
