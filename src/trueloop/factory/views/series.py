"""Series of a part type's characteristics, tools' memory, proposals and alarms."""

from dataclasses import dataclass
from datetime import datetime


@dataclass(frozen=True)
class SeriesRow:
    """A series in a list; deviations are actual less nominal size.

    `expected_um` is to be expected of the next part with the correction in force; None before the level is known.
    """

    part_type: str
    revision: str
    characteristic: str
    parts: int
    last_serial: str
    last_deviation_um: float
    expected_um: float | None
    alarm: str


@dataclass(frozen=True)
class SeriesPoint:
    """One part in a series: the deviation as made, the one without correction, and what was flagged.

    `edge` is the row of the edge that its finish cut was made with, `tool` what that is called.
    """

    serial: str
    at: datetime | None
    deviation_um: float
    without_correction_um: float | None
    expected_um: float | None
    band_um: float | None
    alarm: str
    tool_changed: str
    quarantined: bool
    edge: int | None
    tool: str


@dataclass(frozen=True)
class WeightMove:
    """Where the share of what a part shows that is acted on moved, and why."""

    serial: str
    before: float
    after: float
    why: str


@dataclass(frozen=True)
class SeriesView:
    """A whole series with its limits. `weight`: the share that is acted on now; `moves`: where it moved, latest last.

    `ppk` of the parts since the tool was set, with its one-sided lower limit of 95 %: None where they are too few.
    `proposals` are those of this series that wait.
    """

    row: SeriesRow
    unit: str
    nominal: float
    lower_um: float | None
    upper_um: float | None
    points: tuple[SeriesPoint, ...]
    weight: float
    moves: tuple[WeightMove, ...]
    ppk: float | None
    ppk_lower: float | None
    proposals: tuple[str, ...]


@dataclass(frozen=True)
class ToolRow:
    """A tool's edge in a list."""

    id: int
    tool: str
    edge: str
    nose_radius_mm: float | None
    set_at: datetime | None
    parts: int


@dataclass(frozen=True)
class MemoryCurve:
    """An error over the contact angle with half the width of its 95 % band, µm.

    `part_type`: of the finish cut of a next part of it, had nothing been corrected; empty: the form of the edge itself.
    """

    part_type: str
    error_um: tuple[float, ...]
    band_um: tuple[float, ...]


@dataclass(frozen=True)
class MemoryPoint:
    """One error behind a curve: of which part, touched after the semi-finish cut or inspected after the finish cut."""

    part_type: str
    serial: str
    finish: bool
    contact_angle_deg: float
    error_um: float


@dataclass(frozen=True)
class NextPart:
    """The touches that the next part of a type needs: of the `of` touches that the last one had, placed best, `touches`
    are enough; `left_um` is then to be expected after the correction, RMS. `refusal`: why memory would not tell.
    """

    part_type: str
    touches: int
    of: int
    left_um: float | None
    refusal: str
    notes: tuple[str, ...]


@dataclass(frozen=True)
class ToolEvent:
    """An event of an edge; `values` as they were stated, by name with their unit."""

    at: datetime
    kind: str
    by: str
    values: dict[str, float]


@dataclass(frozen=True)
class ToolMemory:
    """Memory of a tool's edge, at contact angles; `seen`: whether parts have shown an angle near that one.

    `setting_um`: where the tip lies off its setting, along x (of the radius) and z, each ± `setting_band_um` with 95 %.
    """

    tool: ToolRow
    contact_angle_deg: tuple[float, ...]
    seen: tuple[bool, ...]
    curves: tuple[MemoryCurve, ...]
    points: tuple[MemoryPoint, ...]
    parts: int
    inspected: int
    setting_um: tuple[float, ...]
    setting_band_um: tuple[float, ...]
    next_parts: tuple[NextPart, ...]
    events: tuple[ToolEvent, ...]


@dataclass(frozen=True)
class EffectView:
    """The effect of a proposal on one characteristic of the next part."""

    characteristic: str
    size_change_um: float
    error_before_um: float
    error_after_um: float
    standard_u_um: float
    in_tolerance_before: float | None
    in_tolerance_after: float | None


@dataclass(frozen=True)
class ProposalView:
    """A proposal, and what was decided. `state`: open, accepted, rejected, superseded. `refusal`: why it is not open to
    acceptance now, with the code; empty where it is. `corrections`: ids of those that `last_serial`, the last part
    behind it, was cut by; in a list left out. `dx_mm` is on the radius; `dx_u_mm`, `dz_u_mm` (95 %) are None of an axis
    that the measurements do not determine, and where `u_stated` is false.
    """

    id: str
    etag: str
    changes: str
    part_type: str
    made_at: datetime
    made_by: str
    state: str
    effects: tuple[EffectView, ...]
    tool: str
    dx_mm: float | None
    dz_mm: float | None
    u_stated: bool
    dx_u_mm: float | None
    dz_u_mm: float | None
    alarms: tuple[str, ...]
    why: str
    refusal: str
    decided_by: str
    decided_at: datetime | None
    decided_why: str
    last_serial: str = ""
    corrections: tuple[str, ...] = ()


@dataclass(frozen=True)
class AlarmView:
    """An alarm, and who acknowledged it."""

    id: int
    at: datetime
    source: str
    code: str
    said: str
    values: dict[str, str]
    acknowledged_by: str
    acknowledged_at: datetime | None
