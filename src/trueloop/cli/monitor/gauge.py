"""`trueloop monitor gauge`."""

from pathlib import Path
from typing import Annotated

import typer

from trueloop.cli.db.options import Db
from trueloop.cli.failure import ExitStatus, guarded
from trueloop.cli.series.options import Page
from trueloop.cli.terminal import AsJson, print_json, print_lines, print_table


@guarded
def gauge(
    page: Page,
    name: Annotated[
        str | None, typer.Argument(metavar="[NAME]", help="The device, as inspections name it.  [default: all]")
    ] = None,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="Folder for the page and the values.  [default: none]")
    ] = None,
    db: Db = None,
    as_json: AsJson = False,
) -> None:
    """Bias, repeatability and drift of gauges and probes by checks on standard parts. Exit status 1 on an alarm."""
    from trueloop.jobs.monitor.gauges import gauges_of, write_gauges
    from trueloop.jobs.store.opened import opened
    from trueloop.report.monitor.gauge_lines import HEAD, gauge_rows, remark_lines

    shown = gauges_of(opened(db), name)
    files = write_gauges(shown, output, page.language, page.unit)
    if as_json:
        print_json({**shown.model_dump(mode="json"), "files": files})
    else:
        print_table(HEAD, gauge_rows(shown))
        for one in shown.gauges:
            print_lines(remark_lines(one))
    for file in files:
        typer.echo(f"written: {file}", err=True)
    if any(one.alarm for one in shown.gauges):
        raise typer.Exit(ExitStatus.FINDINGS)
