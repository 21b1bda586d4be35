"""Types of arrays, and arrays as the Rust core takes them."""

from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array: TypeAlias = NDArray[np.float64]
Flags: TypeAlias = NDArray[np.bool_]
Integers: TypeAlias = NDArray[np.integer[Any]]


def for_kernel(values: ArrayLike) -> Array:
    """Values as the Rust core takes them: row by row and aligned, which what comes from another process may not be."""
    return np.require(values, np.float64, ("C_CONTIGUOUS", "ALIGNED"))
