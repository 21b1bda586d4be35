"""What is deterministic in a part's deviations and what is random.

A least-squares spline surface is given more and more control points until what it leaves is normal and spatially random
[MPM §§4–6]: the fewest control points that suffice follow what machining repeats and nothing of what it does not.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np

from trueloop.error_surface.moran import Null
from trueloop.error_surface.neighbourhood import Neighbourhood, permutation_p_value, residual_null
from trueloop.error_surface.normality import Normality, normality
from trueloop.error_surface.places import Places, projector, regress
from trueloop.error_surface.spline_surface import Size, SplineSurface
from trueloop.errors import Code, Finding, Severity, TrueloopError
from trueloop.geometry.feature import Array

CONFIDENCE: Final = 0.99
"""P of [MPM §8.2], for every test."""
DEGREES: Final = (2, 3)
"""Degree 2 is the least that keeps second derivatives finite where pieces meet [MPM §5]."""
FULLEST: Final = 0.8
"""Most control points a direction, as a share of the rows measured: the rest is what the tests judge by."""


@dataclass(frozen=True)
class Trial:
    """One size and what the tests say of its residuals."""

    size: Size
    moran_i: float
    null: Null
    moran_p: float
    normality: Normality
    leave_one_out_mm: float

    def random(self, confidence: float) -> bool:
        """Whether the residuals are spatially random."""
        return self.moran_p > 1.0 - confidence

    def normal(self, confidence: float) -> bool:
        """Whether the residuals are normal, judged by Lilliefors."""
        return self.normality.lilliefors_p > 1.0 - confidence

    def adequate(self, confidence: float) -> bool:
        """Whether the residuals are both."""
        return self.random(confidence) and self.normal(confidence)


@dataclass(frozen=True, eq=False)
class Separation:
    """A part's deviations taken apart: `deterministic` as a surface, `random_mm` (n,) as values at the places.

    `trials` are all sizes tried, in order; `chosen` is the one taken. `sigma_mm` is the scatter of the random part,
    with the degrees of freedom counted that the fit took.
    """

    near: Neighbourhood
    measured_mm: Array
    deterministic: SplineSurface
    random_mm: Array
    chosen: Trial
    trials: tuple[Trial, ...]
    sigma_mm: float
    criterion: str
    findings: tuple[Finding, ...]

    @property
    def places(self) -> Places:
        """Where the deviations are known."""
        return self.near.places

    @cached_property
    def permutation_p(self) -> float:
        """The test for spatial randomness by shuffling the random part."""
        return permutation_p_value(self.near, self.random_mm, self.chosen.size)


def separate(
    places: Places,
    errors_mm: Array,
    *,
    near: Neighbourhood | None = None,
    confidence: float = CONFIDENCE,
    degrees: Sequence[int] = DEGREES,
    criterion: str = "randomness",
) -> Separation:
    """Takes deviations apart.

    criterion: "randomness", the published one: fewest control points, then lowest degree, whose residuals are normal
    (Lilliefors) and spatially random (Moran's I against the moments of residuals). "prediction", a modern one: the size
    that predicts left-out points best. Raises SRF-MODEL when no size leaves spatially random residuals.
    """
    near = near or Neighbourhood(places)
    if criterion == "prediction":
        trials = [_trial(near, errors_mm, size) for size in sizes(places, degrees)]
        chosen = min(trials, key=lambda trial: trial.leave_one_out_mm)
    else:
        trials, chosen = _until_random(near, errors_mm, sizes(places, degrees), confidence)
    findings = () if chosen.normal(confidence) else (_not_normal(chosen, confidence),)
    return _taken_apart(near, errors_mm, chosen, trials, criterion, findings)


def of_size(places: Places, errors_mm: Array, size: Size, near: Neighbourhood | None = None) -> Separation:
    """Deviations taken apart by a surface of a given size."""
    near = near or Neighbourhood(places)
    trial = _trial(near, errors_mm, size)
    return _taken_apart(near, errors_mm, trial, [trial], "given", ())


def sizes(places: Places, degrees: Sequence[int] = DEGREES) -> Iterator[Size]:
    """Sizes by growing number of control points, spaced alike along both sides; at each, degrees in ascending order."""
    length = places.sides_mm
    if places.rows is not None and places.columns is not None:
        most = (int(FULLEST * len(places.rows)), int(FULLEST * len(places.columns)))
    else:
        most_in_all = FULLEST**2 * len(places.u)
        ratio = np.sqrt(length[0] / length[1])
        most = (int(np.sqrt(most_in_all) * ratio), int(np.sqrt(most_in_all) / ratio))
    shorter = min(length)
    least = min(degrees) + 1
    for count in range(least, max(most) + 1):
        rows, columns = (
            min(max(least, round(count * side / shorter)), top) for side, top in zip(length, most, strict=True)
        )
        for degree in degrees:
            if min(rows, columns) > degree:
                yield Size(rows, columns, degree)
        if (rows, columns) == most:
            return


def _until_random(
    near: Neighbourhood, errors: Array, candidates: Iterator[Size], confidence: float
) -> tuple[list[Trial], Trial]:
    """Trials up to the first adequate size; then with fewer control points along one direction alone.

    Going down, a size has to be adequate and to predict left-out points no worse: a test that has said no many times
    says yes once by chance. Where no size leaves normal residuals, the smallest that leaves spatially random ones.
    """
    trials: list[Trial] = []
    for size in candidates:
        trials.append(_trial(near, errors, size))
        if trials[-1].adequate(confidence):
            return trials, _narrowed(near, errors, trials, confidence)
    random = [trial for trial in trials if trial.random(confidence)]
    if not random:
        raise _never_random(trials[-1], confidence)
    return trials, random[0]


def _narrowed(near: Neighbourhood, errors: Array, trials: list[Trial], confidence: float) -> Trial:
    best = trials[-1]
    while True:
        smaller = [_trial(near, errors, size) for size in _smaller(best.size)]
        trials += smaller
        limit = best.leave_one_out_mm
        fit = [trial for trial in smaller if trial.adequate(confidence) and trial.leave_one_out_mm <= limit]
        if not fit:
            return best
        best = min(fit, key=lambda trial: trial.leave_one_out_mm)


def _smaller(size: Size) -> list[Size]:
    fewer = (Size(size.rows - 1, size.columns, size.degree), Size(size.rows, size.columns - 1, size.degree))
    return [size for size in fewer if min(size.rows, size.columns) > size.degree]


def _never_random(last: Trial, confidence: float) -> TrueloopError:
    return TrueloopError(
        Code.SRF_MODEL,
        f"up to {last.size} control points the residuals are not spatially random: Moran's I {last.moran_i:.4f}, "
        f"p {last.moran_p:.2g}, wanted above {1 - confidence:.2g}",
        hint="measure more densely: the pattern has waves shorter than two steps of the grid",
    )


def _trial(near: Neighbourhood, errors: Array, size: Size) -> Trial:
    span = projector(near.places, size)
    residuals = span.residuals(errors)
    free = np.maximum(1.0 - span.leverages, 1e-9)
    law = normality(residuals / np.sqrt(free))
    null = residual_null(near, size)
    moran_i = float(near.moran_i(residuals[:, None])[0])
    left_out = float(np.sqrt(np.mean((residuals / free) ** 2)))
    return Trial(size, moran_i, null, null.p_value(moran_i), law, left_out)


def _taken_apart(
    near: Neighbourhood,
    errors: Array,
    chosen: Trial,
    trials: Sequence[Trial],
    criterion: str,
    found: tuple[Finding, ...],
) -> Separation:
    span = projector(near.places, chosen.size)
    residuals = span.residuals(errors)
    return Separation(
        near=near,
        measured_mm=errors,
        deterministic=regress(near.places, errors, chosen.size),
        random_mm=residuals,
        chosen=chosen,
        trials=tuple(trials),
        sigma_mm=float(np.sqrt(np.sum(residuals**2) / (len(errors) - span.rank))),
        criterion=criterion,
        findings=found,
    )


def _not_normal(chosen: Trial, confidence: float) -> Finding:
    return Finding(
        Severity.WARNING,
        Code.SRF_MODEL,
        f"the residuals of {chosen.size} control points are spatially random but not normal: Lilliefors p "
        f"{chosen.normality.lilliefors_p:.2g} (Kolmogorov–Smirnov {chosen.normality.ks_p:.2g}), wanted above "
        f"{1 - confidence:.2g}",
        "look for single bad touches: they make the tails too heavy",
    )
