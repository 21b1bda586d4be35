"""Touches that are likely to be bad: a chip under the ball, coolant, a slip of the probe.

Each touch is compared with what all other touches predict at its place, by fits made without it in which the shape of
the curve is chosen anew. A touch is left out of the fit where the test and the probability agree; where two or three
touches explain each other's disagreement equally well, the words say that it cannot be decided.

The probability is that of a mixture (Box & Tiao 1968, "A Bayesian approach to some outlier problems"): a touch is bad
with the prior `BAD_SHARE`, and then its error is wider by `BAD_SPREAD_MM`. With the deletion residual d, its standard
uncertainty s and ν degrees of freedom, the odds of "touch k is bad" against "none is bad" are
π/(1 − π) · N(d; 0, s² + τ²) / t_ν(d/s)/s: for a linear model this ratio is exact, the shape of the others cancels.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cache, partial
from typing import Final

import numpy as np
from numpy.typing import NDArray

from trueloop.errors import TrueloopError
from trueloop.geometry.profile import Profile
from trueloop.turned.error_curve.curve import student_t_factor
from trueloop.turned.error_curve.uncertainty import FittedChains, finish
from trueloop.turned.fit.fit_chains import Known, fit_chains, fit_touched
from trueloop.turned.fit.options import FitOptions
from trueloop.turned.fit.prior.part_state import part_state
from trueloop.turned.touches.error_vectors import ErrorVectors
from trueloop.units import UM_PER_MM
from trueloop.wording import Um, wording

BAD_SHARE: Final = 0.01
"""Prior probability that a touch is bad."""

BAD_SPREAD_MM: Final = 0.030
"""Standard deviation of a bad touch's own error: chips and slips are tens of micrometres."""

BETWEEN_FEATURES_MM: Final = 0.016
"""How far the cones of [6811 Tables 8, 10] deviate from what the same nose did on the domes, RMS over the ten parts (11
to 17 µm on nine, 30 µm on one whose taper looks falsified): the spread between features."""

FALSE_ALARMS: Final = 0.003
"""Share of clean parts in which the test, shared among all touches, may name one. The shape of an arc's curve is chosen
by the same touches, which makes residuals a little too small: simulated clean parts stay below 1 in 100."""

DECIDED: Final = 0.95
"""A touch is left out where it is bad with at least this probability, against all other explanations."""

MOST: Final = 3
"""More touches are not left out of one part, and never more than a quarter of those of one curve."""

LOOKED_AT: Final = 3
"""Touches of each curve that stand out most are judged by a fit of their own; the others stand out less."""

WORTH_A_FIT: Final = 2.0
"""Times the scatter by which a touch deviates from the others before it gets a fit of its own: the test asks for more
than four, and a clean part is not to pay for a dozen fits."""

GOES_ON: Final = 3.0
"""The search for a second bad touch, which may hide the first, goes on from a touch that stands out this much."""

EXCUSED: Final = 2.0
"""A curve whose touches scatter this many times as much as all do is judged by its own scatter."""

FINEST_MM: Final = 1e-4
"""The resolution below which agreement is not judged: within the last digit of a reading."""


@dataclass(frozen=True)
class SuspectTouch:
    """A touch that the others contradict; `position` is its in the error vectors, lengths in mm.

    `expected_mm` is what the other touches predict there, `standard_u_mm` the standard uncertainty of a good touch
    about that. `probability` is that of this touch being bad. `left_out` touches have weight 0 in the fit, all other
    touches weight 1.
    """

    position: int
    point: str
    feature: str
    error_mm: float
    expected_mm: float
    standard_u_mm: float
    probability: float
    left_out: bool
    z_reference: bool

    def as_dict(self) -> dict[str, object]:
        """Returns it for JSON: errors in µm, the weight that the touch has in the fit."""
        return {
            "point": self.point,
            "feature": self.feature,
            "error_um": self.error_mm * UM_PER_MM,
            "expected_um": self.expected_mm * UM_PER_MM,
            "standard_u_um": self.standard_u_mm * UM_PER_MM,
            "probability_bad": self.probability,
            "weight": 0.0 if self.left_out else 1.0,
        }

    @property
    def words(self) -> str:
        """Describes the finding and its consequence."""
        found = wording(
            "touch {point} on {feature}: {error}, where the other touches predict {expected} with a standard "
            "uncertainty of {u}; bad with probability {probability}",
            point=self.point,
            feature=self.feature,
            error=Um(self.error_mm, "+.1f"),
            expected=Um(self.expected_mm, "+.1f"),
            u=Um(self.standard_u_mm),
            probability=_percent(self.probability),
        )
        if self.z_reference:
            return wording(
                "{found}. The part's z was taken from it: every error along z contains its own. Probe it again",
                found=found,
            )
        if self.left_out:
            return wording("{found}. It is left out of the fit (weight 0). Probe it again", found=found)
        return wording(
            "{found}. This cannot be decided, it stays in the fit: probe it again, or {feature} at more points",
            found=found,
            feature=self.feature,
        )


