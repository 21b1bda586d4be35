"""First-order lags: what a part of the machine feels of a temperature or a speed, a while later."""

import numpy as np

from trueloop.arrays import Array
from trueloop.errors import Code, TrueloopError


def lagged(time_s: Array, inputs: Array, constants_s: Array) -> Array:
    """The solution of τ dy/dt + y = u for each input and time constant, (n, inputs, constants).

    Exact for inputs that run straight between the rows; in equilibrium at the first row (y = u). τ = 0 gives u itself.
    `inputs` (n, inputs), times ascending in any steps. Raises MCH-DATA for times that do not ascend.
    """
    step_s = np.diff(time_s)
    if np.any(step_s <= 0):
        raise TrueloopError(
            Code.MCH_DATA,
            f"times do not ascend at row {int(np.argmax(step_s <= 0)) + 2}",
            hint="sort the rows by time and drop repeated ones",
        )
    return np.stack([_one(step_s, inputs, max(float(tau), 1e-9)) for tau in constants_s], axis=-1)


def _one(step_s: Array, inputs: Array, tau: float) -> Array:
    """y[k+1] = decay·y[k] + u[k+1] − decay·u[k] − τ·slope·(1 − decay): a bidiagonal system, solved as one."""
    from scipy.linalg import solve_banded

    decay = np.exp(-step_s / tau)[:, None]
    slope = np.diff(inputs, axis=0) / step_s[:, None]
    right = np.vstack([inputs[:1], inputs[1:] - decay * inputs[:-1] - tau * slope * (1 - decay)])
    bands = np.ones((2, len(inputs)))
    bands[1, :-1] = -decay[:, 0]
    solution: Array = solve_banded((1, 0), bands, right)
    return solution
