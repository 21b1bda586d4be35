"""Thermal drift after ISO 230-3: how far a machine moves by itself while its surroundings or its spindle warm it."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from trueloop.arrays import Array
from trueloop.errors import Code, TrueloopError


@dataclass(frozen=True)
class Drift:
    """Of one channel, in the unit of its values: range over the whole test, and the largest range within `window_s`."""

    channel: str
    total_range: float
    window_s: float
    window_range: float
    window_start_s: float


@dataclass(frozen=True)
class DriftTest:
    """Displacements (mm), temperatures (°C) and speeds (rev/min) by name at `time_s`, (m,) each."""

    time_s: Array
    displacement_mm: Mapping[str, Array]
    temperature: Mapping[str, Array]
    speed: Mapping[str, Array]

    @property
    def signals(self) -> dict[str, Array]:
        """Temperatures and speeds as a drift model takes them: under their columns' names, NAME_degC and NAME_rpm."""
        warm = {f"{name}_degC": values for name, values in self.temperature.items()}
        return warm | {f"{name}_rpm": values for name, values in self.speed.items()}


def drift(time_s: Array, values: Array, channel: str, window_s: float) -> Drift:
    """Analyses one channel, (n,) each. Raises MCH-DATA where time does not ascend or does not cover a window."""
    if len(time_s) < 2 or np.any(np.diff(time_s) <= 0) or time_s[-1] - time_s[0] < window_s:
        raise TrueloopError(
            Code.MCH_DATA,
            f"{channel}: {len(time_s)} rows do not cover {window_s:g} s in ascending time",
            hint="sort the rows by time, or choose a shorter window",
        )
    starts = np.flatnonzero(time_s <= time_s[-1] - window_s + 1e-9)
    ends = np.searchsorted(time_s, time_s[starts] + window_s, side="right")
    ranges = np.array([np.ptp(values[a:b]) for a, b in zip(starts, ends, strict=True)])
    worst = int(ranges.argmax())
    return Drift(channel, float(np.ptp(values)), window_s, float(ranges[worst]), float(time_s[starts[worst]]))