@dataclass(frozen=True)
class _Deletion:
    """A touch beside what a fit without it predicts: `odds` of bad against good, whether the test rejects it."""

    position: int
    expected_mm: float
    standard_u_mm: float
    times: float
    odds: float
    rejected: bool


@dataclass(frozen=True)
class _Search:
    profile: Profile
    vectors: ErrorVectors
    options: FitOptions
    known: Known = field(default_factory=dict)

    def fitted(self, kept: NDArray[np.intp], feature: int | None = None) -> FittedChains:
        """Returns touched chains fitted to some touches; all of a feature left without any. Others are fitted once."""
        part = self.vectors.chosen(kept)
        fits = fit_touched(self.profile, part, self.options, None, self.known)[0]
        if feature is not None and not any(feature in fit.chain.features for fit in fits.values()):
            state = cache(partial(part_state, self.profile, part, fitted=False))
            fits = fit_chains(self.profile, part, self.options, None, state, self.known)[0]
        return finish(fits, part)


def suspect_touches(profile: Profile, vectors: ErrorVectors, options: FitOptions) -> tuple[SuspectTouch, ...]:
    """Touches that the others contradict, most probable first; empty for clean touches.

    The test is the generalized extreme Studentized deviate test (Rosner 1983): touches are taken away one by one, the
    most extreme first, and as many are named as the last significant step has; so two bad touches do not hide each
    other. Valid where good touches scatter normally about a curve that the fit can follow: a step or a burr within a
    feature looks like bad touches. A touch can be named only where the others have touches to spare.
    """
    search = _Search(profile, vectors, options)
    everything = np.arange(len(vectors.point))
    removed: list[int] = []
    named: list[int] = []
    for _ in range(MOST + 1):
        kept = np.setdiff1d(everything, removed)
        worst = max(
            _deletions(search, kept, _standing_out(search, kept)), key=lambda deletion: deletion.times, default=None
        )
        if worst is None:
            break
        removed.append(worst.position)
        if worst.rejected:
            named = list(removed)
        elif worst.times < GOES_ON:
            break
    return _judged(search, named) if named else ()


def _standing_out(search: _Search, kept: NDArray[np.intp]) -> list[int]:
    """Touches worth a fit of their own: the largest errors of being predicted, and those that no other predicts."""
    if len(kept) < 2:
        return []
    picked: list[int] = []
    fitted = search.fitted(kept)
    for i, fit in fitted.fits.items():
        size = np.where(np.isnan(fit.leave_one_out_mm), np.inf, np.abs(fit.leave_one_out_mm))
        most = np.argsort(-size)[:LOOKED_AT]
        picked += [int(kept[k]) for k in fit.touches[most[size[most] > WORTH_A_FIT * fitted.scatter_mm[i]]]]
    return picked


def _deletions(search: _Search, kept: NDArray[np.intp], looked_at: Sequence[int]) -> list[_Deletion]:
    found = (_deletion(search, kept, k) for k in looked_at)
    return [deletion for deletion in found if deletion is not None]


def _deletion(search: _Search, kept: NDArray[np.intp], k: int) -> _Deletion | None:
    """Tests the touch against a fit to the others; None where those do not determine a curve with touches to spare."""
    try:
        fitted = search.fitted(kept[kept != k], int(search.vectors.feature_index[k]))
    except TrueloopError:
        return None
    expected, u, freedom = _predicted(search, fitted, k)
    if freedom == 0:
        return None
    off = float(search.vectors.error_mm[k]) - expected
    times = abs(off) / u
    limit = student_t_factor(1.0 - FALSE_ALARMS / len(kept), freedom)
    # Odds of a bad touch against a good one, at most 1e12
    wide = math.hypot(u, BAD_SPREAD_MM)
    log_bad = -0.5 * (off / wide) ** 2 - math.log(wide) - 0.5 * math.log(2.0 * math.pi)
    nu = freedom
    log_good = -0.5 * (off / u) ** 2 - math.log(u) - 0.5 * math.log(2.0 * math.pi) if nu > 1000 else (
        math.lgamma((nu + 1) / 2) - math.lgamma(nu / 2) - 0.5 * math.log(nu * math.pi) - math.log(u)
        - (nu + 1) / 2 * math.log1p((off / u) ** 2 / nu)
    )  # fmt: skip
    return _Deletion(
        position=k,
        expected_mm=expected,
        standard_u_mm=u,
        times=times,
        odds=BAD_SHARE / (1.0 - BAD_SHARE) * math.exp(min(log_bad - log_good, 30.0)),
        rejected=times > limit,
    )


