"""What a diagnosis answers: causes with probabilities, evidence in words, remedies, and what would decide."""

from dataclasses import dataclass

from trueloop.diagnosis.causes.cause import Cause
from trueloop.errors import Finding


@dataclass(frozen=True)
class Candidate:
    """One cause on some features: `probability` that it acts, `size_mm` ± `standard_u_mm` if it does.

    `supports` and `contradicts` are evidence in words. `tool` is the one that it concerns, where it is one tool's. The
    size is what it leaves on the feature and the part that show it most, as an error there.
    """

    cause: Cause
    features: tuple[str, ...]
    probability: float
    size_mm: float
    standard_u_mm: float
    supports: tuple[str, ...] = ()
    contradicts: tuple[str, ...] = ()
    tool: str = ""


@dataclass(frozen=True)
class Diagnosis:
    """Of one series: candidates, likeliest first; `sound` is the probability that nothing acts.

    `hypotheses` are sets of causes by their keys with probabilities; () is none. `decide` says in words which
    measurement would tell apart what is left.
    """

    candidates: tuple[Candidate, ...]
    hypotheses: tuple[tuple[tuple[str, ...], float], ...]
    sound: float
    decide: tuple[str, ...] = ()
    gain: float = 1.0
    findings: tuple[Finding, ...] = ()
