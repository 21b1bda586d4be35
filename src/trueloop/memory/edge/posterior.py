"""What errors of earlier parts say of other errors: Gaussian conditioning."""

from dataclasses import dataclass

import numpy as np

from trueloop.arrays import Array, by_content
from trueloop.memory.edge.hyperparameters import JITTER_MM2, Hyperparameters
from trueloop.memory.edge.observations import Observations
from trueloop.memory.edge.terms import along_angle, between_cuts, terms


@by_content
@dataclass(frozen=True)
class Posterior:
    """n errors and the actuator's gain, jointly Gaussian: (n + 1,) mean and covariance, the gain last.

    `mean_mm` and `covariance_mm2` are those of the errors as they would be measured: scatter of the cut and uncertainty
    of the measurement included.
    """

    mean: Array
    covariance: Array

    @property
    def mean_mm(self) -> Array:
        """Of the errors (n,)."""
        return self.mean[:-1]

    @property
    def covariance_mm2(self) -> Array:
        """Of the errors (n, n)."""
        return self.covariance[:-1, :-1]

    @property
    def gain(self) -> float:
        """What the actuator makes of a correction of 1."""
        return float(self.mean[-1])

    @property
    def gain_u(self) -> float:
        """Its standard uncertainty."""
        return float(np.sqrt(self.covariance[-1, -1]))

    def after(self, correction_mm: Array) -> tuple[Array, Array]:
        """Mean (n,) and covariance (n, n) of the errors E − gain·C that a correction C leaves."""
        leaves = np.column_stack([np.eye(len(correction_mm)), -correction_mm])
        return leaves @ self.mean, leaves @ self.covariance @ leaves.T


def joint(asked: Observations, size: Hyperparameters) -> Posterior:
    """Errors as measured, and the gain, before any is known.

    With gain γ the inspected error is F = E − γC; thus F + C = E − (γ − 1)C.
    """
    places = np.ix_(asked.cut, asked.cut)
    difference = np.subtract.outer(asked.contact_angle_rad, asked.contact_angle_rad)
    shared, along = between_cuts(terms(asked.cuts), size), along_angle(difference, size)
    errors = np.sum([shared[goes][places] * along[goes] for goes in along], axis=0)
    gain = np.append(-asked.correction_mm, 1.0)
    covariance = size.gain_sd**2 * np.outer(gain, gain)
    covariance[:-1, :-1] += errors
    of_itself = np.arange(len(errors))
    covariance[of_itself, of_itself] += size["noise_mm"] ** 2 + asked.standard_u_mm**2 + JITTER_MM2
    return Posterior(np.append(np.zeros(len(errors)), 1.0), covariance)


def condition(belief: Posterior, value_mm: Array) -> Posterior:
    """The rest of the errors, and the gain, once the first errors are known."""
    from scipy.linalg import cho_factor, cho_solve

    known = len(value_mm)
    if known == 0:
        return belief
    factor = cho_factor(belief.covariance[:known, :known], lower=True, check_finite=False)
    across = belief.covariance[:known, known:]
    weights = cho_solve(factor, across, check_finite=False)
    rest = belief.covariance[known:, known:] - across.T @ weights
    return Posterior(belief.mean[known:] + weights.T @ (value_mm - belief.mean[:known]), (rest + rest.T) / 2)