def _predicted(search: _Search, fitted: FittedChains, k: int) -> tuple[float, float, int]:
    """Predicts touch k by a fit without it: value, standard uncertainty of a good touch, its degrees of freedom."""
    feature = int(search.vectors.feature_index[k])
    c = next(c for c, fit in fitted.fits.items() if feature in fit.chain.features)
    fit, spline = fitted.fits[c], fitted.splines[c]
    start = fit.chain.starts_mm[fit.chain.features.index(feature)]
    s = np.clip(start + search.vectors.arc_length_mm[k], 0.0, spline.length_mm)
    form = spline.value_form(s)
    scatter, freedom = fitted.scatter_mm[c], fitted.degrees_of_freedom
    curve_u = math.hypot(math.sqrt(max(float(spline.variance(form)[0]), 0.0)), float(spline.drawn_out_u_mm(s)[0]))
    own = math.sqrt(float(np.sum(fit.residual_mm**2)) / fit.spare) if fit.spare > 0 else 0.0
    if own > EXCUSED * scatter:
        curve_u, scatter, freedom = curve_u * own / scatter, own, fit.spare
    between = BETWEEN_FEATURES_MM if 0 < len(fit.touches) < (3 if fit.chain.curved else 2) else 0.0
    u = max(math.hypot(curve_u, scatter, between), FINEST_MM)
    estimated = not len(fit.touches) and all(source.neighbour is None for source in fit.sources)
    found = scatter if estimated else math.hypot(curve_u, scatter)
    # The degrees of freedom where the rest of the uncertainty is stated, not estimated from touches
    # (Welch–Satterthwaite).
    return float(spline.of(form)[0]), u, int(min(freedom / max((found / u), 1e-3) ** 4, 10_000.0))


def _judged(search: _Search, named: Sequence[int]) -> tuple[SuspectTouch, ...]:
    """Returns the probabilities of each named touch, and of what explains the data as well without the others."""
    everything = np.arange(len(search.vectors.point))
    found: dict[int, SuspectTouch] = {}
    for k in named:
        kept = np.setdiff1d(everything, [other for other in named if other != k])
        # Deletions of all touches on the feature of touch k and the standing-out ones of the others
        same = kept[search.vectors.feature_index[kept] == search.vectors.feature_index[k]]
        rivals = _deletions(search, kept, sorted({int(i) for i in same} | set(_standing_out(search, kept))))
        total = 1.0 + sum(rival.odds for rival in rivals)
        for rival in rivals:
            probability = rival.odds / total
            if rival.position == k or probability > 1.0 - DECIDED:
                suspect = _suspect(search, rival, probability, rival.position == k and _may_go(search, named, k))
                if rival.position not in found or rival.position == k:
                    found[rival.position] = suspect
    return tuple(sorted(found.values(), key=lambda touch: -touch.probability))


def _may_go(search: _Search, named: Sequence[int], k: int) -> bool:
    """Returns whether the touch's curve keeps three quarters of its touches without the named ones."""
    index = search.vectors.feature_index
    gone = sum(int(index[i]) == int(index[k]) for i in named)
    return gone <= int(np.count_nonzero(index == index[k])) // 4


def _suspect(search: _Search, deletion: _Deletion, probability: float, may_go: bool) -> SuspectTouch:
    k, vectors = deletion.position, search.vectors
    return SuspectTouch(
        position=k,
        point=vectors.point[k],
        feature=search.profile.names[vectors.feature_index[k]],
        error_mm=float(vectors.error_mm[k]),
        expected_mm=deletion.expected_mm,
        standard_u_mm=deletion.standard_u_mm,
        probability=probability,
        left_out=may_go and probability >= DECIDED,
        z_reference=bool(vectors.at_reference[k]),
    )


def _percent(probability: float) -> str:
    over = wording("more than {percent:.1f} %", percent=99.9)
    return over if probability > 0.999 else wording("{percent:.1f} %", percent=100.0 * probability)
