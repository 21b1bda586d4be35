"""The range of validity of a model: the machine's travel, and the positions and temperatures of its data."""

from collections.abc import Collection, Iterable, Mapping

import numpy as np
from numpy.typing import ArrayLike, NDArray

from trueloop.arrays import Array
from trueloop.errors import Code
from trueloop.machine.model.chain import ZERO, Axis, Vector, in_words
from trueloop.machine.model.history import check_lags_given
from trueloop.machine.model.model import MachineModel, State
from trueloop.machine.model.term import Signals

ROUNDING = 1e-6
"""Amount by which a quantity may lie outside: resolutions of controls and rounded ends."""
ROUNDING_MM = 1.3e-3
"""A length may lie outside by half of 0.0001 inch, in which many files state ends of travel that are whole mm."""


def known_state(
    model: MachineModel,
    positions: Mapping[str, ArrayLike],
    signals: Signals | None = None,
    *,
    tool_mm: Array | Vector = ZERO,
    extrapolate: Collection[str] = (),
) -> State:
    """Returns the state at which a model's errors are requested: `positions` by axis, machine coordinates in mm and
    rad, numbers or (n,).

    Axes that are not named stand at 0; the direction of travel is not known. `tool_mm` is the tool point from the frame
    of the last axis that carries the tool. Raises MCH-AXIS for an axis that the machine does not have, MCH-HISTORY for
    a lag that is not among the signals, and what `check_state` does.

    >>> machine, form = trueloop.read_machine(trueloop.example("machine/machine.toml"))
    >>> readings = trueloop.read_readings(trueloop.example("machine/readings.csv"), machine.chain)
    >>> found, _ = trueloop.fit_form(machine, form, readings)
    >>> state = trueloop.known_state(found.model, {"X": [100.0, 300.0], "Z": -100.0}, {"T1": 25.0})
    >>> (1e3 * found.model.error_mm(state)).round(1) + 0.0  # E at both places along X, Y, Z, µm
    array([[ 4. ,  0. ,  6.4],
           [12. ,  0. ,  6.4]])
    >>> (1e3 * found.model.comp_mtg_mm(state)).round(1) + 0.0  # what corrects it
    array([[ -4. ,   0. ,  -6.4],
           [-12. ,   0. ,  -6.4]])
    >>> trueloop.known_state(found.model, {"X": 600.0}, {"T1": 25.0})
    Traceback (most recent call last):
    trueloop.errors.TrueloopError
    """
    given, signals = {name: np.asarray(value, dtype=np.float64) for name, value in positions.items()}, signals or {}
    check_lags_given(model.lags, signals)
    state = State(model.machine.chain.positions(given), 0.0, signals, tool_mm)
    check_state(model, state, extrapolate)
    return state


def require_in_force(model: MachineModel, sha256: str) -> None:
    """Refuses an offered version that nobody accepted (MCH-OFFERED); `sha256` is that of the model's file."""
    version = model.version
    if version is None or version.accepted is not None:
        return
    raise Code.MCH_OFFERED.refusal(
        f"version {version.number} of the model of {model.machine.name!r} ({sha256[:16]}), made {version.made_at}, is "
        f"offered and not accepted: {version.reason}",
        hint="look at it: `trueloop machine show`; then accept it: `trueloop machine accept MODEL.json -o NEW.json`",
        values={"sha256": sha256},
    )


def check_state(model: MachineModel, state: State, extrapolate: Collection[str] = ()) -> None:
    """Refuses positions beyond travel (MCH-TRAVEL), and positions or signals beyond the data (MCH-RANGE).

    The latter may be allowed by naming the axis or signal in `extrapolate`: the model then goes on as its functions do,
    temperatures linearly, positions with the value at the end of the segments.
    """
    chain, ranged = model.machine.chain, list[Ranged]()
    for name, position in zip(chain.order, state.positions.T, strict=True):
        axis = chain.axis(name)
        check_travel(axis, position)
        if name in model.identified and name not in extrapolate and _depends_on(model, name):
            low, high = map(axis.in_unit, model.identified[name])
            ranged.append((name, np.array([axis.in_unit(k) for k in position]), (low, high), axis.unit))
    check_ranges((*ranged, *_signals_of_data(model, state.signals, extrapolate)))


