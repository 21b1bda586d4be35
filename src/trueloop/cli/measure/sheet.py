"""`trueloop measure sheet`: what a person measures of a job's part, to print and to fill in."""

from pathlib import Path
from typing import Annotated

import typer

from trueloop.cli.terminal import guarded, put

Job = Annotated[Path, typer.Argument(metavar="JOB.toml", help="The job of the part.")]
Output = Annotated[
    Path | None,
    typer.Option("--output", "-o", help="File to write: .pdf or .html to print, else CSV.  [default: stdout]"),
]


@guarded
def sheet(job: Job, output: Output = None) -> None:
    """List the diameters and lengths to measure by hand, each with an empty cell: to print, or to fill in."""
    from trueloop.jobs.turned.gauge_sheet import gauge_sheet_of, write_sheet

    planned = gauge_sheet_of(job)
    if output is None:
        put(planned.csv, None, ())
    else:
        typer.echo(f"written: {write_sheet(planned, output)}", err=True)
