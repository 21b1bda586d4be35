"""`trueloop measure read`: what inspection files say, and on which features of a job's part."""

from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final, Literal

import typer

from trueloop.cli.options import StoreChoice, kept_as_dict, print_findings
from trueloop.cli.shared_options import argument, option
from trueloop.cli.terminal import AsJson, ExitStatus, busy, print_json, print_lines, wide_console

if TYPE_CHECKING:
    from trueloop.jobs.measure.keep_measured import StatedCut
    from trueloop.jobs.store.keep_facts import KeptFacts
    from trueloop.report.measured import FileOnPart, OnPart, ValueRow

Files = Annotated[list[Path], argument("File of a gauge, a measuring machine or a control.", metavar="FILE…")]
Job = Annotated[Path | None, option("The job whose part was measured.  [default: none]", "--job", "-j")]
Output = Annotated[
    Path | None, option("CSV to write of touches or readings that a job can name; needs --job.", "--output", "-o")
]


@dataclass(frozen=True, kw_only=True)
class Meant:
    """Options for information missing in a file, and the choice of its inspections."""

    unit: Annotated[Literal["mm", "inch"] | None, option("Unit of its lengths.  [default: as it states]")] = None
    mapping: Annotated[
        Path | None, option("TOML file that states what columns, variables and names mean.", "--mapping", "-m")
    ] = None
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
        from trueloop.jobs.store.finish_cut import CutStatement

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
        _print(found)
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
    if cut.after is None:
        return None
    from trueloop.formats.inspections.shared.text import feature_names
    from trueloop.jobs.measure.keep_measured import keep_measured

    shown = cut.shown()
    assert shown is not None
    kept = keep_measured(files, job, shown, store.keeping(meant.serial), feature_names(meant.mapping))
    if kept is None:
        why = "--no-store is given" if store.no_store else "there is no store"
        raise typer.BadParameter(f"{why}: name by --db the one that `trueloop compensate` kept the correction in")
    return kept


def _print(files: "list[FileOnPart]") -> None:

    for file in files:
        print_file(file)


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
