"""Drift models at work: later rows predicted from earlier ones, and other logs."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.machine.drift.drift import DriftTest
from trueloop.machine.drift.model import DriftModel, fit_drift
from trueloop.machine.model.validity import check_range
from trueloop.statistics import rms
from trueloop.units import SIGNALS, UM_PER_MM

REZEROED_H: Final = (1.0, 2.0, 4.0, 8.0)
"""Hours between references that are tried."""

STATIC = ((0.0,),)
"""The ladder of a model that knows no past."""


@dataclass(frozen=True)
class DriftRun:
    """One channel, µm: `predicted_um` (k,) for its last k rows, and root mean squares over them.

    `rms_um` of what the model of the earlier rows leaves there, `static_rms_um` of what one without the past leaves,
    `raw_um` of the displacement itself against the mean of the earlier rows, `rezeroed_um` of what is left where an
    operator's reference sets it to zero every so many hours (hours to RMS).
    """

    channel: str
    predicted_um: Array
    rms_um: float
    static_rms_um: float
    raw_um: float
    rezeroed_um: Mapping[float, float] = field(default_factory=dict)


def held_out(test: DriftTest, share: float) -> list[DriftRun]:
    """Every channel's last `share` of the time, predicted from what was before. Raises MCH-DATA for too few rows."""
    known = test.time_s <= test.time_s[-1] - share * (test.time_s[-1] - test.time_s[0])
    before = {name: values[known] for name, values in test.signals.items()}
    runs = []
    for channel, moved_mm in test.displacement_mm.items():
        moved = UM_PER_MM * moved_mm
        model = fit_drift(test.time_s[known], before, moved[known])
        static = fit_drift(test.time_s[known], before, moved[known], STATIC)
        found = model.predict(test.time_s, test.signals)[~known]
        still = static.predict(test.time_s, test.signals)[~known]
        rest = moved[~known]
        rezeroed = {hours: rms(since_reference(test.time_s[~known], rest - found, hours)) for hours in REZEROED_H}
        raw = rms(rest - float(moved[known].mean()))
        runs.append(DriftRun(channel, found, rms(rest - found), rms(rest - still), raw, rezeroed))
    return runs


def judged_models(test: DriftTest, runs: Sequence[DriftRun]) -> dict[str, DriftModel]:
    """Each channel's model of the whole log, with what the model of its beginning left. Raises MCH-DATA."""
    return {
        run.channel: replace(
            fit_drift(test.time_s, test.signals, UM_PER_MM * test.displacement_mm[run.channel]), left_um=run.rms_um
        )
        for run in runs
    }


def since_reference(time_s: Array, off: Array, every_h: float) -> Array:
    """What is left of deviations (n,) where each is counted from the first row of its `every_h` hours."""
    number = np.floor((time_s - time_s[0]) / (3600 * every_h))
    _, first, own = np.unique(number, return_index=True, return_inverse=True)
    left: Array = off - off[first[own.ravel()]]
    return left


def predicted_um(
    models: Mapping[str, DriftModel], test: DriftTest, extrapolate: Collection[str] = ()
) -> dict[str, Array]:
    """Each channel's drift (n,) at the log's times. Raises MCH-SIGNAL, and MCH-RANGE for signals beyond the data.

    Those in `extrapolate`, named with or without their unit, may leave the data: the model goes on as its functions do.
    """
    found = {}
    for channel, model in models.items():
        found[channel] = model.predict(test.time_s, test.signals)
        for column in model.signals:
            name, _, ending = column.rpartition("_")
            if not {name, column} & set(extrapolate):
                check_range(name, test.signals[column], model.known[column], SIGNALS[f"_{ending}"])
    return found


def compared(found_um: Mapping[str, Array], test: DriftTest) -> dict[str, tuple[float, float]]:
    """Of channels that the log holds as well: RMS of read − predicted in µm, and that about its mean."""
    left = {
        name: UM_PER_MM * test.displacement_mm[name] - found_um[name]
        for name in found_um
        if name in test.displacement_mm
    }
    return {name: (rms(rest), float(np.std(rest))) for name, rest in left.items()}
