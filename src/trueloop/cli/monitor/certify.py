"""`trueloop monitor certify`."""

from pathlib import Path
from typing import Annotated

import typer

from trueloop.cli.db.options import Db
from trueloop.cli.failure import ExitStatus, guarded
from trueloop.cli.numbers import positive
from trueloop.cli.series.options import Page
from trueloop.cli.terminal import AsJson, print_json, print_lines, print_table


@guarded
def certify(
    serial: Annotated[str, typer.Argument(metavar="SERIAL", help="The part's serial number.")],
    page: Page,
    output: Annotated[Path, typer.Option("--output", "-o", help="Folder for the certificate.")],
    part_type: Annotated[
        str | None, typer.Option("--type", "-t", help="The part type, where several have that serial number.")
    ] = None,
    u_um: Annotated[
        float | None,
        typer.Option(
            "--u-um", callback=positive, help="Standard uncertainty of readings that state none.  [default: unknown]"
        ),
    ] = None,
    who: Annotated[str | None, typer.Option("--who", help="Who certifies.  [default: the user's name]")] = None,
    db: Db = None,
    as_json: AsJson = False,
) -> None:
    """Certify a part: what was measured by what, verdicts, what was in force. Exit status 1 unless it conforms."""
    from trueloop.jobs.monitor.certificate import certificate_of, write_certificate
    from trueloop.jobs.store.opened import opened
    from trueloop.report.monitor.certificate_lines import HEAD, certificate_rows, in_force_lines

    shown = certificate_of(opened(db), serial, part_type, u_um, who or "")
    files = write_certificate(shown, output, page.language, page.unit)
    if as_json:
        print_json({**shown.model_dump(mode="json"), "files": files})
    else:
        proven = sum(one.certified for one in shown.characteristics)
        of_all = f"{proven} of {len(shown.characteristics)} characteristics certified"
        print_lines([f"{shown.part_type} {shown.serial}: {shown.outcome}, {of_all}"])
        print_table(HEAD, certificate_rows(shown))
        print_lines(in_force_lines(shown))
    for file in files:
        typer.echo(f"written: {file}", err=True)
    if shown.outcome != "conforms":
        raise typer.Exit(ExitStatus.FINDINGS)
