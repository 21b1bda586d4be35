"""The Rust core, as Python sees it. Checked against the built module by a test."""

import numpy as np
from numpy.typing import NDArray

# curve-fit: constrained splines

class CurveFitError(ValueError):
    """A fit was refused: arguments are the kind, a message and where points are missing (from, to) or None."""

def fit_spline(
    points: NDArray[np.float64],
    values: NDArray[np.float64],
    weights: NDArray[np.float64] | None,
    interior_knots: NDArray[np.float64],
    length: float,
    degree: int,
    ends: tuple[float | None, float | None, float | None, float | None],
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Least-squares spline with end conditions: (coefficients, covariance band, sensitivity, leverages)."""

def spline_basis(
    points: NDArray[np.float64],
    interior_knots: NDArray[np.float64],
    length: float,
    degree: int,
    lower: float,
    upper: float,
) -> tuple[NDArray[np.int64], NDArray[np.float64], NDArray[np.float64]]:
    """Basis functions that differ from zero at each point: (index of the first, values, slopes)."""
