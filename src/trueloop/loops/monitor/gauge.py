"""Gauges and probes judged on calibrated parts: one series a device, standard part and characteristic."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime

import numpy as np

from trueloop.arrays import Array
from trueloop.domain.inspection import Inspection, Reading, StandardPart
from trueloop.errors import Code, TrueloopError
from trueloop.loops.monitor.chart import BASELINE
from trueloop.monitoring.capability import Drift, drift, e_n
from trueloop.monitoring.charts import RULES, Alarm
from trueloop.monitoring.segments import SegmentedSeries, charted
from trueloop.wording import Um, wording

WARM_K = 1.0
"""The difference from the temperature of the calibration, K, beyond which a check is remarked on."""


@dataclass(frozen=True)
class Check:
    """One characteristic of a standard part as a device measured it. `deviations_mm` of repeats: measured less
    calibrated.

    `gauge_u_mm`: as the readings state it; None: not stated. `calibration_u_mm` is that of the standard part.
    """

    at: datetime | None
    deviations_mm: tuple[float, ...]
    gauge_u_mm: float | None
    calibration_u_mm: float
    temperature_c: float | None = None

    @property
    def deviation_mm(self) -> float:
        """Returns the mean of the repeats."""
        return float(np.mean(self.deviations_mm))

    @property
    def e_n(self) -> float | None:
        """Returns the deviation over the expanded uncertainty; None: the gauge's is not stated."""
        return None if self.gauge_u_mm is None else e_n(self.deviation_mm, self.gauge_u_mm, self.calibration_u_mm)


@dataclass(frozen=True)
class GaugeSeries:
    """A device on one characteristic of a standard part, checks in order of time. `charted`: None below eight."""

    device: str
    standard: str
    characteristic: str
    checks: tuple[Check, ...]
    drift: Drift
    charted: SegmentedSeries | None

    @property
    def alarms(self) -> tuple[Alarm, ...]:
        """Returns the alarms of the charts; the moving range's alone are none."""
        found = () if self.charted is None else self.charted.alarms
        return tuple(alarm for alarm in found if alarm.chart != "moving range")

    def failing(self, k: int) -> str:
        """Returns in words why check k fails; empty: it does not."""
        one = self.checks[k]
        off = Um(one.deviation_mm, "+.1f")
        at = "" if one.at is None else f"{one.at:%Y-%m-%d %H:%M}"
        if one.e_n is not None and abs(one.e_n) > 1.0:
            return wording(
                "check of {device} on {standard} {at}: {off} off, {times:.1f} times its expanded uncertainty",
                device=self.device, standard=self.standard, at=at, off=off, times=abs(one.e_n),
            )  # fmt: skip
        said = next((alarm.meaning for alarm in self.alarms if alarm.index == k), "")
        if not said:
            return ""
        return wording(
            "check of {device} on {standard} {at}: {off} off; {meaning}",
            device=self.device, standard=self.standard, at=at, off=off, meaning=said,
        )  # fmt: skip

    @property
    def remarks(self) -> tuple[str, ...]:
        """Returns remarks on the checks, and on what is to be done."""
        return tuple(_remarks(self))


def gauges(
    standards: Sequence[StandardPart], inspections: Sequence[Inspection], device: str | None = None
) -> tuple[GaugeSeries, ...]:
    """Returns all series of checks, or those of a device; `inspections` may be of other parts too, which are left out.

    Raises MON-NONE where no inspection is of a standard part and by that device.
    """
    known = {standard.part.identity for standard in standards}
    of_standards = [one for one in inspections if one.part.identity in known]
    found: dict[tuple[str, str, str], list[Check]] = {}
    for inspection in sorted(of_standards, key=_time):
        for name, check in _checks(standards, inspection):
            if device is None or inspection.device == device:
                found.setdefault((inspection.device, inspection.part.serial, name), []).append(check)
    if not found:
        devices = sorted({repr(standard.device) for standard in of_standards})
        raise Code.MON_NONE.refusal(
            f"the store holds {len(standards)} standard parts and {len(of_standards)} inspections of them, "
            f"0 by {'any device' if device is None else repr(device)} on a calibrated characteristic",
            hint=f"devices that inspected one: {', '.join(devices) or 'none'}; a standard part is kept with its "
            "calibrated values, then inspected as any part",
            values={"characteristic": device or ""},
        )
    return tuple(_series(*key, checks) for key, checks in found.items())


