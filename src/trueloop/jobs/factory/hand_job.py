"""The job of a part that a person corrects: what was stated, and the job as it is written of that."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from datetime import datetime
from pathlib import Path
from typing import Annotated, Literal

from pydantic import AfterValidator, Field

from trueloop.described import filled_from
from trueloop.domain.option import Language, LengthUnit
from trueloop.errors import Code
from trueloop.formats.jobs.profile_of_job import quoted
from trueloop.geometry.profile import Side
from trueloop.jobs.turned.new import Chosen, NewFiles, Wanted, Zero, gauge_sheet_of, new_job
from trueloop.monitoring.capability import COVERAGE
from trueloop.turned.options import By

Finite = Annotated[float, Field(allow_inf_nan=False)]
Number = Annotated[int, Field(ge=0, lt=1 << 31)]
Words = Annotated[str, Field(max_length=200, pattern=r"^[^\x00-\x1f\x7f]*$")]
Typed = Annotated[str, Field(max_length=40, pattern=r"^[^\x00-\x1f\x7f]*$")]
Hash = Annotated[str, Field(max_length=64, pattern=r"^[0-9a-f]*$")]
Id = Annotated[str, Field(pattern=r"^[0-9a-f]{16}$")]


def _zoned(moment: datetime) -> datetime:
    """Refuses a time without its zone. Not pydantic's own type, which the process that reads files cannot be sent."""
    if moment.tzinfo is None:
        raise ValueError("a time states its zone: 2026-11-20T09:40:00+01:00")
    return moment


JOB, SHEET, MAPPING = "job.toml", "readings.csv", "mapping.toml"


@dataclass(frozen=True)
class AskedPart:
    """A part by the finish program that cuts it: `program` and `drawing` are hashes of files handed over.

    What is left out is taken from the program, the drawing, or asked for.
    """

    program: Hash
    nose_radius_mm: Annotated[float, Field(ge=0, le=1000, allow_inf_nan=False)]
    drawing: Hash = ""
    name: Words = ""
    dialect: Words | None = None
    unit: Literal["mm", "inch"] | None = None
    side: Literal["outside", "inside"] = "outside"
    tool: Annotated[int, Field(ge=1, lt=1 << 31)] | None = None
    tip: Annotated[int, Field(ge=0, le=9)] | None = None
    lines: tuple[Number, Number] | None = None
    parameters: Annotated[Mapping[Words, Finite], Field(max_length=1000)] = field(default_factory=dict)
    outline: Annotated[int, Field(ge=1, lt=1 << 31)] | None = None
    zero: Zero = "drawing"
    accept_unknown_words: bool = False


@dataclass(frozen=True)
class AskedReadings:
    """Measurements: `values` as they were read, by the name of the size, or `file`, the hash of one handed over.

    `by`: what carries the correction. `cut_with`: "given", the id of a correction, or "" where nothing is stated;
    `made_before`: the ids of the corrections among which that was chosen. `tolerances`, by the name under which the
    part as shown has them, are as the drawing writes them, in the program's unit. `expanded_uncertainty_um` (k = 2)
    holds for the values that state none.
    """

    values: Annotated[Mapping[Words, tuple[Typed, ...]], Field(max_length=1000)] = field(default_factory=dict)
    file: Hash = ""
    file_unit: Literal["mm", "inch"] | None = None
    mapping_toml: Annotated[str, Field(max_length=100_000)] = ""
    serial: Words = ""
    instrument: Words = ""
    expanded_uncertainty_um: Annotated[float, Field(gt=0, le=1e6, allow_inf_nan=False)] | None = None
    measured_at: Annotated[datetime, AfterValidator(_zoned)] | None = None
    measured_allowance_mm: Annotated[float, Field(ge=-100, le=100, allow_inf_nan=False)] | None = None
    by: By = "auto"
    cut_with: Annotated[str, Field(pattern=r"^(given|[0-9a-f]{16})?$")] = ""
    cut_by: Literal["corrected", "offsets", "wear"] | None = None
    made_before: Annotated[tuple[Id, ...], Field(max_length=10_000)] = ()
    tolerances: Annotated[Mapping[Words, Typed], Field(max_length=1000)] = field(default_factory=dict)


