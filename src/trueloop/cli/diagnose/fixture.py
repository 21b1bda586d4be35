"""`trueloop diagnose fixture`."""

from pathlib import Path
from typing import Annotated

import typer

from trueloop.cli.db.options import Db
from trueloop.cli.diagnose.options import Of, Output, Page
from trueloop.cli.diagnose.printed import print_diagnosis
from trueloop.cli.failure import ExitStatus, guarded
from trueloop.cli.numbers import positive
from trueloop.cli.terminal import AsJson


@guarded
def fixture(
    of_what: Annotated[
        str, typer.Argument(metavar="FILE.csv|SERIAL", help="Repeats at one point right after fixturing, or a part.")
    ],
    of: Of,
    page: Page,
    repeats_to_um: Annotated[
        float | None,
        typer.Option("--repeats-to-um", callback=positive, help="What one reading repeats to.  [default: as stated]"),
    ] = None,
    limit_um: Annotated[
        float | None, typer.Option("--limit-um", callback=positive, help="What it may vary by.  [default: no limit]")
    ] = None,
    output: Output = None,
    db: Db = None,
    as_json: AsJson = False,
) -> None:
    """Show whether the fixturing of part, tool probe and part probe holds: spread, drift, step. Ends with 1 if not."""
    from trueloop.jobs.diagnose import fixtures
    from trueloop.jobs.diagnose.written import write_diagnosis
    from trueloop.jobs.store.opened import opened
    from trueloop.report.diagnosis.lines import fixture_lines
    from trueloop.report.diagnosis.page_fixture import fixture_page

    repeats = fixtures.limits_of(repeats_to_um, limit_um)
    if of_what.lower().endswith((".csv", ".txt")):
        found = fixtures.fixture_of_file(Path(of_what), repeats)
    else:
        found = fixtures.fixture_of_part(opened(db), of_what, of.asked(None), repeats)
    files = write_diagnosis(found, "fixture", fixture_page, output, page.language, page.unit)
    print_diagnosis(found, fixture_lines(found), found.findings, files, as_json=as_json)
    if not all(one.stable for one in found.fixturings):
        raise typer.Exit(ExitStatus.FINDINGS)
