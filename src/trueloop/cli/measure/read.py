"""`trueloop measure read`: what inspection files say, and on which features of a job's part."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from trueloop.cli.failure import ExitStatus, guarded
from trueloop.cli.terminal import AsJson, busy, print_json

if TYPE_CHECKING:
    from trueloop.report.measured import FileOnPart

Files = Annotated[
    list[Path], typer.Argument(metavar="FILE…", help="What a gauge, a measuring machine or a control wrote.")
]
Job = Annotated[Path | None, typer.Option("--job", "-j", help="The job whose part was measured.  [default: none]")]
Output = Annotated[
    Path | None,
    typer.Option("--output", "-o", help="CSV to write of touches or readings that a job can name; needs --job."),
]


@dataclass(frozen=True, kw_only=True)
class Meant:
    """What a file does not say itself, and which of its inspections are meant."""

    unit: Annotated[
        Literal["mm", "inch"] | None, typer.Option("--unit", help="Unit of its lengths.  [default: what it says]")
    ] = None
    mapping: Annotated[
        Path | None, typer.Option("--mapping", "-m", help="TOML file that says what columns, variables and names mean.")
    ] = None
    serial: Annotated[str | None, typer.Option("--serial", help="Serial number of the part.  [default: all]")] = None
    run: Annotated[int | None, typer.Option("--run", min=1, help="Which inspection of the file.  [default: all]")] = (
        None
    )
    axis: Annotated[
        Literal["x", "y", "z", "-x", "-y", "-z"] | None,
        typer.Option(
            "--axis",
            metavar="AXIS",
            help="Axis of the points' frame along the spindle: x, y or z, with a minus where it points to the chuck.  "
            "[default: found, z where it fits]",
        ),
    ] = None


@guarded
def read(files: Files, meant: Meant, job: Job = None, output: Output = None, as_json: AsJson = False) -> None:
    """Show what inspection files hold, and with --job which feature each value was matched with, and why not."""
    from trueloop.errors import Severity
    from trueloop.formats.inspections.measured_file import Stated
    from trueloop.jobs.measure.measured import Chosen, read_measured, read_part_of_job, write_measured
    from trueloop.report.measured import measured_as_dict

    if output is not None and job is None:
        raise typer.BadParameter("needs --job: touches and readings are of its features", param_hint="--output")
    stated, chosen = Stated(meant.unit, meant.mapping), Chosen(meant.serial, meant.run)
    with busy(f"reading {', '.join(map(str, files))}"):
        part = None if job is None else read_part_of_job(job)
        found = [read_measured(file, stated, part, chosen, meant.axis) for file in files]
    if as_json:
        print_json(measured_as_dict(found))
    else:
        _print(found)
    if output is not None and part is not None:
        mappings = [] if meant.mapping is None else [meant.mapping]
        for written in write_measured(found, part, output, [*files, *part.files, *mappings]):
            typer.echo(f"written: {written}", err=True)
    odd = [one for file in found for on_part in file.on_part for one in on_part.findings]
    if any(one.severity is Severity.ERROR for one in odd):
        raise typer.Exit(ExitStatus.FINDINGS)


def _print(found: "list[FileOnPart]") -> None:
    from trueloop.cli.measure.measured_table import print_file

    for file in found:
        print_file(file)
