"""Similarity between nominal and measured points of a plane: where a part lay, how it was turned, how it had grown."""

from dataclasses import dataclass

import numpy as np

from trueloop.arrays import Array
from trueloop.errors import Code, TrueloopError


@dataclass(frozen=True)
class Similarity:
    """measured ≈ offset + scale · R(rotation) · nominal; `residual_mm` (n, 2) is what is left, measured − fitted."""

    offset_mm: tuple[float, float]
    scale: float
    rotation_rad: float
    residual_mm: Array

    @property
    def offset(self) -> complex:
        """The offset as a complex number."""
        return complex(*self.offset_mm)

    @property
    def slope(self) -> complex:
        """What is beyond the identity, scale · exp(i rotation) − 1."""
        return complex(self.scale * np.exp(1j * self.rotation_rad) - 1.0)

    @property
    def rms_mm(self) -> float:
        """Root mean square of the residuals' lengths."""
        return float(np.sqrt(np.mean(np.sum(self.residual_mm**2, axis=1))))


def fit_similarity(nominal_mm: Array, measured_mm: Array) -> Similarity:
    """Least-squares similarity of (n, 2) points; in complex numbers w ≈ a + b z. Raises MCH-DATA below 3 points."""
    if len(nominal_mm) < 3 or nominal_mm.shape != measured_mm.shape:
        raise TrueloopError(
            Code.MCH_DATA,
            f"{len(nominal_mm)} nominal and {len(measured_mm)} measured points do not determine a similarity",
            hint="give three pairs of points at least",
        )
    z, w = as_complex(nominal_mm), as_complex(measured_mm)
    rows = np.column_stack([np.ones_like(z), z])
    (a, b), *_ = np.linalg.lstsq(rows, w, rcond=None)
    rest = w - rows @ np.array([a, b])
    return Similarity((a.real, a.imag), float(abs(b)), float(np.angle(b)), np.column_stack([rest.real, rest.imag]))


def as_complex(points: Array) -> np.ndarray[tuple[int], np.dtype[np.complex128]]:
    """(n, 2) points as n complex numbers."""
    number: np.ndarray[tuple[int], np.dtype[np.complex128]] = points[:, 0] + 1j * points[:, 1]
    return number
