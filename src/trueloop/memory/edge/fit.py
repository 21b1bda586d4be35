"""Hyperparameters from earlier parts: the marginal likelihood times the priors, at its maximum.

log p(y | θ) = −½ yᵀK⁻¹y − ½ log|K| − …,    ∂/∂θ = ½ tr((αα ᵀ − K⁻¹) ∂K/∂θ),   α = K⁻¹y
"""

import math
from functools import lru_cache
from typing import Any, Final, TypeAlias

import numpy as np

from trueloop.arrays import Array
from trueloop.memory.edge.hyperparameters import (
    GAIN_SD,
    LOG_SD,
    MEDIAN,
    NAMES,
    WRONG,
    Hyperparameters,
    log_prior,
)
from trueloop.memory.edge.observations import Observations
from trueloop.memory.edge.terms import between_cuts, matern, matern_by_log_angle, terms

Row: TypeAlias = np.ndarray[tuple[int], np.dtype[np.float64]]

FITTED_PARTS: Final = 15
"""Sizes are fitted to so many of the latest parts: enough to tell them, and what an edge was long ago counts less."""

BOUND: Final = 4.0
"""Hyperparameters stay within so many standard deviations of their priors: numbers that can be computed with."""

JITTER_MM2: Final = 1e-10
"""Added to every variance: (0.01 µm)². Keeps the covariance of coincident touches positive definite."""


@lru_cache(maxsize=64)
def fitted(observed: Observations) -> Hyperparameters:
    """The most probable hyperparameters, given errors in cutting order; of the gain, whether it is 1 or to be learned.

    The corrections of one edge are much alike, so that a gain near 1 cannot be told from d(φ): it is learned only where
    the errors say that it is wrong.
    """
    right, of_right = best(observed, 0.0)
    if not np.any(observed.correction_mm):
        return right
    wrong, of_wrong = best(observed, GAIN_SD)
    return wrong if of_wrong + math.log(WRONG) > of_right + math.log(1.0 - WRONG) else right


def best(observed: Observations, gain_sd: float) -> tuple[Hyperparameters, float]:
    """The most probable hyperparameters with the gain's standard deviation given, and the logarithm of that.

    Always begun at the priors' medians, so that the same parts give the same result whatever was asked before.
    """
    from scipy.optimize import minimize

    latest = observed.at(observed.cuts.part[observed.cut] > observed.cuts.part.max() - FITTED_PARTS)
    bounds = [(float(m - BOUND * sd), float(m + BOUND * sd)) for m, sd in zip(MEDIAN, LOG_SD, strict=True)]
    options: Any = {"maxiter": 60, "ftol": 1e-6}
    badness, start = Badness(latest, gain_sd), np.array(MEDIAN, dtype=np.float64).reshape(len(NAMES))
    found = minimize(badness.of, start, jac=True, method="L-BFGS-B", bounds=bounds, options=options)
    return Hyperparameters(np.asarray(found.x, dtype=np.float64), gain_sd), -float(found.fun)


class Badness:
    """−log posterior of the hyperparameters' logarithms, and its gradient."""

    def __init__(self, observed: Observations, gain_sd: float) -> None:
        self._observed = observed
        self._cuts, self._rows = np.unique(observed.cut, return_index=True)
        self._places = np.ix_(observed.cut, observed.cut)
        self._terms = terms(observed.cuts)
        angle = observed.contact_angle_rad
        self._difference = np.subtract.outer(angle, angle)
        self._cos = np.cos(self._difference)
        self._fixed = gain_sd**2 * np.outer(observed.correction_mm, observed.correction_mm)
        self._fixed[np.diag_indices(len(angle))] += observed.standard_u_mm**2 + JITTER_MM2

    def of(self, logarithm: Row) -> tuple[float, Row]:
        """Value and gradient."""
        from scipy.linalg import cho_factor, cho_solve

        size = Hyperparameters(logarithm)
        form, offset = between_cuts(self._terms, size)
        shape = matern(self._difference, size["angle_rad"])
        form_here = form[self._places]
        covariance = form_here * shape + offset[self._places] * self._cos + self._fixed
        n = len(covariance)
        covariance[np.diag_indices(n)] += size["noise_mm"] ** 2
        factor = cho_factor(covariance, lower=True, check_finite=False)
        alpha = cho_solve(factor, self._observed.error_mm, check_finite=False)
        pull = np.outer(alpha, alpha) - cho_solve(factor, np.eye(n), check_finite=False)
        prior, prior_slope = log_prior(logarithm)
        log_determinant = 2.0 * float(np.sum(np.log(np.diag(factor[0]))))
        value = -0.5 * float(self._observed.error_mm @ alpha) - 0.5 * log_determinant + prior
        slope = self._slope(size, pull, shape, form_here) + prior_slope
        return -value, -slope.reshape(len(NAMES))

    def _slope(self, size: Hyperparameters, pull: Array, shape: Array, form_here: Array) -> Array:
        """½ tr(pull · ∂K/∂log θ): summed over the touches of each pair of cuts first, as all terms are of cuts."""
        of_form, of_offset = self._by_cut(pull * shape), self._by_cut(pull * self._cos)
        slope = np.zeros(len(NAMES))
        for term in self._terms:
            total = 0.0 if term.form is None else float(np.vdot(of_form, term.form[np.ix_(self._cuts, self._cuts)]))
            if term.offset is not None:
                total += float(np.vdot(of_offset, term.offset[np.ix_(self._cuts, self._cuts)]))
            slope[NAMES.index(term.name)] = size[term.name] ** 2 * total
        slope[NAMES.index("noise_mm")] = size["noise_mm"] ** 2 * float(np.trace(pull))
        change = matern_by_log_angle(self._difference, size["angle_rad"])
        slope[NAMES.index("angle_rad")] = 0.5 * float(np.vdot(pull * form_here, change))
        return slope

    def _by_cut(self, values: Array) -> Array:
        return np.asarray(np.add.reduceat(np.add.reduceat(values, self._rows, axis=0), self._rows, axis=1))
