"""The shapes of series as JSON: `docs/series.schema.json` is written from them.

Errors are actual less nominal size in µm: of a shaft positive where material is left on, a diameter's twice the radial
one. Bands hold 95 %. Sizes are in mm.
"""

from typing import Literal

from pydantic import SkipValidation

from trueloop.report.shape import Shape


class PartShape(Shape):
    """One part of a series, in the order in which the parts were cut."""

    serial: str
    """Its serial number."""
    before_um: float
    """Error without correction: of a replay as measured, else had nothing been corrected."""
    after_um: float
    """Error with correction: of a replay what would have been left, else as measured."""
    correction_um: float
    """What was, or would have been, taken off the size."""
    expected_um: float | None
    """What was expected of `after_um`, from earlier parts alone."""
    band_um: float | None
    """Half width of the 95 % band about it."""
    inside: bool | None
    """Whether the band holds it."""
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
    """What is proposed for the next part."""

    size_change_um: float
    """To be added to the size."""
    expected_um: float
    """Error then."""
    band_um: float
    """Half width of its 95 % band."""
    probability_before: float | None
    """Of being inside the limits without the proposal; null: no limits."""
    probability_after: float | None
    """The same with it."""


class CapabilityShape(Shape):
    """Ppk of the parts since the tool was last set, with its lower limit of 95 %."""

    ppk: float
    """Least distance of the mean to a limit over three standard deviations."""
    lower: float
    """What it is at least, with 95 %."""
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
    """What to do."""


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
    """What is odd."""
