"""A pattern as a draw of a stated random process, and what measured places then tell of others (kriging).

    p = form + waves,  cov = τ_f² M(Δa/2A) M(Δb/2B) + τ² M(Δa/ℓ_a) M(Δb/ℓ_b),  M(r) = (1 + √5 r + 5r²/3) exp(−√5 r):

products of Matérn's correlation (ν = 5/2: curvature is continuous, nothing smoother is believed), both of mean zero.
The form's lengths are twice the sides A, B of the patch: offset, tilt, bow. The variances, the waves' lengths and the
noise are the likeliest for the values measured (Rasmussen & Williams 2006, §§2.2, 5.4.1). The expectation fades to zero
and its variance grows to the whole one, with the distance from what was measured, in the process's own lengths. Valid
where the pattern is alike all over the patch: a ridge that stands in a gap alone is not foreseen.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Final, TypeAlias

import numpy as np

from trueloop.arrays import Array
from trueloop.surface.separation.separate import COVERAGE, MANY, student

Sides: TypeAlias = tuple[float, float]

FORM_SIDES: Final = 2.0
SOME: Final = 250
"""Places that the process is estimated from: its few figures need no more."""
STARTS: Final = (0.08, 0.3)
"""Lengths of the waves, as shares of the sides, that the search may begin with."""
RATIOS: Final = (-12.0, 12.0)
"""Logarithms of form and noise over waves that are searched."""
LEAST_NOISE: Final = 1e-4
"""Of the waves' variance, as noise: keeps the equations solvable where values carry none."""
FEWEST: Final = 3.0
"""Independent waves that a patch holds at least."""
AT_ONCE: Final = 2000
"""Places whose variance is computed at once."""


@dataclass(frozen=True)
class Process:
    """Variances of waves, form and noise in mm², lengths in mm along each direction."""

    waves_mm2: float
    form_mm2: float
    noise_mm2: float
    waves_mm: tuple[float, ...]
    form_mm: tuple[float, ...]

    @property
    def variance_mm2(self) -> float:
        """Of the pattern at any place, before anything is measured."""
        return self.waves_mm2 + self.form_mm2

    def widening(self, area_mm2: float) -> float:
        """By how much a band is wider than the normal law has it, for the waves' variance is an estimate.

        Of Student's law with as many degrees of freedom as such an area holds independent waves, A B/ℓ_a ℓ_b.
        """
        independent = area_mm2 / (self.waves_mm[0] * self.waves_mm[-1])
        return student(COVERAGE, max(FEWEST, independent)) / student(COVERAGE, MANY)

    def covariance_mm2(self, a_mm: Array, b_mm: Array) -> Array:
        """Between the pattern at places (n, 2) and (m, 2), without noise: (n, m)."""
        apart = np.abs(a_mm[:, None, :] - b_mm[None, :, :])
        waves, form = (_product(apart, lengths) for lengths in (self.waves_mm, self.form_mm))
        return np.asarray(self.waves_mm2 * waves + self.form_mm2 * form)


class FieldProcess(Process):
    """A process in space, over faces of a part (`field`), its lengths alike in all directions.

    Places are rows (n, 7): point, outward normal, number of the group of faces that run on into each other.
    """

    def covariance_mm2(self, a_mm: Array, b_mm: Array) -> Array:
        """Between the field at places (n, 7) and (m, 7), without noise: (n, m)."""
        apart, alike = apart_and_alike(a_mm, b_mm)
        waves, form = matern(apart / self.waves_mm[0]), matern(apart / self.form_mm[0])
        return np.asarray(alike * (self.waves_mm2 * waves + self.form_mm2 * form))


def apart_and_alike(a: Array, b: Array) -> tuple[Array, Array]:
    """Returns distances and shares of the covariance between places (n, 7) and (m, 7)."""
    from scipy.spatial.distance import cdist  # slow to import

    same = a[:, None, 6] == b[None, :, 6]
    return np.asarray(cdist(a[:, :3], b[:, :3])), np.asarray((1 + a[:, 3:6] @ b[:, 3:6].T + same) / 3)


