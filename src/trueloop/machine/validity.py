"""Where a model may be asked: within the machine's travel, and within the positions and temperatures of its data."""

from collections.abc import Collection

import numpy as np

from trueloop.errors import Code, TrueloopError
from trueloop.geometry.feature import Array
from trueloop.machine.model import MachineModel, State

ROUNDING = 1e-6
"""mm or rad by which a position may lie outside: control resolutions and rounded ends of travel."""


def check_state(model: MachineModel, state: State, extrapolate: Collection[str] = ()) -> None:
    """Refuses positions beyond travel (MCH-TRAVEL), and positions or signals beyond the data (MCH-RANGE).

    The latter may be allowed by naming the axis or signal in `extrapolate`: the model then goes on as its functions do,
    temperatures linearly, positions with the value at the end of the segments.
    """
    chain = model.machine.chain
    for name, position in zip(chain.order, state.positions.T, strict=True):
        _check_travel(name, position, chain.axis(name).travel)
        if name in model.identified and name not in extrapolate and _depends_on(model, name):
            _check_range(name, position, model.identified[name], "mm or rad")
    for name in model.needs():
        if name in model.identified and name in state.signals and name not in extrapolate:
            _check_range(name, np.atleast_1d(state.signals[name]), model.identified[name], "in the unit of the data")


def _depends_on(model: MachineModel, axis: str) -> bool:
    return any(term.name.axis == axis and any(part.basis.size > 1 for part in term.parts) for term in model.terms)


def _check_travel(name: str, position: Array, travel: tuple[float, float]) -> None:
    low, high = float(position.min()), float(position.max())
    if low < travel[0] - ROUNDING or high > travel[1] + ROUNDING:
        raise TrueloopError(
            Code.MCH_TRAVEL,
            f"{name} would go from {low:g} to {high:g}, its travel is {travel[0]:g} to {travel[1]:g}",
            hint="check the work offset and the tool length, both in machine coordinates and mm",
        )


def _check_range(name: str, values: Array, known: tuple[float, float], unit: str) -> None:
    low, high = float(values.min()), float(values.max())
    if low < known[0] - ROUNDING or high > known[1] + ROUNDING:
        raise TrueloopError(
            Code.MCH_RANGE,
            f"{name} is {low:g} to {high:g}; the model was found from {known[0]:g} to {known[1]:g} ({unit})",
            hint="warm the machine up, or characterize it over that range",
            override=f"--extrapolate {name}",
        )
