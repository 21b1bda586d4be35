"""How the virtual lathe warms up: heat of spindle and screw, what lags behind it, and what its sensors say.

Time constants are those of a lathe divided by 60: a second here is a minute there, so that a cut of a minute sees the
warm-up of an hour.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from trueloop.arrays import Array

COLD_C: Final = 20.0
FASTER: Final = 60.0
STEP_S: Final = 0.02
BEARING_K, BEARING_S = 24.0, 20.0
CASTING_SHARE, CASTING_S = 0.8, 30.0
NUT_K, NUT_S, SCREW_S = 8.0, 25.0, 18.0
HALL_K, HALL_PERIOD_S = 0.4, 900.0
SURFACE_SHARE: Final = 0.2
SENSOR_NOISE_K: Final = 0.02

Spans = Sequence[tuple[float, float]]
"""From when to when something runs, s."""


@dataclass(frozen=True)
class WarmUp:
    """Temperatures over time, each (n,), °C above 20: front bearing, casting of the headstock, nut, screw, hall.

    The nut is heated where it runs; the screw follows it, and no sensor is on it.
    """

    time_s: Array
    bearing: Array
    casting: Array
    nut: Array
    screw: Array
    hall: Array

    def at(self, time_s: Array) -> "WarmUp":
        """At other times, straight between the known ones, the ends holding beyond."""
        known = (self.bearing, self.casting, self.nut, self.screw, self.hall)
        return WarmUp(time_s, *(np.interp(time_s, self.time_s, values) for values in known))

    def sensors(self, rng: np.random.Generator | None = None) -> dict[str, Array]:
        """What is measured, °C: T1 at the bearing, T2 on the casting's skin near it, T3 at the nut."""
        skin = (1 - SURFACE_SHARE) * self.casting + SURFACE_SHARE * self.bearing
        true = {"T1": self.bearing, "T2": skin, "T3": self.nut}
        noise = rng.normal(0.0, SENSOR_NOISE_K, (3, len(self.time_s))) if rng else np.zeros((3, len(self.time_s)))
        return {name: COLD_C + self.hall + true[name] + n for name, n in zip(true, noise, strict=True)}


def warm_up(until_s: float, spindle: Spans, axes: Spans) -> WarmUp:
    """From a cold machine at 0 s, with the spindle turning and the axes moving within the spans."""
    time_s = np.arange(0.0, until_s + STEP_S, STEP_S)
    turning, moving = (_within(time_s, spans) for spans in (spindle, axes))
    bearing = _follows(BEARING_K * turning, BEARING_S)
    casting = _follows(CASTING_SHARE * bearing, CASTING_S)
    nut = _follows(NUT_K * moving, NUT_S)
    hall = HALL_K * np.sin(2 * np.pi * time_s / HALL_PERIOD_S)
    return WarmUp(time_s, bearing, casting, nut, _follows(nut, SCREW_S), hall)


def _within(time_s: Array, spans: Spans) -> Array:
    return np.asarray(sum(((time_s >= low) & (time_s < high) for low, high in spans), np.zeros(len(time_s))))


def _follows(driven: Array, constant_s: float) -> Array:
    """A body that takes on the temperature of what heats it, cold at first."""
    share, at, found = STEP_S / constant_s, 0.0, np.empty(len(driven))
    for k, towards in enumerate(driven.tolist()):
        at += share * (towards - at)
        found[k] = at
    return found
