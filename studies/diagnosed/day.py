"""Temperatures of a day: spindle, carriage and cross slide warm by time constants of their own, with pauses."""

from dataclasses import dataclass
from typing import Final

import numpy as np

from studies.diagnosed.axis_errors import REFERENCE_C, SIGNALS

MINUTES_A_PART: Final = 12.0
RISE_K: Final = (20.0, 13.0, 10.0)
CONSTANT_MIN: Final = (55.0, 80.0, 30.0)
HALL_K: Final = 0.8
SENSOR_K: Final = 0.03


@dataclass(frozen=True)
class Moment:
    """One part's: minutes since the day began, and temperatures by signal, as they are and as sensors read them."""

    minutes: float
    true_c: dict[str, float]
    read_c: dict[str, float]


def day(parts: int, rng: np.random.Generator, steady: bool = False) -> tuple[Moment, ...]:
    """A moment for each part; with `steady` an air-conditioned machine that never warms.

    Speed and travel differ from part to part as batches do, and every few parts there is a pause of half an hour.
    """
    warm, minutes, found = np.zeros(3), 0.0, []
    load = rng.uniform(0.3, 1.0, 3)
    for k in range(parts):
        if k % 5 == 0:
            load = rng.uniform(0.3, 1.0, 3)
        rest = float(rng.uniform(15.0, 50.0)) if k and k % 6 == 0 else 0.0
        for span, towards in ((rest, np.zeros(3)), (MINUTES_A_PART, load * RISE_K)):
            warm = towards + (warm - towards) * np.exp(-span / np.array(CONSTANT_MIN))
        minutes += rest + MINUTES_A_PART
        hall = HALL_K * np.sin(2 * np.pi * minutes / 600.0)
        at = REFERENCE_C + (0.0 if steady else 1.0) * (warm + hall)
        read = at + rng.normal(0.0, SENSOR_K, 3) * (0.0 if steady else 1.0)
        found.append(Moment(minutes, _named(at), _named(read)))
    return tuple(found)


def _named(values: np.ndarray) -> dict[str, float]:
    return {name: float(value) for name, value in zip(SIGNALS, values, strict=True)}
