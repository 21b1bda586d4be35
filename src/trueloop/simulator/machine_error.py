"""How the simulated machine errs: E(p, T) = actual − commanded position, a sum of powers.

Each term adds `coefficient_mm` · (x/100)^i · (z/100)^j · (T − 20 °C)^k to the error of one axis, positions in mm. The
machine's own model (package `machine`) is not used: the simulator must be able to prove it wrong.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np

from trueloop.arrays import Array

PER_MM: Final = 0.01
REFERENCE_C: Final = 20.0


@dataclass(frozen=True)
class ErrorTerm:
    """One term; `axis` 0 is x, 1 is z."""

    axis: int
    coefficient_mm: float
    x_power: int = 0
    z_power: int = 0
    temperature_power: int = 0


@dataclass(frozen=True)
class MachineError:
    """All terms. Without any the machine goes where it is commanded."""

    terms: tuple[ErrorTerm, ...] = ()

    def error_mm(self, position_mm: Array, temperature_c: float) -> Array:
        """E at positions (n, 2), (n, 2)."""
        error = np.zeros_like(position_mm)
        x, z, warmer = position_mm[:, 0] * PER_MM, position_mm[:, 1] * PER_MM, temperature_c - REFERENCE_C
        for term in self.terms:
            shape = x**term.x_power * z**term.z_power * warmer**term.temperature_power
            error[:, term.axis] += term.coefficient_mm * shape
        return error