@dataclass(frozen=True)
class HandJob:
    """Statements on a part, with the names of its files in the folder of the program ("": there is no such file).

    `operator` is who stated it; sentences and pictures are for a reader of this language and unit.
    """

    part: AskedPart
    name: str
    measured: AskedReadings | None = None
    drawing: str = ""
    file: str = ""
    operator: str = ""
    language: Language = "en"
    unit: LengthUnit = "mm"


def written_job(program: Path, hand_job: HandJob) -> tuple[Path, NewFiles]:
    """Writes the job beside its program, with the readings, as `trueloop new` does; returns its path and the part.

    Raises what `new_job` raises, MSR-FEATURE for a value of a size that is not on the sheet, and SRV-REQUEST for values
    beside a file.
    """
    folder, part, measured = program.parent, hand_job.part, hand_job.measured
    if measured is not None and hand_job.file and measured.values:
        raise Code.SRV_REQUEST.refusal(
            f"values of {len(measured.values)} sizes are given beside a file of measurements",
            hint="give the values or the file of measurements, not both",
        )
    made = new_job(
        filled_from(
            Wanted,
            part,
            program=program,
            name=hand_job.name,
            folder=folder,
            drawing=folder / hand_job.drawing if hand_job.drawing else None,
            measured_file=folder / hand_job.file if hand_job.file else None,
            side=Side(part.side),
            chosen=Chosen(part.outline, part.zero),
            stated={} if measured is None else _stated(folder, measured, hand_job),
            tolerances={} if measured is None else measured.tolerances,
        )
    )
    job = folder / JOB
    if measured is not None and not hand_job.file:
        sheet = gauge_sheet_of(job).filled_in(measured.values, _above(measured, hand_job.operator))
        (folder / SHEET).write_text(sheet, encoding="utf-8")
    return job, made


def _above(measured: AskedReadings, operator: str) -> dict[str, str]:
    """The statements for all readings of a sheet. They are part of its hash: another statement, another inspection."""
    u_um, at = measured.expanded_uncertainty_um, measured.measured_at
    return {
        "serial": measured.serial,
        "instrument": measured.instrument,
        "expanded_uncertainty_um": "" if u_um is None else repr(u_um),
        "operator": operator,
        "measured_at": "" if at is None else at.isoformat(),
    }


def _stated(folder: Path, measured: AskedReadings, job: HandJob) -> dict[str, dict[str, str]]:
    """The keys of the job that say what was measured and how it is to be corrected, with their values in TOML."""
    gauging = {}
    if job.file:
        gauging = {"device": quoted(measured.instrument), "operator": quoted(job.operator)}
    if job.file and measured.measured_at is not None:
        gauging["measured_at"] = measured.measured_at.isoformat()
    if job.file and measured.expanded_uncertainty_um is not None:
        gauging["readings_u_um"] = repr(measured.expanded_uncertainty_um / COVERAGE)
    if measured.measured_allowance_mm is not None:
        gauging["measured_allowance_mm"] = repr(measured.measured_allowance_mm)
    if measured.file_unit is not None:
        gauging["readings_unit"] = quoted(measured.file_unit)
    if measured.mapping_toml:
        (folder / MAPPING).write_text(measured.mapping_toml, encoding="utf-8")
        gauging["readings_mapping"] = quoted(MAPPING)
    cut = {"cut_with": measured.cut_with, "cut_by": measured.cut_by or ""}
    return {
        "part": {"serial": quoted(measured.serial)},
        "programs": {key: quoted(value) for key, value in cut.items() if value},
        "gauging": gauging,
        "compensation": {"by": quoted(measured.by)},
        "report": {"language": quoted(job.language)},
    }
