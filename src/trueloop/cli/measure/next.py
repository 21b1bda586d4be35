"""`trueloop measure next`: which measurements of a part are worth their time."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final, Literal

import typer

from trueloop.cli.probe import Control
from trueloop.cli.shared_options import Db, argument, option
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
Output = Annotated[
    Path | None, option("Folder for lists of points, a sheet to fill in and a DMIS program.", "--output", "-o")
]


Type = Annotated[str | None, option("The part type, where several have that serial number.", "--type", "-t")]

OfControl = Annotated[Control | None, option("Also write the probing program for this control.", "--control", "-c")]


def next_measurement(
    of_what: Asked,
    count: Count = 5,
    instruments: With = "probe,micrometer,cmm",
    minutes: Minutes = None,
    output: Output = None,
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
    if unknown := [one for one in kinds if one not in KINDS]:
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
    for one in plan.chosen:
        table.add_row(one.name, one.instrument, f"{one.minutes:.2f}", shown(one.before), shown(one.after))
    console.print(table)
    more = f" No further measurement {enough}." if plan.enough else ""
    console.print(
        f"\nExpected of the next part{aimed or ','} {what}{worst}: {shown(plan.before)} now, {shown(plan.after)} after "
        f"{plan.minutes:.1f} minutes.{more}"
    )
