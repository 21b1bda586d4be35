"""`trueloop measure`: what gauges and measuring machines are to measure, and what they reported."""

from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final, Literal

import typer

from trueloop.cli.options import StoreChoice, kept_as_dict, print_findings
from trueloop.cli.probe import Control
from trueloop.cli.shared_options import Db, argument, option, positive
from trueloop.cli.terminal import AsJson, ExitStatus, Group, busy, print_json, print_lines, put, wide_console

if TYPE_CHECKING:
    from trueloop.formats.inspections.measured_file import MeasuredFile
    from trueloop.jobs.measure.keep_measured import StatedCut
    from trueloop.jobs.store.keep_facts import KeptFacts
    from trueloop.loops.turned.next_measurement import Plan
    from trueloop.report.measured import FileOnPart, OnPart, ValueRow


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


Files = Annotated[list[Path], argument("File of a gauge, a measuring machine or a control.", metavar="FILE…")]
Job = Annotated[Path | None, option("The job whose part was measured.  [default: none]", "--job", "-j")]
Output = Annotated[
    Path | None, option("CSV to write of touches or readings that a job can name; needs --job.", "--output", "-o")
]


Unit = Annotated[Literal["mm", "inch"] | None, option("Unit of its lengths.  [default: as it states]", "--unit")]
Mapping = Annotated[
    Path | None, option("TOML file that states what columns, variables and names mean.", "--mapping", "-m")
]


@dataclass(frozen=True, kw_only=True)
class Meant:
    """Options for information missing in a file, and the choice of its inspections."""

    unit: Unit = None
    mapping: Mapping = None
    serial: Annotated[str | None, option("Serial number of the part.  [default: all]")] = None
    run: Annotated[int | None, option("Which inspection of the file.  [default: all]", min=1)] = None
    axis: Annotated[
        Literal["x", "y", "z", "-x", "-y", "-z"] | None,
        option(
            "Axis of the points' frame along the spindle: x, y or z, with a minus where it points to the chuck.  "
            "[default: found, z where it fits]",
            metavar="AXIS",
        ),
    ] = None


@dataclass(frozen=True, kw_only=True)
class CutShown:
    """Which cut the inspections show, for the store."""

    after: Annotated[
        Literal["semifinish", "finish", "released"] | None,
        option("Keep them in the store, as what this stage left; released: off the machine."),
    ] = None
    record: Annotated[
        str | None, option("The finish cut's correction.  [default: the part's last one]", metavar="ID")
    ] = None
    program: Annotated[Path | None, option("The program that ran: its mark names the correction.")] = None
    ran: Annotated[
        Literal["corrected", "offsets", "wear", "as-programmed"] | None,
        option(
            "The program that ran; wear: the offset was entered at the control; as-programmed: nothing corrected.  "
            "[default: what was to be run]"
        ),
    ] = None
    minutes: Annotated[float | None, option("Time in cut of the finish cut.", min=0)] = None
    order: Annotated[int | None, option("The part's place in the order in which the edge cut.", min=0)] = None
    measured_at: Annotated[
        datetime | None, option("When files without a time were measured, local.", formats=["%Y-%m-%dT%H:%M"])
    ] = None

    def shown(self) -> "StatedCut | None":
        """As jobs take it; None: nothing is to be kept."""
        from trueloop.domain.life import Ran
        from trueloop.errors import Code
        from trueloop.formats.input_file import read_input
        from trueloop.jobs.measure.keep_measured import StatedCut
        from trueloop.jobs.store.keep_facts import CutStatement

        if self.after is None:
            return None
        hint = "--program names what the control ran"
        text = None if self.program is None else read_input(self.program, Code.NC_FILE, hint=hint)
        ran = None if self.ran is None else Ran(self.ran)
        at = None if self.measured_at is None else self.measured_at.astimezone()
        return StatedCut(self.after, CutStatement(self.record, text, ran, self.minutes, self.order), at)


