"""Hyperparameters from earlier parts: the marginal likelihood times the priors, at its maximum.

log p(y | θ) = −½ yᵀK⁻¹y − ½ log|K| + …,    ∂/∂θ = ½ tr((ααᵀ − K⁻¹) ∂K/∂θ),   α = K⁻¹y
"""

import math
from collections.abc import Mapping
from functools import lru_cache
from typing import Any, Final, TypeAlias

import numpy as np

from trueloop.arrays import Array
from trueloop.memory.edge.hyperparameters import (
    GAIN_SD,
    JITTER_MM2,
    LOG_SD,
    MEDIAN,
    NAMES,
    SUSPECT,
    WRONG,
    Hyperparameters,
    log_prior,
)
from trueloop.memory.edge.observations import Observations
from trueloop.memory.edge.posterior import condition, joint
from trueloop.memory.edge.terms import FORMS, along_angle, between_cuts, matern_by_log_angle, terms

Row: TypeAlias = np.ndarray[tuple[int], np.dtype[np.float64]]

FITTED_PARTS: Final = 12
"""Sizes are fitted to so many of the latest parts: enough to tell them, and what an edge was long ago counts less."""

BOUND: Final = 4.0
"""Hyperparameters stay within so many standard deviations of their priors: numbers that can be computed with."""


@lru_cache(maxsize=64)
def fitted(observed: Observations) -> Hyperparameters:
    """The most probable hyperparameters, given errors in cutting order; of the gain, whether it is 1 or to be learned.

    The corrections of one edge are much alike, so that a gain near 1 cannot be separated from d(φ): it is learned only
    where the errors say that it is wrong.
    """
    latest = observed.at(observed.cuts.part[observed.cut] > observed.cuts.part.max() - FITTED_PARTS)
    right, of_right = best(latest, 0.0)
    if not _suspect(latest):
        return right
    wrong, of_wrong = best(latest, GAIN_SD)
    return wrong if of_wrong + math.log(WRONG) > of_right + math.log(1.0 - WRONG) else right


def best(observed: Observations, gain_sd: float) -> tuple[Hyperparameters, float]:
    """The most probable hyperparameters with the gain's standard deviation given, and the logarithm of that.

    Always begun at the priors' medians, so that the same parts give the same result whatever was asked before.
    """
    from scipy.optimize import minimize

    bounds = [(float(m - BOUND * sd), float(m + BOUND * sd)) for m, sd in zip(MEDIAN, LOG_SD, strict=True)]
    options: Any = {"maxiter": 60, "ftol": 1e-6}
    start = np.array(MEDIAN, dtype=np.float64).reshape(len(NAMES))
    if not len(observed.error_mm):  # of an edge that cuts no arc nothing is known but the priors
        return Hyperparameters(start, gain_sd), log_prior(start)[0]
    badness = Badness(observed, gain_sd)
    found = minimize(badness.of, start, jac=True, method="L-BFGS-B", bounds=bounds, options=options)
    return Hyperparameters(np.asarray(found.x, dtype=np.float64), gain_sd), -float(found.fun)


class Badness:
    """−log posterior of the hyperparameters' logarithms, and its gradient."""

    def __init__(self, observed: Observations, gain_sd: float) -> None:
        self._observed = observed
        self._cuts, self._rows = np.unique(observed.cut, return_index=True)
        self._places = np.ix_(observed.cut, observed.cut)
        self._terms = terms(observed.cuts)
        # Parts of one type are touched at the same angles: forms are computed once for each pair of angles.
        angles, which = np.unique(observed.contact_angle_rad, return_inverse=True)
        self._difference, self._pairs = np.subtract.outer(angles, angles), np.ix_(which, which)
        self._fixed = gain_sd**2 * np.outer(observed.correction_mm, observed.correction_mm)
        self._fixed[np.diag_indices(len(which))] += observed.standard_u_mm**2 + JITTER_MM2

    def of(self, logarithm: Row) -> tuple[float, Row]:
        """Value and gradient."""
        from scipy.linalg.lapack import dpotrf, dpotri

        size, error = Hyperparameters(logarithm), self._observed.error_mm
        shared = {goes: of_cuts[self._places] for goes, of_cuts in between_cuts(self._terms, size).items()}
        along = {goes: of_angles[self._pairs] for goes, of_angles in along_angle(self._difference, size).items()}
        covariance = self._fixed + sum(shared[goes] * along[goes] for goes in along)
        covariance[np.diag_indices(len(error))] += size["noise_mm"] ** 2
        factor = dpotrf(covariance, lower=True)[0]
        inverse = np.tril(dpotri(factor, lower=True)[0])
        inverse += np.tril(inverse, -1).T
        alpha = inverse @ error
        prior, prior_slope = log_prior(logarithm)
        value = -0.5 * float(error @ alpha) - float(np.sum(np.log(np.diag(factor)))) + prior
        slope = self._slope(size, np.outer(alpha, alpha) - inverse, shared, along) + prior_slope
        return -value, -slope.reshape(len(NAMES))

    def _slope(
        self, size: Hyperparameters, pull: Array, shared: Mapping[str, Array], along: Mapping[str, Array]
    ) -> Array:
        """½ tr(pull · ∂K/∂log θ): summed over the touches of each pair of cuts first, as all terms are of cuts."""
        slope = np.zeros(len(NAMES))
        by_cut = {goes: self._by_cut(pull * along[goes]) for goes in along}
        for term in self._terms:
            total = float(np.vdot(by_cut[term.goes], term.shared[np.ix_(self._cuts, self._cuts)]))
            slope[NAMES.index(term.size)] += size[term.size] ** 2 * total
        slope[NAMES.index("noise_mm")] = size["noise_mm"] ** 2 * float(np.trace(pull))
        for form in FORMS:
            change = matern_by_log_angle(self._difference, size[form])[self._pairs]
            slope[NAMES.index(form)] = 0.5 * float(np.vdot(pull * shared[form], change))
        return slope

    def _by_cut(self, values: Array) -> Array:
        return np.asarray(np.add.reduceat(np.add.reduceat(values, self._rows, axis=0), self._rows, axis=1))


def _suspect(observed: Observations) -> bool:
    """Whether the actuator's gain seems wrong, with terms as large as they were believed beforehand."""
    if not np.any(observed.correction_mm):
        return False
    gain = condition(joint(observed, Hyperparameters(MEDIAN, GAIN_SD)), observed.error_mm).gain
    return abs(gain - 1.0) > SUSPECT
