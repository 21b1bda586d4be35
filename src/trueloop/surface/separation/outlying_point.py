"""A touch that does not belong to its part, and a part whose touches scatter more than the others'."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from trueloop.surface.separation.places import projector
from trueloop.surface.separation.separate import Separation

COVERAGE: Final = 0.95
MANY: Final = 100_000
"""Degrees of freedom with which Student's law is the normal one; more parts than anybody measures."""


def student(coverage: float, freedom: float) -> float:
    """Two-sided factor of Student's t."""
    from scipy.special import stdtrit  # slow to import

    return float(stdtrit(freedom, 0.5 + coverage / 2))


@dataclass(frozen=True)
class OutlyingPoint:
    """The place of a part, from 0, that its surface fits worst: by how much, and the probability of that by chance."""

    index: int
    off_mm: float
    p_value: float


@dataclass(frozen=True)
class ScatteringPart:
    """The part, from 0, whose random part is largest, that of the others, and the probability of that by chance."""

    index: int
    sigma_mm: float
    others_mm: float
    p_value: float


def outlying_point(apart: Separation) -> OutlyingPoint:
    """The touch with the largest studentised residual.

    What the fit without the touch would leave at it, r/(1 − h), over its standard deviation from all other touches,
    follows Student's t (Cook & Weisberg 1982, §2.2.2); the probability is shared among the touches (Bonferroni). Valid
    for one bad touch: two beside each other hide behind each other.
    """
    from scipy.special import stdtr  # slow to import

    span = projector(apart.places, apart.chosen.size)
    left, free = apart.random_mm, np.maximum(1.0 - span.leverages, 1e-9)
    freedom = len(left) - span.rank - 1
    others = np.maximum(np.sum(left**2) - left**2 / free, 0.0) / freedom
    t = np.abs(left) / np.sqrt(np.maximum(others * free, np.finfo(float).tiny))
    k = int(np.argmax(t))
    return OutlyingPoint(k, float(left[k] / free[k]), min(1.0, 2 * len(left) * float(stdtr(freedom, -t[k]))))


def scattering_part(parts: Sequence[Separation]) -> ScatteringPart:
    """The part whose touches scatter most, by an F test against the others, shared among the parts (Bonferroni)."""
    from scipy.special import fdtrc  # slow to import

    freedom = np.array([len(part.random_mm) - projector(part.places, part.chosen.size).rank for part in parts])
    squares = np.array([part.sigma_mm**2 for part in parts]) * freedom
    k = int(np.argmax(squares / freedom))
    rest = np.delete(np.arange(len(parts)), k)
    others = float(np.sum(squares[rest]) / np.sum(freedom[rest]))
    ratio = float(squares[k] / freedom[k]) / max(others, np.finfo(float).tiny)
    p = min(1.0, len(parts) * float(fdtrc(freedom[k], np.sum(freedom[rest]), ratio)))
    return ScatteringPart(k, parts[k].sigma_mm, others**0.5, p)
