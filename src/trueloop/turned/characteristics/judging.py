"""A characteristic judged from the part errors at its places and their covariance."""

from dataclasses import replace
from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.domain.characteristic import Characteristic, Quantity
from trueloop.domain.judged import Judgement, Verdict
from trueloop.tolerances.conformance import PROVEN, judge
from trueloop.turned.characteristics.covariance import Covariance
from trueloop.turned.characteristics.measurand import Measurand

DRAWS: Final = 10_000
"""Parts drawn where several sizes have to be in together: a probability is good to 0.5 %."""


def judged(asked: Characteristic, sizes: Measurand, error_mm: Array, covariance: Covariance) -> Judgement:
    """Judges one size by its distribution; of several, the one least likely to be in, and the probability that all
    are.
    """
    values = sizes.nominal + sizes.gains @ error_mm
    if asked.quantity is Quantity.FORM:
        return _form(asked, _drawn(values, sizes.gains, covariance))
    standard_u, freedom = covariance.of(sizes.gains)
    each = [
        judge(value, u, known, asked.lower_limit, asked.upper_limit)
        for value, u, known in zip(values.tolist(), standard_u.tolist(), freedom, strict=True)
    ]
    worst = min(each, key=lambda one: (one.probability_in or 0.0, one.margin or 0.0))
    return (
        worst
        if len(each) == 1 or worst.probability_in is None
        else _together(asked, worst, _drawn(values, sizes.gains, covariance))
    )


def _together(asked: Characteristic, worst: Judgement, drawn: Array) -> Judgement:
    """Returns the worst size with the probability that all are in, and proven in only where that is proven."""
    low = -np.inf if asked.lower_limit is None else asked.lower_limit
    high = np.inf if asked.upper_limit is None else asked.upper_limit
    share = float(np.mean(np.all((drawn >= low) & (drawn <= high), axis=1)))
    probability = share if worst.probability_in is None else min(share, worst.probability_in)
    unproven = worst.verdict == "in" and probability < PROVEN
    return replace(worst, probability_in=probability, verdict="undecided" if unproven else worst.verdict)


def _form(asked: Characteristic, drawn: Array) -> Judgement:
    """Judges the range of the residuals of a fitted line or circle: never negative, and so judged by its share
    alone.
    """
    form = np.ptp(drawn, axis=1)
    upper, value = asked.upper_limit, float(np.mean(form))
    if upper is None:
        return Judgement(value, float(np.std(form)), None, None, None, None)
    share = float(np.mean(form <= upper))
    verdict: Verdict = "in" if share >= PROVEN else "out" if share <= 1.0 - PROVEN else "undecided"
    return Judgement(value, float(np.std(form)), None, share, upper - value, verdict)


def _drawn(values: Array, gains: Array, covariance: Covariance) -> Array:
    """Draws sizes of so many parts, (draws, m), the same in every run; those from touches by Student's distribution."""
    rng = np.random.default_rng(0)
    found, stated = (rng.standard_normal((DRAWS, len(part))) @ _root(part).T for part in covariance.parts)
    freedom = covariance.degrees_of_freedom
    if freedom is not None:
        found *= np.sqrt(freedom / rng.chisquare(freedom, DRAWS))[:, None]
    return np.asarray(values + (found + stated) @ gains.T)


def _root(covariance: Array) -> Array:
    """Returns R with R Rᵀ = covariance."""
    values, vectors = np.linalg.eigh(covariance)
    return np.asarray(vectors * np.sqrt(np.maximum(values, 0.0)))
