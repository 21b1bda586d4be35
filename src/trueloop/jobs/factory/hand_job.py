"""The job of a part that a person corrects: what was stated, of a milled one too, and the job of a turned one."""

from collections.abc import Mapping
from dataclasses import KW_ONLY, dataclass, field, replace
from datetime import datetime
from pathlib import Path
from typing import Annotated, Literal

from pydantic import AfterValidator, Field

from trueloop.described import filled_from
from trueloop.domain.option import Language
from trueloop.errors import Code
from trueloop.geometry.profile import Side
from trueloop.jobs.turned.new import Chosen, NewFiles, NewTool, Wanted, WantedProgram, Zero, gauge_sheet_of, new_job
from trueloop.monitoring.capability import COVERAGE
from trueloop.turned.options import By
from trueloop.wording import wording

Finite = Annotated[float, Field(allow_inf_nan=False)]
Number = Annotated[int, Field(ge=0, lt=1 << 31)]
Count = Annotated[int, Field(ge=1, lt=1 << 31)]
Radius = Annotated[float, Field(ge=0, le=1000, allow_inf_nan=False)]
Tip = Annotated[int, Field(ge=0, le=9)]
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
class AskedTool:
    """A tool that a program cuts with, by the number of its offset; `name` where two set-ups call that number."""

    nose_radius_mm: Radius
    number: Count
    tip: Tip | None = None
    name: Words = ""


@dataclass(frozen=True)
class AskedProgram:
    """A finish program, by the hash of the file handed over, with its tool, and the `tools` that it cuts with besides.

    Of several set-ups: z of the part where its Z is 0, and whether the part is turned round. What is left out is taken
    from the program, the drawing, or asked for; of several tools each has its number.
    """

    program: Hash
    nose_radius_mm: Radius
    _: KW_ONLY
    dialect: Words | None = None
    unit: Literal["mm", "inch"] | None = None
    tool: Count | None = None
    tip: Tip | None = None
    tool_name: Words = ""
    tools: Annotated[tuple[AskedTool, ...], Field(max_length=20)] = ()
    lines: tuple[Number, Number] | None = None
    parameters: Annotated[Mapping[Words, Finite], Field(max_length=1000)] = field(default_factory=dict)
    accept_unknown_words: bool = False
    zero_at_z_mm: Annotated[float, Field(ge=-1e5, le=1e5, allow_inf_nan=False)] | None = None
    flipped: bool = False


@dataclass(frozen=True)
class AskedPart(AskedProgram):
    """A part by the finish program that cuts it, or of several set-ups by that of the first, with those of all others.

    `drawing` is the hash of a file handed over.
    """

    drawing: Hash = ""
    name: Words = ""
    side: Literal["outside", "inside", "around"] = "outside"
    outline: Count | None = None
    zero: Zero = "drawing"
    then: Annotated[tuple[AskedProgram, ...], Field(max_length=9)] = ()

    @property
    def programs(self) -> tuple[AskedProgram, ...]:
        """Returns the programs of all set-ups."""
        return (self, *self.then)

    @property
    def by_one_tool(self) -> bool:
        """Returns whether one tool cuts the whole part in one set-up."""
        return not self.tools and not self.then


