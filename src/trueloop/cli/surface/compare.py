"""`trueloop surface compare`: parts cut after a correction beside those cut before."""

from pathlib import Path
from typing import Annotated

import typer

from trueloop.cli.failure import guarded
from trueloop.cli.terminal import AsJson, busy, print_json


@guarded
def compare(
    before: Annotated[Path, typer.Argument(metavar="BEFORE.toml", help="The job of the parts cut before.")],
    after: Annotated[Path, typer.Argument(metavar="AFTER.toml", help="The job of the parts cut after.")],
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", help="Folder for the results.  [default: output.folder of the job after]"),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Set parts cut after a correction beside those before: deterministic, random, worst."""
    from trueloop.formats.outputs import write_all
    from trueloop.jobs.surface.job import compare_jobs, read_surface
    from trueloop.loops.surface.surface import Work
    from trueloop.report.surface.compare_page import compare_page
    from trueloop.report.surface.compare_summary import comparison_json, comparison_lines, comparison_summary

    with busy(f"comparing {before} and {after}") as progress:
        jobs = read_surface(before), read_surface(after)
        found = compare_jobs(*jobs, Work(progress=progress))
        contents = [("compare.html", compare_page(found).encode()), ("compare.json", comparison_json(found))]
        files = write_all(output or jobs[1].output_folder, contents, (*jobs[0].files, *jobs[1].files))
    if as_json:
        print_json({**comparison_summary(found), "files": list(map(str, files))})
        return
    for line in (*comparison_lines(found), *found.findings, *files):
        print(line)
