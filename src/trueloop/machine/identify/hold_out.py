"""The residuals of a model in readings it was not made from."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from trueloop.arrays import Array
from trueloop.errors import TrueloopError
from trueloop.machine.identify.identify import Identification, values_weight, weighted_rows
from trueloop.machine.identify.observations import Observations
from trueloop.machine.identify.robust import instrument_columns, orthonormal, slope_columns, without, zero_columns
from trueloop.machine.model.model import MachineModel
from trueloop.statistics import rms
from trueloop.units import UM_PER_MM, URAD_PER_RAD

Rows = NDArray[np.bool_]

SPARED = 1e-7
"""The share of the information of all runs on some combination of terms that has to be left without one run."""


@dataclass(frozen=True)
class Left:
    """The residuals of readings of one kind: RMS of the readings, RMS and largest of reading − model; all in one unit.

    All without the runs' own zeros and slopes, where those are not known. `gain` is the slope of the readings on their
    prediction, `scaled_rms` what gain · prediction leaves of them; `chi2` the mean square of reading − model in units
    of its variance, where that is known.
    """

    readings: int
    raw: float
    rms: float
    largest: float
    gain: float
    scaled_rms: float
    chi2: float | None = None


@dataclass(frozen=True)
class HeldOut:
    """The residuals of one run, lengths and angles apart; None where it has no reading of the kind."""

    run: str
    length_mm: Left | None
    angle_rad: Left | None

    @property
    def by_unit(self) -> dict[str, Left]:
        """Returns the existing residuals as they are printed: in µm, in µrad."""
        kinds = (("µm", self.length_mm, UM_PER_MM), ("µrad", self.angle_rad, URAD_PER_RAD))
        return {unit: _scaled(left, scale) for unit, left, scale in kinds if left}


def compare(model: MachineModel, readings: Observations, run: str = "") -> HeldOut:
    """Compares a model with readings, whose runs' own zeros and slopes are taken out of the residuals.

    >>> machine, form = trueloop.read_machine(trueloop.example("machine/machine.toml"))
    >>> readings = trueloop.read_readings(trueloop.example("machine/readings.csv"), machine.chain)
    >>> found, _ = trueloop.fit_form(machine, form, readings)
    >>> left = trueloop.compare(found.model, readings).by_unit["µm"]
    >>> round(left.raw, 1), round(left.rms, 1)  # RMS of the readings, and of what the model leaves
    (7.7, 0.2)
    """
    chain = model.machine.chain
    opened = np.hstack([zero_columns(readings), slope_columns(chain, readings), instrument_columns(readings)])
    both = np.column_stack([readings.reading, readings.reading - readings.with_lags(model.lags).predicted(model)])
    return _held(run, without(opened, both), readings.is_angle)


def _held(run: str, both: Array, angle: Rows, chi2: float | None = None) -> HeldOut:
    raw, rest = both.T
    length_mm, angle_rad = (_left(raw[rows], rest[rows], chi2) for rows in (~angle, angle))
    return HeldOut(run, length_mm, angle_rad)


def hold_out(
    readings: Observations, found: Identification, refit: Callable[[Observations], MachineModel], *, anew: bool = False
) -> tuple[HeldOut, ...]:
    """Predicts each run from all others, with the weights that readings have in `found`; nothing for a single run.

    The readings of a run are taken out of the normal equations of all. Where the others cannot determine every term,
    and for every run with `anew` (for models that are not linear, or choose), the model is fitted to them. Runs
    without which that fails too are left out of the report.
    """
    runs = list(dict.fromkeys(readings.run))
    if len(runs) < 2:
        return ()
    predicted = None if anew else _Downdated(found, readings)
    judged = []
    for run in runs:
        own = np.array([name == run for name in readings.run])
        left = predicted and predicted.without_rows(own, run)
        judged.append(left or _refitted(readings, own, run, refit))
    return tuple(left for left in judged if left)


def _refitted(
    readings: Observations, own: Rows, run: str, refit: Callable[[Observations], MachineModel]
) -> HeldOut | None:
    try:
        return compare(refit(readings.only(~own)), readings.only(own), run)
    except TrueloopError:
        return None


class _Downdated:
    """The weighted readings in an orthonormal basis q of the columns of model and instruments, zeros and slopes of runs
    taken out.
    """

    def __init__(self, found: Identification, readings: Observations) -> None:
        machine = found.model.machine
        whole = readings.with_lags(found.model.lags)
        rows, values, _ = weighted_rows(machine, found.model.terms, whole)
        root = np.sqrt(found.share)
        self.readings, self.root, self.weight = readings, root, values_weight(readings) * root
        self.opened = np.hstack([zero_columns(readings), slope_columns(machine.chain, readings)])
        opened = self.opened * self.weight[:, None]
        shared = instrument_columns(readings)
        columns = np.hstack([rows * root[:, None], shared * self.weight[:, None]])
        self.q = orthonormal(without(opened, columns))
        self.opened = np.hstack([self.opened, shared])
        self.values = without(opened, values * root)
        self.right = self.q.T @ self.values

    def without_rows(self, own: Rows, run: str) -> HeldOut | None:
        """Returns the residuals of the rows `own` from the equations of all others; None where these do not determine
        the model.
        """
        q, values = self.q[own], self.values[own]
        strength, directions = np.linalg.eigh(np.eye(q.shape[1]) - q.T @ q)
        if strength[0] < SPARED:
            return None
        solution = directions @ ((directions.T @ (self.right - q.T @ values)) / strength)
        rest = (values - q @ solution) / self.weight[own]
        both = without(self.opened[own], np.column_stack([self.readings.reading[own], rest]))
        # the variance of the deviation is I + q (I − qᵀq)⁻¹ qᵀ, its inverse I − q qᵀ; weights of outliers are left out
        deviation = (values - q @ solution) / self.root[own]
        along = q.T @ deviation
        return _held(run, both, self.readings.is_angle[own], float(deviation @ deviation - along @ along) / len(q))


def _left(raw: Array, rest: Array, chi2: float | None) -> Left | None:
    if not len(raw):
        return None
    predicted = raw - rest
    size = float(predicted @ predicted)
    gain = float(raw @ predicted) / size if size > 0 else 0.0
    return Left(len(raw), rms(raw), rms(rest), float(np.abs(rest).max()), gain, rms(raw - gain * predicted), chi2)


def _scaled(left: Left, scale: float) -> Left:
    lengths = {name: scale * getattr(left, name) for name in ("raw", "rms", "largest", "scaled_rms")}
    return replace(left, **lengths)
