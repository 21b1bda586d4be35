"""Parts in lists, and the life of one part."""

from dataclasses import dataclass
from datetime import datetime

from trueloop.domain.factory import BlockKind, FactKind, PartState, StepState
from trueloop.factory.views.orders import MachineNow, TransferView


@dataclass(frozen=True)
class CalibrationView:
    """A calibration of a machine's probe: `values` are the results as reported."""

    at: datetime
    who: str
    values: dict[str, str]


@dataclass(frozen=True)
class TemperatureView:
    """A sensor's values, oldest first, °C; the latest hours, no more than a picture shows."""

    signal: str
    at: tuple[datetime, ...]
    celsius: tuple[float, ...]
    stale: bool


@dataclass(frozen=True)
class MachineView:
    """A machine: what it does, links, model, latest calibrations, temperatures, transfers; `part_id`: what it cuts."""

    now: MachineNow
    part_id: int | None
    model_version: str
    keys: int
    calibrations: tuple[CalibrationView, ...]
    temperatures: tuple[TemperatureView, ...]
    transfers: tuple[TransferView, ...]


@dataclass(frozen=True)
class PartRow:
    """A part in a list. `state` is None for a part that no order made: measured and kept, no more."""

    id: int
    part_type: str
    revision: str
    serial: str
    state: PartState | None
    order: str
    machine: str
    changed_at: datetime


@dataclass(frozen=True)
class FactView:
    """One fact of a run."""

    what: FactKind
    at: datetime
    witness: str
    values: dict[str, str]


@dataclass(frozen=True)
class StepView:
    """One step of the part's route; `facts` of the last attempt."""

    no: int
    kind: BlockKind
    state: StepState
    attempts: int
    run: str
    program_sha256: str
    sent_sha256: str
    facts: tuple[FactView, ...]


@dataclass(frozen=True)
class Result:
    """One characteristic as one inspection found it; `deviation_um` is actual less nominal (of angles None)."""

    characteristic: str
    unit: str
    nominal: float
    lower_limit: float | None
    upper_limit: float | None
    actual: float
    standard_u: float | None
    deviation_um: float | None
    verdict: str


@dataclass(frozen=True)
class InspectionView:
    """One inspection: when, by what, after which stage, what it found; `rms_um` of all errors; `touches`: points."""

    id: int
    at: datetime | None
    source: str
    stage: str
    file: str
    touches: int
    rms_um: float | None
    results: tuple[Result, ...]


@dataclass(frozen=True)
class CorrectionView:
    """A correction of this part, and who decided; `source`: the program's name; `has_report`: a page exists."""

    id: str
    product: str
    made_at: str
    made_by: str
    summary: tuple[str, ...]
    source: str
    source_sha256: str
    corrected_sha256: str
    has_report: bool


@dataclass(frozen=True)
class CertificateRow:
    """A certificate in a list."""

    id: int
    part_type: str
    serial: str
    made_at: datetime
    made_by: str
    verdict: str
    sha256: str


@dataclass(frozen=True)
class PartLife:
    """All that is known of a part, oldest first."""

    part: PartRow
    etag: str
    label: str
    tool: str
    steps: tuple[StepView, ...]
    inspections: tuple[InspectionView, ...]
    corrections: tuple[CorrectionView, ...]
    certificates: tuple[CertificateRow, ...]
    events: tuple["EventView", ...]


@dataclass(frozen=True)
class EventView:
    """One line of the event log."""

    id: int
    at: datetime
    who: str
    what: str
    subject: str
    values: dict[str, str]
