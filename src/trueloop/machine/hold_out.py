"""How a model does on readings it was not made from."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from trueloop.errors import TrueloopError
from trueloop.machine.model import MachineModel
from trueloop.machine.observations import Observations


@dataclass(frozen=True)
class HeldOut:
    """Of one run: RMS and largest of reading − model, and RMS of the readings themselves; mm or rad."""

    run: str
    readings: int
    rms: float
    largest: float
    raw: float


def compare(model: MachineModel, readings: Observations, run: str = "") -> HeldOut:
    """A model against readings."""
    rest = readings.reading - readings.with_lags(model.lags).predicted(model)
    rms, raw = (float(np.sqrt(np.mean(values**2))) for values in (rest, readings.reading))
    return HeldOut(run, len(readings), rms, float(np.abs(rest).max()), raw)


def hold_out(readings: Observations, fit: Callable[[Observations], MachineModel]) -> tuple[HeldOut, ...]:
    """Each run predicted by a model fitted to all others; nothing for a single run.

    Runs without which the rest cannot determine the model are left out of the report.
    """
    runs = list(dict.fromkeys(readings.run))
    found = []
    for run in runs if len(runs) > 1 else []:
        own = np.array([name == run for name in readings.run])
        try:
            model = fit(readings.only(~own))
        except TrueloopError:
            continue
        found.append(compare(model, readings.only(own), run))
    return tuple(found)
