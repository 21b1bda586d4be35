"""First-order lags: what a part of the machine feels of a temperature or a speed, a while later."""

import numpy as np

from trueloop.errors import Code, TrueloopError
from trueloop.geometry.feature import Array


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
    tau = np.maximum(constants_s, 1e-9)
    result = np.empty((*inputs.shape, len(tau)))
    result[0] = inputs[0][:, None]
    for k, dt in enumerate(step_s):
        slope = (inputs[k + 1] - inputs[k])[:, None] / dt
        decay = np.exp(-dt / tau)
        result[k + 1] = inputs[k + 1][:, None] - tau * slope + (result[k] - inputs[k][:, None] + tau * slope) * decay
    return result