@dataclass(frozen=True)
class AskedReadings:
    """Measurements: `values` as they were read, by the name of the size, or `file`, the hash of one handed over.

    `by`: what carries the correction. `cut_with`: "given", the id of a correction, or "" where nothing is stated;
    `made_before`: the ids of the corrections among which that was chosen. `tolerances`, by the name under which the
    part as shown has them, are as the drawing writes them, in the program's unit. `expanded_uncertainty_um` (k = 2)
    holds for the values that state none, `temperature_c` is that of the part while the values were read.
    """

    values: Annotated[Mapping[Words, tuple[Typed, ...]], Field(max_length=1000)] = field(default_factory=dict)
    file: Hash = ""
    file_unit: Literal["mm", "inch"] | None = None
    mapping_toml: Annotated[str, Field(max_length=100_000)] = ""
    serial: Words = ""
    instrument: Words = ""
    expanded_uncertainty_um: Annotated[float, Field(gt=0, le=1e6, allow_inf_nan=False)] | None = None
    measured_at: Annotated[datetime, AfterValidator(_zoned)] | None = None
    temperature_c: Annotated[float, Field(ge=-50, le=200, allow_inf_nan=False)] | None = None
    measured_allowance_mm: Annotated[float, Field(ge=-100, le=100, allow_inf_nan=False)] | None = None
    by: By = "auto"
    cut_with: Annotated[str, Field(pattern=r"^(given|[0-9a-f]{16})?$")] = ""
    cut_by: Literal["corrected", "offsets", "wear"] | None = None
    made_before: Annotated[tuple[Id, ...], Field(max_length=10_000)] = ()
    tolerances: Annotated[Mapping[Words, Typed], Field(max_length=1000)] = field(default_factory=dict)


@dataclass(frozen=True)
class HandJob:
    """Statements on a part, with the names of its files in the folder of the program ("": there is no such file).

    `then` are those of the programs of further set-ups, and `cut` is the list of corrections that cut a part of several
    tools or set-ups. `operator` is who stated it; sentences and pictures are for a reader of this language.
    """

    part: AskedPart
    name: str
    measured: AskedReadings | None = None
    drawing: str = ""
    file: str = ""
    then: tuple[str, ...] = ()
    cut: str = ""
    operator: str = ""
    language: Language = "en"

    def stated(self, k: int) -> AskedProgram:
        """Returns the program of set-up k, from 0: control and unit, where it states none, are those of the first."""
        of = self.part.programs[k]
        return replace(of, dialect=of.dialect or self.part.dialect, unit=of.unit or self.part.unit)


@dataclass(frozen=True)
class AskedMilled:
    """A milled part by its finish program, the hash of a file handed over; radii of cutters by tool number.

    `wear`: D holds wear alone, so that paths under G41 and G42 are those of the cutter's centre.
    """

    program: Hash
    cutters: Annotated[Mapping[Count, Radius], Field(max_length=200)] = field(default_factory=dict)
    wear: bool = False
    name: Words = ""
    dialect: Words | None = None
    unit: Literal["mm", "inch"] | None = None
    parameters: Annotated[Mapping[Words, Finite], Field(max_length=1000)] = field(default_factory=dict)
    accept_unknown_words: bool = False


@dataclass(frozen=True)
class MilledReadings:
    """Values as they were read, by the name of the size, or `file`, the hash of one handed over.

    `tolerances` by the name of the size as the drawing writes them, in the program's unit. `names`: the feature of the
    part by the file's name for it. `entered` is the hash of the record of the numbers that were entered last before
    the part was cut, "" for none.
    """

    values: Annotated[Mapping[Words, tuple[Typed, ...]], Field(max_length=1000)] = field(default_factory=dict)
    tolerances: Annotated[Mapping[Words, Typed], Field(max_length=1000)] = field(default_factory=dict)
    file: Hash = ""
    file_unit: Literal["mm", "inch"] | None = None
    mapping_toml: Annotated[str, Field(max_length=100_000)] = ""
    names: Annotated[Mapping[Words, Words], Field(max_length=1000)] = field(default_factory=dict)
    serial: Words = ""
    expanded_uncertainty_um: Annotated[float, Field(gt=0, le=1e6, allow_inf_nan=False)] | None = None
    entered: Hash = ""


@dataclass(frozen=True)
class MillJob:
    """Statements on a milled part, with the names of its files in the folder of the program."""

    part: AskedMilled
    name: str
    measured: MilledReadings | None = None
    file: str = ""
    entered: str = ""


