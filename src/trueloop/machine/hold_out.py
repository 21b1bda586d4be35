"""How a model does on readings it was not made from."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from trueloop.errors import TrueloopError
from trueloop.geometry.feature import Array
from trueloop.machine.model import MachineModel
from trueloop.machine.observations import Observations
from trueloop.machine.run_zeros import slope_columns, without, zero_columns
from trueloop.statistics import rms
from trueloop.units import UM_PER_MM, URAD_PER_RAD


@dataclass(frozen=True)
class Left:
    """Of readings of one kind: RMS of the readings, RMS and largest of reading − model; all in one unit.

    All without the runs' own zeros and slopes, where those are not known.
    """

    readings: int
    raw: float
    rms: float
    largest: float


@dataclass(frozen=True)
class HeldOut:
    """Of one run, lengths and angles apart; None where it has no reading of the kind."""

    run: str
    length_mm: Left | None
    angle_rad: Left | None

    @property
    def by_unit(self) -> dict[str, Left]:
        """What there is, as it is told: in µm, in µrad."""
        kinds = (("µm", self.length_mm, UM_PER_MM), ("µrad", self.angle_rad, URAD_PER_RAD))
        return {unit: _scaled(left, scale) for unit, left, scale in kinds if left}


def compare(model: MachineModel, readings: Observations, run: str = "") -> HeldOut:
    """A model against readings, what is left of them by their runs' own zeros and slopes taken out."""
    chain = model.machine.chain
    opened = np.hstack([zero_columns(readings), slope_columns(chain, readings)])
    both = np.column_stack([readings.reading, readings.reading - readings.with_lags(model.lags).predicted(model)])
    raw, rest = without(opened, both).T
    angle = readings.is_angle
    length_mm, angle_rad = (_left(raw[rows], rest[rows]) for rows in (~angle, angle))
    return HeldOut(run, length_mm, angle_rad)


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


def _left(raw: Array, rest: Array) -> Left | None:
    if not len(raw):
        return None
    return Left(len(raw), rms(raw), rms(rest), float(np.abs(rest).max()))


def _scaled(left: Left, scale: float) -> Left:
    return replace(left, raw=scale * left.raw, rms=scale * left.rms, largest=scale * left.largest)