def _time(inspection: Inspection) -> float:
    """Inspections without a time come first, in the order in which they were kept."""
    at = inspection.measured_at
    return 0.0 if at is None else (at if at.tzinfo else at.replace(tzinfo=UTC)).timestamp()


def _checks(standards: Sequence[StandardPart], inspection: Inspection) -> Iterator[tuple[str, Check]]:
    calibrated = {reading.characteristic: reading for reading in _in_force(standards, inspection).values}
    for name, by in calibrated.items():
        own = [reading for reading in inspection.readings if reading.characteristic == name]
        if own and by.standard_u is not None:
            yield name, _check(inspection, own, by, by.standard_u)


def _check(inspection: Inspection, own: Sequence[Reading], by: Reading, calibration_u_mm: float) -> Check:
    stated = [reading.standard_u for reading in own if reading.standard_u is not None]
    warm = [reading.temperature_c for reading in own if reading.temperature_c is not None]
    return Check(
        inspection.measured_at,
        tuple(reading.actual - by.actual for reading in own),
        max(stated, default=None),
        calibration_u_mm,
        float(np.mean(warm)) if warm else None,
    )


def _in_force(standards: Sequence[StandardPart], inspection: Inspection) -> StandardPart:
    """Returns the latest calibration before the inspection; where none was before, the first."""
    own = [standard for standard in standards if standard.part.identity == inspection.part.identity]
    before = [part for part in own if part.at is not None and part.at.timestamp() <= _time(inspection)]
    return max(before, key=lambda part: part.at.timestamp() if part.at else 0.0) if before else own[0]


def _series(device: str, standard: str, name: str, checks: Sequence[Check]) -> GaugeSeries:
    repeats = [np.array(check.deviations_mm) for check in checks]
    found = drift(repeats, _days(checks), max(check.calibration_u_mm for check in checks))
    return GaugeSeries(
        device=device,
        standard=standard,
        characteristic=name,
        checks=tuple(checks),
        drift=found,
        charted=_charted(checks),
    )


def _days(checks: Sequence[Check]) -> Array | None:
    """Returns the days since the first check; None where a time is not stated."""
    times = [check.at for check in checks]
    if any(at is None for at in times):
        return None
    seconds = np.array([(at if at.tzinfo else at.replace(tzinfo=UTC)).timestamp() for at in times if at is not None])
    days: Array = (seconds - seconds[0]) / 86400.0
    return days


def _charted(checks: Sequence[Check]) -> SegmentedSeries | None:
    values = np.array([check.deviation_mm for check in checks])
    try:
        return charted(values, np.arange(len(values)) < BASELINE, (), RULES[:1])
    except TrueloopError as refused:
        if refused.code is not Code.MON_FEW:
            raise
        return None


def _remarks(series: GaugeSeries) -> Iterator[str]:
    if series.drift.biased and series.drift.bias_u is not None:
        bias, u = Um(series.drift.bias, "+.2f"), Um(2.0 * series.drift.bias_u, ".2f")
        yield wording("bias {bias} ± {u} (k = 2): calibrate it anew", bias=bias, u=u)
    slope = series.drift.slope
    if slope is not None and slope.significant:
        per_day, half = Um(slope.per_day, "+.3f"), Um(slope.half_width, ".3f")
        yield wording("drifts by {per_day} ± {half} a day: check it more often", per_day=per_day, half=half)
    if series.failing(len(series.checks) - 1):
        yield wording("the last check fails: what it measured since the check before is in doubt")
    if series.charted is None:
        yield wording("{n} checks are too few for a chart", n=len(series.checks))
    if series.drift.repeatability is None:
        yield wording("no check has repeats: repeatability is not known")
    if all(check.gauge_u_mm is None for check in series.checks):
        yield wording("the device states no uncertainty: checks are judged by the chart alone")
    warm = [check.temperature_c for check in series.checks if check.temperature_c is not None]
    if warm and max(abs(t - 20.0) for t in warm) > WARM_K:
        yield wording("checks at up to {t:.1f} °C: expansion of the standard part is in the deviations", t=max(warm))
