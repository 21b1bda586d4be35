"""Series of a part type's characteristics, tools' memory, proposals and alarms."""

from dataclasses import dataclass
from datetime import datetime


@dataclass(frozen=True)
class SeriesRow:
    """A series in a list."""

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
    """One part in a series: the deviation as made, the one without correction, and what was flagged."""

    serial: str
    at: datetime | None
    deviation_um: float
    without_correction_um: float | None
    expected_um: float | None
    band_um: float | None
    alarm: str
    tool_changed: str
    quarantined: bool


@dataclass(frozen=True)
class SeriesView:
    """A whole series with its limits; `weights` is the share that was acted on, part by part."""

    row: SeriesRow
    unit: str
    nominal: float
    lower_um: float | None
    upper_um: float | None
    points: tuple[SeriesPoint, ...]
    weights: tuple[float | None, ...]
    cpk: float | None


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
class ToolMemory:
    """What a tool's edge remembers: its error over the contact angle, with a 95 % band, from so many parts."""

    tool: ToolRow
    contact_angle_deg: tuple[float, ...]
    error_um: tuple[float, ...]
    band_um: tuple[float, ...]
    parts: int
    events: tuple[str, ...]


@dataclass(frozen=True)
class EffectView:
    """What a proposal does to one characteristic of the next part."""

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
    acceptance now, with the code; empty where it is.
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
    alarms: tuple[str, ...]
    why: str
    refusal: str
    decided_by: str
    decided_at: datetime | None
    decided_why: str


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