@dataclass(frozen=True, eq=False)
class Kriging:
    """The process elsewhere, given values measured at places (n, k): (n, 2) in mm for a process over a patch."""

    process: Process
    at_mm: Array

    def expected_mm(self, values_mm: Array, where_mm: Array) -> Array:
        """The process at places (m, …), given values (n, k): (m, k)."""
        weights = np.linalg.solve(self._factor.T, np.linalg.solve(self._factor, values_mm))
        pieces = np.array_split(where_mm, max(1, len(where_mm) // AT_ONCE))
        return np.concatenate([self.process.covariance_mm2(some, self.at_mm) @ weights for some in pieces])

    def variance_mm2(self, where_mm: Array) -> Array:
        """Of the process at places (m, …) about what is expected: from near none to its whole variance."""
        from scipy.linalg import solve_triangular  # slow to import

        left = [
            np.sum(
                solve_triangular(self._factor, self.process.covariance_mm2(self.at_mm, some), lower=True) ** 2, axis=0
            )
            for some in np.array_split(where_mm, max(1, len(where_mm) // AT_ONCE))
        ]
        return np.asarray(np.clip(self.process.variance_mm2 - np.concatenate(left), 0.0, None))

    @cached_property
    def _factor(self) -> Array:
        noise = max(self.process.noise_mm2, LEAST_NOISE * self.process.waves_mm2)
        covariance = self.process.covariance_mm2(self.at_mm, self.at_mm)
        return np.asarray(np.linalg.cholesky(covariance + noise * np.eye(len(covariance))), float)


def fitted_process(at_mm: Array, values_mm: Array, sides_mm: Sides, step_mm: float) -> Process:
    """The likeliest process for values (n,) at places (n, 2), about `step_mm` apart, on a patch of such sides.

    Waves are not shorter than half a step and no longer than the longer side.
    """
    if len(values_mm) > SOME:
        some = np.random.default_rng(1).choice(len(values_mm), SOME, replace=False)
        at_mm, values_mm = at_mm[some], values_mm[some]
    apart, form_mm = np.abs(at_mm[:, None, :] - at_mm[None, :, :]), (FORM_SIDES * sides_mm[0], FORM_SIDES * sides_mm[1])
    form_of_sides, low, high = _product(apart, form_mm), np.log(step_mm / 2), np.log(max(sides_mm))

    def process(x: Array) -> tuple[Process, Array]:
        lengths_mm = tuple(np.exp(np.clip(x[:2], low, high)).tolist())
        form, noise = np.exp(np.clip(x[2:], *RATIOS)).tolist()
        found = Process(1.0, form, max(noise, LEAST_NOISE), lengths_mm, form_mm)
        return found, _product(apart, lengths_mm) + form * form_of_sides

    return likeliest(
        values_mm, process, [np.array([*np.log(np.multiply(sides_mm, each)), 0.0, -4.0]) for each in STARTS]
    )


def likeliest(values_mm: Array, process: Callable[[Array], tuple[Process, Array]], starts: Sequence[Array]) -> Process:
    """Returns the likeliest process for values (n,) among those that `process` makes of parameters, each with its
    covariance (n, n) without noise, the waves' variance 1: the scale that is best for the values counts.
    """
    from scipy.optimize import minimize  # slow to import

    def judged(x: Array) -> tuple[float, Process]:
        found, covariance = process(x)
        factor = np.linalg.cholesky(covariance + found.noise_mm2 * np.eye(len(values_mm)))
        white = np.linalg.solve(factor, values_mm)
        scale = max(float(white @ white) / len(white), np.finfo(float).tiny)
        deviance = len(white) * float(np.log(scale)) + 2 * float(np.sum(np.log(np.diag(factor))))
        form_mm2, noise_mm2 = scale * found.form_mm2, scale * found.noise_mm2
        return deviance, replace(found, waves_mm2=scale, form_mm2=form_mm2, noise_mm2=noise_mm2)

    start = min(starts, key=lambda x: judged(x)[0])
    find: Any = minimize  # whose stubs know no method without derivatives
    options = {"maxfev": 120, "xatol": 0.03, "fatol": 0.05}
    return judged(find(lambda x: judged(x)[0], start, method="Nelder-Mead", options=options).x)[1]


def _product(apart_mm: Array, lengths_mm: Sequence[float]) -> Array:
    """Correlation of places that are so far apart along both directions (n, m, 2)."""
    return np.asarray(matern(apart_mm[..., 0] / lengths_mm[0]) * matern(apart_mm[..., 1] / lengths_mm[1]))


def matern(r: Array) -> Array:
    """Matérn's correlation at r lengths, ν = 5/2."""
    s = np.sqrt(5.0) * r
    return np.asarray((1 + s + s**2 / 3) * np.exp(-s))
