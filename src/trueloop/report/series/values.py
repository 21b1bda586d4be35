"""Series as values for JSON and for the page: as they are, or replayed."""

from collections.abc import Sequence
from typing import Any

from trueloop.errors import Finding
from trueloop.loops.post_process.options import SeriesOptions
from trueloop.loops.post_process.propose import effect_of
from trueloop.loops.post_process.replay import Replay, Replayed
from trueloop.loops.post_process.series import Series
from trueloop.loops.post_process.tracked import Tracked, TrackedPart, capability
from trueloop.report.series.shapes import (
    CapabilityShape,
    CharacteristicSeriesShape,
    FindingShape,
    NextShape,
    PartShape,
    SeriesShape,
)
from trueloop.statistics import NORMAL_95
from trueloop.units import UM_PER_MM


def status_shape(
    part_type: str, series: Sequence[Tracked], parts: int, findings: Sequence[Finding], options: SeriesOptions
) -> SeriesShape:
    """The series of a part type as they are."""
    of_each = [_tracked(one, options) for one in series]
    return SeriesShape(
        part_type=part_type, kind="status", parts=parts, characteristics=of_each, findings=_findings(findings)
    )


def replay_shape(
    part_type: str, replays: Sequence[Replay], parts: int, findings: Sequence[Finding], *, simulated: bool = False
) -> SeriesShape:
    """The series as they would have been with memory."""
    return SeriesShape(
        part_type=part_type,
        kind="simulation" if simulated else "replay",
        parts=parts,
        characteristics=[_replay(one) for one in replays],
        findings=_findings(findings),
    )


def _findings(findings: Sequence[Finding]) -> list[FindingShape]:
    return [
        FindingShape(severity=one.severity.value, code=one.code.value, message=one.message, hint=one.hint)
        for one in findings
    ]


def _um(value_mm: float | None) -> float | None:
    return None if value_mm is None else round(value_mm * UM_PER_MM, 4) + 0.0


def _sure(value_mm: float) -> float:
    return round(value_mm * UM_PER_MM, 4) + 0.0


def _band(u_mm: float | None) -> float | None:
    return None if u_mm is None else _sure(NORMAL_95 * u_mm)


def _tracked(one: Tracked, options: SeriesOptions) -> CharacteristicSeriesShape:
    step, alarm, found = one.last.step, one.open_alarm, capability(one.series)
    return CharacteristicSeriesShape(
        **_of_series(one.series),
        level_um=_um(step.level_mm),
        level_band_um=_band(step.level_u_mm),
        scatter_um=_um(step.scatter_mm),
        gain=step.gain,
        open_alarm=None if alarm is None else alarm.made.serial,
        next=_next(one, options) if one.series.latest else None,
        capability=None if found is None else CapabilityShape(ppk=found.ppk, lower=found.lower, parts=found.parts),
        left_rms_um={},
        parts=[_part(part) for part in one.parts],
    )


def _of_series(series: Series) -> dict[str, Any]:
    asked = series.characteristic
    return {
        "characteristic": asked.name,
        "quantity": asked.quantity.value,
        "nominal_mm": asked.nominal,
        "lower_limit_mm": asked.lower_limit,
        "upper_limit_mm": asked.upper_limit,
        "latest": series.latest,
    }


def _next(one: Tracked, options: SeriesOptions) -> NextShape | None:
    if abs(one.change_mm) <= options.least_mm:
        return None
    effect = effect_of(one, -one.change_mm)
    return NextShape(
        size_change_um=_sure(effect.size_change_mm),
        expected_um=_sure(effect.error_after_mm),
        band_um=_sure(NORMAL_95 * effect.standard_u_mm),
        probability_before=effect.probability_in_before,
        probability_after=effect.probability_in_after,
    )


def _part(one: TrackedPart) -> PartShape:
    made, step = one.made, one.step
    return PartShape(
        serial=made.serial,
        before_um=_sure(made.uncorrected_mm),
        after_um=_sure(made.error_mm),
        correction_um=_sure(made.correction_mm),
        expected_um=_um(one.expected_mm),
        band_um=_band(one.expected_u_mm),
        inside=one.inside,
        weight=step.weight.value,
        reason=step.weight.reason,
        drift_um=_um(step.drift_mm),
        alarm=one.alarm,
        tool_set=made.set_before,
    )


def _replay(one: Replay) -> CharacteristicSeriesShape:
    last = one.parts[-1]
    rules = ("measured", "memory", *one.rivals_mm)
    left = {rule: one.rms_mm(rule) for rule in rules}
    return CharacteristicSeriesShape(
        **_of_series(one.series),
        level_um=None,
        level_band_um=None,
        scatter_um=None,
        gain=None,
        open_alarm=last.serial if last.alarm else None,
        next=None,
        capability=None,
        left_rms_um={rule: _sure(value) for rule, value in left.items() if value is not None},
        parts=[_replayed(part) for part in one.parts],
    )


def _replayed(one: Replayed) -> PartShape:
    return PartShape(
        serial=one.serial,
        before_um=_sure(one.measured_mm),
        after_um=_sure(one.left_mm),
        correction_um=_sure(one.correction_mm),
        expected_um=_sure(one.expected_mm),
        band_um=_sure(NORMAL_95 * one.expected_u_mm),
        inside=one.inside,
        weight=one.weight,
        reason=one.reason,
        drift_um=_um(one.drift_mm),
        alarm=one.alarm,
        tool_set=one.set_before,
    )
