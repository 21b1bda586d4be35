"""What a diagnosis of the series adds to the causes of an alarm."""

from dataclasses import replace

from trueloop.diagnosis.causes.candidate import Candidate, Diagnosis
from trueloop.monitoring.explain import Explained, Likely


def with_diagnosis(found: Explained, diagnosis: Diagnosis, sigma_mm: float) -> Explained:
    """The explained alarm with the candidates of a diagnosis: they share what nothing known explains.

    A candidate gets its probability of that share, less where all of them together have more than 1; what is left
    stays unknown. Sizes are in `sigma_mm`, the charts' standard deviation.
    """
    total = max(1.0, sum(one.probability for one in diagnosis.candidates))
    added = [_likely(one, found.unknown * one.probability / total, sigma_mm) for one in diagnosis.candidates]
    ordered = sorted([*found.likely, *added], key=lambda one: one.probability, reverse=True)
    left = found.unknown - sum(one.probability for one in added)
    return replace(found, likely=tuple(ordered), unknown=max(left, 0.0))


def _likely(one: Candidate, probability: float, sigma_mm: float) -> Likely:
    words = one.supports[0] if one.supports else one.cause.name
    return Likely(one.cause.key, words, probability, one.size_mm / sigma_mm, one.standard_u_mm / sigma_mm)
