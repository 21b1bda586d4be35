"""One value for many."""

import numpy as np

from trueloop.arrays import Array


def rms(values: Array) -> float:
    """Root of the mean square, about zero and not about the mean; NaN of no values."""
    return float(np.sqrt(np.mean(values**2))) if len(values) else float("nan")