def check_signals(model: MachineModel, signals: Signals, extrapolate: Collection[str] = ()) -> None:
    """Refuses signals beyond the data (MCH-RANGE), but those named."""
    check_ranges(_signals_of_data(model, signals, extrapolate))


def _signals_of_data(model: MachineModel, signals: Signals, extrapolate: Collection[str]) -> Iterable["Ranged"]:
    for name in model.needs():
        if name in model.identified and name in signals and name not in extrapolate:
            yield name, np.atleast_1d(signals[name]), model.identified[name], model.units.get(name, "")


def _depends_on(model: MachineModel, axis: str) -> bool:
    return any(term.name.axis == axis and any(part.basis.size > 1 for part in term.parts) for term in model.terms)


def outside(position: Array, travel: tuple[float, float], unit: str) -> NDArray[np.bool_]:
    """Returns which positions lie beyond, by more than rounding in their unit, (n,)."""
    least = ROUNDING_MM if unit == "mm" else ROUNDING
    beyond: NDArray[np.bool_] = (position < travel[0] - least) | (position > travel[1] + least)
    return beyond


def check_travel(axis: Axis, position: Array) -> None:
    """Raises MCH-TRAVEL for positions that the axis cannot reach."""
    if outside(position, axis.travel, axis.unit).any():
        low, high, *ends = map(axis.shown, (float(position.min()), float(position.max()), *axis.travel))
        way = f"to {low}" if low == high else f"from {low} to {high}"
        raise Code.MCH_TRAVEL.refusal(
            f"{axis.name} would go {way}, its travel is {ends[0]} to {ends[1]}",
            hint="check the work offset and the tool length, both in machine coordinates and mm",
            values={"axis": axis.name, "travel": [axis.in_unit(end) for end in axis.travel], "unit": axis.unit},
        )


Ranged = tuple[str, Array, tuple[float, float], str]
"""A quantity's name, its values (n,), the range that the data had, and the unit of both; `""` where it is not known."""


def check_ranges(quantities: Iterable[Ranged]) -> None:
    """Raises MCH-RANGE for quantities with values outside of those that the data had, naming all of them."""
    beyond = [
        (name, values, known, unit) for name, values, known, unit in quantities if outside(values, known, unit).any()
    ]
    if not beyond:
        return
    name, values, known, unit = beyond[0]
    raise Code.MCH_RANGE.refusal(
        "; ".join(_beyond(*quantity) for quantity in beyond),
        hint="warm the machine up, or characterize it over that range",
        override=" ".join(f"--extrapolate {name}" for name, *_ in beyond),
        values={"name": name, "found": [float(values.min()), float(values.max())], "known": list(known), "unit": unit},
    )


def _beyond(name: str, values: Array, bounds: tuple[float, float], unit: str) -> str:
    low, high, *ends = (in_words(value, unit) for value in (float(values.min()), float(values.max()), *bounds))
    return f"{name} is {low if low == high else f'{low} to {high}'}; the model was found from {ends[0]} to {ends[1]}"


def require_serial(model: MachineModel, serial: str | None) -> None:
    """Raises MCH-MACHINE for a model of a machine with another serial number than the one given."""
    if serial is not None and serial != model.machine.serial:
        raise Code.MCH_MACHINE.refusal(
            f"the model is of {model.machine.name!r}, serial number {model.machine.serial!r}, not {serial!r}",
            hint="every machine errs in its own way: make a model of this one",
            values={"machine": model.machine.name, "serial": model.machine.serial, "expected_serial": serial},
        )
