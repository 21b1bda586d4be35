"""`trueloop compensate`: a job file in; programs, table, record and report out."""

from pathlib import Path
from typing import Annotated

import typer

from trueloop.cli.failure import guarded
from trueloop.cli.terminal import AsJson, busy, print_json


@guarded
def compensate(
    job: Annotated[Path, typer.Argument(metavar="JOB.toml", help="The job file; docs/job-file.md explains its keys.")],
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="Folder for the results.  [default: output.folder of the job]")
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Correct a finish program by the touches taken after the semi-finish cut.

    Writes corrected.nc, offsets.nc, table.csv, record.json and report.html: all, or none when anything is wrong.
    """
    run_job(job, output, as_json)


def run_job(path: Path, output: Path | None, as_json: bool) -> None:
    """Corrects as the job says and prints what was done."""
    with busy(f"correcting as {path.parent.name}/{path.name} says"):
        from trueloop.cli.turned.summary import print_summary
        from trueloop.jobs.compensate import compensate_job
        from trueloop.report.turned.correction_json import correction_as_dict

        correction, files = compensate_job(path, output)
    if as_json:
        print_json({**correction_as_dict(correction), "files": [str(file) for file in files]})
    else:
        print_summary(correction, files)