def written_job(program: Path, hand_job: HandJob) -> tuple[Path, NewFiles]:
    """Writes the job beside its program, with the readings, as `trueloop new` does; returns its path and the part.

    Raises what `new_job` raises, MSR-FEATURE for a value of a size that is not on the sheet, and SRV-REQUEST for values
    beside a file.
    """
    folder, part, measured = program.parent, hand_job.part, hand_job.measured
    if measured is not None and hand_job.file and measured.values:
        raise Code.SRV_REQUEST.refusal(
            wording("values of {n} sizes are given beside a file of measurements", n=len(measured.values)),
            hint=wording("give the values or the file of measurements, not both"),
        )
    if not part.by_one_tool and not hand_job.drawing:
        raise Code.SRV_REQUEST.refusal(
            wording(
                "the part is cut by {n} programs and {tools} tools, and has no drawing",
                n=len(part.programs),
                tools=sum(1 + len(one.tools) for one in part.programs),
            ),
            hint=wording(
                "hand over the drawing of the finished part (DXF, STEP or IGES): what several tools leave does not "
                "follow from the programs"
            ),
        )
    stated = _cut(measured, hand_job)

    def wanted(of: AskedProgram, program: Path) -> WantedProgram:
        tools = tuple(filled_from(NewTool, tool) for tool in of.tools)
        return filled_from(WantedProgram, of, program=program, tools=tools, cut=stated)

    made = new_job(
        filled_from(
            Wanted,
            part,
            program=program,
            tools=wanted(part, program).tools,
            cut=stated,
            name=hand_job.name,
            folder=folder,
            drawing=folder / hand_job.drawing if hand_job.drawing else None,
            measured_file=folder / hand_job.file if hand_job.file else None,
            side=Side(part.side),
            chosen=Chosen(part.outline, part.zero),
            stated={} if measured is None else _stated(folder, measured, hand_job),
            tolerances={} if measured is None else measured.tolerances,
            then=tuple(wanted(hand_job.stated(k), folder / name) for k, name in enumerate(hand_job.then, 1)),
        )
    )
    job = folder / JOB
    if measured is not None and not hand_job.file:
        sheet = gauge_sheet_of(job).filled_in(measured.values, _above(measured, hand_job.operator))
        (folder / SHEET).write_text(sheet, encoding="utf-8")
    return job, made


def _cut(measured: AskedReadings | None, job: HandJob) -> dict[str, str]:
    """The keys of a program's table that state what cut the part."""
    if measured is None:
        return {}
    cut = {"cut_with": job.cut or measured.cut_with, "cut_by": measured.cut_by or ""}
    return {key: value for key, value in cut.items() if value}


def _above(measured: AskedReadings, operator: str) -> dict[str, str]:
    """The statements for all readings of a sheet. They are part of its hash: another statement, another inspection."""
    u_um, at = measured.expanded_uncertainty_um, measured.measured_at
    return {
        "serial": measured.serial,
        "instrument": measured.instrument,
        "expanded_uncertainty_um": "" if u_um is None else repr(u_um),
        "operator": operator,
        "measured_at": "" if at is None else at.isoformat(),
        "temperature_c": "" if measured.temperature_c is None else repr(measured.temperature_c),
    }


def _stated(folder: Path, measured: AskedReadings, job: HandJob) -> dict[str, dict[str, object]]:
    """Returns the keys of the job that state what was measured and how it is to be corrected."""
    gauging: dict[str, object] = {}
    if job.file:
        u_um = measured.expanded_uncertainty_um
        gauging = {
            "device": measured.instrument,
            "operator": job.operator,
            "measured_at": measured.measured_at,
            "readings_u_um": None if u_um is None else u_um / COVERAGE,
        }
    gauging |= {"measured_allowance_mm": measured.measured_allowance_mm, "readings_unit": measured.file_unit}
    if measured.mapping_toml:
        (folder / MAPPING).write_text(measured.mapping_toml, encoding="utf-8")
        gauging["readings_mapping"] = MAPPING
    return {
        "part": {"serial": measured.serial},
        "gauging": gauging,
        "compensation": {"by": measured.by},
        "report": {"language": job.language},
    }
