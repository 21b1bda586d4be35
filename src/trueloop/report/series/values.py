"""Series as values for JSON and for the page: as they are, or replayed."""

from collections.abc import Iterable, Sequence
from typing import Any, Literal

from pydantic import SkipValidation

from trueloop.errors import Finding
from trueloop.loops.post_process.propose import effect_of
from trueloop.loops.post_process.series import Series, SeriesOptions
from trueloop.loops.post_process.tracked import Replay, ReplayedSeries, TrackedPart, TrackedSeries, capability
from trueloop.report.shape import Shape, known_um, um
from trueloop.statistics import NORMAL_95


class PartShape(Shape):
    """One part of a series, in the order in which the parts were cut."""

    serial: str
    """Its serial number."""
    before_um: float
    """Error without correction: of a replay as measured, else had nothing been corrected."""
    after_um: float
    """Error with correction: of a replay what would have been left, else as measured."""
    correction_um: float
    """The correction of the size, applied or computed."""
    expected_um: float | None
    """The prediction of `after_um` from earlier parts alone."""
    band_um: float | None
    """Half width of the 95 % band about it."""
    inside: bool | None
    """True if the band holds it."""
    weight: float
    """Share of what this part showed unexpectedly that the next correction acts on."""
    reason: SkipValidation[str]  # a `Wording`, which a page says in its own language
    """Why the weight is what it is."""
    drift_um: float | None
    """Estimated drift from part to part."""
    alarm: bool
    """Beyond what chance explains."""
    tool_set: bool
    """The tool was set or changed before this part, or memory was begun anew."""


class NextShape(Shape):
    """The proposal for the next part."""

    size_change_um: float
    """To be added to the size."""
    expected_um: float
    """Error then."""
    band_um: float
    """Half width of its 95 % band."""
    probability_before: float | None
    """Of being inside the limits without the proposal; null: no limits."""
    probability_after: float | None
    """The probability of being inside the limits with the proposal."""


class CapabilityShape(Shape):
    """Ppk of the parts since the tool was last set, with its lower limit of 95 %."""

    ppk: float
    """Least distance of the mean to a limit over three standard deviations."""
    lower: float
    """Its lower bound, with 95 %."""
    parts: int
    """How many parts it is from."""


class CharacteristicSeriesShape(Shape):
    """One characteristic over the parts."""

    characteristic: str
    """Its name."""
    quantity: str
    """diameter, radius, length or position."""
    nominal_mm: float
    """A diameter is a diameter."""
    lower_limit_mm: float | None
    """Smallest size; null: no limit."""
    upper_limit_mm: float | None
    """Largest size; null: no limit."""
    latest: bool
    """False: its nominal or limits have changed since, and another series goes on."""
    level_um: float | None
    """Error had nothing been corrected, now."""
    level_band_um: float | None
    """Half width of its 95 % band."""
    scatter_um: float | None
    """Standard deviation of one part."""
    gain: float | None
    """Share of a correction that arrives."""
    open_alarm: str | None
    """Serial number of the part that alarms; null: none."""
    next: NextShape | None
    """Of the last part's proposal; null of a replay, and where nothing is to be changed."""
    capability: CapabilityShape | None
    """Null with fewer than twenty parts or without limits."""
    left_rms_um: dict[str, float]
    """Of a replay: what each rule would have left, from the second part on; "measured": as it was."""
    parts: list[PartShape]
    """The parts, as they were cut."""


class FindingShape(Shape):
    """Something odd about the parts."""

    severity: Literal["error", "warning", "note"]
    """How much it matters."""
    code: str
    """As docs/errors.md lists it."""
    message: str
    """In words."""
    hint: str
    """The action."""


class SeriesShape(Shape):
    """All series of one part type."""

    part_type: str
    """Its name."""
    kind: Literal["status", "replay", "simulation"]
    """As it is, as it would have been with memory, or simulated."""
    parts: int
    """How many parts count."""
    characteristics: list[CharacteristicSeriesShape]
    """One for each."""
    findings: list[FindingShape]
    """The findings."""


def status_shape(
    part_type: str, series: Sequence[TrackedSeries], parts: int, findings: Sequence[Finding], options: SeriesOptions
) -> SeriesShape:
    """Makes the shape of the series of a part type as they are."""
    of_each = [_tracked(one, options) for one in series]
    return SeriesShape(
        part_type=part_type, kind="status", parts=parts, characteristics=of_each, findings=findings_shape(findings)
    )


def replay_shape(
    part_type: str, replays: Sequence[Replay], parts: int, findings: Sequence[Finding], *, simulated: bool = False
) -> SeriesShape:
    """Makes the shape of the series as they would have been with memory."""
    return SeriesShape(
        part_type=part_type,
        kind="simulation" if simulated else "replay",
        parts=parts,
        characteristics=[_replay(replay) for replay in replays],
        findings=findings_shape(findings),
    )


def findings_shape(findings: Iterable[Finding]) -> list[FindingShape]:
    """Returns the shapes of findings."""
    return [FindingShape.from_values(finding) for finding in findings]


def _band(u_mm: float | None) -> float | None:
    return None if u_mm is None else um(NORMAL_95 * u_mm)


def _tracked(series: TrackedSeries, options: SeriesOptions) -> CharacteristicSeriesShape:
    step, alarm, found = series.last.step, series.open_alarm, capability(series.series)
    return CharacteristicSeriesShape(
        **_of_series(series.series),
        level_um=known_um(step.level_mm),
        level_band_um=_band(step.level_u_mm),
        scatter_um=known_um(step.scatter_mm),
        gain=step.gain,
        open_alarm=None if alarm is None else alarm.made.serial,
        next=_next(series, options) if series.series.latest else None,
        capability=None if found is None else CapabilityShape.from_values(found),
        left_rms_um={},
        parts=[_part(part) for part in series.parts],
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


def _next(series: TrackedSeries, options: SeriesOptions) -> NextShape | None:
    if abs(series.change_mm) <= options.least_mm:
        return None
    effect = effect_of(series, -series.change_mm)
    return NextShape(
        size_change_um=um(effect.size_change_mm),
        expected_um=um(effect.error_after_mm),
        band_um=um(NORMAL_95 * effect.standard_u_mm),
        probability_before=effect.probability_in_before,
        probability_after=effect.probability_in_after,
    )


def _part(tracked_part: TrackedPart) -> PartShape:
    made, step = tracked_part.made, tracked_part.step
    return PartShape.from_values(
        *(tracked_part, made, step, step.weight),
        before_um=um(made.uncorrected_mm),
        after_um=um(made.error_mm),
        band_um=_band(tracked_part.expected_u_mm),
        weight=step.weight.value,
        tool_set=made.set_before,
    )


def _replay(replay: Replay) -> CharacteristicSeriesShape:
    last = replay.parts[-1]
    rules = ("measured", "memory", *replay.rivals_mm)
    left = {rule: replay.rms_mm(rule) for rule in rules}
    return CharacteristicSeriesShape(
        **_of_series(replay.series),
        level_um=None,
        level_band_um=None,
        scatter_um=None,
        gain=None,
        open_alarm=last.serial if last.alarm else None,
        next=None,
        capability=None,
        left_rms_um={rule: um(value) for rule, value in left.items() if value is not None},
        parts=[_replayed(part) for part in replay.parts],
    )


def _replayed(series: ReplayedSeries) -> PartShape:
    return PartShape.from_values(
        series,
        before_um=um(series.measured_mm),
        after_um=um(series.left_mm),
        band_um=um(NORMAL_95 * series.expected_u_mm),
        tool_set=series.set_before,
    )
