"""`trueloop compensate`: a job file in; programs, table, record and report out."""

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from trueloop.cli.failure import guarded
from trueloop.cli.terminal import AsJson, busy, print_json

if TYPE_CHECKING:
    from trueloop.loops.turned.correction import Correction


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
    """Reads, corrects, writes and says what was done."""
    with busy(f"correcting as {path.parent.name}/{path.name} says"):
        from trueloop.cli import summary
        from trueloop.formats.outputs import write_all
        from trueloop.jobs.turned import read_inputs
        from trueloop.loops.turned.process_intermittent import compensate

        job = read_inputs(path)
        correction = compensate(job.inputs)
        files = write_all(output or _from_here(job.output_folder), _contents(correction).items(), job.files)
    if as_json:
        print_json(summary.as_dict(correction, files))
    else:
        summary.print_summary(correction, files)


def _from_here(folder: Path) -> Path:
    """The folder as seen from where the command runs, without a detour by the job's folder."""
    resolved = folder.resolve()
    return resolved.relative_to(Path.cwd()) if resolved.is_relative_to(Path.cwd()) else resolved


def _contents(correction: "Correction") -> Mapping[str, bytes | None]:
    """File name to bytes, None for one that there shall not be. The record comes last: then its set is complete."""
    from trueloop.formats.tables.table_csv import table_to_csv
    from trueloop.report.turned.page import page

    return {
        correction.corrected_name: None if correction.runs_as_given else correction.corrected_program,
        correction.offsets_name: correction.offsets_program,
        "table.csv": table_to_csv(correction.table),
        "report.html": page(correction).encode(),
        "record.json": correction.record.to_json().encode(),
    }
