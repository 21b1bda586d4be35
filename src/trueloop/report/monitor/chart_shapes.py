"""The shapes of control charts as JSON.

Values are errors (actual less nominal size, a diameter's twice the radial one) in µm, or residuals after correction in
standard deviations of what memory expected: `unit` says which.
"""

from typing import Literal

from pydantic import SkipValidation

from trueloop.report.series.shapes import FindingShape
from trueloop.report.shape import Shape


class ValueShape(Shape):
    """One part on a chart, in the order in which the parts were cut."""

    serial: str
    """Its serial number."""
    value: float
    """In the unit of the chart."""
    in_baseline: bool
    """Whether limits come from it, among others."""
    tool_set: bool
    """The tool was set or changed before it."""


class ChartShape(Shape):
    """One chart of one segment: what is plotted of each part, with its limits."""

    name: str
    """individuals, moving range, EWMA, CUSUM upwards, CUSUM downwards."""
    centre: float
    """Its middle line."""
    plotted: list[float | None]
    """Null where a part has none: the first moving range."""
    low: list[float]
    """Lower limits."""
    high: list[float]
    """Upper limits."""


class SegmentShape(Shape):
    """Parts with one centre."""

    first: int
    """Index of its first part, from 0."""
    stop: int
    """Index after its last part."""
    centre: float | None
    """Mean of its baseline; null: too few parts, and no charts."""
    charts: list[ChartShape]
    """All charts of it."""


class AlarmShape(Shape):
    """What one chart found at one part."""

    serial: str
    """The part at which the pattern is complete."""
    chart: str
    """Which chart."""
    meaning: SkipValidation[str]
    """Which rule, in words."""


class CauseShape(Shape):
    """Something that happened and may explain an alarm."""

    kind: SkipValidation[str]
    """tool set, proposal accepted, another program, correction not run, wear, temperature, another device, gauge; of a
    diagnosis the key of its cause."""
    words: SkipValidation[str]
    """What is known of it."""
    probability: float
    """That it is the cause, among those known and none of them."""
    size: float
    """How far it moved the values, in the unit of the chart, if it did."""
    size_u: float
    """Standard uncertainty of that."""


class EpisodeShape(Shape):
    """Alarms of consecutive parts."""

    first: str
    """Serial number of the first alarming part."""
    last: str
    """Of the last."""
    since: str
    """The part with which a step would begin with the greatest probability."""
    alarms: list[AlarmShape]
    """Each."""
    causes: list[CauseShape]
    """Likeliest first."""
    unknown: float
    """Probability of a step that nobody knows of."""
    chance: float
    """Probability that nothing moved."""


class IndexShape(Shape):
    """An index of capability or performance."""

    name: str
    """Pp, Ppk, Cp or Cpk, as ISO 22514-2 has them."""
    value: float | None
    """Null where a limit that it needs is not stated."""
    low: float | None
    """Lower end of its 95 % interval."""
    high: float | None
    """Upper end."""


class CapabilityShape(Shape):
    """Capability and performance against the limits."""

    count: int
    """Parts."""
    mean: float
    """Mean error."""
    sigma: float
    """Standard deviation of all parts."""
    short_sigma: float
    """That within segments, from moving ranges."""
    normal_p: float
    """Probability of values as unlike the normal distribution (Shapiro, Wilk)."""
    indices: list[IndexShape]
    """Pp, Ppk, Cp, Cpk."""


class CharacteristicChartShape(Shape):
    """One characteristic charted."""

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
    sigma: float
    """Short-term standard deviation, in the unit of the chart."""
    baseline: int
    """Parts that it comes from."""
    correlation: float
    """Of neighbours in the baseline."""
    parts: list[ValueShape]
    """All, as they were cut."""
    segments: list[SegmentShape]
    """Parts between settings of the tool, where that was asked for; else one."""
    alarms: list[EpisodeShape]
    """In order of the parts."""
    capability: CapabilityShape | None
    """Null of residuals and without limits."""
    remarks: list[SkipValidation[str]]
    """What limits and indices are not good for."""


class ChartsShape(Shape):
    """Charts of a part type."""

    part_type: str
    """Its name."""
    what: Literal["value", "residual"]
    """Errors as inspected, or residuals after correction."""
    unit: Literal["um", "sigma"]
    """Of values, centres and limits."""
    rules: list[int]
    """Nelson's tests on the individuals."""
    characteristics: list[CharacteristicChartShape]
    """Each with values enough."""
    findings: list[FindingShape]
    """What is odd about the parts."""
