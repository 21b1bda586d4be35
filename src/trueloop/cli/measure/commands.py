"""`trueloop measure`: what gauges and measuring machines are to measure, and what they reported."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final, Literal

import typer

from trueloop.cli.measure.read import read
from trueloop.cli.shared_options import argument, option, positive
from trueloop.cli.terminal import Group, busy, print_lines, put

if TYPE_CHECKING:
    from trueloop.jobs.measure.measured import Mapped
from typing import TYPE_CHECKING

from trueloop.cli.probe import Control
from trueloop.cli.shared_options import Db
from trueloop.cli.terminal import AsJson, print_json

if TYPE_CHECKING:
    from trueloop.loops.turned.next_measurement import Plan


Instrument = Literal["probe", "micrometer", "cmm"]
KINDS: Final[tuple[Instrument, ...]] = ("probe", "micrometer", "cmm")
Asked = Annotated[
    str, argument("The job of the part, or the serial number of one in the store.", metavar="JOB.toml|SERIAL")
]
Count = Annotated[int, option("So many measurements at most.", "--count", "-n", min=1)]
With = Annotated[str, option("Instruments at hand: probe, micrometer and cmm, separated by commas.", "--with")]
Minutes = Annotated[
    list[str] | None,
    option(
        "Minutes that a measurement takes; several times.  [default: probe=0.25 micrometer=1 cmm=0.2]",
        "--minutes",
        metavar="KIND=MINUTES",
    ),
]
PointsOutput = Annotated[
    Path | None, option("Folder for lists of points, a sheet to fill in and a DMIS program.", "--output", "-o")
]


Type = Annotated[str | None, option("The part type, where several have that serial number.", "--type", "-t")]

OfControl = Annotated[Control | None, option("Also write the probing program for this control.", "--control", "-c")]


def next_measurement(
    of_what: Asked,
    count: Count = 5,
    instruments: With = "probe,micrometer,cmm",
    minutes: Minutes = None,
    output: PointsOutput = None,
    control: OfControl = None,
    part_type: Type = None,
    db: Db = None,
    as_json: AsJson = False,
) -> None:
    """List the next measurements, the most telling a minute first.

    Telling: that lower most of what is not known of the next part. Where none is needed, it prints that. Decided by the
    probability that a characteristic with limits is out of them, else by the error along the contour.
    """
    kinds = [one.strip() for one in instruments.split(",")]
    if unknown := [kind for kind in kinds if kind not in KINDS]:
        raise typer.BadParameter(f"{unknown[0]!r} is not one of {', '.join(KINDS)}", param_hint="--with")
    taken = dict(map(_minutes, minutes or ()))
    from trueloop.formats.outputs import write_all
    from trueloop.jobs.measure.next_measurement import next_of_job, next_of_part, written_files
    from trueloop.jobs.store.opened import opened

    asked, job = [one for one in KINDS if one in kinds], Path(of_what) if of_what.endswith(".toml") else None
    if job is not None:
        found = next_of_job(job, count, asked, taken, db)
    elif control is not None:
        raise typer.BadParameter("a probing program needs the probe that a job names: name the job", param_hint="-c")
    else:
        found = next_of_part(opened(db), of_what, count, asked, taken, part_type)
    if output is not None and found.plan.chosen:
        texts = written_files(found, job, control)
        for file in write_all(output, [(name, text.encode()) for name, text in texts.items()], found.files):
            typer.echo(f"written: {file}", err=True)
    if as_json:
        print_json(found.as_dict())
        return
    if not found.measured:
        typer.echo(
            "No file of touches or readings that the job names is there: planned as for a part not measured yet."
        )
    _show(found.plan)


def _minutes(stated: str) -> tuple[Instrument, float]:
    kind, _, number = stated.partition("=")
    try:
        value = float(number)
    except ValueError:
        value = 0.0
    known = next((one for one in KINDS if one == kind), None)
    if known is None or not 0.0 < value < 1e6:
        raise typer.BadParameter(f"{stated!r} is not KIND=MINUTES, as probe=0.25", param_hint="--minutes")
    return known, value


def _show(plan: "Plan") -> None:
    """Prints the plan as a table."""
    from rich.console import Console
    from rich.table import Table

    from trueloop.loops.turned.next_measurement import OUT, WORTHWHILE

    console = Console(highlight=False, soft_wrap=True)
    limits = plan.criterion == "probability_out"

    def shown(value: float) -> str:
        return f"{100.0 * value:.2f} %" if limits else f"{value:.2f} µm"

    what = "largest probability out of limits" if limits else "RMS error along the contour"
    # Not the cut that a correction was written for: a nominal value that lies on a limit is out half of the time.
    aimed = ", corrected to its nominal sizes," if limits else ""
    worst = f" ({plan.worst})" if plan.worst else ""
    enough = "is needed" if limits and plan.after < OUT else f"lowers it by more than {100.0 * WORTHWHILE:g} %"
    if not plan.chosen:
        console.print(f"No measurement {enough}: {what}{worst} of the next part{aimed} {shown(plan.before)}.")
        return
    table = Table("measure", "with", box=None, pad_edge=False)
    for heading in ("minutes", "before", "after"):
        table.add_column(heading, justify="right")
    for measurement in plan.chosen:
        table.add_row(
            measurement.name,
            measurement.instrument,
            f"{measurement.minutes:.2f}",
            shown(measurement.before),
            shown(measurement.after),
        )
    console.print(table)
    more = f" No further measurement {enough}." if plan.enough else ""
    console.print(
        f"\nExpected of the next part{aimed or ','} {what}{worst}: {shown(plan.before)} now, {shown(plan.after)} after "
        f"{plan.minutes:.1f} minutes.{more}"
    )


TableFile = Annotated[Path, argument("A table of measured values: CSV, .xlsx, .xls or .ods.", metavar="FILE")]
MappingOutput = Annotated[
    Path | None, option("Mapping to write.  [default: FILE.map.toml beside it]", "--output", "-o")
]
Sheet = Annotated[str, option("Sheet of a workbook.  [default: the only one with headings]", "--sheet")]
Unit = Annotated[Literal["mm", "inch"] | None, option("Unit of its lengths.  [default: as it states]", "--unit")]
Columns = Annotated[
    list[str] | None,
    option(
        "Meaning of a column: actual=Ist; repeatable. Of columns side by side: parts=, repeats=, characteristics=.",
        "--column",
        "-c",
        metavar="MEANING=HEADING",
    ),
]
SHOWN = 8


def map_columns(
    file: TableFile, output: MappingOutput = None, sheet: Sheet = "", unit: Unit = None, column: Columns = None
) -> None:
    """Propose a mapping for the columns of a table, and write it.

    The first values are shown as they would be read.
    """
    from trueloop.errors import TrueloopError
    from trueloop.jobs.measure.measured import map_table

    mapped = map_table(file, output, sheet, unit, _given(column or []))
    mapping = mapped.mapping
    print_lines([f"headings in row {mapping.header_row}" + (f" of sheet {mapping.sheet!r}" if mapping.sheet else "")])
    print_lines(f"  {role:<16} {name}" for role, name in mapping.columns.named().items())
    for key in ("parts", "repeats", "characteristics", "ignored"):
        if names := getattr(mapping.columns, key):
            print_lines([f"  {key:<16} {', '.join(names)}"])
    said = {"unit": mapping.unit, "deviations": mapping.deviation, "lower tolerances": mapping.lower_tolerance}
    print_lines([f"  {key:<16} {value}" for key, value in said.items() if value])
    if isinstance(mapped.file, TrueloopError):
        typer.echo(f"written: {mapped.path}", err=True)
        raise mapped.file
    _print_values(mapped)
    typer.echo(f"written: {mapped.path}", err=True)


def _given(columns: list[str]) -> dict[str, list[str]]:
    from trueloop.formats.inspections.tables.mapping import Columns as Known

    given: dict[str, list[str]] = {}
    for text in columns:
        meaning, equals, heading = text.partition("=")
        if not equals or meaning not in Known.model_fields:
            known = ", ".join(Known.model_fields)
            raise typer.BadParameter(f"{text!r} is no MEANING=HEADING; meanings: {known}", param_hint="--column")
        given.setdefault(meaning, []).append(heading)
    return given


def _print_values(mapped: "Mapped") -> None:
    from dataclasses import replace

    from trueloop.cli.measure.read import print_file
    from trueloop.formats.inspections.measured_file import MeasuredFile
    from trueloop.report.measured import FileOnPart, OnPart

    file = mapped.file
    if not isinstance(file, MeasuredFile):
        return
    shown = [replace(inspection, values=inspection.values[:SHOWN]) for inspection in file.inspections[:2]]
    print_lines([""])
    print_file(FileOnPart(file, tuple(OnPart(run, inspection) for run, inspection in enumerate(shown, 1))))


PlannedJob = Annotated[Path, argument("The job whose points are to be measured.", metavar="JOB.toml")]
Angles = Annotated[
    list[float] | None,
    option("Where about the part's axis, degrees from x to y; several times.  [default: 0]", "--angle"),
]
Diameters = Annotated[
    bool, option("Touch cylinders also half a turn further, so that diameters are measured.", "--diameters")
]
PlanOutput = Annotated[
    Path | None, option("File to write: .dms a DMIS program, .csv a list.  [default: list on stdout]", "--output", "-o")
]
PROGRAMS: Final = (".dms", ".dmi", ".dmis")
LISTS: Final = (".csv", ".txt")


@dataclass(frozen=True, kw_only=True)
class Moves:
    """How a program leads the ball."""

    ball_radius_mm: Annotated[float, option("Radius of the ball that the moves are for.", callback=positive)] = 1.0
    approach_mm: Annotated[float, option("Distance before the surface at which a touch begins.", callback=positive)] = (
        3.0
    )
    clearance_mm: Annotated[float, option("Distance of moves between points from the part.", callback=positive)] = 10.0


def plan(
    job: PlannedJob, moves: Moves, angle: Angles = None, diameters: Diameters = False, output: PlanOutput = None
) -> None:
    """List where a measuring machine touches, or write DMIS.

    Points have their normals.
    """
    if output is not None and output.suffix.lower() not in (*PROGRAMS, *LISTS):
        kinds = ", ".join(PROGRAMS), ", ".join(LISTS)
        raise typer.BadParameter(f"{output.name!r} ends with none of {kinds[0]} (program), {kinds[1]} (list)")
    from trueloop.formats.measurements.cmm_plan_csv import cmm_plan_to_csv
    from trueloop.jobs.measure.probing import program_of, read_measuring
    from trueloop.probing.cmm_plan import CmmApproach

    measuring = read_measuring(job, angle or (0.0,), diameters=diameters)
    if output is None or output.suffix.lower() in LISTS:
        put(cmm_plan_to_csv(measuring.touches), output, measuring.files)
        return
    approach = CmmApproach(moves.ball_radius_mm, moves.approach_mm, moves.clearance_mm, measuring.allowance_mm)
    put(program_of(measuring, approach, job.name), output, measuring.files)


Job = Annotated[Path, argument("The job of the part.", metavar="JOB.toml")]
SheetOutput = Annotated[
    Path | None, option("File to write: .pdf or .html to print, else CSV.  [default: stdout]", "--output", "-o")
]


def sheet(job: Job, output: SheetOutput = None) -> None:
    """List the diameters and lengths to measure by hand.

    Each has an empty cell: to print, or to fill in.
    """
    from trueloop.jobs.turned.new import gauge_sheet_of, write_sheet

    planned = gauge_sheet_of(job)
    if output is None:
        put(planned.csv, None, ())
    else:
        typer.echo(f"written: {write_sheet(planned, output)}", err=True)


File = Annotated[Path, argument("File of a gauge, a measuring machine or a control.", metavar="FILE")]
Output = Annotated[Path, option("File to write: QIF 3.0 (.qif), Q-DAS (.dfq) or DMIS (.dmo).", "--output", "-o")]
Mapping = Annotated[
    Path | None, option("TOML file that states what columns, variables and names mean.", "--mapping", "-m")
]


def convert(file: File, output: Output, unit: Unit = None, mapping: Mapping = None) -> None:
    """Write an inspection file in another format, in mm and degrees.

    All its parts are written.
    """
    from trueloop.formats.inspections.measured_file import StatedFacts
    from trueloop.jobs.measure.measured import convert as write_converted

    with busy(f"reading {file}"):
        read = write_converted(file, StatedFacts(unit, mapping), output)
    for remark in read.remarks:
        typer.echo(f"{file}{'' if remark.line is None else f':{remark.line}'}: {remark.text}", err=True)
    values = sum(inspection.count for inspection in read.inspections)
    typer.echo(f"{read.format}: {len(read.inspections)} inspections, {values} values", err=True)
    typer.echo(f"written: {output}", err=True)


app = Group("Files of gauges and measuring machines, and plans for them.")
app.add(convert)
app.add(next_measurement, "next")
app.add(plan)
app.add(read)
app.add(sheet)
app.add(map_columns, "map")