def read(
    files: Files,
    meant: Meant,
    cut: CutShown,
    store: StoreChoice,
    job: Job = None,
    output: Output = None,
    as_json: AsJson = False,
) -> None:
    """Show the values of inspection files, with --job their features.

    A value without a feature has the reason. With --after they are kept in the job's store, linked with the cut that
    they show.
    """
    from trueloop.errors import Severity
    from trueloop.formats.inspections.measured_file import StatedFacts
    from trueloop.jobs.measure.measured import Chosen, read_measured, read_part_of_job, write_measured
    from trueloop.report.measured import measured_as_dict

    if output is not None and job is None:
        raise typer.BadParameter("needs --job: touches and readings are of its features", param_hint="--output")
    if cut.after is not None and job is None:
        raise typer.BadParameter("needs --job: its part was inspected", param_hint="--after")
    if cut.after is None and (store.db or cut != CutShown()):
        raise typer.BadParameter("needs --after: which cut the inspections show", param_hint="--db")
    stated, chosen = StatedFacts(meant.unit, meant.mapping), Chosen(meant.serial, meant.run)
    with busy(f"reading {', '.join(map(str, files))}"):
        part = None if job is None else read_part_of_job(job)
        found = [read_measured(file, stated, part, chosen, meant.axis) for file in files]
    kept = None if job is None else _kept(found, job, cut, store, meant)
    if as_json:
        print_json({**measured_as_dict(found), **kept_as_dict(kept)})
    else:
        for file in found:
            print_file(file)
        if kept is not None:
            print_lines([kept.words, *(obtained.words for obtained in kept.obtained)])
            print_findings(kept.findings)
    if output is not None and part is not None:
        mappings = [] if meant.mapping is None else [meant.mapping]
        for written in write_measured(found, part, output, [*files, *part.files, *mappings]):
            typer.echo(f"written: {written}", err=True)
    odd = [finding for file in found for on_part in file.on_part for finding in on_part.findings]
    if any(finding.severity is Severity.ERROR for finding in odd):
        raise typer.Exit(ExitStatus.FINDINGS)


def _kept(files: "list[FileOnPart]", job: Path, cut: CutShown, store: StoreChoice, meant: Meant) -> "KeptFacts | None":
    """Keeps the inspections and returns the result; None if nothing was requested."""
    from trueloop.formats.inspections.shared.text import feature_names
    from trueloop.jobs.measure.keep_measured import keep_measured

    shown = cut.shown()
    if shown is None:
        return None
    kept = keep_measured(files, job, shown, store.keeping(meant.serial), feature_names(meant.mapping))
    if kept is None:
        why = "--no-store is given" if store.no_store else "there is no store"
        raise typer.BadParameter(f"{why}: name by --db the one that `trueloop compensate` kept the correction in")
    return kept


MOST: Final = 200
"""Rows of a table: nobody reads more on a screen."""
NAMED: Final = 6
"""Names in a list of values that have one thing in common."""
VERDICTS: Final = {True: "in", False: "OUT", None: ""}


def print_file(file: "FileOnPart") -> None:
    """The file's own facts, a table for each inspection, what was not matched, and remarks."""
    from trueloop.report.measured import rows_of

    read = file.file
    count = len(read.inspections)
    print_lines(
        [
            f"{read.path}: {read.format}, {read.encoding}, unit {read.unit or 'not stated'}, "
            f"{count} {'inspection' if count == 1 else 'inspections'}"
        ]
    )
    for on_part in file.on_part:
        print_lines(["", _heading(on_part)])
        rows = list(rows_of(file, on_part))
        _print_table([row for row in rows if not row.reason], matched=on_part.matches is not None)
        _print_left([row for row in rows if row.reason and row.is_error])
        _print_kept([row for row in rows if row.reason and not row.is_error])
        print_lines(on_part.findings)
    if read.remarks:
        print_lines(["", "remarks:"])
        print_lines(
            f"  line {remark.line}: {remark.text}" if remark.line else f"  {remark.text}"
            for remark in read.remarks[:MOST]
        )
    print_lines([""])


def _heading(on_part: "OnPart") -> str:
    inspection, matches = on_part.inspection, on_part.matches
    part = inspection.part
    said = [
        f"{on_part.run}.",
        part.part_type.name or "part not stated",
        f"serial {part.serial}" if part.serial else "serial not stated",
        *([f"{inspection.measured_at:%Y-%m-%d %H:%M}"] if inspection.measured_at else []),
        *([inspection.device] if inspection.device else []),
        f"{inspection.count} {inspection.measured}",
    ]
    if matches is not None:
        total = matches.count + len(matches.unmatched)
        said.append(f"{matches.count} of {total} matched")
        if matches.axis is not None:
            said.append(f"spindle along {matches.axis}")
    return f"{said[0]} {', '.join(said[1:])}"


