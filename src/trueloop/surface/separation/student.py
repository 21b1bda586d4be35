"""Student's law, for standard deviations that are estimates themselves."""

from typing import Final

COVERAGE: Final = 0.95
MANY: Final = 100_000
"""Degrees of freedom with which Student's law is the normal one; more parts than anybody measures."""


def student(coverage: float, freedom: float) -> float:
    """Two-sided factor of Student's t."""
    from scipy.special import stdtrit  # slow to import

    return float(stdtrit(freedom, 0.5 + coverage / 2))
