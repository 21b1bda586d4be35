"""Files that people hand over, as they are read, before anything of them is kept as a fact."""

from dataclasses import dataclass
from typing import Literal

Kind = Literal["program", "measurement", "drawing"]


@dataclass(frozen=True)
class Remarked:
    """Something odd about a file. `severity`: error, warning, note; `code` is empty for what has none."""

    severity: str
    code: str
    said: str
    hint: str = ""
    line: int | None = None


@dataclass(frozen=True)
class ProgramRead:
    """An NC program: its dialect, the unit of its lengths (None: it has none), how many blocks."""

    dialect: str
    unit: Literal["mm", "inch"] | None
    blocks: int
    remarks: tuple[Remarked, ...]


@dataclass(frozen=True)
class ValueRead:
    """One value with the part's feature that it was found to be of, and by what: "name", "geometry", "" for none.

    Lengths and limits in `unit`; `within` is None without limits; `reason` says why it was not found.
    """

    characteristic: str
    quantity: str
    feature: str
    by: str
    nominal: float | None
    actual: float | None
    deviation: float | None
    lower_limit: float | None
    upper_limit: float | None
    within: bool | None
    unit: str
    reason: str


@dataclass(frozen=True)
class InspectionRead:
    """One inspection of a file, its `run`-th from 1; `values` are the first of `count`."""

    run: int
    serial: str
    measured_at: str
    count: int
    values: tuple[ValueRead, ...]
    remarks: tuple[Remarked, ...]


@dataclass(frozen=True)
class MeasurementRead:
    """A measurement's file: `mapping_toml` is what a table's columns were taken to mean, "" where it needs none."""

    format: str
    unit: Literal["mm", "inch"] | None
    inspections: tuple[InspectionRead, ...]
    remarks: tuple[Remarked, ...]
    mapping_toml: str


@dataclass(frozen=True)
class DrawingRead:
    """A profile as the table `[part]` of a job, for a person to look at."""

    part_toml: str


@dataclass(frozen=True)
class UploadView:
    """A file handed over. One of `program`, `measurement`, `drawing` is what was read, or `problem` says why not."""

    name: str
    sha256: str
    size_bytes: int
    kind: Kind
    program: ProgramRead | None = None
    measurement: MeasurementRead | None = None
    drawing: DrawingRead | None = None
    problem: Remarked | None = None
    mapping_toml: str = ""


@dataclass(frozen=True)
class ImportedView:
    """The values kept from a file. `sha256` of a program's text; `kept` counts values, `new` those not there before."""

    sha256: str
    kept: int
    new: int
    remarks: tuple[Remarked, ...]
    recorded: bool = False