def _print_table(rows: "list[ValueRow]", *, matched: bool) -> None:
    if not rows:
        return
    from rich.table import Table

    table = Table(box=None, pad_edge=False)
    for name in ("characteristic", "quantity", "feature", *(("by",) if matched else ())):
        table.add_column(name)
    numbers = (*(("away mm",) if matched else ()), "nominal", "actual", "deviation", "lower", "upper")
    for name in numbers:
        table.add_column(name, justify="right", no_wrap=True)
    table.add_column("")
    placed = any(row.place_mm for row in rows)
    if placed:
        table.add_column("place mm")
    for row in rows[:MOST]:
        table.add_row(
            *_cells(row, matched=matched), *([" ".join(f"{one:.4f}" for one in row.place_mm)] if placed else [])
        )
    wide_console().print(table)
    if len(rows) > MOST:
        print_lines([f"… and {len(rows) - MOST} more: --json has all"])


def _cells(row: "ValueRow", *, matched: bool) -> list[str]:
    from rich.markup import escape

    name = row.characteristic if row.repeat == 1 else f"{row.characteristic} ({row.repeat})"
    found = [row.by] if matched else []
    away = [_number(row.distance_mm, "z.4f")] if matched else []
    limits = [_number(one, ".4f") for one in (row.lower_limit, row.upper_limit)]
    sizes = [_number(row.nominal, ".4f"), _number(row.actual, ".4f"), _number(row.deviation, "+z.4f"), *limits]
    words = [escape(one) for one in (name, row.quantity, row.feature, *found)]
    return [*words, *away, *sizes, VERDICTS[row.within]]


def _number(value: float | None, form: str) -> str:
    return "" if value is None else format(value, form)


def _print_left(rows: "list[ValueRow]") -> None:
    if not rows:
        return
    print_lines(["", f"not matched: {len(rows)}"])
    for row in rows[:MOST]:
        where = f" (line {row.line})" if row.line else ""
        print_lines([f"  {row.characteristic or row.quantity}{where}: {row.reason}"])
    if len(rows) > MOST:
        print_lines([f"  … and {len(rows) - MOST} more: --json has all"])


def _print_kept(rows: "list[ValueRow]") -> None:
    """By reason, for they are many where each circle has its position and its form."""
    if not rows:
        return
    print_lines(["", f"no errors of the profile, kept: {len(rows)}"])
    for reason in dict.fromkeys(row.reason for row in rows):
        names = [row.characteristic or row.quantity for row in rows if row.reason == reason]
        more = f" and {len(names) - NAMED} more" if len(names) > NAMED else ""
        print_lines([f"  {', '.join(names[:NAMED])}{more}: {reason}"])


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
    from trueloop.formats.inspections.gauge_csv import holds_readings
    from trueloop.formats.outputs import write_all
    from trueloop.jobs.measure.next_measurement import SHEET, next_of_part, plan_measurements, written_files
    from trueloop.jobs.store.opened import open_store

    asked, job = [one for one in KINDS if one in kinds], Path(of_what) if of_what.endswith(".toml") else None
    if job is not None:
        found = plan_measurements(job, count, asked, taken, db)
    elif control is not None:
        raise typer.BadParameter("a probing program needs the probe that a job names: name the job", param_hint="-c")
    else:
        found = next_of_part(open_store(db), of_what, count, asked, taken, part_type)
    if output is not None and found.plan.chosen:
        texts = written_files(found, job, control)
        inputs = (*found.files, *([output / SHEET] if holds_readings(output / SHEET) else []))
        for file in write_all(output, [(name, text.encode()) for name, text in texts.items()], inputs):
            typer.echo(f"written: {file}", err=True)
    if as_json:
        print_json(found.as_dict())
        return
    if not found.measured:
        typer.echo(
            "No file of touches or readings that the job names has a value: planned as for a part not measured yet."
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
    if not isinstance(mapped.file, TrueloopError):
        _print_values(mapped.file)
    typer.echo(f"written: {mapped.path}", err=True)
    if isinstance(mapped.file, TrueloopError):
        raise mapped.file


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


def _print_values(file: "MeasuredFile") -> None:
    from dataclasses import replace

    from trueloop.report.measured import FileOnPart, OnPart

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


JobArgument = Annotated[Path, argument("The job of the part.", metavar="JOB.toml")]
SheetOutput = Annotated[
    Path | None, option("File to write: .pdf or .html to print, else CSV.  [default: stdout]", "--output", "-o")
]


def sheet(job: JobArgument, output: SheetOutput = None) -> None:
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
ConvertOutput = Annotated[Path, option("File to write: QIF 3.0 (.qif), Q-DAS (.dfq) or DMIS (.dmo).", "--output", "-o")]


def convert(file: File, output: ConvertOutput, unit: Unit = None, mapping: Mapping = None) -> None:
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
