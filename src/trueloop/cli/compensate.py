"""`trueloop compensate`: a job file in; programs, table, record and report out."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from trueloop.cli.options import StoreChoice, kept_as_dict, print_findings
from trueloop.cli.shared_options import argument, option
from trueloop.cli.terminal import AsJson, busy, guarded, print_json
from trueloop.domain.option import Language, LengthUnit, MemoryUse
from trueloop.formats.examples import example

if TYPE_CHECKING:
    from trueloop.jobs.store.opened import Keeping


@dataclass(frozen=True, kw_only=True)
class PageChoice:
    """How the report is shown, where that is not to be the job's choice."""

    language: Annotated[Language | None, option("Of the report.  [default: report.language of the job]")] = None
    unit: Annotated[
        LengthUnit | None, option("Of the report.  [default: report.unit of the job, else the program's]")
    ] = None
    pdf: Annotated[bool, option("Print report.pdf besides, by Chromium or Chrome.", "--pdf")] = False


@guarded
def compensate(
    job: Annotated[Path, argument("The job file; docs/job-file.md explains its keys.", metavar="JOB.toml")],
    page: PageChoice,
    store: StoreChoice,
    output: Annotated[
        Path | None, option("Folder for the results.  [default: output.folder of the job]", "--output", "-o")
    ] = None,
    serial: Annotated[str | None, option("Serial number of the part.  [default: part.serial of the job]")] = None,
    memory: Annotated[
        MemoryUse | None, option("Use of the edge's earlier parts.  [default: memory.use of the job]")
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Correct a finish program by touches of the semi-finished part.

    Writes corrected.nc, offsets.nc, table.csv, record.json, report.html and report.json: all, or none when anything is
    wrong. A part with a serial number is kept in a store, with what was measured, the programs and the correction, and
    earlier parts of the edge take part: it is trueloop.db beside the job, which is made, where none is named.

    A job with tables [[tools]] gets a table, a record and a report for each edge, and part.json; one with tables
    [[setups]] a corrected program for each set-up too.
    """
    run_job(job, output, page, store.keeping(serial), as_json, memory)


def run_job(
    path: Path,
    output: Path | None,
    page: PageChoice,
    keeping: "Keeping",
    as_json: bool,
    memory: MemoryUse | None = None,
) -> None:
    """Corrects as the job says and prints what was done."""
    with busy(f"correcting as {path.parent.name}/{path.name} says"):
        from trueloop.jobs.turned.compensate import compensate_and_keep
        from trueloop.report.turned.correction_json import correction_as_dict
        from trueloop.report.turned.part import part_as_dict

        done = compensate_and_keep(
            path, output, keeping, language=page.language, unit=page.unit, pdf=page.pdf, memory=memory
        )
    alone, files = done.corrected.alone, [str(file) for file in done.files]
    if as_json:
        shown = part_as_dict(done.corrected) if alone is None else correction_as_dict(alone)
        print_json({**shown, "files": files, **kept_as_dict(done.kept)})
        return
    from trueloop.cli.summary import print_part, print_summary

    if alone is None:
        print_part(done.corrected, done.files)
    else:
        print_summary(alone, done.files)
    if done.kept is not None:
        typer.echo(done.kept.words)
        print_findings(done.kept.findings)
    elif keeping.db is not False:
        typer.echo("kept in no store: the part has no serial number (part.serial of the job, or --serial)")


Part = Literal["facetst", "modbas2", "piecs11"]
"""The parts of [6811] that come with trueloop."""


@guarded
def demo(
    page: PageChoice,
    part: Annotated[Part, argument("Which part.")] = "modbas2",
    output: Annotated[Path | None, option("Folder for the results.  [default: out/PART]", "--output", "-o")] = None,
    as_json: AsJson = False,
) -> None:
    """Correct a part that NIST measured in the 1990s.

    From its touches to a corrected program, as a ready job.
    """
    run_job(
        example(f"{part}/job.toml"),
        output or Path("out") / part,
        page,
        StoreChoice(no_store=True).keeping(None),
        as_json,
    )
